//! Renders that end by time or by error, and what they tell of it.

use std::time::Instant;

use serde_json::Value;

use crate::program::Workplace;

fn stats(place: &Workplace) -> Value {
    serde_json::from_slice(&place.read("stats.json")).expect("JSON")
}

#[test]
fn time_ends_a_heavy_render_and_the_picture_is_whole() {
    let place = Workplace::with_scene();
    let started = Instant::now();
    let run = place.succeed("render scene.ron --size 96x64 --depth 8 --time 500ms -o a.exr --stats stats.json");
    let wall = started.elapsed().as_secs_f64();
    assert!(run.stdout.contains("stopped by --time after "), "{run:?}");
    let stats = stats(&place);
    let seconds = stats["seconds"]["render"].as_f64().expect("a number");
    // Passes have 16 samples or fewer; twice a pass, because other programs may slow the last one down.
    let samples = stats["pixel_samples"]["most"].as_f64().expect("a number");
    let pass = seconds * (16.0 / samples).min(1.0);
    assert!(seconds < 0.525 + 2.0 * pass && wall >= seconds, "{seconds} s with passes of {pass} s");
    let film = place.film("a.exr");
    assert!(film.pixels().iter().all(|pixel| pixel.iter().sum::<f32>() > 0.0), "a pixel is missing");
}

#[test]
fn a_target_is_reached_or_not_and_says_so() {
    let place = Workplace::with_scene();
    let run = place.succeed("render scene.ron --target-error 90% --stats stats.json");
    assert!(run.stdout.contains("stopped by --target-error after"), "{run:?}");
    assert_eq!((&stats(&place)["stopped"], &stats(&place)["unconverged_pixels"]), (&"target-error".into(), &0.into()));
    let run = place.succeed("render scene.ron --target-error 1% --spp 64 --two-stage");
    assert!(run.stdout.contains("stopped by --spp after 64 samples per pixel"), "{run:?}");
    assert!(run.stdout.contains("1 % is not reached in "), "{run:?}");
}

#[test]
fn the_error_is_estimated_where_there_are_passes() {
    let place = Workplace::with_scene();
    let run = place.succeed("render scene.ron");
    assert!(run.stdout.contains("error not estimated: one pass"), "{run:?}");
    let run = place.succeed("render scene.ron --spp 16 --passes 4 --stats stats.json");
    assert!(run.stdout.contains("estimated RMSE "), "{run:?}");
    let error = &stats(&place)["estimated_error"];
    let number = |value: &Value| value.as_f64().expect("a number");
    let [low, high] = [0, 1].map(|end| number(&error["rmse_interval"][end]));
    assert!(0.0 < low && low < number(&error["rmse"]) && number(&error["rmse"]) < high, "{error}");
    let run = place.succeed("render scene.ron --sampler grid --passes 2");
    assert!(run.stdout.contains("grid samples are the same in every pass"), "{run:?}");
    let run = place.succeed("render scene.ron --sampler half-jittered --passes 2");
    assert!(run.stdout.contains("the bias of half-jittered samples adds to it"), "{run:?}");
}

#[test]
fn standard_errors_and_sample_counts_are_written() {
    let place = Workplace::with_scene();
    place.succeed("render scene.ron --spp 16 --passes 4 --aov variance=error.exr --aov samples=count.pfm");
    assert!(place.film("count.pfm").pixels().iter().all(|count| *count == [16.0; 3]));
    let error = place.film("error.exr");
    assert_eq!((error.width(), error.height()), (48, 32));
    let largest = error.pixels().as_flattened().iter().copied().fold(0.0, f32::max);
    assert!(largest > 0.01 && largest < 1.0, "{largest}");
    let run = place.succeed(
        "render scene.ron --adaptive object-space --least 2 --spp 16 --aov samples=count.pfm --stats stats.json",
    );
    let counts = place.film("count.pfm");
    let few = counts.pixels().iter().filter(|count| **count == [2.0; 3]).count();
    let all = counts.pixels().iter().filter(|count| **count == [16.0; 3]).count();
    assert!(few > 0 && all > 0 && few + all == counts.pixels().len(), "{few} and {all}");
    assert_eq!(stats(&place)["simple_pixels"], few);
    assert!(run.stdout.contains(" of the pixels show no edge and took 2 samples"), "{run:?}");
    place.succeed("render scene.ron --target-error 20% --spp 256 --aov samples=count.png");
    let shown = place.film("count.png");
    let white = shown.pixels().iter().filter(|pixel| **pixel == [1.0; 3]).count();
    assert!(white > 0 && white < shown.pixels().len(), "{white} pixels have most samples");
}
