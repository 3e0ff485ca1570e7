//! `converge`: error against run time.

use std::fmt::Write;

use rt_image::Image;
use serde_json::Value;

use crate::program::{Run, Workplace, signal, wait_until};

/// Edges and a smooth area: half of the pixels are noisy.
const SCENE: &str = r#"(
    camera: (look_from: (0, 0, 6), look_at: (0, 0, 0), fov: 30),
    film: (size: (16, 12)),
    background: constant(gray(0.1)),
    lights: [point(position: (-4, 6, 5), intensity: gray(0.8))],
    materials: { "red": phong(color: rgb(0.9, 0.3, 0.1)) },
    nodes: [
        (shape: sphere(), material: "red"),
        (transform: [rotate_z(20)], shape: box(min: (0.5, -2, -1), max: (2, 2, -0.5)), material: "red"),
    ],
)"#;

/// Image whose lower half is white: the mean is 1/2.
const HALF: &str = r#"(
    camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), orthographic: 2),
    film: (size: (5, 5)),
    truth: (mean: gray(0.5), note: "half of the image is white"),
    lights: [ambient(gray(1))],
    background: constant(gray(0)),
    materials: { "white": phong(ambient: gray(1), diffuse: gray(0)) },
    nodes: [(shape: box(min: (-9, -9, -1), max: (9, 0, 0)), material: "white")],
)"#;

fn place() -> Workplace {
    Workplace::with("edge.ron", SCENE)
}

/// JSON report of a successful run.
fn json(place: &Workplace, arguments: &str) -> Value {
    place.succeed(&format!("converge {arguments} -o out"));
    place.json("out/converge.json")
}

#[test]
fn slopes_are_those_of_the_samplers() {
    let place = place();
    let report = json(&place, "edge.ron --vary sampler=random,jittered,sobol --spp 16,64,256 --quiet");
    let slopes = report["methods"].as_array().expect("a list").iter().map(|method| {
        let interval = &method["slope_of_samples"];
        ["low", "mean", "high"].map(|end| interval[end].as_f64().expect("a number"))
    });
    let slopes: Vec<[f64; 3]> = slopes.collect();
    // Edges: −1/2, −3/4, −3/4 (Mitchell 1996); smooth parts of the image make the last two steeper.
    assert!((slopes[0][1] + 0.5).abs() < 0.05, "{slopes:?}");
    assert!((-1.1..-0.65).contains(&slopes[1][1]) && (-1.2..-0.65).contains(&slopes[2][1]), "{slopes:?}");
    assert!(slopes[1][2] < slopes[0][0] && slopes[2][2] < slopes[0][0], "{slopes:?}");
    let rmse = |method: usize| report["methods"][method]["points"][2]["rmse"].as_f64().expect("a number");
    assert!(rmse(2) < rmse(1) && rmse(1) < 0.5 * rmse(0), "{} {} {}", rmse(0), rmse(1), rmse(2));
    for method in 0..3 {
        for point in report["methods"][method]["points"].as_array().expect("a list") {
            let [bias, error] = ["bias", "bias_standard_error"].map(|name| point[name].as_f64().expect("a number"));
            assert!(bias.abs() < 6.0 * error, "{point}");
            assert_eq!(point["runs"].as_array().map(Vec::len), Some(8));
        }
    }
    assert_eq!(report["against"], "split");
    assert!(report["measured_against"].as_str().is_some_and(|text| text.contains("by whitted and halton")), "{report}");
}

