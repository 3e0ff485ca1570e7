//! Stop rules and error estimates.

use std::time::Instant;

use serde_json::Value;

use crate::program::Workplace;

#[test]
fn time_ends_a_heavy_render_and_the_image_is_whole() {
    let place = Workplace::with_scene();
    let started = Instant::now();
    let run = place.succeed("render scene.ron --size 96x64 --depth 8 --time 500ms -o a.exr --stats stats.json");
    let wall = started.elapsed().as_secs_f64();
    assert!(run.stdout.contains("stopped by --time; relative RMSE "), "{run:?}");
    let run = place.succeed("render scene.ron --size 96x64 --depth 8 --time 1ms -o b.exr");
    assert!(run.stdout.contains("no error estimate: needs at least two passes (allow more --time)"), "{run:?}");
    let stats = place.json("stats.json");
    let seconds = stats["seconds"]["render"].as_f64().expect("a number");
    // Passes have 16 samples or fewer; twice a pass, because other programs may slow the last one down.
    let samples = stats["pixel_samples"]["max"].as_f64().expect("a number");
    let pass = seconds * (16.0 / samples).min(1.0);
    assert!(seconds < 0.525 + 2.0 * pass && wall >= seconds, "{seconds} s with passes of {pass} s");
    let film = place.film("a.exr");
    assert!(film.pixels().iter().all(|pixel| pixel.iter().sum::<f32>() > 0.0), "a pixel is missing");
}

#[test]
fn a_target_is_reached_or_not_and_says_so() {
    let place = Workplace::with_scene();
    let run = place.succeed("render scene.ron --target-error 90% --stats stats.json");
    assert!(run.stdout.contains("stopped by --target-error 90 %; relative RMSE "), "{run:?}");
    assert_eq!(
        (&place.json("stats.json")["stopped"], &place.json("stats.json")["unconverged_pixels"]),
        (&"target-error".into(), &Value::Null)
    );
    let run = place.succeed("render scene.ron --target-error 90% --target-error-pixels 100% --stats stats.json");
    assert!(run.stdout.contains("stopped by --target-error 90 % in 100 % of the pixels; relative RMSE "), "{run:?}");
    assert_eq!(
        (&place.json("stats.json")["stopped"], &place.json("stats.json")["unconverged_pixels"]),
        (&"target-error".into(), &0.into())
    );
    let strict = "render scene.ron --target-error 1% --target-error-pixels 99% --spp 64 --two-stage";
    let run = place.succeed(strict);
    let cap = "stopped by the cap of 64 samples per pixel (--spp): 1 % is not reached";
    assert!(run.stdout.contains(&format!("{cap} in ")), "{run:?}");
    let run = place.succeed("render scene.ron --target-error 0.01% --spp 64");
    assert!(run.stdout.contains(&format!("{cap}; relative RMSE ").replace("1 %", "0.01 %")), "{run:?}");
}

#[test]
fn a_target_has_a_cap_that_is_named() {
    let place = Workplace::with_scene();
    let run = place.succeed("render scene.ron --target-error 0.0001% --crop 20,12,4,4 --stats stats.json");
    let cap = "stopped by the cap of 4096 samples per pixel (--spp): 0.0001 % is not reached; relative RMSE ";
    assert!(run.stdout.contains(cap), "{run:?}");
    assert_eq!(place.json("stats.json")["pixel_samples"]["max"], 4096);
    assert_eq!(place.json("stats.json")["settings"]["samples_per_pixel"], 4096);
}

#[test]
fn the_worst_pixel_of_the_cornell_box_does_not_decide() {
    let place = Workplace::with_scene();
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/lecture/cornell.ron");
    let run = place.succeed(&format!("render {scene} --size 32x32 --target-error 5% --stats stats.json"));
    let stats = place.json("stats.json");
    let reached = stats["estimated_error"]["relative_rmse"].as_f64().expect("a number");
    assert!((0.03..=0.05).contains(&reached), "{reached}: {run:?}");
    let samples = stats["pixel_samples"]["max"].as_u64().expect("a number");
    assert!(samples <= 1024, "{samples} samples per pixel: {run:?}");
}

#[test]
fn statistics_are_two_lines_unless_verbose() {
    let place = Workplace::with_scene();
    let lines = |options: &str| {
        let run = place.succeed(&format!("render scene.ron {options}"));
        run.stdout.lines().map(str::to_owned).collect::<Vec<_>>()
    };
    for options in ["", "--spp 16 --passes 4", "--integrator path --clamp 3", "--time 100ms", "--target-error 50%"] {
        let lines = lines(options);
        assert_eq!(lines.len(), 2, "{options}: {lines:?}");
        assert!(lines[0].starts_with("wrote scene.png (48x32, ") && lines[0].ends_with(" Mrays/s"), "{lines:?}");
    }
    let noted = lines("--sampler jittered --spp 5");
    assert!(noted.len() == 3 && noted[0].starts_with("note: 9 samples per pixel"), "{noted:?}");
    for option in ["-v", "--verbose"] {
        let all = lines(option);
        let has = |text: &str| all.iter().any(|line| line.contains(text));
        assert!(has("primary") && has("load ") && has(" Mrays/s on ") && has("left out of the plan: "), "{all:?}");
        assert!(all[all.len() - 2].starts_with("wrote scene.png (48x32, "), "{all:?}");
    }
}

