//! Renders that are interrupted, killed and continued, and pictures of many parts.

use std::sync::atomic::{AtomicBool, Ordering};

use rt_camera::SamplerKind;
use rt_math::random::hash;
use rt_render::{
    Checkpoint, JoinError, Observer, Part, PlanOptions, RenderError, RenderPlan, RenderSnapshot, Rendering, RunOptions,
    Share, StopRule, Stopped, TargetError,
};
use rt_scene_io::{Adaptive, Integrator, Scene};

use crate::support::{everything, spheres};

/// Lets a render go on for some tiles, keeps its checkpoint, and interrupts it some tiles later.
struct Killer<'a> {
    kept_after: u64,
    killed_after: u64,
    tiles: u64,
    checkpoint: Vec<u8>,
    interrupt: &'a AtomicBool,
}

impl Observer for Killer<'_> {
    fn tile_done(&mut self, so_far: &RenderSnapshot<'_>) {
        self.tiles += 1;
        if self.tiles == self.kept_after {
            self.checkpoint = postcard::to_stdvec(&so_far.checkpoint()).expect("written");
        }
        if self.tiles >= self.killed_after {
            self.interrupt.store(true, Ordering::Relaxed);
        }
    }
}

/// A way to render: a scene, and what ends it.
struct Way {
    name: &'static str,
    scene: Scene,
    rule: Option<StopRule>,
}

fn ways() -> Vec<Way> {
    let set = |name, scene: &dyn Fn() -> Scene, change: &dyn Fn(&mut Scene), rule| {
        let mut scene = scene();
        (scene.film.width, scene.film.height, scene.settings.spp) = (61, 43, 16);
        change(&mut scene);
        Way { name, scene, rule }
    };
    let growing = StopRule { max_spp: 11, ..StopRule::default() };
    let target = |target| StopRule { target: Some(target), max_spp: 256, time: None };
    let of_pixels = |two_stage| TargetError { two_stage, ..TargetError::of_pixels(0.3) };
    let path = |scene: &mut Scene| scene.settings.integrator = Integrator::Path;
    let caustics = |scene: &mut Scene| scene.settings.integrator = Integrator::Caustics;
    let adaptive = |scene: &mut Scene| scene.settings.adaptive = Some(Adaptive::ObjectSpace { least: Some(4) });
    let random = |scene: &mut Scene| scene.settings.pattern = SamplerKind::Random;
    vec![
        set("whitted", &everything, &|_| {}, None),
        set("path", &everything, &path, None),
        set("caustics", &everything, &caustics, None),
        set("object space", &spheres, &adaptive, None),
        set("growing", &everything, &path, Some(growing)),
        set("target", &spheres, &random, Some(target(of_pixels(false)))),
        set("two stages", &spheres, &random, Some(target(of_pixels(true)))),
        set("image", &spheres, &random, Some(target(TargetError::of_image(0.1)))),
        set(
            "image in two stages",
            &spheres,
            &random,
            Some(target(TargetError { two_stage: true, ..TargetError::of_image(0.2) })),
        ),
    ]
}

const RUN: RunOptions<'_> = RunOptions { threads: 2, count: true, maps: true, share: Share::ALL, interrupt: None };

fn part(plan: &RenderPlan<'_>, way: &Way, run: &RunOptions<'_>) -> Part {
    plan.render_part(run, way.rule.as_ref(), None, |_| {}).expect("renders")
}

/// What may not depend on interruptions. Times do.
fn assert_same(one: &Rendering, other: &Rendering, what: &str) {
    assert_eq!(one.film, other.film, "{what}");
    assert_eq!(one.standard_error, other.standard_error, "{what}");
    assert_eq!(one.sample_counts, other.sample_counts, "{what}");
    assert_eq!((one.error, one.stopped, one.unconverged), (other.error, other.stopped, other.unconverged), "{what}");
    assert_eq!(one.samples_per_pixel, other.samples_per_pixel, "{what}");
}

