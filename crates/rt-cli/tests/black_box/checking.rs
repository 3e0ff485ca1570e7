//! Reports on the health of scenes.

use std::path::Path;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::program::{Run, Workplace};

/// A little of everything that can be wrong with a scene that renders.
const SICK: &str = r#"(
    name: "sick",
    camera: (look_from: (0, 2, 8), look_at: (0, 1, 0), fov: 40),
    film: (size: (48, 32)),
    lights: [
        point(position: (3, 0.5, 0), intensity: gray(1)),
        point(position: (0, 1e9, 0), intensity: gray(1)),
    ],
    materials: {
        "red": phong(color: rgb(0.9, 0.1, 0.1)),
        "shiny": phong(diffuse: gray(0.9), specular: gray(0.9), exponent: 4),
        "glass": phong(diffuse: gray(0), transmission: gray(0.9), ior: 1.5, fresnel: true),
    },
    nodes: [
        (shape: plane(), material: "shiny"),
        (name: "sunk", shape: box(min: (-4, -1, 0), max: (-3, 0, 1)), material: "red"),
        (name: "bulb", shape: sphere(center: (3, 0.5, 0), radius: 0.5), material: "red"),
        (name: "pane", shape: triangle((-1, 0.1, 1), (1, 0.1, 1), (0, 2, 1)), material: "glass"),
        (name: "speck", shape: sphere(center: (0, 3, 0), radius: 1e-9)),
        (name: "needle", transform: [stretch(1e-7, 1, 1)], shape: sphere(center: (0, 1, 2), radius: 0.5)),
        (name: "mirrored", transform: [stretch(-1, 1, 1)], shape: sphere(center: (2, 1, -2), radius: 0.5)),
    ],
)"#;

fn report(place: &Workplace, arguments: &str) -> Value {
    let run = place.succeed(&format!("check {arguments} --format json"));
    serde_json::from_str(&run.stdout).unwrap_or_else(|error| panic!("{error}: {}", run.stdout))
}

#[test]
fn a_sick_scene_is_reported_as_text() {
    let place = Workplace::with("sick.ron", SICK);
    let Run { stdout, stderr, .. } = place.succeed("check sick.ron");
    assert_eq!(stderr, "");
    insta::assert_snapshot!("sick_text", stdout);
}

#[test]
fn a_sick_scene_is_reported_as_json() {
    let place = Workplace::with("sick.ron", SICK);
    let mut report = report(&place, "sick.ron");
    assert_eq!(report["version"].take(), json!(env!("CARGO_PKG_VERSION")));
    insta::assert_snapshot!("sick_json", serde_json::to_string_pretty(&report).expect("JSON"));
}

#[test]
fn only_strict_reports_fail() {
    let place = Workplace::with_scene();
    place.write("sick.ron", SICK);
    place.succeed("check scene.ron --strict");
    let strict = place.run("check sick.ron --strict");
    assert_eq!(strict.code, Some(3), "{strict:?}");
    assert!(strict.stdout.ends_with(" notes\n"), "the report is printed all the same: {strict:?}");
    assert!(strict.stderr.starts_with("error: sick.ron: "), "{strict:?}");
    assert_eq!(place.run("check sick.ron --format yaml").code, Some(2));
    assert_eq!(place.run("check missing.ron").code, Some(3));
    assert_eq!(place.files(), ["scene.ron", "sick.ron"]);
}

#[test]
fn repairs_of_the_loader_are_found() {
    let place = Workplace::with("flat.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nf 1 2 3\nf 1 2 4\n");
    let report = report(&place, "flat.obj");
    let findings = report["findings"].as_array().expect("a list");
    let fixed = findings.iter().find(|finding| finding["kind"] == "load-warning").expect("it is listed");
    assert!(
        fixed["message"].as_str().is_some_and(|text| text == "triangles without area were dropped: 1 of 2"),
        "{fixed}"
    );
    assert_eq!(report["warnings"], json!(1), "{report}");
}