#[test]
fn the_page_is_self_contained_and_all_files_are_written() {
    let place = place();
    let run = place.succeed("converge edge.ron --vary sampler=random,sobol --spp 1..4 --seeds 2");
    assert!(run.stdout.ends_with("wrote edge-converge\n"), "{run:?}");
    let files = ["csv", "json", "svg", "png", "html"]
        .map(|extension| place.read(&format!("edge-converge/converge.{extension}")));
    let page = std::str::from_utf8(&files[4]).expect("text");
    assert!(!page.contains("http") && !page.contains("url(") && !page.contains("<link") && !page.contains("@import"));
    // Two images of each method, the reference, and the errors of both methods on one scale.
    assert_eq!(page.matches("src=\"data:image/png;base64,").count(), 2 * 2 + 1 + 2);
    assert_eq!((page.matches("class=\"shown\"").count(), page.matches("class=\"scale\"").count()), (5, 1));
    for part in ["<svg", "id=\"slider\"", "type=\"range\"", "random, 4 spp", "sobol, 1 spp", "slope −1/2"] {
        assert!(page.contains(part), "{part}");
    }
    let csv = std::str::from_utf8(&files[0]).expect("text");
    assert_eq!(csv.lines().count(), 1 + 6, "{csv}");
    let plot = place.film("edge-converge/converge.png");
    let colour = |bytes: [u8; 3]| bytes.map(|byte| rt_image::Encoding::Srgb.decode(byte));
    // The legend is in the upper right corner; lines are wherever the times of so short runs put them.
    let (width, height) = (plot.width() as usize, plot.height() as usize);
    let outside = || {
        let numbered = plot.pixels().iter().enumerate();
        numbered.filter(|(at, _)| at / width > height / 6 || at % width < width * 4 / 5).map(|(_, pixel)| pixel)
    };
    for drawn in [[0, 114, 178], [213, 94, 0], [180, 0, 0]] {
        assert!(outside().filter(|pixel| **pixel == colour(drawn)).count() > 30, "{drawn:?}");
    }
    let folder = place.path("").display().to_string();
    for file in [page, csv, std::str::from_utf8(&files[1]).expect("text")] {
        assert!(!file.contains(&folder), "no absolute paths");
    }
}

#[test]
fn a_truth_is_measured_against() {
    let place = Workplace::with("half.ron", HALF);
    let report = json(&place, "half.ron --vary sampler=random,sobol --spp 4,64 --seeds 16 --quiet");
    assert_eq!((&report["against"], &report["floor"]), (&Value::from("truth"), &Value::Null));
    for method in report["methods"].as_array().expect("a list") {
        let points = method["points"].as_array().expect("a list");
        let rmse = |index: usize| points[index]["rmse"].as_f64().expect("a number");
        // Five pixels of 25 have an edge in their middle: σ = √(5/4) / 25 / √N if samples are random.
        if method["sampler"] == "random" {
            let expected = 1.25f64.sqrt() / 25.0 / 2.0;
            assert!((rmse(0) / expected - 1.0).abs() < 0.5 && (rmse(1) / expected * 4.0 - 1.0).abs() < 0.5, "{method}");
        }
        assert!(points.iter().all(|point| point["flip"].is_null()), "{method}");
    }
    // Another view, light or time is not that of the truth: lights and times were taken for the same.
    for options in ["--crop 0,0,2,2", "--lights studio", "--at-time 1", "--shutter 0,1"] {
        let report = json(&place, &format!("half.ron --spp 1 --seeds 2 {options} --quiet"));
        assert_eq!(report["against"], "split", "{options}");
    }
    let report = json(&place, "half.ron --spp 1 --seeds 2 --reference-kind split --quiet");
    assert_eq!(report["against"], "split");
    // A given image was ignored.
    place.fails(3, "converge half.ron --spp 1 --seeds 2 --reference missing.exr", "missing.exr: ");
}

/// The mean of a square image was the truth of a wide one, which shows more.
#[test]
fn a_truth_is_not_that_of_an_image_with_another_aspect_ratio() {
    let place = Workplace::with("half.ron", HALF);
    for (size, against) in [("8x4", "split"), ("10x10", "truth")] {
        let report = json(&place, &format!("half.ron --spp 1 --seeds 2 --size {size} --quiet"));
        assert_eq!(report["against"], against, "{size}");
    }
    let said = "--reference-kind truth: the declared mean holds for the view, aspect ratio, lights and time";
    place.fails(2, "converge half.ron --spp 1 --seeds 2 --size 8x4 --reference-kind truth", said);
}

