//! Every bad input ends in a message that names the file, the place, the value and the rule.

use std::fs;
use std::path::Path;

use rt_scene_io::format::{parse_json, parse_ron};
use rt_scene_io::{LoadOptions, load, resolve};

fn error(ron: &str) -> String {
    let path = Path::new("scene.ron");
    match parse_ron(ron, path) {
        Err(error) => error.to_string(),
        Ok(file) => resolve(&file, path, &LoadOptions::default()).expect_err(ron).to_string(),
    }
}

fn errors(scenes: &[&str]) -> String {
    scenes.iter().map(|scene| format!("{scene}\n    {}\n", error(scene).replace('\n', "\n    "))).collect()
}

#[test]
fn syntax_and_names() {
    let text = errors(&[
        "",
        "()",
        "(nodes: 3)",
        "(nodes: [], film: (size: (-1, 3)))",
        "(nodes: [(shape: sphere(radius: 1,5))])",
        "(nodes: [], settings: (integrator: path-caustics))",
        "(nodes: [(shape: sphere(radius: 1.5)])",
        "(nodes: [(shape: sphere(radius: 1)),,])",
        "(nodes: [])) ",
        "(nodes: [(shape: sphere(center: (0, 0)))])",
        "(nodes: [(shape: sphere(raduis: 1))])",
        "(\n    nodse: [],\n)",
        "(nodes: [(shape: sphare(radius: 1))])",
        "(nodes: [], lights: [point(intensity: gray(1))])",
        "(nodes: [], materials: {\"a\": phong(), \"a\": phong()})",
        "(nodes: [], materials: {\"red\": phong()}, cameras: [(name: \"a\"), (name: \"a\")])",
        "(nodes: [(children: [(shape: sphere(), material: \"rad\")])], materials: {\"red\": phong(), \"gold\": phong()})",
        "(nodes: [(material: \"red\")])",
        "(nodes: [(instance: \"tre\")], groups: {\"tree\": [], \"house\": []})",
        "(nodes: [], groups: {\"a\": [(instance: \"b\")], \"b\": [(children: [(instance: \"a\")])]})",
        "(nodes: [(shape: sphere(), instance: \"a\")], groups: {\"a\": []})",
        "(nodes: [(instance: \"a\", material: \"m\")], groups: {\"a\": []}, materials: {\"m\": phong()})",
    ]);
    insta::assert_snapshot!(text);
}

