//! Statistics of a render.

use serde_json::{Value, json};

use crate::program::Workplace;

fn stats(place: &Workplace, options: &str) -> Value {
    place.succeed(&format!("render scene.ron --stats stats.json {options}"));
    place.json("stats.json")
}

/// Other tests check counts and times; this one checks the names.
fn blank_numbers(value: &mut Value) {
    match value {
        Value::Number(_) => *value = json!(0),
        Value::Array(values) => values.iter_mut().for_each(blank_numbers),
        Value::Object(fields) => fields.values_mut().for_each(blank_numbers),
        _ => {}
    }
}

#[test]
fn the_file_has_this_shape() {
    let place = Workplace::with_scene();
    let mut stats = stats(&place, "--crop 8,8,32,16 --threads 2");
    for key in ["load", "build", "render", "output"] {
        assert!(stats["seconds"][key].as_f64().is_some_and(|s| (0.0..60.0).contains(&s)), "{key}: {stats}");
    }
    assert!(stats["mega_rays_per_second"].as_f64().is_some_and(|rate| rate > 0.0), "{stats}");
    if cfg!(target_os = "linux") {
        assert!(stats["peak_memory_bytes"].take().as_u64().is_some_and(|bytes| bytes > 1 << 20), "{stats}");
    }
    assert_eq!(stats["version"].take(), json!(env!("CARGO_PKG_VERSION")));
    assert!(stats["plan"]["used"].take().as_array().is_some_and(|used| used.contains(&json!("3 spheres"))));
    assert_eq!(stats["plan"]["left_out"].take()["triangles"], json!("the scene has none"));
    for part in ["plan", "rays", "shading", "seconds", "mega_rays_per_second"] {
        blank_numbers(&mut stats[part]);
    }
    let text = serde_json::to_string_pretty(&stats).expect("JSON");
    insta::assert_snapshot!(text);
}

#[test]
fn brute_force_tests_every_ray_against_every_primitive() {
    let place = Workplace::with(
        "scene.ron",
        "(film: (size: (20, 10)), settings: (spp: 4), nodes: [
            (shape: sphere()), (shape: sphere(center: (3, 0, 0))), (shape: sphere(center: (0, 3, 0))),
        ])",
    );
    let stats = stats(&place, "--accel linear");
    let primary = &stats["rays"]["primary"];
    assert_eq!(primary["rays"], json!(20 * 10 * 4));
    assert_eq!(primary["primitive_tests"], json!(20 * 10 * 4 * 3));
    assert_eq!(stats["samples"], json!(20 * 10 * 4));
}

#[test]
fn totals_are_sums_and_counts_are_the_same_in_every_run() {
    let place = Workplace::with_scene();
    let (one, three) = (stats(&place, "--threads 1"), stats(&place, "--threads 3"));
    assert_eq!(one["rays"], three["rays"]);
    assert_eq!(one["shading"], three["shading"]);
    for count in ["rays", "nodes", "primitive_tests", "hits"] {
        let of = |kind: &str| one["rays"][kind][count].as_u64().expect("a count");
        let kinds = ["primary", "shadow", "reflection", "refraction", "diffuse"];
        assert_eq!(of("total"), kinds.into_iter().map(of).sum::<u64>(), "{count}");
    }
}

#[test]
fn the_table_lists_the_rays_of_the_file() {
    let place = Workplace::with_scene();
    let run = place.succeed("render scene.ron --stats stats.json -v");
    let stats = place.json("stats.json");
    let row = |kind: &str| {
        let line = run.stdout.lines().find(|line| line.trim_start().starts_with(kind)).expect("a row");
        line.split_whitespace().nth(1).expect("a count").replace(',', "").parse::<u64>().expect("a number")
    };
    for kind in ["primary", "shadow", "reflection", "refraction", "total"] {
        assert_eq!(json!(row(kind)), stats["rays"][kind]["rays"], "{kind}");
    }
    assert!(run.stdout.contains("tests/ray"));
    assert!(!place.succeed("render scene.ron -v").stdout.contains("tests/ray"), "uncounted costs are not shown");
    assert!(run.stdout.contains("left out of the plan: "), "{run:?}");
}
