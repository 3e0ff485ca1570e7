//! Whether renders end as they promise.

use std::{
    f64::consts::FRAC_PI_4,
    time::{Duration, Instant},
};

use rayon::prelude::*;
use rt_camera::SamplePattern;
use rt_render::{PlanOptions, Progress, RenderPlan, RunOptions, StopRule, Stopped, TargetError};
use rt_scene_io::Integrator;

use super::{Case, Conditions, Fallible, Found, Tally, coverage, enclosures::Room, picture::Picture};

/// Seeds of each scene and pattern.
const SEEDS: u64 = 200;

pub(super) const CASES: &[Case] = &[
    Case {
        id: "S72",
        title: "half a second for the Cornell box",
        expected: "over after it and one pass, with a whole picture",
        tolerance: "5 %",
        run: half_a_second,
    },
    Case {
        id: "S73",
        title: "`--target-error`, tried with at least 200 seeds",
        expected: "kept 94 times of 100",
        tolerance: "α = 1 %",
        run: target_error,
    },
];

fn half_a_second(conditions: &Conditions) -> Found {
    let limit = Duration::from_millis(500);
    let path = conditions.workspace.root.join("scenes/lecture/cornell.ron");
    let scene = rt_scene_io::load(&path, &rt_scene_io::LoadOptions::default())?;
    let plan = RenderPlan::compile(&scene, &PlanOptions::default())?;
    let rule = StopRule { time: Some(limit), ..StopRule::default() };
    let (start, mut began, mut longest) = (Instant::now(), Instant::now(), Duration::ZERO);
    let mut passes = 0;
    let rendering = plan.render_until(&RunOptions::default(), &rule, |progress: Progress| {
        let finished = progress.pass.map_or(0, |pass| pass.finished);
        if finished > passes {
            longest = longest.max(began.elapsed());
            (began, passes) = (Instant::now(), finished);
        }
    })?;
    let taken = start.elapsed();
    // Of the last one only the end of the render tells.
    longest = longest.max(began.elapsed());
    let mut tally = Tally::default();
    tally.note(format!("{taken:.2?} with {passes} passes of at most {longest:.2?}"));
    tally.same(rendering.stopped, Stopped::Time, "what ended the render");
    tally.check(taken <= limit.mul_f64(1.05) + longest, || {
        format!("{taken:?} and not {limit:?} and a pass of {longest:?}")
    });
    let pixels = rendering.film.pixels();
    tally.check(pixels.iter().flatten().all(|value| value.is_finite()), || "a pixel is not finite".to_owned());
    let least = rendering.samples_per_pixel.least;
    tally.check(least > 0, || "a pixel has no sample".to_owned());
    Ok(tally)
}

/// How often the mean lies within the error that was asked for is held against a binomial distribution, all scenes together.
fn target_error(conditions: &Conditions) -> Found {
    let relative = if conditions.full { 0.01 } else { 0.05 };
    let scenes = [
        ("y < .3 + .2 x", Integrator::Whitted, 0.4, coverage::half_plane(0.3, 0.2)?),
        ("disk of .5", Integrator::Whitted, FRAC_PI_4, coverage::disk(0.5, 0.5)?),
        ("disk of .5", Integrator::Path, FRAC_PI_4, coverage::disk(0.5, 0.5)?),
        ("cube of .5", Integrator::Path, 2.0, Room::Cube.shining(0.5, 100)?),
        ("six quads of .5", Integrator::Path, 2.0, Room::Quads.shining(0.5, 100)?),
    ];
    let mut tally = Tally::default();
    let (mut kept, mut tried) = (0.0, 0.0);
    for (what, integrator, truth, picture) in scenes {
        for pattern in [SamplePattern::Random, SamplePattern::Jittered, SamplePattern::Sobol] {
            let keeps = |seed| keeps(&picture, (integrator, pattern, seed), relative, truth);
            let all = (0..SEEDS).into_par_iter().map(keeps).collect::<Fallible<Vec<bool>>>()?;
            let count = all.iter().filter(|kept| **kept).count();
            tally.note(format!("{what}, {}, {}: {count} of {SEEDS}", integrator.name(), pattern.name()));
            kept += count as f64;
            tried += SEEDS as f64;
        }
    }
    // One-sided, at the level of 1 %.
    let expected = 0.94 * tried;
    let least = expected - 2.326 * (expected * 0.06).sqrt();
    tally.note(format!("{kept} of {tried} kept {relative}"));
    tally.check(kept >= least, || format!("{kept} of {tried}, and not {least:.0}"));
    Ok(tally)
}

/// True if a render to this error ends within it.
fn keeps(
    picture: &Picture,
    (integrator, pattern, seed): (Integrator, SamplePattern, u64),
    relative: f64,
    truth: f64,
) -> Fallible<bool> {
    let mut scene = picture.scene.clone();
    let settings = &mut scene.settings;
    (settings.integrator, settings.pattern, settings.seed) = (integrator, pattern, seed);
    let plan = RenderPlan::compile(&scene, &PlanOptions::default())?;
    let target = Some(TargetError { relative, two_stage: false });
    let rule = StopRule { target, max_spp: 1 << 20, time: None };
    let rendering = plan.render_until(&RunOptions { threads: 1, ..RunOptions::default() }, &rule, |_| {})?;
    let mean = f64::from(rendering.film.pixels()[0][1]);
    Ok(rendering.stopped == Stopped::Target && (mean - truth).abs() <= relative * (mean + 0.01))
}