#[test]
fn values() {
    let text = errors(&[
        "(nodes: [(shape: sphere(radius: 0))])",
        "(nodes: [(shape: sphere(radius: -1))])",
        "(nodes: [(shape: sphere(center: (NaN, 0, 0)))])",
        "(nodes: [(shape: sphere(center: (0, -inf, 0)))])",
        "(nodes: [(shape: sphere(center: (0, 0, 1e400)))])",
        "(nodes: [(shape: sphere(center: (0, 0, 2e60)))])",
        "(nodes: [(shape: box(min: (0, 1, 0), max: (1, 0, 1)))])",
        "(nodes: [(shape: cylinder(radius: 0))])",
        "(nodes: [(shape: cylinder(bottom: 1, top: 1))])",
        "(nodes: [(shape: cylinder(top: NaN))])",
        "(nodes: [(shape: infinite_cylinder(radius: -1))])",
        "(nodes: [(shape: double_cone(slope: 0))])",
        "(nodes: [(shape: cone(radius: -2))])",
        "(nodes: [(shape: cone(height: 0))])",
        "(nodes: [(shape: frustum(top_radius: 0))])",
        "(nodes: [(shape: frustum(height: inf))])",
        "(nodes: [(shape: disk(radius: 0.5, inner_radius: 0.5))])",
        "(nodes: [(shape: disk(inner_radius: -0.1))])",
        "(nodes: [(shape: rectangle(width: 0))])",
        "(nodes: [(shape: rectangle(depth: -3))])",
        "(nodes: [(shape: torus(tube_radius: 0))])",
        "(nodes: [(shape: torus(tube_radius: 1))])",
        "(nodes: [(shape: torus(minor: 1))])",
        "(nodes: [(shape: plane(normal: (0, 0, 0)))])",
        "(nodes: [(shape: triangle((0, 0, 0), (1, 1, 1), (2, 2, 2)))])",
        "(nodes: [(shape: mesh(positions: [(0, 0, 0)], triangles: [(0, 1, 2)]))])",
        "(nodes: [(shape: mesh(positions: [(0, 0, NaN)], triangles: [(0, 0, 0)]))])",
        "(nodes: [(shape: mesh(positions: [(0, 0, 0)], triangles: []))])",
        "(nodes: [(shape: mesh(positions: [(0, 0, 0)], faces: [[0, 0, 0, 1]]))])",
        "(nodes: [(shape: mesh(positions: [(0, 0, 0)], faces: [[0, 0]]))])",
        "(nodes: [(shape: strip([(0, 0, 0), (1, 0, 0)]))])",
        "(nodes: [(shape: fan([(0, 0, 0), (1, 0, 0), (1, 0, 0)]))])",
        "(nodes: [(shape: polygon(points: [(0, 0, 0), (1, 0, 0)]))])",
        "(nodes: [(shape: polygon(points: [(0, 0, 0), (1, 0, NaN), (1, 1, 0)]))])",
        "(nodes: [(shape: polygon(points: [(0, 0, 0), (1, 1, 1), (2, 2, 2), (3, 3, 3)]))])",
        "(nodes: [(shape: polygon(points: [(0, 0, 0), (1, 0, 0), (1, 1, 0.01), (0, 1, 0)]))])",
        "(nodes: [(shape: polygon(points: [(0, 0, 0), (4, 0, 0), (4, 4, 0), (2, 1, 0), (0, 4, 0)], rule: convex))])",
        "(nodes: [(shape: polygon(points: [(0, 0, 0), (4, 0, 0), (0, 4, 0)], holes: [[(1, 1, 0), (2, 1, 0), (1, 2, 0)]], rule: convex))])",
        "(nodes: [(shape: polygon(points: [(0, 0, 0), (4, 0, 0), (0, 4, 0)], holes: [[(1, 1, 0), (2, 1, 0)]]))])",
        "(nodes: [(shape: polygon(points: [(0, 0, 0), (4, 0, 0), (0, 4, 0)], rule: odd))])",
        "(nodes: [(transform: [scale(0)])])",
        "(nodes: [(transform: [translate(0, 0, 0), stretch(1, 0, 1)])])",
        "(nodes: [(transform: [matrix((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 2))])])",
        "(nodes: [(transform: [matrix((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, NaN, 0), (0, 0, 0, 1))])])",
        "(nodes: [(transform: [rotate(axis: (0, 0, 0), degrees: 3)])])",
        "(nodes: [(transform: [stretch(1, 1, 1e-7), stretch(1, 1, 1e-7)])])",
        "(nodes: [(transform: [translate(1e60, 0, 0), translate(1e60, 0, 0)])])",
        "(nodes: [], camera: (look_from: (1, 2, 3), look_at: (1, 2, 3)))",
        "(nodes: [], camera: (look_from: (0, 5, 0)))",
        "(nodes: [], camera: (look_at: (0, 5, 0)))",
        "(nodes: [], camera: (look_from: (0, 0, 5), transform: [scale(1)]))",
        "(nodes: [], camera: (fov: 0))",
        "(nodes: [], camera: (fov: 180))",
        "(nodes: [], camera: (fov: 20, orthographic: 2))",
        "(nodes: [], camera: (orthographic: -2))",
        "(nodes: [], camera: (lens_shift: (NaN, 0)))",
        "(nodes: [], camera: (lens: (radius: -0.1, focus: 0, blades: 2, rotate: NaN)))",
        "(nodes: [], camera: (lens: (focal_length: 1)))",
        "(nodes: [], camera: (shutter: (0.5, 0.25)))",
        "(nodes: [], camera: (shutter: (0, NaN)))",
        "(nodes: [], camera: (look_from: (0, 0, 5), motion: [scale(0)]))",
        "(nodes: [(shape: sphere(), motion: [stretch(-1, 1, 1)])])",
        "(nodes: [(shape: sphere(), motion: [rotate_z(10), translate(0, 1e70, 0)])])",
        "(nodes: [(shape: sphere(), animation: (keys: []))])",
        "(nodes: [(shape: sphere(), animation: (keys: [(time: 0), (time: 2), (time: 1)]))])",
        "(nodes: [(shape: sphere(), animation: (keys: [(time: 0), (time: NaN), (time: inf)]))])",
        "(nodes: [(shape: sphere(), animation: (keys: [(time: 0), (time: 1, transform: [scale(0)])]))])",
        "(nodes: [(shape: sphere(), animation: (keys: [(time: 0), (time: 1, transform: [stretch(1, -1, 1)])]))])",
        "(nodes: [(shape: sphere(), motion: [translate(1, 0, 0)], animation: (keys: [(time: 0)]))])",
        "(nodes: [(shape: sphere(), animation: (keys: [(transform: [])]))])",
        "(nodes: [(shape: sphere(), animation: (interpolation: cubic, keys: [(time: 0)]))])",
        "(nodes: [], camera: (animation: (keys: [])))",
        "(nodes: [], camera: (animation: (keys: [(time: 0, look_at: (0, 0, 0))])))",
        "(nodes: [], camera: (animation: (keys: [(time: 0, look_from: (0, 0, 5)), (time: 1, transform: [rotate_y(9)])])))",
        "(nodes: [], camera: (transform: [rotate_y(90)], animation: (keys: [(time: 0, look_from: (0, 0, 5))])))",
        "(nodes: [], camera: (animation: (keys: [(time: 0, look_from: (0, 5, 0))])))",
        "(nodes: [], camera: (animation: (keys: [(time: -1, look_from: (0, 0, 5)), (time: 1, look_from: (0, 0, -5))])))",
        "(nodes: [], camera: (animation: (keys: [(time: 0, fov: 180)])))",
        "(nodes: [], camera: (look_from: (0, 0, 5), motion: [scale(1)], animation: (keys: [(time: 0, fov: 18)])))",
        "(nodes: [], camera: (lens: (radius: 1, f_stop: 2)))",
        "(nodes: [], camera: (lens: (f_stop: 0, focal_length: -1)))",
        "(nodes: [], camera: (lens: (radius: 1, focus: 1, focus_at: (0, 0, 0))))",
        "(nodes: [], camera: (look_from: (0, 0, 5), lens: (radius: 1, focus_at: (0, 0, 6))))",
        "(nodes: [], camera: (transform: [rotate_y(90)], lens: (radius: 1)))",
        "(nodes: [], camera: (look_from: (0, 0, 1), fov: 1), film: (size: (0, 480)))",
        "(nodes: [], film: (size: (1000000000000, 1000000000000)))",
        "(nodes: [], film: (sample_offset: (0.5, 2), filter: gaussian(0), exposure: NaN, encoding: gamma(0)))",
        "(nodes: [], settings: (spp: 0))",
        "(nodes: [], settings: (spp: 4294967296, max_depth: 10001, min_contribution: -1))",
        "(nodes: [], materials: {\"m\": phong(ior: 0)})",
        "(nodes: [], materials: {\"m\": phong(exponent: -1)})",
        "(nodes: [], materials: {\"m\": phong(exponent: 2e7)})",
        "(nodes: [], materials: {\"m\": phong(diffuse: rgb(0.5, -0.1, 0), specular: hex(\"#12345\"))})",
        "(nodes: [], materials: {\"m\": phong(absorption: gray(-1))})",
        "(nodes: [], materials: {\"m\": mix([(0.3, glossy(diffuse: 0.5)), (0.3, glossy(diffuse: 0.5)), (0.3, glossy(diffuse: 0.5))])})",
        "(nodes: [], materials: {\"m\": mix([(0.5, light(radiance: 1)), (0.5, diffuse(albedo: 0, emission: checker(even: 1, odd: 0)))])})",
        "(nodes: [], materials: {\"m\": mix([(0.5, light(radiance: 1)), (0.5, diffuse(albedo: 0, emission: 1))])})",
        "(nodes: [], materials: {\"m\": phong(color: checker(even: gray(1), odd: gray(0), size: 0))})",
        "(nodes: [], materials: {\"m\": phong(color: checker(even: gray(1), odd: gray(0)), diffuse: checker(even: gray(1), odd: gray(0)))})",
        "(nodes: [], lights: [point(position: (0, 0, 0), intensity: gray(NaN))])",
        "(nodes: [], lights: [point(position: (0, 0, 0), shadow_near: -1)])",
        "(nodes: [], lights: [directional(direction: (0, 0, 0))])",
        "(nodes: [], lights: [spot(position: (0, 0, 0), direction: (0, 0, 1), inner: 30, outer: 20)])",
        "(nodes: [], lights: [ambient(rgb(1, 1, inf))])",
        "(nodes: [], background: gradient(bottom: gray(-1), top: gray(1)))",
    ]);
    insta::assert_snapshot!(text);
}