#[test]
fn a_killed_render_goes_on_to_the_same_bits() {
    for (number, way) in ways().iter().enumerate() {
        let plan = RenderPlan::compile(&way.scene, &PlanOptions::default()).expect("compiles");
        let whole = part(&plan, way, &RUN).into_rendering();
        let mut kills_in_all = 0;
        // A quick render may be over before it notices, on a busy machine more often than not.
        for seed in 0..60u64 {
            if seed >= 6 && kills_in_all > 6 {
                break;
            }
            let mut from = None;
            let mut kills = 0;
            let result = loop {
                let interrupt = AtomicBool::new(false);
                let draw = |dimension, most| 1 + hash(&[number as u64, seed, kills, dimension]) % most;
                let kept_after = draw(0, 5);
                let killed_after = kept_after + draw(1, 4);
                let mut killer =
                    Killer { kept_after, killed_after, tiles: 0, checkpoint: Vec::new(), interrupt: &interrupt };
                let run = RunOptions { interrupt: Some(&interrupt), ..RUN };
                let part = plan.render_part(&run, way.rule.as_ref(), from, &mut killer).expect("renders");
                let rendering = part.into_rendering();
                if rendering.stopped != Stopped::Interrupted {
                    break rendering;
                }
                kills += 1;
                from = Some(postcard::from_bytes::<Checkpoint>(&killer.checkpoint).expect("read"));
            };
            let what = format!("{} with seed {seed} after {kills} kills", way.name);
            kills_in_all += kills;
            assert_same(&whole, &result, &what);
            let (of_whole, of_result) = (whole.statistics, result.statistics);
            assert_eq!((of_whole.samples, of_whole.passes), (of_result.samples, of_result.passes), "{what}");
            assert_eq!(of_whole.counters, of_result.counters, "{what}");
            assert_eq!(of_whole.shading, of_result.shading, "{what}");
        }
        assert!(kills_in_all > 6, "{} was killed {kills_in_all} times", way.name);
    }
}

impl Observer for &mut Killer<'_> {
    fn tile_done(&mut self, so_far: &RenderSnapshot<'_>) {
        (**self).tile_done(so_far);
    }
}

#[test]
fn a_picture_so_far_has_the_pixels_of_its_tiles() {
    for way in ways().iter().filter(|way| way.rule.is_none_or(|rule| rule.target.is_none())) {
        struct Painter(Vec<[f32; 3]>, u32);
        impl Observer for &mut Painter {
            fn tile_done(&mut self, so_far: &RenderSnapshot<'_>) {
                let tile = so_far.tile();
                for (place, pixel) in so_far.pixels().into_iter().enumerate() {
                    let (x, y) = (tile.x + place as u32 % tile.width, tile.y + place as u32 / tile.width);
                    self.0[(y * self.1 + x) as usize] = pixel;
                }
                assert_eq!(so_far.film().pixels(), self.0);
            }
        }
        let film = &way.scene.film;
        let mut painter = Painter(vec![[0.0; 3]; (film.width * film.height) as usize], film.width);
        let plan = RenderPlan::compile(&way.scene, &PlanOptions::default()).expect("compiles");
        let part = plan.render_part(&RUN, way.rule.as_ref(), None, &mut painter).expect("renders");
        assert_eq!(part.into_rendering().film.pixels(), painter.0, "{}", way.name);
    }
}

#[test]
fn shares_join_to_the_bits_of_one_render() {
    for way in ways().iter().filter(|way| way.rule.is_none()) {
        let plan = RenderPlan::compile(&way.scene, &PlanOptions::default()).expect("compiles");
        let whole = part(&plan, way, &RUN).into_rendering();
        for count in [1, 3, 8, 100] {
            let share = |index| Share::new(index, count).expect("a share");
            let mut parts: Vec<_> =
                (0..count).map(|index| part(&plan, way, &RunOptions { share: share(index), ..RUN })).collect();
            // Any order will do, and so will parts that were written down and read.
            parts.sort_by_key(|part| hash(&[u64::from(part.share().index())]));
            let written = postcard::to_stdvec(&parts).expect("written");
            let parts: Vec<Part> = postcard::from_bytes(&written).expect("read");
            let joined = Part::join(parts).expect("all are there").into_rendering();
            assert_same(&whole, &joined, &format!("{} in {count} parts", way.name));
            // Light paths belong to no tile: each part follows all of them.
            if way.scene.settings.integrator != Integrator::Caustics {
                assert_eq!(whole.statistics.counters, joined.statistics.counters);
            }
        }
    }
}

