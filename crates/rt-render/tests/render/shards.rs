//! Interrupted and resumed renders, and images merged from shards.

use std::sync::atomic::{AtomicBool, Ordering};

use rt_camera::SamplerKind;
use rt_math::random::hash;
use rt_render::{
    Checkpoint, MergeError, PlanOptions, RenderError, RenderPlan, RenderSnapshot, Rendering, RunOptions, Shard,
    ShardSpec, StopRule, Stopped, TargetError,
};
use rt_scene_io::{AdaptiveSampling, Integrator, Scene};

use crate::support::{OnTile, compile, compile_with, everything, interrupted, node, sphere, spheres};

/// Mode of rendering: a scene and a stop rule.
struct Mode {
    name: &'static str,
    scene: Scene,
    rule: Option<StopRule>,
}

fn modes() -> Vec<Mode> {
    let set = |name, scene: &dyn Fn() -> Scene, change: &dyn Fn(&mut Scene), rule| {
        let mut scene = scene();
        (scene.film.width, scene.film.height, scene.settings.spp) = (61, 43, 4);
        change(&mut scene);
        Mode { name, scene, rule }
    };
    let growing = StopRule { max_spp: 11, ..StopRule::default() };
    let target = |target| StopRule { target: Some(target), max_spp: 256, time: None };
    let of_pixels = |two_stage| TargetError { two_stage, ..TargetError::of_pixels(0.3) };
    let path = |scene: &mut Scene| scene.settings.integrator = Integrator::Path;
    let caustics = |scene: &mut Scene| scene.settings.integrator = Integrator::Caustics;
    let adaptive = |scene: &mut Scene| {
        scene.settings.spp = 8;
        scene.settings.adaptive = Some(AdaptiveSampling::ObjectSpace { min_spp: Some(4) });
    };
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

const RUN: RunOptions<'_> =
    RunOptions { threads: 2, count: true, maps: true, shard: ShardSpec::ALL, interrupt: None, layers: &[] };

fn shard(plan: &RenderPlan<'_>, mode: &Mode, run: &RunOptions<'_>) -> Shard {
    plan.render_shard(run, mode.rule.as_ref(), None, |_| {}).expect("renders")
}

/// Compares all results that are independent of interruptions; times are not.
fn assert_same(one: &Rendering, other: &Rendering, what: &str) {
    assert_eq!(one.film, other.film, "{what}");
    assert_eq!(one.standard_error, other.standard_error, "{what}");
    assert_eq!(one.sample_counts, other.sample_counts, "{what}");
    assert_eq!((one.error, one.stopped, one.unconverged), (other.error, other.stopped, other.unconverged), "{what}");
    assert_eq!(one.samples_per_pixel, other.samples_per_pixel, "{what}");
}

/// Each part of a render runs on another number of threads than the part before it.
#[test]
fn resumed_renders_are_bit_identical() {
    for (number, mode) in modes().iter().enumerate() {
        let plan = compile(&mode.scene);
        let whole = shard(&plan, mode, &RUN).into_rendering();
        let mut kills_in_all = 0;
        // Short renders can finish before the interrupt takes effect, most often on a busy machine.
        for seed in 0..60u64 {
            if seed >= 3 && kills_in_all > 3 {
                break;
            }
            let mut from = None;
            let mut kills = 0;
            let result = loop {
                let random = |dimension, max| 1 + hash(&[number as u64, seed, kills, dimension]) % max;
                let kept_after = random(0, 5);
                let tiles = [kept_after, kept_after + random(1, 4)];
                let run = RunOptions { threads: 1 + (seed + kills) as usize % 3, ..RUN };
                let (checkpoint, rendering) = interrupted(&plan, mode.rule.as_ref(), from, run, tiles);
                if rendering.stopped != Stopped::Interrupted {
                    break rendering;
                }
                kills += 1;
                from = Some(postcard::from_bytes::<Checkpoint>(&checkpoint).expect("read"));
            };
            let what = format!("{} with seed {seed} after {kills} kills", mode.name);
            kills_in_all += kills;
            assert_same(&whole, &result, &what);
            let (of_whole, of_result) = (whole.statistics, result.statistics);
            assert_eq!((of_whole.samples, of_whole.passes), (of_result.samples, of_result.passes), "{what}");
            assert_eq!(of_whole.counters, of_result.counters, "{what}");
            assert_eq!(of_whole.shading, of_result.shading, "{what}");
        }
        assert!(kills_in_all > 3, "{} was killed {kills_in_all} times", mode.name);
    }
}

#[test]
fn snapshots_contain_the_pixels_of_finished_tiles() {
    for mode in modes().iter().filter(|mode| mode.rule.is_none_or(|rule| rule.target.is_none())) {
        let film = &mode.scene.film;
        let mut copied = vec![[0.0; 3]; (film.width * film.height) as usize];
        let observer = OnTile(|snapshot: &RenderSnapshot<'_>| {
            let tile = snapshot.tile();
            for (index, pixel) in snapshot.pixels().into_iter().enumerate() {
                let (x, y) = (tile.x + index as u32 % tile.width, tile.y + index as u32 / tile.width);
                copied[(y * film.width + x) as usize] = pixel;
            }
            assert_eq!(snapshot.film().pixels(), copied);
        });
        let plan = compile(&mode.scene);
        let shard = plan.render_shard(&RUN, mode.rule.as_ref(), None, observer).expect("renders");
        assert_eq!(shard.into_rendering().film.pixels(), copied, "{}", mode.name);
    }
}