#[test]
fn json_says_the_same_as_ron() {
    let path = Path::new("scene.json");
    let error = |text: &str| match parse_json(text, path) {
        Err(error) => error.to_string(),
        Ok(file) => resolve(&file, path, &LoadOptions::default()).expect_err(text).to_string(),
    };
    let text = [
        "",
        "{\n  \"nodes\": [],\n  \"lihgts\": []\n}",
        r#"{"nodes": [{"shape": {"sphere": {"raduis": 1}}}]}"#,
        r#"{"nodes": [{"shape": {"sphare": {}}}]}"#,
        r#"{"nodes": [{"shape": {"sphere": {"radius": 1e400}}}]}"#,
        r#"{"nodes": [{"shape": {"sphere": {"radius": -1}}}]}"#,
        r#"{"nodes": [], "groups": {"a": [], "a": []}}"#,
    ]
    .map(error)
    .join("\n");
    insta::assert_snapshot!(text);
}

#[test]
fn a_default_camera_that_is_too_far_away_is_no_error_of_a_field_that_the_scene_lacks() {
    let rule =
        "is a coordinate of the camera that shows the whole scene, and above 1e60: place the camera by `look_from`";
    for (scene, place) in [
        ("(nodes: [(shape: sphere(center: (1e60, 0, 0)))])", "scene.ron: nodes: "),
        ("(nodes: [(shape: sphere(), transform: [scale(1e50), scale(1e50)])])", "scene.ron: nodes: "),
        ("(nodes: [(shape: sphere())], camera: (fov: 1e-80))", "scene.ron: camera: "),
    ] {
        let error = error(scene);
        assert!(error.starts_with(place) && error.contains(rule), "{error}");
        assert_eq!(error.lines().count(), 1, "{error}");
    }
}