#[test]
fn a_reference_is_measured_against() {
    let place = place();
    place.succeed("render edge.ron --spp 1024 --sampler halton --seed 77 -o right.exr");
    place.succeed("render edge.ron --spp 1024 --sampler halton --seed 77 -o right.png");
    let rmse = |report: &Value, point: usize| report["methods"][0]["points"][point]["rmse"].as_f64().expect("a number");
    let split = json(&place, "edge.ron --spp 4,16 --quiet");
    let image = json(&place, "edge.ron --spp 4,16 --reference right.exr --quiet");
    assert_eq!((&image["against"], &image["floor"]), (&Value::from("reference"), &Value::Null));
    for point in 0..2 {
        assert!((rmse(&image, point) / rmse(&split, point) - 1.0).abs() < 0.02, "{image} {split}");
    }
    assert!(image["measured_against"].as_str().is_some_and(|text| text.starts_with("right.exr; its own error")));
    // Bytes are compared with bytes: the image equals itself.
    let same = "edge.ron --spp 1024 --seeds 2 --seed 77 --vary sampler=halton --reference right.png --quiet";
    let bytes = json(&place, same);
    let first = &bytes["methods"][0]["points"][0]["runs"][0];
    assert_eq!((&first["mse"], &bytes["methods"][0]["points"][0]["flip"]), (&Value::from(0.0), &Value::from(0.0)));
}

#[test]
fn results_are_reproducible_except_times() {
    let place = place();
    let errors = |arguments: &str| {
        let report = json(&place, &format!("edge.ron --vary accel=bvh,linear --spp 1,4 --seeds 2 --quiet {arguments}"));
        let points = report["methods"].as_array().expect("a list").iter().map(|method| {
            let points = method["points"].as_array().expect("a list").iter();
            points
                .map(|point| [point["rmse"].clone(), point["bias"].clone(), point["flip"].clone()])
                .collect::<Vec<_>>()
        });
        points.collect::<Vec<_>>()
    };
    let one = errors("--threads 1");
    assert_eq!(one, errors("--threads 3"));
    assert_eq!(one[0], one[1], "any accelerator gives the same image");
    assert_ne!(one, errors("--seed 9"));
}

#[test]
fn the_time_limit_reports_skipped_sample_counts() {
    let place = place();
    let started = std::time::Instant::now();
    let run = place.succeed("converge edge.ron --spp 1..1073741824 --seeds 2 --time 1s -o out");
    assert!(started.elapsed().as_secs_f64() < 30.0, "{run:?}");
    assert!(run.stdout.contains("the time limit skipped ") && run.stdout.contains("1073741824 samples"), "{run:?}");
    let report = place.json("out/converge.json");
    let points = report["methods"][0]["points"].as_array().expect("a list").len();
    let left_out = report["left_out"].as_array().expect("a list").len();
    assert!(points > 0 && points + left_out == 31, "{points} {left_out}");
}

#[test]
#[cfg(unix)]
fn an_interrupt_keeps_the_complete_sample_counts() {
    let place = Workplace::with("half.ron", HALF);
    // The last sample count takes hours.
    let child = place.spawn("converge half.ron --spp 4,16,1073741824 --seeds 2 --threads 1 -o out");
    wait_until("two sample counts", || {
        std::fs::read_to_string(place.path("out/converge.csv")).is_ok_and(|csv| csv.lines().count() == 3)
    });
    signal(&child, "INT");
    let run = Run::end(child);
    assert_eq!(run.code, Some(130), "{run:?}");
    assert_eq!(run.stderr, "error: interrupted after 2 of 3 sample counts; their results were written to out\n");
    assert!(run.stdout.contains("an interrupt skipped 1073741824 samples per pixel"), "{run:?}");
    assert_eq!(place.json("out/converge.json")["left_out"], serde_json::json!([1_073_741_824]));
    // Within the first sample count, and within the reference.
    for options in ["", "--reference-kind split"] {
        let child = place.spawn(&format!("converge half.ron --spp 1073741824 --seeds 2 --threads 1 -o none {options}"));
        wait_until("the directory", || place.path("none").exists());
        std::thread::sleep(std::time::Duration::from_millis(300));
        signal(&child, "INT");
        let run = Run::end(child);
        let expected = "error: interrupted after 0 of 1 sample counts; nothing was written\n";
        assert_eq!((run.code, run.stderr.as_str()), (Some(130), expected), "{run:?}");
        assert!(!place.path("none").exists());
    }
}

