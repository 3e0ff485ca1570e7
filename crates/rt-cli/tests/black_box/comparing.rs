//! `compare`: difference of two images.

use rt_image::{Development, Image};
use serde_json::{Value, json};

use crate::program::Workplace;

/// Two images of 16 by 12 pixels. In `a.exr`, a quarter of the pixels is brighter by 0.5 in red than in `b.exr`, and one is darker
/// by 1 in blue.
fn place_with_images() -> Workplace {
    let place = Workplace::new();
    let reference = film(|_, _| [0.5, 0.25, 2.0]);
    let test = film(|x, y| {
        let red = if x % 2 == 0 && y % 2 == 0 { 1.0 } else { 0.5 };
        [red, 0.25, if [x, y] == [7, 5] { 1.0 } else { 2.0 }]
    });
    place.save("a.exr", &test);
    place.save("b.exr", &reference);
    place
}

fn film(radiance: impl Fn(u32, u32) -> [f32; 3]) -> Image {
    let mut film = Image::new(16, 12, false);
    for (index, pixel) in (0..).zip(film.pixels_mut()) {
        *pixel = radiance(index % 16, index / 16);
    }
    film
}

fn report(place: &Workplace, arguments: &str) -> Value {
    let run = place.run(&format!("compare {arguments} --json"));
    serde_json::from_str(&run.stdout).unwrap_or_else(|error| panic!("{error}: {run:?}"))
}

#[test]
fn equal_images_are_equal_whatever_the_file() {
    let place = Workplace::with_scene();
    for name in ["p.exr", "p.pfm", "p.png"] {
        place.succeed(&format!("render scene.ron --exposure 0.5 -o {name}"));
    }
    place.succeed("compare p.exr p.pfm");
    place.succeed("compare p.png p.png");
    for pair in ["p.png p.exr", "p.pfm p.png"] {
        place.succeed(&format!("compare {pair} --exposure 0.5"));
        assert_eq!(place.run(&format!("compare {pair}")).code, Some(1), "developed otherwise");
    }
}

#[test]
fn cut_out_images_equal_their_radiance() {
    let place = Workplace::with("ball.ron", "(film: (size: (24, 16)), nodes: [(shape: sphere())])");
    for name in ["p.exr", "p.png"] {
        place.succeed(&format!("render ball.ron --background transparent -o {name}"));
    }
    place.succeed("compare p.png p.exr");
    place.succeed("compare p.exr p.png --metric coverage");
    place.succeed("render ball.ron --background black -o opaque.exr");
    let report = report(&place, "opaque.exr p.exr --metric coverage");
    assert_eq!((&report["metrics"]["coverage"], &report["different"]), (&json!(1.0), &json!(true)));
    // Regression: images with other coverage were equal.
    for metric in ["rmse", "psnr", "ssim", "flip"] {
        let command = format!("compare opaque.exr p.exr --metric {metric}");
        place.fails(1, &command, "coverage is 1.00000, the threshold is 0");
    }
    place.succeed("compare opaque.exr p.exr --threshold 0");
}

#[test]
fn the_table_has_this_shape() {
    let place = place_with_images();
    let run = place.run("compare a.exr b.exr --heat-map map.png");
    assert_eq!(run.code, Some(1), "{run:?}");
    insta::assert_snapshot!("table", format!("{}{}", run.stdout, run.stderr));
}