#[test]
fn joined_shares_are_bit_identical_to_one_render() {
    for mode in modes().iter().filter(|mode| mode.rule.is_none()) {
        let plan = compile(&mode.scene);
        let whole = shard(&plan, mode, &RUN).into_rendering();
        // Light paths belong to no tile: each shard traces all of them.
        let traces_all = mode.scene.settings.integrator == Integrator::Caustics;
        for &count in if traces_all { &[1, 3][..] } else { &[1, 3, 100] } {
            let spec = |index| ShardSpec::new(index, count).expect("a shard");
            let mut shards: Vec<_> =
                (0..count).map(|index| shard(&plan, mode, &RunOptions { shard: spec(index), ..RUN })).collect();
            // The order of shards does not matter, and they survive serialisation.
            shards.sort_by_key(|shard| hash(&[u64::from(shard.spec().index())]));
            let written = postcard::to_stdvec(&shards).expect("written");
            let shards: Vec<Shard> = postcard::from_bytes(&written).expect("read");
            let merged = Shard::merge(shards).expect("all are there").into_rendering();
            assert_same(&whole, &merged, &format!("{} in {count} shards", mode.name));
            if !traces_all {
                assert_eq!(whole.statistics.counters, merged.statistics.counters);
            }
        }
    }
}

#[test]
fn join_errors_name_the_part() {
    let mode = &modes()[0];
    let plan = compile(&mode.scene);
    let of =
        |index, count| shard(&plan, mode, &RunOptions { shard: ShardSpec::new(index, count).expect("a shard"), ..RUN });
    let [a, b, c] = [0, 1, 2].map(|index| of(index, 3));
    assert_eq!(Shard::merge(vec![]), Err(MergeError::Nothing));
    assert_eq!(Shard::merge(vec![a.clone(), c.clone()]), Err(MergeError::Missing(vec![1], 3)));
    assert_eq!(Shard::merge(vec![a.clone(), b.clone(), a.clone()]), Err(MergeError::Doubled(0, 2)));
    let other = MergeError::ShardCounts { shard: 1, count: 4, expected: 3 };
    assert_eq!(Shard::merge(vec![a.clone(), of(1, 4), c.clone()]), Err(other));
    let mut small = mode.scene.clone();
    small.film.width -= 1;
    let foreign = compile(&small);
    let foreign = shard(&foreign, mode, &RunOptions { shard: ShardSpec::new(1, 3).expect("a shard"), ..RUN });
    assert_eq!(Shard::merge(vec![a.clone(), foreign, c.clone()]), Err(MergeError::Foreign(1)));

    // Interrupt before the start: after a tile, other threads could already have finished the rest.
    let interrupt = AtomicBool::new(true);
    let run = RunOptions { interrupt: Some(&interrupt), shard: ShardSpec::new(1, 3).expect("a shard"), ..RUN };
    let unfinished = plan.render_shard(&run, None, None, |_| {}).expect("renders");
    let missing = unfinished.missing_tiles();
    assert!(missing > 0);
    assert_eq!(Shard::merge(vec![c, a, unfinished]), Err(MergeError::Unfinished { shard: 2, missing }));
    let message = MergeError::Missing(vec![0, 4], 8).to_string();
    assert_eq!(message, "2 of 8 shards are missing: 1/8, 5/8; render them");
}

