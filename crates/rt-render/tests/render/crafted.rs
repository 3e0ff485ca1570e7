//! Crafted parts and checkpoints: they are rejected, or used without a panic or an overflow.

use rt_camera::SamplerKind;
use rt_render::{
    Checkpoint, ContentError, Criterion, MergeError, PlanOptions, RenderSnapshot, RunOptions, Shard, ShardSpec,
    StopRule, TargetError, UncheckedCheckpoint, UncheckedShard,
};
use rt_scene_io::{Integrator, Scene};
use serde_json::{Number, Value, json};

use crate::support::{OnTile, compile, compile_with, interrupted, spheres};

/// Two tiles, one of them a single pixel wide.
const SIZE: [u32; 2] = [17, 3];

/// Number of changed entries at the beginning of a list; the last one is changed as well.
const CHANGED: usize = 2;

fn scene(integrator: Integrator) -> Scene {
    let mut scene = spheres();
    [scene.film.width, scene.film.height] = SIZE;
    (scene.settings.spp, scene.settings.integrator) = (2, integrator);
    scene.settings.pattern = SamplerKind::Random;
    scene
}

fn crafted_numbers() -> Vec<Value> {
    let whole = [0, 1, 2, 3, 50, 255, 1 << 20, u64::from(u32::MAX), 1 << 32, 1 << 61, u64::MAX - 1, u64::MAX];
    let real = [-1.0, 0.5, 1e-300, 1e30, 1e308, f64::MIN].map(|value| Number::from_f64(value).expect("finite"));
    whole.into_iter().map(Value::from).chain(real.map(Value::Number)).collect()
}

/// Calls `try_it` with all variants of the value in which one number, list or key is changed.
fn for_each_variant(value: &Value, mut try_it: impl FnMut(&str, Value)) {
    let mut pointers = Vec::new();
    collect(value, &mut String::new(), &mut pointers);
    for pointer in &pointers {
        let found = value.pointer(pointer).expect("it was found");
        let variants = match found {
            Value::Array(list) => {
                let shorter = list[..list.len().saturating_sub(1)].to_vec();
                let longer = [&list[..], &list[..list.len().min(1)]].concat();
                vec![json!([]), Value::Array(shorter), Value::Array(longer), json!([u32::MAX]), json!([0, 0])]
            }
            Value::Object(map) => {
                // Keys are numbers of tiles.
                let rename = |from: &String, to: &str| {
                    let mut map = map.clone();
                    let moved = map.remove(from)?;
                    map.insert(to.to_owned(), moved);
                    Some(Value::Object(map))
                };
                let keys = map.keys().filter(|key| key.parse::<u32>().is_ok());
                keys.flat_map(|key| ["0", "1", "2", "4294967295"].map(|to| rename(key, to))).flatten().collect()
            }
            _ => crafted_numbers(),
        };
        for variant in variants {
            let mut changed = value.clone();
            *changed.pointer_mut(pointer).expect("it is there") = variant.clone();
            try_it(&format!("{pointer} = {variant}"), changed);
        }
    }
}

/// Finds numbers, lists, and maps with numeric keys. Of long lists, only the first and last entries.
fn collect(value: &Value, pointer: &mut String, found: &mut Vec<String>) {
    let length = pointer.len();
    let mut each = |key: &str, value: &Value| {
        pointer.push('/');
        pointer.push_str(key);
        collect(value, pointer, found);
        pointer.truncate(length);
    };
    match value {
        Value::Array(list) => {
            for (index, entry) in list.iter().enumerate() {
                if index < CHANGED || index + 1 == list.len() {
                    each(&index.to_string(), entry);
                }
            }
            found.push(pointer.clone());
        }
        Value::Object(map) => {
            map.iter().for_each(|(key, entry)| each(key, entry));
            found.push(pointer.clone());
        }
        Value::Number(_) | Value::Null => found.push(pointer.clone()),
        Value::Bool(_) | Value::String(_) => {}
    }
}