#[test]
fn metrics_have_their_closed_forms() {
    let place = place_with_images();
    let report = report(&place, "a.exr b.exr");
    let pixels = 192.0;
    let near = |value: &Value, expected: f64| {
        let value = value.as_f64().unwrap_or(f64::NAN);
        assert!((value - expected).abs() < 1e-12 * expected.abs().max(1.0), "{value} {expected}");
    };
    let (red, blue): (f64, f64) = (0.25 * 0.25, 1.0 / pixels);
    near(&report["channels"]["rmse"][0], red.sqrt());
    near(&report["channels"]["rmse"][1], 0.0);
    near(&report["channels"]["rmse"][2], f64::sqrt(blue));
    near(&report["metrics"]["rmse"], f64::sqrt((red + blue) / 3.0));
    near(&report["metrics"]["mae"], (0.125 + 1.0 / pixels) / 3.0);
    near(&report["metrics"]["bias"], (0.125 - 1.0 / pixels) / 3.0);
    near(&report["metrics"]["relmse"], (red / 0.26 + blue / 4.01) / 3.0);
    near(&report["metrics"]["max"], 1.0);
    let largest = json!({"pixel": [7, 5], "channel": "blue", "test": [0.5, 0.25, 1.0], "reference": [0.5, 0.25, 2.0]});
    assert_eq!(report["largest_difference"], largest);
    // Blue of 2 and of 1 look alike; red of 0.5 is a signal of 0.735.
    let signal = Development::default().signal(0.5);
    near(
        &report["metrics"]["psnr"],
        -10.0 * rt_math::transcendental::log(0.25 / 3.0 * (1.0 - signal) * (1.0 - signal)) / std::f64::consts::LN_10,
    );
    for seen in ["flip", "hdr-flip"] {
        let value = report["metrics"][seen].as_f64().expect("a number");
        assert!(value > 0.05 && value < 0.9, "{seen}: {value}");
    }
    assert_eq!((&report["width"], &report["height"], &report["different"]), (&json!(16), &json!(12), &json!(true)));
}

#[test]
fn every_metric_has_a_threshold() {
    let place = place_with_images();
    let report = report(&place, "a.exr b.exr");
    for (name, value) in report["metrics"].as_object().expect("by name") {
        if name == "coverage" {
            let refused = "--metric coverage requires an image with an alpha channel";
            place.fails(2, "compare a.exr b.exr --metric coverage", refused);
            continue;
        }
        let value = value.as_f64().expect("a number");
        let better_if_less = !["psnr", "ssim"].contains(&name.as_str());
        for (factor, worse) in [(0.999, better_if_less), (1.001, !better_if_less)] {
            let run = place.run(&format!("compare a.exr b.exr --metric {name} --threshold {}", value * factor));
            assert_eq!(run.code, Some(i32::from(worse)), "{name} times {factor}: {run:?}");
            assert_eq!(run.stderr.contains(&format!("differ: {name} is")), worse, "{run:?}");
        }
        assert_eq!(place.run(&format!("compare a.exr b.exr --metric {name}")).code, Some(1), "{name}");
        place.succeed(&format!("compare b.exr b.exr --metric {name}"));
    }
    place.succeed("compare a.exr b.exr --max-rmse 0.16");
    assert_eq!(place.run("compare a.exr b.exr --max-rmse 0.14").code, Some(1));
}

#[test]
fn heat_maps_have_the_colours_of_their_legend() {
    let place = place_with_images();
    let run = place.run("compare a.exr b.exr --heat-map map.png --heat-map-scale 1");
    assert!(run.stdout.contains("blue -1.00000 or less, white 0, red 1.00000 or more"), "{run:?}");
    let decode = |bytes: [u8; 3]| bytes.map(|byte| f64::from(rt_image::Encoding::Srgb.decode(byte)));
    let map = place.film("map.png");
    for (pixel, bytes) in [([1, 1], [247, 247, 247]), ([7, 5], [5, 113, 176]), ([2, 4], [244, 165, 130])] {
        assert_eq!(map.pixel(pixel[0], pixel[1]).map(rt_math::Rgb::to_array), Some(decode(bytes)), "{pixel:?}");
    }
    for of in ["flip", "hdr-flip"] {
        place.run(&format!("compare b.exr b.exr --heat-map map.png --heat-map-of {of}"));
        assert_eq!(place.film("map.png").pixel(3, 3).map(rt_math::Rgb::to_array), Some(decode([0, 0, 4])), "{of}");
        let run = place.run(&format!("compare a.exr b.exr --heat-map {of}.png --heat-map-of {of}"));
        assert!(run.stdout.contains("black 0, violet, orange, pale yellow 1.00000 or more"), "{run:?}");
        assert!(place.film(&format!("{of}.png")).pixel(2, 4).is_some_and(|colour| colour.r > 0.0), "{of}");
    }
}