#[test]
fn parts_that_make_no_picture_are_named() {
    let way = &ways()[0];
    let plan = RenderPlan::compile(&way.scene, &PlanOptions::default()).expect("compiles");
    let of = |index, count| part(&plan, way, &RunOptions { share: Share::new(index, count).expect("a share"), ..RUN });
    let [a, b, c] = [0, 1, 2].map(|index| of(index, 3));
    assert_eq!(Part::join(vec![]), Err(JoinError::Nothing));
    assert_eq!(Part::join(vec![a.clone(), c.clone()]), Err(JoinError::Missing(vec![1], 3)));
    assert_eq!(Part::join(vec![a.clone(), b.clone(), a.clone()]), Err(JoinError::Doubled(0, 2)));
    let other = JoinError::Shares { part: 1, count: 4, expected: 3 };
    assert_eq!(Part::join(vec![a.clone(), of(1, 4), c.clone()]), Err(other));
    let mut small = way.scene.clone();
    small.film.width -= 1;
    let foreign = RenderPlan::compile(&small, &PlanOptions::default()).expect("compiles");
    let foreign = part(&foreign, way, &RunOptions { share: Share::new(1, 3).expect("a share"), ..RUN });
    assert_eq!(Part::join(vec![a.clone(), foreign, c.clone()]), Err(JoinError::Foreign(1)));

    // Interrupted before it starts: after a tile, the other threads might already have done all the rest.
    let interrupt = AtomicBool::new(true);
    let run = RunOptions { interrupt: Some(&interrupt), share: Share::new(1, 3).expect("a share"), ..RUN };
    let unfinished = plan.render_part(&run, None, None, |_| {}).expect("renders");
    let missing = unfinished.missing_tiles();
    assert!(missing > 0);
    assert_eq!(Part::join(vec![c, a, unfinished]), Err(JoinError::Unfinished { part: 2, missing }));
    let message = JoinError::Missing(vec![0, 4], 8).to_string();
    assert_eq!(message, "2 of 8 shares missing: 1/8, 5/8");
}

#[test]
fn an_interrupted_part_of_passes_was_taken_for_finished() {
    let way = &ways()[2];
    assert_eq!(way.name, "caustics");
    let plan = RenderPlan::compile(&way.scene, &PlanOptions::default()).expect("compiles");
    let interrupt = AtomicBool::new(true);
    let parts = [0, 1].map(|index| {
        let run = RunOptions { interrupt: Some(&interrupt), share: Share::new(index, 2).expect("a share"), ..RUN };
        plan.render_part(&run, None, None, |_| {}).expect("renders")
    });
    let missing = parts[0].missing_tiles();
    assert!(missing > 0);
    assert_eq!(Part::join(parts.to_vec()), Err(JoinError::Unfinished { part: 0, missing }));
}

#[test]
fn checkpoints_of_other_renders_are_refused() {
    let keep = |way: &Way, options: &PlanOptions, run: RunOptions<'_>| {
        let plan = RenderPlan::compile(&way.scene, options).expect("compiles");
        let interrupt = AtomicBool::new(false);
        let mut killer =
            Killer { kept_after: 1, killed_after: 1, tiles: 0, checkpoint: Vec::new(), interrupt: &interrupt };
        let run = RunOptions { interrupt: Some(&interrupt), ..run };
        plan.render_part(&run, way.rule.as_ref(), None, &mut killer).expect("renders");
        killer.checkpoint
    };
    let ways = ways();
    let [plain, path, growing, target] = [0, 1, 4, 5].map(|index| &ways[index]);
    let try_in = |checkpoint: &[u8], way: &Way, run: RunOptions<'_>| {
        let plan = RenderPlan::compile(&way.scene, &PlanOptions::default()).expect("compiles");
        let from = postcard::from_bytes(checkpoint).expect("read");
        plan.render_part(&run, way.rule.as_ref(), Some(from), |_| {}).map(|_| ())
    };
    let kept = keep(plain, &PlanOptions::default(), RUN);
    assert!(try_in(&kept, plain, RUN).is_ok());
    for (way, run) in [
        (growing, RUN),
        (plain, RunOptions { maps: false, ..RUN }),
        (plain, RunOptions { count: false, ..RUN }),
        (plain, RunOptions { share: Share::new(1, 2).expect("a share"), ..RUN }),
    ] {
        assert!(matches!(try_in(&kept, way, run), Err(RenderError::Checkpoint)), "{}", way.name);
    }
    let transparent = keep(plain, &PlanOptions { transparent: true, ..PlanOptions::default() }, RUN);
    assert!(matches!(try_in(&transparent, plain, RUN), Err(RenderError::Checkpoint)));
    let of_target = keep(target, &PlanOptions::default(), RUN);
    assert!(matches!(try_in(&of_target, growing, RUN), Err(RenderError::Checkpoint)));
    assert!(matches!(try_in(&of_target, path, RUN), Err(RenderError::Checkpoint)));
}

#[test]
fn a_share_takes_a_fixed_number_of_samples() {
    let ways = ways();
    let plan = RenderPlan::compile(&ways[4].scene, &PlanOptions::default()).expect("compiles");
    let run = RunOptions { share: Share::new(0, 2).expect("a share"), ..RUN };
    let refused = plan.render_part(&run, ways[4].rule.as_ref(), None, |_| {});
    assert!(matches!(refused, Err(RenderError::SharedUntil)));
    assert_eq!((Share::new(2, 2), Share::new(0, 0), Share::new(0, Share::MOST + 1)), (None, None, None));
}