#[test]
fn crafted_numbers_of_parts_are_refused_or_harmless() {
    for integrator in [Integrator::Path, Integrator::Caustics] {
        let scene = scene(integrator);
        let plan = compile_with(&scene, PlanOptions { transparent: true, ..PlanOptions::default() });
        let shard = |index| {
            let spec = ShardSpec::new(index, 2).expect("a shard");
            let run = RunOptions { threads: 1, count: true, shard: spec, ..RunOptions::default() };
            plan.render_shard(&run, None, None, |_| {}).expect("renders")
        };
        let [crafted, other] = [0, 1].map(shard);
        let written = serde_json::to_value(&crafted).expect("numbers");
        assert_eq!(serde_json::from_value::<Shard>(written.clone()).expect("sound"), crafted);
        let (mut refused, mut used) = (0, 0);
        for_each_variant(&written, |what, changed| {
            let Ok(unchecked) = serde_json::from_value::<UncheckedShard>(changed.clone()) else { return };
            let checked = unchecked.check();
            assert_eq!(serde_json::from_value::<Shard>(changed).is_ok(), checked.is_ok(), "{what}");
            let Ok(shard) = checked else {
                refused += 1;
                return;
            };
            used += 1;
            // A larger image with missing tiles is valid as well.
            let (missing, bytes) = (shard.missing_tiles(), shard.rendering_bytes());
            let rendering = shard.clone().into_rendering();
            assert_eq!(
                rendering.film.pixels().len() as u64,
                bytes / if rendering.film.alpha().is_some() { 16 } else { 12 },
                "{what}"
            );
            assert!(missing == 0 || Shard::merge(vec![shard.clone()]).is_err(), "{what}");
            // Sums over both parts are at least the counts of each.
            let samples = rendering.statistics.samples;
            if let Ok(merged) = Shard::merge(vec![shard, other.clone()]) {
                let merged = merged.into_rendering().statistics;
                assert!(merged.samples > samples, "{what}");
                assert!(merged.render_seconds.is_finite() && merged.counters.total().rays < 1 << 63, "{what}");
            }
        });
        assert!(refused > 100 && used > 100, "{refused} refused, {used} used");
    }
}

#[test]
fn counts_of_parts_that_overflowed_together_are_refused() {
    let scene = scene(Integrator::Path);
    let plan = compile(&scene);
    let shards = [0, 1].map(|index| {
        let run = RunOptions { shard: ShardSpec::new(index, 2).expect("a shard"), ..RunOptions::default() };
        let shard = plan.render_shard(&run, None, None, |_| {}).expect("renders");
        let mut written = serde_json::to_value(&shard).expect("numbers");
        *written.pointer_mut("/statistics/counters/by_kind/1/rays").expect("rays") = json!((1_u64 << 60) - 1);
        serde_json::from_value::<Shard>(written).expect("each is possible")
    });
    let refused = Shard::merge(shards.to_vec());
    assert!(matches!(refused, Err(MergeError::Damaged(1, ContentError::Count { .. }))), "{refused:?}");
}

