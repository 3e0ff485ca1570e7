//! Images that show nothing.

use crate::program::{Run, Workplace};

fn render(scene: &str, options: &str) -> Run {
    let place = Workplace::with("a.ron", scene);
    let run = place.run(&format!("render a.ron -o a.png --size 16x12 {options}"));
    assert!(place.path("a.png").exists() || run.code != Some(0), "{run:?}");
    run
}

fn warnings(run: &Run) -> Vec<&str> {
    run.stderr.lines().filter(|line| line.starts_with("warning: ")).collect()
}

const SPHERE: &str = "nodes: [(shape: sphere())]";

#[test]
fn a_camera_that_looks_away_is_reported() {
    let away = format!("(camera: (look_from: (0, 0, 5), look_at: (0, 0, 9)), {SPHERE})");
    for options in ["", "--integrator path", "--integrator normals", "--env", "--background transparent"] {
        let options = if options == "--env" { "--background white" } else { options };
        let run = render(&away, options);
        let [warning] = warnings(&run)[..] else { panic!("{options}: {run:?}") };
        assert!(
            warning.contains("no camera ray hits an object") && warning.contains("--look-at 0,0,0 (the centre"),
            "{run:?}"
        );
        assert_eq!(run.code, Some(0));
        let strict = render(&away, &format!("{options} --strict"));
        assert!(strict.code == Some(5) && strict.stderr.contains("the image was written to a.png"), "{strict:?}");
    }
    // A part of an image may well show nothing, and the cost of nothing is worth an image.
    for options in ["--crop 0,0,2,2", "--integrator cost"] {
        assert!(warnings(&render(&away, options)).is_empty(), "{options}");
    }
}

/// The warning was that the camera looks away.
#[test]
fn a_camera_that_looks_at_surfaces_without_hits_is_reported() {
    let triangle = |material: &str| {
        r#"{"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "scene": 0, "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
            "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36, "uri": "m.bin"}],
            "materials": [MATERIAL]}"#
            .replace("MATERIAL", material)
    };
    let clear = r#"{"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0]}}"#;
    for (material, z) in [("{}", -5), (clear, 5)] {
        let place = Workplace::with("m.gltf", triangle(material));
        let corners: [f32; 9] = [0., 0., 0., 1., 0., 0., 0., 1., 0.];
        place.write("m.bin", corners.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<_>>());
        let run = |look_at: &str| {
            let camera = format!("--look-from 0.5,0.5,{z} --look-at {look_at}");
            place.run(&format!("render m.gltf -o a.png --size 16x12 --spp 1 {camera}"))
        };
        let seen = run("0.25,0.5,0");
        assert!(seen.stderr.contains("backs of single-sided materials and an alpha of 0"), "{seen:?}");
        let away = run("0.5,5,0");
        assert!(away.stderr.contains("the camera probably looks away"), "{away:?}");
    }
}

#[test]
fn the_centre_of_a_small_scene_has_enough_digits() {
    let nodes = "nodes: [(shape: sphere(center: (3e-5, 0, 0), radius: 1e-5))]";
    let run = render(&format!("(camera: (look_from: (0, 0, 5), look_at: (0, 0, 9)), {nodes})"), "");
    assert!(run.stderr.contains("try --look-at 3.000e-5,0,0 (the centre of the scene)"), "{run:?}");
}

#[test]
fn a_scene_without_objects_is_reported() {
    let run = render("(nodes: [])", "");
    let [warning] = warnings(&run)[..] else { panic!("{run:?}") };
    assert!(warning.contains("the scene has no objects"), "{run:?}");
}

#[test]
fn a_scene_without_light_is_reported_before_it_is_rendered() {
    let dark = format!("(camera: (look_from: (0, 0, 5)), lights: [], background: constant(gray(0)), {SPHERE})");
    for integrator in ["whitted", "path", "direct"] {
        let run = render(&dark, &format!("--integrator {integrator}"));
        let [warning] = warnings(&run)[..] else { panic!("{integrator}: {run:?}") };
        assert!(warning.contains("the scene has no light"), "{run:?}");
        assert_eq!(run.code, Some(0));
        assert_eq!(render(&dark, &format!("--integrator {integrator} --strict")).code, Some(3));
    }
    for options in [
        "--integrator normals",
        "--integrator depth",
        "--integrator ambient-occlusion",
        "--background white --integrator path",
    ] {
        assert!(warnings(&render(&dark, options)).is_empty(), "{options}: {:?}", render(&dark, options));
    }
}

#[test]
fn a_black_image_of_a_lit_scene_is_reported() {
    let behind = format!(
        "(camera: (look_from: (0, 0, 5), fov: 10), background: constant(gray(0)), \
          lights: [point(position: (0, 0, -5), intensity: gray(1))], {SPHERE})"
    );
    let run = render(&behind, "");
    let [warning] = warnings(&run)[..] else { panic!("{run:?}") };
    assert!(warning.contains("the image is black: no light reaches the visible surfaces"), "{run:?}");
    let lit = behind.replace("(0, 0, -5)", "(0, 0, 5)");
    assert!(warnings(&render(&lit, "")).is_empty());
    let run = render(&lit, "--exposure -30");
    let [warning] = warnings(&run)[..] else { panic!("{run:?}") };
    assert!(warning.contains("raise --exposure"), "{run:?}");
    assert!(warnings(&render(&behind, "--quiet")).is_empty());
}

/// The light is there: its samples are beyond `f32`.
#[test]
fn an_image_that_is_black_because_of_bad_samples_is_not_called_unlit() {
    for scene in [
        "(nodes: [(shape: sphere(), material: diffuse(emission: 1e60))])",
        "(nodes: [(shape: sphere())], lights: [quad(corner: (-9, 8, -9), edges: ((0, 0, 18), (18, 0, 0)), radiance: 1e60)])",
    ] {
        let run = render(scene, "--integrator path --background black");
        let [warning] = warnings(&run)[..] else { panic!("{run:?}") };
        assert!(warning.contains("samples were NaN, infinite or negative"), "{run:?}");
    }
}

#[test]
fn area_lights_that_whitted_does_not_sample_are_named() {
    let scene = "(camera: (look_from: (0, 0, 5)), lights: [quad(corner: (-9, 8, -9), edges: ((0, 0, 1), (1, 0, 0)))], background: constant(0), \
                 nodes: [(shape: sphere())])";
    let place = Workplace::with("scene.ron", scene);
    let note = "note: `whitted` takes no light from area lights: use `distributed` or `path`, or --lights studio.\n";
    let run = place.run("render scene.ron --size 8x8 --spp 1 --integrator whitted");
    assert!(run.stdout.contains(note), "{run:?}");
    assert_eq!(
        warnings(&run),
        ["warning: the image is black: `whitted` samples no area lights; use `distributed` or `path`"]
    );
    let run = place.run("explain scene.ron --integrator whitted");
    assert!(run.stdout.contains("the scene has no point, spot or directional light"), "{run:?}");
    let run = place.run("render scene.ron --size 8x8 --spp 1 --integrator direct");
    assert!(!run.stdout.contains(note), "{run:?}");
}

#[test]
fn a_background_lights_nothing_under_whitted() {
    let place = Workplace::with("scene.ron", "(background: constant(0.5), lights: [], nodes: [(shape: sphere())])");
    let run = place.run("render scene.ron --size 8x8 --spp 1 --integrator whitted");
    assert!(run.stderr.contains("light"), "{run:?}");
    let run = place.run("render scene.ron --size 8x8 --spp 1 --integrator path");
    assert!(!run.stderr.contains("warning"), "{run:?}");
}