/// The map was drawn before the metric was found to be undefined.
#[test]
fn an_undefined_metric_overwrites_no_heat_map() {
    let place = place_with_images();
    place.save("small.exr", &Image::new(8, 8, false));
    place.write("map.png", "an earlier map");
    for (pair, metric) in [("a.exr b.exr", "coverage"), ("small.exr small.exr", "ssim")] {
        for map in ["map.png", "new.png"] {
            let arguments = format!("compare {pair} --metric {metric} --heat-map {map}");
            place.fails(2, &arguments, &format!("--metric {metric} requires"));
        }
        assert_eq!(place.read("map.png"), b"an earlier map", "{metric}");
        assert!(!place.path("new.png").exists(), "{metric}");
    }
}

#[test]
fn non_finite_pixels_are_reported_and_differ() {
    let place = place_with_images();
    let broken = |value: f32| film(move |x, _| if x == 3 { [value, 0.0, 0.0] } else { [0.5; 3] });
    for (name, value) in [("nan.exr", f32::NAN), ("inf.exr", f32::INFINITY), ("sound.exr", 0.0)] {
        place.save(name, &broken(value));
    }
    place.prints("compare nan.exr nan.exr", "NaN or infinite pixels: 12 of A, 12 of B, 0 of them different");
    for pair in ["nan.exr inf.exr", "nan.exr sound.exr", "sound.exr inf.exr"] {
        place.fails(
            1,
            &format!("compare {pair} --threshold 1000"),
            "12 pixels are NaN or infinite in one image and different",
        );
        let report = report(&place, pair);
        assert_eq!((&report["differently_finite"], &report["metrics"]["rmse"]), (&json!(12), &json!(0.0)));
    }
    place.save("blind.exr", &film(|_, _| [f32::NAN; 3]));
    let blind = place.run("compare blind.exr sound.exr");
    assert_eq!((blind.code, blind.stdout.as_str()), (Some(3), ""), "{blind:?}");
}

#[test]
fn incomparable_images_are_refused() {
    let place = place_with_images();
    place.save("small.exr", &Image::new(4, 4, false));
    place.save("a.png", &film(|_, _| [0.5; 3]));
    place.write("text.png", "hello");
    let said = place.refusals(
        "compare",
        &[
            (2, "a.exr"),
            (2, "a.exr b.exr --metric mse"),
            (2, "a.exr b.exr --threshold nan"),
            (2, "a.exr b.exr --max-rmse 1 --threshold 1"),
            (2, "a.exr b.exr --heat-map map.exr"),
            (2, "a.exr b.exr --heat-map-scale 0 --heat-map map.png"),
            (2, "a.exr b.exr --pixels-per-degree 0"),
            (2, "a.png b.exr --metric hdr-flip"),
            (2, "a.png b.exr --heat-map map.png --heat-map-of hdr-flip"),
            (2, "small.exr small.exr --metric ssim"),
            (3, "a.exr small.exr"),
            (3, "a.exr missing.exr"),
            (3, "text.png a.exr"),
            (4, "a.exr b.exr --heat-map a.png/map.png"),
            (4, "a.png b.exr --heat-map a.png"),
        ],
    );
    insta::assert_snapshot!("refused", said);
}

/// The legend was "blue -0 or less, white 0, red 0 or more".
#[test]
fn the_heat_map_of_equal_images_is_white() {
    let run = place_with_images().succeed("compare b.exr b.exr --heat-map map.png");
    assert!(run.stdout.contains("white 0 everywhere") && !run.stdout.contains("-0 or less"), "{run:?}");
}

#[test]
fn negative_thresholds_of_errors_are_refused() {
    let place = place_with_images();
    let message = "--threshold -1: rmse is never negative; give a number from 0 up";
    let run = place.fails(2, "compare a.exr b.exr --threshold -1 --heat-map map.png", message);
    assert!(run.stdout.is_empty() && !place.path("map.png").exists());
    place.succeed("compare a.exr b.exr --metric psnr --threshold -1");
}

/// Regression: the alpha channel was left out of a JPEG without a word.
#[test]
fn transparent_images_are_not_developed_to_a_format_without_alpha() {
    let place = Workplace::with_scene();
    place.succeed("render scene.ron --background transparent -o clear.exr");
    place.fails(
        2,
        "develop clear.exr -o clear.jpg",
        "clear.jpg: an image with transparent pixels requires a .png file",
    );
    place.succeed("develop clear.exr -o clear.png");
    place.succeed("render scene.ron -o opaque.exr");
    place.succeed("develop opaque.exr -o opaque.jpg");
}