#[test]
fn crafted_numbers_of_checkpoints_are_refused_or_harmless() {
    let pixels = Criterion::Pixels { share: 1.0 };
    let target = |criterion, two_stage| StopRule {
        target: Some(TargetError { relative: 0.5, criterion, two_stage }),
        max_spp: 64,
        time: None,
    };
    let growing = StopRule { max_spp: 5, ..StopRule::default() };
    for (integrator, rule, tiles) in [
        (Integrator::Path, None, 1),
        (Integrator::Caustics, None, 2),
        (Integrator::Path, Some(growing), 3),
        (Integrator::Path, Some(target(Criterion::Image, false)), 17),
        (Integrator::Path, Some(target(pixels, false)), 17),
        (Integrator::Path, Some(target(pixels, true)), 1000),
    ] {
        let scene = scene(integrator);
        let plan = compile(&scene);
        // The last checkpoint of a render of two stages is of its second.
        let mut tiles_in_all = 0;
        let count = |_| tiles_in_all += 1;
        let run = RunOptions { threads: 1, ..RunOptions::default() };
        plan.render_shard(&run, rule.as_ref(), None, count).expect("renders");
        let last = tiles.min(tiles_in_all - 1);
        let (kept, _) = interrupted(&plan, rule.as_ref(), None, run, [last, last]);
        let kept = serde_json::to_value(postcard::from_bytes::<Checkpoint>(&kept).expect("read")).expect("numbers");
        let (mut refused, mut used) = (0, 0);
        for_each_variant(&kept, |what, changed| {
            let Ok(unchecked) = serde_json::from_value::<UncheckedCheckpoint>(changed.clone()) else { return };
            let checked = unchecked.check();
            assert_eq!(serde_json::from_value::<Checkpoint>(changed).is_ok(), checked.is_ok(), "{what}");
            let Ok(checkpoint) = checked else {
                refused += 1;
                return;
            };
            used += 1;
            let (samples, rays) = (checkpoint.samples(), checkpoint.rays());
            if let Ok(shard) = plan.render_shard(&run, rule.as_ref(), Some(checkpoint), |_| {}) {
                let statistics = shard.into_rendering().statistics;
                assert!(statistics.samples >= samples && statistics.counters.total().rays >= rays, "{what}");
            }
        });
        assert!(refused > 100 && used > 50, "{refused} refused, {used} used of {integrator:?}, {rule:?}");
    }
}

/// Seeds of the fuzz targets match the current formats. `WRITE_SEEDS=1` writes them again.
#[test]
fn seeds_of_the_fuzz_targets_are_sound() {
    let folder = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../fuzz/seeds"));
    let scene = scene(Integrator::Path);
    let plan = compile(&scene);
    let run = |spec| RunOptions { threads: 1, maps: true, shard: spec, ..RunOptions::default() };
    if std::env::var_os("WRITE_SEEDS").is_some() {
        for index in [0, 1] {
            let run = run(ShardSpec::new(index, 2).expect("a shard"));
            let shard = plan.render_shard(&run, None, None, |_| {}).expect("renders");
            let file = folder.join(format!("part/{}-of-2.part", index + 1));
            std::fs::write(file, postcard::to_stdvec(&shard).expect("written")).expect("written");
        }
        for (name, rule) in [("tiles", None), ("passes", Some(StopRule { max_spp: 4, ..StopRule::default() }))] {
            let mut written = Vec::new();
            let keep = OnTile(|snapshot: &RenderSnapshot<'_>| {
                if written.is_empty() {
                    written = postcard::to_stdvec(&snapshot.checkpoint()).expect("written");
                }
            });
            plan.render_shard(&run(ShardSpec::ALL), rule.as_ref(), None, keep).expect("renders");
            std::fs::write(folder.join(format!("checkpoint/{name}.checkpoint")), written).expect("written");
        }
    }
    let files = |name: &str| {
        let entries = std::fs::read_dir(folder.join(name)).expect("a folder");
        entries.map(|entry| std::fs::read(entry.expect("an entry").path()).expect("a file")).collect::<Vec<_>>()
    };
    let (shards, checkpoints) = (files("part"), files("checkpoint"));
    assert!(shards.len() >= 2 && checkpoints.len() >= 2);
    for shard in shards {
        postcard::from_bytes::<UncheckedShard>(&shard).expect("run it with WRITE_SEEDS=1").check().expect("sound");
    }
    for checkpoint in checkpoints {
        postcard::from_bytes::<UncheckedCheckpoint>(&checkpoint)
            .expect("run it with WRITE_SEEDS=1")
            .check()
            .expect("sound");
    }
}
