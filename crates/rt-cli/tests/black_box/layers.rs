//! Layers in one file, read back by the project and by OpenImageIO.

use std::process::Command;

use exr::prelude::{ReadChannels as _, ReadLayers as _, read};
use rt_tests::skip;

use crate::program::Workplace;

const CHANNELS: &str = "R, G, B, albedo.R, albedo.G, albedo.B, coverage.V, depth.Z, emission.R, emission.G, emission.B, \
    geometric_normal.X, geometric_normal.Y, geometric_normal.Z, instance_id.V, material_id.V, normal.X, normal.Y, normal.Z, \
    object_id.V, position.X, position.Y, position.Z, roughness.V, samples.V, stderr.R, stderr.G, stderr.B, uv.A, uv.U, uv.V";

/// Names by number, as OpenImageIO prints them.
const OBJECTS: &str = r#"objects: "[null,"ball"]""#;
const MATERIALS: &str = r#"materials: "[null,"red"]""#;

#[test]
fn layers_leave_the_image_alone_and_hold_it() {
    let place = Workplace::with_scene();
    for options in ["--spp 4", "--spp 8 --passes 2 --integrator path", "--crop 3,4,9,7 --integrator normals"] {
        place.succeed(&format!("render scene.ron {options} -o plain.exr"));
        place.succeed(&format!("render scene.ron {options} -o a.exr --aov all=layers.exr --aov depth,uv=few.exr"));
        assert_eq!(place.read("a.exr"), place.read("plain.exr"), "{options}");
        assert_eq!(place.film("layers.exr"), place.film("plain.exr"), "{options}");
        let layers = place.read("layers.exr");
        place.succeed(&format!("render scene.ron {options} -o a.exr --aov all=layers.exr --threads 1"));
        assert_eq!(place.read("layers.exr"), layers, "{options}");
        assert!(place.read("few.exr").len() < layers.len(), "{options}");
    }
}

#[test]
fn open_image_io_reads_names_values_and_attributes() {
    if Command::new("oiiotool").arg("--help").output().is_err() {
        return skip("oiiotool is not installed (Debian's openimageio-tools)");
    }
    let place = Workplace::with(
        "s.ron",
        "(camera: (look_from: (0, 0, 5), look_at: (0, 0, 0)), film: (size: (9, 9)),
          materials: {\"red\": diffuse(albedo: (0.75, 0.25, 0))},
          nodes: [(name: \"ball\", shape: sphere(), material: \"red\")])",
    );
    place.succeed("render s.ron --spp 4 --passes 2 --sampler jittered --seed 7 -o a.exr --aov all=layers.exr");
    let oiio = |arguments: &[&str]| {
        let output = Command::new("oiiotool").current_dir(place.path("")).args(arguments).output().expect("it runs");
        assert!(output.status.success(), "{output:?}");
        String::from_utf8(output.stdout).expect("text")
    };
    let info = oiio(&["--info", "-v", "layers.exr"]);
    assert!(info.contains("9 x    9, 31 channel, float openexr"), "{info}");
    assert!(info.contains(&format!("channel list: {CHANNELS}\n")), "{info}");
    for attribute in
        ["renderer: \"rt ", "scene: \"s\"", "seed: \"7\"", "spp: \"8\"", "sceneHash: \"", OBJECTS, MATERIALS]
    {
        assert!(info.contains(attribute), "{attribute}: {info}");
    }
    let channels = "depth.Z,albedo.R,albedo.G,material_id.V";
    let middle = oiio(&["layers.exr", "--ch", channels, "--cut", "1x1+4+4", "--printstats"]);
    let numbers = middle.lines().find_map(|line| line.trim().strip_prefix("Stats Min:")).expect("values");
    let numbers: Vec<f64> = numbers.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    let [depth, red, green, material] = numbers[..] else { panic!("four values: {middle}") };
    assert!((4.0..4.1).contains(&depth), "{middle}");
    assert_eq!((red, green, material), (0.75, 0.25, 1.0), "{middle}");
}

#[test]
fn a_single_pass_has_no_layer_of_standard_errors() {
    let place = Workplace::with_scene();
    for (passes, has_errors) in [(1, false), (2, true)] {
        place.succeed(&format!("render scene.ron --spp 4 --passes {passes} -o a.pfm --aov all=a.exr"));
        let reader = read().no_deep_data().largest_resolution_level().all_channels().all_layers().all_attributes();
        let file = reader.from_file(place.path("a.exr")).expect("an EXR file");
        let names = file.layer_data[0].channel_data.list.iter().map(|channel| channel.name.to_string());
        let all: Vec<_> = names.filter(|name| name.starts_with("stderr.") || name == "samples.V").collect();
        assert_eq!(all.len(), if has_errors { 4 } else { 1 }, "{passes} passes: {all:?}");
    }
}

#[test]
fn scenes_and_cameras_have_names_in_any_script() {
    let place = Workplace::with(
        "日本.ron",
        "(cameras: [(name: \"カメラ\", look_from: (0, 0, 5))], film: (size: (8, 8)), nodes: [(shape: sphere())])",
    );
    place.succeed("render 日本.ron -o a.png --aov depth=a.exr --stats a.json");
    assert_eq!(place.files(), ["a.exr", "a.json", "a.png", "日本.ron"]);
}

#[test]
fn layers_take_as_many_samples_as_a_render_that_stops_by_itself() {
    let place = Workplace::with(
        "s.ron",
        "(camera: (look_from: (0, 0, 5)), film: (size: (9, 9)), settings: (spp: 1), nodes: [(shape: sphere())])",
    );
    let has_partial_coverage = |options: &str| {
        place.succeed(&format!("render s.ron -o a.pfm {options} --aov coverage=a.exr"));
        let reader =
            read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
        let file = reader.from_file(place.path("a.exr")).expect("an OpenEXR file");
        let channels = &file.layer_data.channel_data.list;
        let coverage = channels.iter().find(|channel| channel.name.to_string() == "coverage.V").expect("a layer");
        coverage.sample_data.values_as_f32().any(|share| 0.0 < share && share < 1.0)
    };
    assert!(!has_partial_coverage(""), "one sample hits or misses");
    assert!(has_partial_coverage("--time 100ms"), "more samples than the scene asks for");
}

#[test]
fn layers_that_cannot_be_written_are_refused_at_once() {
    let place = Workplace::with_scene();
    let cases = [
        (2, "render scene.ron -o a.png --aov depth=a.png"),
        (2, "render scene.ron -o a.png --aov dept=a.exr"),
        (2, "render scene.ron -o a.png --spp 1 --integrator depth --aov stderr,depth=b.exr"),
        (2, "render scene.ron -o a.exr --aov depth=a.exr"),
        (2, "merge a.part -o a.exr --aov depth=b.exr"),
        (3, "render scene.ron -o a.exr --size 8000x8000 --memory 12GiB --integrator depth --spp 1 --aov all=b.exr"),
    ];
    for (code, arguments) in cases {
        let run = place.run(arguments);
        assert_eq!(run.code, Some(code), "{arguments}: {run:?}");
        assert!(["--aov", "a.exr", "b.exr"].iter().any(|word| run.stderr.contains(word)), "{run:?}");
    }
    assert_eq!(place.files(), ["scene.ron"]);
}