#[test]
fn vertices_beyond_single_precision_are_refused_with_that_limit() {
    let with = |z: &str| {
        error(&format!(
            "(nodes: [(shape: mesh(positions: [(1, 0, 0), (0, 0, {z}), (0, 1, 0)], triangles: [(0, 1, 2)]))])"
        ))
    };
    let rule =
        "has a coordinate beyond 3.4e38, the limit of the single precision in which vertices of meshes are stored";
    assert_eq!(with("-1e39"), format!("scene.ron: nodes[0].shape: vertex 1 at (0, 0, -inf) {rule}"));
    assert_eq!(with("NaN"), "scene.ron: nodes[0].shape: vertex 1 at (0, 0, NaN) must have finite coordinates");
}

#[test]
fn two_choices_in_an_object_of_json_are_named() {
    let error = |text: &str| parse_json(text, Path::new("s.json")).expect_err(text).to_string();
    for (text, message) in [
        (
            r#"{"nodes": [{"shape": {"sphere": {}, "box": {}}}]}"#,
            "s.json:1:37: `sphere` and `box` are two choices in one object: remove one of them",
        ),
        (
            r#"{"nodes": [{"material": {"phong": {}, "diffuse": {}}}]}"#,
            "s.json:1:39: `phong` and `diffuse` are two choices in one object: remove one of them",
        ),
        (
            r#"{"nodes": [], "lights": [{"ambient": 1, "point": {}}]}"#,
            "s.json:1:41: `ambient` and `point` are two choices in one object: remove one of them",
        ),
    ] {
        assert!(error(text).starts_with(message), "{}", error(text));
    }
}

#[test]
fn all_problems_are_named_at_once() {
    let text = error(
        "(nodes: [(shape: sphere(radius: 0)), (shape: sphere(), material: \"x\")], film: (size: (0, 1)), camera: (fov: 0))",
    );
    assert_eq!(text.lines().count(), 4, "{text}");
    let many = format!("(nodes: [{}])", "(shape: sphere(radius: 0)),".repeat(1000));
    let text = error(&many);
    assert_eq!(text.lines().count(), 21);
    assert!(text.ends_with("scene.ron: 980 more errors are not listed; fix these first"), "{text}");
}