#[test]
fn clamping_is_said_to_be_biased_and_counted() {
    let place = Workplace::with("room.ron", INTERIOR);
    place.prints("render room.ron --clamp 0.02 --stats stats.json", "; biased: clamping to 0.02 reduced ");
    let clamping = &place.json("stats.json")["clamping"];
    assert!(clamping["contributions"].as_u64().is_some_and(|count| count > 0), "{clamping}");
    assert!(clamping["lost_share"].as_f64().is_some_and(|share| share > 0.0 && share < 1.0), "{clamping}");
    place.prints("explain room.ron --clamp 0.02", "indirect light clamped to 0.02 (biased)");
    let run = place.succeed("render room.ron --stats stats.json");
    assert!(!run.stdout.contains("biased"), "{run:?}");
    assert_eq!(place.json("stats.json")["clamping"], Value::Null);
    place.prints("render room.ron --integrator direct --clamp 0.02", "note: --clamp has no effect: ");
}

/// Closed room with a small light.
const INTERIOR: &str = r#"(
    camera: (look_from: (0, 1, 3.9), look_at: (0, 1, 0), fov: 60),
    film: (size: (24, 18)),
    settings: (integrator: path),
    lights: [],
    materials: { "white": diffuse(albedo: gray(0.7)), "lamp": light(radiance: gray(50)) },
    nodes: [
        (shape: box(min: (-2, 0, -2), max: (2, 3, 4)), material: "white"),
        (shape: disk(radius: 0.2), transform: [rotate_x(180), translate(-1, 2.9, 0)], material: "lamp"),
    ],
)"#;

#[test]
fn shares_of_pixels_need_an_error() {
    let place = Workplace::with_scene();
    for options in ["--target-error-pixels 99%", "--target-error 1% --target-error-pixels 101%"] {
        let run = place.run(&format!("render scene.ron {options}"));
        assert_eq!(run.code, Some(2), "{options}: {run:?}");
    }
}

#[test]
fn the_error_is_estimated_where_there_are_passes() {
    let place = Workplace::with_scene();
    place.prints("render scene.ron", "no error estimate: needs at least two passes (try --passes 4)");
    place.prints("render scene.ron --spp 16 --passes 4 --stats stats.json", "relative RMSE ");
    let error = &place.json("stats.json")["estimated_error"];
    let number = |value: &Value| value.as_f64().expect("a number");
    let [low, high] = [0, 1].map(|end| number(&error["rmse_interval"][end]));
    assert!(0.0 < low && low < number(&error["rmse"]) && number(&error["rmse"]) < high, "{error}");
    place.prints("render scene.ron --sampler grid --passes 2", "grid samples are the same in every pass");
    place.prints("render scene.ron --sampler half-jittered --passes 2", "the bias of half-jittered samples adds to it");
}

#[test]
fn standard_errors_and_sample_counts_are_written() {
    let place = Workplace::with_scene();
    place.succeed("render scene.ron --spp 16 --passes 4 --aov stderr=error.exr --aov samples=count.pfm");
    assert!(place.film("count.pfm").pixels().iter().all(|count| *count == [16.0; 3]));
    let error = place.film("error.exr");
    assert_eq!((error.width(), error.height()), (48, 32));
    let largest = error.pixels().as_flattened().iter().copied().fold(0.0, f32::max);
    assert!(largest > 0.01 && largest < 1.0, "{largest}");
    let run = place.succeed(
        "render scene.ron --adaptive object-space --min-spp 2 --spp 16 --aov samples=count.pfm --stats stats.json -v",
    );
    let counts = place.film("count.pfm");
    let few = counts.pixels().iter().filter(|count| **count == [2.0; 3]).count();
    let all = counts.pixels().iter().filter(|count| **count == [16.0; 3]).count();
    assert!(few > 0 && all > 0 && few + all == counts.pixels().len(), "{few} and {all}");
    assert_eq!(place.json("stats.json")["simple_pixels"], few);
    assert!(run.stdout.contains(" of the pixels show no edge and took 2 samples"), "{run:?}");
    place.succeed("render scene.ron --target-error 20% --target-error-pixels 100% --spp 256 --aov samples=count.png");
    let shown = place.film("count.png");
    let white = shown.pixels().iter().filter(|pixel| **pixel == [1.0; 3]).count();
    assert!(white > 0 && white < shown.pixels().len(), "{white} pixels have most samples");
}