/// Lights of the list `lights` in the plane of a ceiling were not found.
#[test]
fn area_lights_in_the_plane_of_a_ceiling_are_found() {
    const CEILING: &str = r#"(
        camera: (look_from: (0, 0.5, 3), look_at: (0, 0.5, 0)),
        lights: [
            quad(corner: (-0.2, HEIGHT, -0.2), edges: ((0.4, 0, 0), (0, 0, 0.4)), radiance: 5),
            disk(center: (0.6, HEIGHT, 0), normal: (0, -1, 0), radius: 0.1, radiance: 3),
        ],
        nodes: [(transform: [translate(0, 1, 0)], shape: rectangle(width: 2, depth: 2))],
    )"#;
    let place = Workplace::new();
    for (height, expected) in [("1", 2), ("0.999", 0)] {
        place.write("room.ron", CEILING.replace("HEIGHT", height));
        let report = report(&place, "room.ron");
        assert_eq!(report["warnings"], json!(expected), "{report}");
    }
}

#[test]
fn dark_scenes_and_enclosed_emitters_are_found() {
    let scene = |nodes: &str| format!("(lights: [], settings: (integrator: path), nodes: [{nodes}])");
    let solid = "(shape: box(min: (-1, -1, -1), max: (1, 1, 1)))";
    let emitter = "(shape: sphere(radius: 0.3), material: light(radiance: 3))";
    let place = Workplace::new();
    for (nodes, kind) in [(solid.to_owned(), "unlit"), (format!("{solid}, {emitter}"), "light-enclosed")] {
        place.write("dark.ron", scene(&nodes));
        let report = report(&place, "dark.ron");
        let kinds: Vec<&Value> = report["findings"].as_array().expect("a list").iter().map(|f| &f["kind"]).collect();
        assert_eq!(kinds, [kind], "{report}");
    }
}

/// The prediction for a check was that for a render.
#[test]
fn the_memory_of_the_check_counts() {
    let side = 200;
    let point = |i: i32| format!("v {} 0 {}\n", i % (side + 1), i / (side + 1));
    let face = |i: i32| {
        let a = i / side * (side + 1) + i % side + 1;
        format!("f {a} {} {} {}\n", a + side + 1, a + side + 2, a + 1)
    };
    let points: String = (0..(side + 1) * (side + 1)).map(point).collect();
    let faces: String = (0..side * side).map(face).collect();
    let place = Workplace::with("sheet.obj", points + &faces);
    place.fails(3, "check sheet.obj --memory 25MiB", "for the lists of objects, faces and edges of the check");
    place.succeed("explain sheet.obj --memory 25MiB");
    place.succeed("check sheet.obj --memory 40MiB");
}

#[test]
fn every_scene_has_a_report() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut files = rt_tests::files_below(&root.join("scenes"), &["ron"]);
    assert!(files.len() >= 13, "{files:?}");
    let models = rt_tests::shared_or_skip("data");
    if let Some(models) = &models {
        files.extend(rt_tests::files_below(models, &["obj", "gltf", "glb"]));
    }
    let place = Workplace::new();
    for file in files {
        let started = Instant::now();
        let mut command = place.command("check --format json");
        let output = command.arg(&file).output().expect("it starts");
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(started.elapsed() < Duration::from_secs(60), "{} takes too long", file.display());
        assert!(!stderr.contains("panicked"), "{}: {stderr}", file.display());
        // Models that are broken on purpose are refused when they are loaded.
        if output.status.code() == Some(3) {
            assert!(models.as_ref().is_some_and(|models| file.starts_with(models)), "{}: {stderr}", file.display());
            continue;
        }
        assert_eq!(output.status.code(), Some(0), "{}: {stderr}", file.display());
        let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        assert_eq!(report["errors"], json!(0), "{}: {report}", file.display());
    }
}

#[test]
fn an_animated_gltf_file_without_a_time_is_in_its_rest_pose() {
    let place = Workplace::with_animated_model();
    for command in ["render m.gltf --size 8x6", "explain m.gltf", "check m.gltf"] {
        let run = place.succeed(&format!("{command} --strict"));
        assert!(
            command.starts_with("check") || run.stdout.contains("is animated: it is shown in its rest pose"),
            "{run:?}"
        );
    }
    place.succeed("render m.gltf --size 8x6 --at-time 0.5 --strict");
}