#[test]
fn deep_nesting_is_refused_without_a_stack_overflow() {
    for depth in [64, 1000, 100_000] {
        let ron = format!("(nodes: [{}{}])", "(children: [".repeat(depth), "])".repeat(depth));
        assert!(error(&ron).contains("nested deeper than 128"), "{depth}");
        let json = format!(r#"{{"nodes": [{}{}]}}"#, r#"{"children": ["#.repeat(depth), "]}".repeat(depth));
        let error = parse_json(&json, Path::new("scene.json")).unwrap_err().to_string();
        assert!(error.contains("nested deeper than 128"), "{error}");
    }
    // What is allowed is parsed, dropped and resolved as well.
    let ron = format!("(nodes: [{}{}])", "(children: [".repeat(60), "])".repeat(60));
    let file = parse_ron(&ron, Path::new("scene.ron")).unwrap();
    resolve(&file, Path::new("scene.ron"), &LoadOptions::default()).unwrap();
}

#[test]
fn a_scene_with_any_character_changed_is_read_or_refused() {
    let whole = include_str!("../../../../scenes/gallery/showcase.ron");
    let path = Path::new("scene.ron");
    let others = ["", ")", "(", "\"", "-", "9", "e", "\u{0}", "é"];
    for (at, (position, _)) in whole.char_indices().step_by(5).enumerate() {
        // Three of them at each position, in turn.
        for other in others.iter().skip(at % 3).step_by(3) {
            let rest = whole[position..].chars().next().map_or("", |c| &whole[position + c.len_utf8()..]);
            let changed = [&whole[..position], other, rest].concat();
            if let Ok(file) = parse_ron(&changed, path) {
                // Neither outcome is wrong; both must come without a panic, and errors with a place.
                if let Err(error) = resolve(&file, path, &LoadOptions::default()) {
                    assert!(error.diagnostics().iter().all(|diagnostic| diagnostic.file == "scene.ron"), "{error}");
                }
            }
        }
    }
}

#[test]
fn references_must_stay_below_the_root() {
    let folder = tempfile::tempdir().unwrap();
    let scenes = folder.path().join("scenes");
    fs::create_dir(&scenes).unwrap();
    fs::write(folder.path().join("secret.png"), b"x").unwrap();
    fs::write(scenes.join("bad.png"), b"x").unwrap();
    let with = |reference: &str, options: &LoadOptions| {
        let path = scenes.join("a.ron");
        let reference = reference.replace('\\', "\\\\");
        let scene = format!("(nodes: [], materials: {{\"m\": phong(color: image(file: \"{reference}\"))}})");
        fs::write(&path, scene).unwrap();
        let error = load(&path, options).expect_err(&reference).to_string();
        error.replace(&folder.path().display().to_string(), "")
    };
    let default = LoadOptions::default();
    let place = "/scenes/a.ron:1:36: materials[\"m\"].color: ";
    for (reference, rule) in [
        ("../secret.png", "`../secret.png` lies outside of /scenes"),
        ("..\\secret.png", "lies outside of /scenes"),
        ("/etc/passwd", "`/etc/passwd` is absolute"),
        ("C:\\x.png", "is absolute"),
        ("file:///etc/passwd", "is a URL"),
        ("https://example.org/x.png", "is a URL"),
        ("none.png", "`none.png` does not exist"),
        ("", "is empty"),
        ("bad.png", "`bad.png` is not a PNG, JPEG, HDR or EXR image"),
    ] {
        let error = with(reference, &default);
        assert!(error.starts_with(place) && error.contains(rule), "{reference}: {error}");
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("../secret.png", scenes.join("link.png")).unwrap();
        assert!(with("link.png", &default).contains("lies outside"));
    }
    // A wider root lets it through: now only the content is wrong.
    let wide = LoadOptions { root: Some(folder.path().to_path_buf()), ..default };
    assert!(with("../secret.png", &wide).contains("is not a PNG"));
}

#[test]
fn a_model_that_is_no_model_file_is_an_error_at_its_reference() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("s.ron");
    fs::write(folder.path().join("notes.txt"), "text").expect("written");
    for (reference, rule) in
        [(".", "is a directory; give the path of a file"), ("notes.txt", "has no known extension (known are .obj")]
    {
        fs::write(&path, format!("(nodes: [\n(model: \"{reference}\")])")).expect("written");
        let error = load(&path, &LoadOptions::default()).expect_err(reference).to_string();
        assert!(error.contains(&format!("s.ron:2:2: nodes[0].model: `{reference}` {rule}")), "{error}");
    }
}

#[test]
fn errors_of_values_are_in_the_order_of_the_text() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("s.ron");
    let text = "(\n  settings: (spp: 0),\n  camera: (fov: 200),\n  nodes: [\n    (shape: sphere(radius: -1)),\n  ],\n)";
    fs::write(&path, text).expect("written");
    let error = load(&path, &LoadOptions::default()).expect_err("refused").to_string();
    let places = ["s.ron:2:14: settings.spp: ", "s.ron:3:12: camera.fov: ", "s.ron:5:6: nodes[0].shape: "];
    let found: Vec<_> = places.iter().map(|place| error.find(place)).collect();
    assert!(found[0].is_some() && found.is_sorted(), "{error}");
    assert!(error.contains("    5 |     (shape: sphere(radius: -1)),\n      |      ^"), "{error}");
}