/// Each tile would take hours.
#[test]
fn an_interrupt_does_not_wait_for_tiles_of_many_samples() {
    let mut scene = spheres();
    // It covers the image, so that no tile is empty.
    scene.nodes = vec![node(sphere(0.0, 0.0, 0.0, 6.0), 0)];
    scene.settings.spp = 1 << 30;
    let plan = compile(&scene);
    let interrupt = AtomicBool::new(false);
    let mut finished = 0;
    let shard = std::thread::scope(|scope| {
        scope.spawn(|| {
            std::thread::sleep(std::time::Duration::from_millis(50));
            interrupt.store(true, Ordering::Relaxed);
        });
        let run = RunOptions { threads: 3, interrupt: Some(&interrupt), ..RUN };
        plan.render_shard(&run, None, None, |_| finished += 1).expect("renders")
    });
    let missing = shard.missing_tiles();
    assert_eq!((shard.into_rendering().stopped, finished), (Stopped::Interrupted, 0));
    assert!(missing > 0);
}

#[test]
fn interrupted_parts_of_passes_are_unfinished() {
    let mode = &modes()[2];
    assert_eq!(mode.name, "caustics");
    let plan = compile(&mode.scene);
    let interrupt = AtomicBool::new(true);
    let shards = [0, 1].map(|index| {
        let run = RunOptions { interrupt: Some(&interrupt), shard: ShardSpec::new(index, 2).expect("a shard"), ..RUN };
        plan.render_shard(&run, None, None, |_| {}).expect("renders")
    });
    let missing = shards[0].missing_tiles();
    assert!(missing > 0);
    assert_eq!(Shard::merge(shards.to_vec()), Err(MergeError::Unfinished { shard: 0, missing }));
}

#[test]
fn checkpoints_of_other_renders_are_refused() {
    let keep = |mode: &Mode, options: &PlanOptions, run: RunOptions<'_>| {
        let plan = compile_with(&mode.scene, *options);
        interrupted(&plan, mode.rule.as_ref(), None, run, [1, 1]).0
    };
    let modes = modes();
    let [plain, path, growing, target] = [0, 1, 4, 5].map(|index| &modes[index]);
    let try_in = |checkpoint: &[u8], mode: &Mode, run: RunOptions<'_>| {
        let plan = compile(&mode.scene);
        let from = postcard::from_bytes(checkpoint).expect("read");
        plan.render_shard(&run, mode.rule.as_ref(), Some(from), |_| {}).map(|_| ())
    };
    let kept = keep(plain, &PlanOptions::default(), RUN);
    assert!(try_in(&kept, plain, RUN).is_ok());
    for (mode, run) in [
        (growing, RUN),
        (plain, RunOptions { maps: false, ..RUN }),
        (plain, RunOptions { count: false, ..RUN }),
        (plain, RunOptions { shard: ShardSpec::new(1, 2).expect("a shard"), ..RUN }),
    ] {
        assert!(matches!(try_in(&kept, mode, run), Err(RenderError::Checkpoint)), "{}", mode.name);
    }
    let transparent = keep(plain, &PlanOptions { transparent: true, ..PlanOptions::default() }, RUN);
    assert!(matches!(try_in(&transparent, plain, RUN), Err(RenderError::Checkpoint)));
    let of_target = keep(target, &PlanOptions::default(), RUN);
    assert!(matches!(try_in(&of_target, growing, RUN), Err(RenderError::Checkpoint)));
    assert!(matches!(try_in(&of_target, path, RUN), Err(RenderError::Checkpoint)));
}

#[test]
fn a_share_takes_a_fixed_number_of_samples() {
    let modes = modes();
    let plan = compile(&modes[4].scene);
    let run = RunOptions { shard: ShardSpec::new(0, 2).expect("a shard"), ..RUN };
    let refused = plan.render_shard(&run, modes[4].rule.as_ref(), None, |_| {});
    assert!(matches!(refused, Err(RenderError::ShardWithStopRule)));
    assert_eq!(
        (ShardSpec::new(2, 2), ShardSpec::new(0, 0), ShardSpec::new(0, ShardSpec::MAX_COUNT + 1)),
        (None, None, None)
    );
}