/// Report without values that depend on times.
fn without_times(run: &Run) -> String {
    let mut text = String::new();
    for line in run.stdout.lines().filter(|line| !line.contains("rustc")) {
        let mut words: Vec<&str> = line.split_whitespace().collect();
        let count = words.len();
        if line.contains('±') {
            // After method, depth and samples per pixel.
            (words[4], words[count - 1]) = ("SECONDS", "EFFICIENCY");
        } else if line.contains(" .. ") {
            words.splice(count - 5.., ["SLOPE", "BY", "SECONDS"]);
        }
        writeln!(text, "{}", words.join(" ")).expect("memory");
    }
    text
}

/// Each pass takes one sample at least.
#[test]
fn the_reference_has_64_times_the_samples_of_the_method_with_most_passes() {
    let report = json(&place(), "edge.ron --vary passes=2,4 --spp 2 --seeds 2 --quiet");
    let text = report["measured_against"].as_str().expect("a text");
    assert!(text.contains("of 128 samples per pixel each"), "{text}");
    assert!(text.ends_with("together 64 times the largest measured count of 4"), "{text}");
    let spp = |method: usize| report["methods"][method]["points"][0]["spp"].clone();
    assert_eq!((spp(0), spp(1)), (Value::from(2), Value::from(4)));
}

#[test]
fn tables_have_this_shape() {
    let run =
        place().succeed("converge edge.ron --vary sampler=random,sobol --vary depth=0,1 --spp 1,4,16 --threads 2");
    insta::assert_snapshot!("tables", without_times(&run));
}

#[test]
fn invalid_experiments_are_refused_before_rendering() {
    let place = place();
    place.write("broken.ron", "(nodes: [(shape: sphere(radius: -1))])");
    place.write("text.exr", "hello");
    place.write("file", "older");
    place.save("small.exr", &Image::new(4, 4, false));
    let said = place.refusals(
        "converge",
        &[
            (2, "edge.ron --vary sampelr=random"),
            (2, "edge.ron --vary sampler=random,jitered"),
            (2, "edge.ron --vary size=4x4,8x8"),
            (2, "edge.ron --vary sampler=random --vary sampler=sobol"),
            (2, "edge.ron --vary sampler=random --sampler sobol"),
            (2, "edge.ron --spp 8..4"),
            (2, "edge.ron --seeds 1"),
            (2, "edge.ron --reference-kind truth"),
            (2, "edge.ron --reference-kind reference"),
            (2, "edge.ron --target-rmse 0"),
            (2, "edge.ron --time soon"),
            (2, "edge.ron --crop 10,10,10,10"),
            (3, "missing.ron"),
            (3, "broken.ron"),
            (3, "edge.ron --reference missing.exr"),
            (3, "edge.ron --reference text.exr"),
            (3, "edge.ron --reference small.exr"),
            (2, "edge.ron -o -"),
            (4, "edge.ron -o file"),
            (4, "edge.ron -o missing/out"),
        ],
    );
    insta::assert_snapshot!("refused", said);
}

/// The missing file was reported first, and the option after it was found.
#[test]
fn wrong_options_are_reported_before_a_missing_scene() {
    let place = place();
    for options in [
        "--vary adaptive=on",
        "--vary adaptive",
        "--vary sampler=random --vary sampler=sobol",
        "--vary sampler=random --sampler sobol",
        "--reference-kind reference",
        "-o -",
    ] {
        let arguments = format!("converge missing.ron {options}");
        let run = place.run(&arguments);
        assert!(run.code == Some(2) && !run.stderr.contains("missing.ron"), "{options}: {run:?}");
    }
}
