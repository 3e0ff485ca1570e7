//! Units of lights, studio lights, and integrators of bare models.

use std::f64::consts::{FRAC_1_PI, TAU};
use std::fmt::Write;

use base64::{Engine, engine::general_purpose::STANDARD};
use rt_math::{Rgb, transcendental::sincos};

use crate::program::{Run, Workplace};

const LIGHT_TRANSPORT: [&str; 5] = ["path", "direct", "distributed", "caustics", "whitted"];

/// glTF file of a square of side 20 that faces +y, seen from above.
fn floor(material: &str, more: &str) -> String {
    let corners = [[-10.0f32, 0.0, 10.0], [10.0, 0.0, 10.0], [10.0, 0.0, -10.0], [-10.0, 0.0, -10.0]];
    let floats: Vec<u8> = corners.iter().flatten().flat_map(|c| c.to_le_bytes()).collect();
    let indices: Vec<u8> = [0u16, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()).collect();
    let data = STANDARD.encode([floats, indices].concat());
    format!(
        r#"{{"asset": {{"version": "2.0"}}, "scene": 0, "materials": [{material}],
        "buffers": [{{"byteLength": 60, "uri": "data:application/octet-stream;base64,{data}"}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 48}}, {{"buffer": 0, "byteOffset": 48, "byteLength": 12}}],
        "accessors": [
            {{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-10, 0, -10], "max": [10, 0, 10]}},
            {{"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "indices": 1, "material": 0}}]}}],
        "cameras": [{{"type": "orthographic", "orthographic": {{"xmag": 0.01, "ymag": 0.01, "znear": 0.1, "zfar": 9}}}}],
        {more}}}"#
    )
}

const CAMERA: &str = r#"{"camera": 0, "translation": [0, 5, 0], "rotation": [-0.70710678, 0, 0, 0.70710678]}"#;

/// Floor without a light.
fn unlit_floor(material: &str) -> String {
    let nodes = format!(r#""nodes": [{{"mesh": 0}}, {CAMERA}], "scenes": [{{"nodes": [0, 1]}}]"#);
    floor(material, &nodes)
}

/// Floor with a light of 1 cd at height 1 above the visible point.
fn lit_floor(material: &str, extensions: &str) -> String {
    let more = format!(
        r#""extensionsUsed": ["KHR_lights_punctual", {extensions}],
        "extensions": {{"KHR_lights_punctual": {{"lights": [{{"type": "point"}}]}}}},
        "nodes": [{{"mesh": 0}}, {CAMERA}, {{"translation": [0, 1, 0], "extensions": {{"KHR_lights_punctual": {{"light": 0}}}}}}],
        "scenes": [{{"nodes": [0, 1, 2]}}]"#
    );
    floor(material, &more)
}

const WHITE: &str = r#"{"pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 1},
    "extensions": {"KHR_materials_specular": {"specularFactor": 0}}}"#;

/// Sphere as an OBJ file with normals.
fn sphere_obj() -> String {
    let mut text = "mtllib m.mtl\nusemtl m\n".to_owned();
    let (rows, columns) = (32, 64);
    for row in 0..=rows {
        for column in 0..columns {
            let (height, turn) =
                (0.5 * TAU * f64::from(row) / f64::from(rows), TAU * f64::from(column) / f64::from(columns));
            let ((across, y), (sin, cos)) = (sincos(height), sincos(turn));
            let (x, z) = (across * sin, across * cos);
            writeln!(text, "v {x} {y} {z}\nvn {x} {y} {z}").expect("written");
        }
    }
    for row in 0..rows {
        for column in 0..columns {
            let at = |row: i32, column: i32| row * columns + column % columns + 1;
            let corners = [at(row, column), at(row + 1, column), at(row + 1, column + 1), at(row, column + 1)];
            let [a, b, c, d] = corners.map(|i| format!("{i}//{i}"));
            writeln!(text, "f {a} {b} {c} {d}").expect("written");
        }
    }
    text
}

/// HDR image of one pixel: mantissas in 256ths, and an exponent above 128.
fn sky(rgbe: [u8; 4]) -> Vec<u8> {
    [b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n".as_slice(), &rgbe].concat()
}

fn mean(place: &Workplace, arguments: &str) -> Rgb {
    place.succeed(&format!("render {arguments} -o out.exr -q"));
    let film = place.film("out.exr");
    let pixels = film.pixels();
    pixels.iter().fold(Rgb::BLACK, |sum, pixel| sum + Rgb::from(pixel.map(f64::from))) / pixels.len() as f64
}

fn notes(run: &Run, of: &str) -> Vec<String> {
    run.stdout.lines().filter(|line| line.starts_with("note: ") && line.contains(of)).map(str::to_owned).collect()
}

#[test]
fn gltf_lights_have_physical_units() {
    let place = Workplace::with("m.gltf", lit_floor(WHITE, r#""KHR_materials_specular""#));
    for integrator in LIGHT_TRANSPORT {
        let arguments = format!("m.gltf --size 4x4 --spp 4 --integrator {integrator}");
        let seen = mean(&place, &arguments).r;
        assert!((seen - FRAC_1_PI).abs() < 1e-4, "{integrator}: {seen}, not 1/pi");
        place.succeed("convert m.gltf -o m.ron");
        let converted = mean(&place, &arguments.replace("gltf", "ron")).r;
        assert_eq!(converted, seen, "{integrator}, converted");
    }
    let text = String::from_utf8(place.read("m.ron")).expect("text");
    assert!(text.contains("units: physical"), "{text}");
}

#[test]
fn environment_images_replace_studio_lights() {
    let place = Workplace::with("m.gltf", unlit_floor(WHITE));
    place.write("m.obj", "v -1 0 1\nv 1 0 1\nv 1 0 -1\nv -1 0 -1\nf 1 2 3 4\n");
    place.write("sky.hdr", sky([128, 64, 32, 128]));
    for model in ["m.gltf", "m.obj"] {
        let run = place.succeed(&format!("explain {model} --env sky.hdr"));
        assert!(run.stdout.contains("no delta lights"), "{model}: {run:?}");
    }
    let seen = mean(&place, "m.gltf --size 4x4 --spp 1024 --integrator path --env sky.hdr");
    assert!((seen.r - 0.5).abs() < 0.01 && (seen.b - 0.125).abs() < 0.01, "{seen:?}");
    place.prints("explain m.gltf --env sky.hdr --lights studio", "2 delta lights, 1 with shadows");
    place.prints("explain m.gltf --lights none", "no delta lights");
}

#[test]
fn emissive_objects_and_backgrounds_are_lights_of_a_scene() {
    let place = Workplace::new();
    let scene = |more: &str, emission: &str| {
        format!("(nodes: [(shape: sphere(), material: \"m\")], materials: {{ \"m\": phong({emission}) }}, {more})")
    };
    let lights = |place: &Workplace, arguments: &str| {
        let run = place.succeed(&format!("explain scene.ron {arguments}"));
        run.stdout.contains("2 delta lights, 1 with shadows")
    };
    place.write("scene.ron", scene("", ""));
    assert!(lights(&place, "") && !lights(&place, "--lights none"));
    assert!(!lights(&place, "--integrator path --background 1,1,1"));
    assert!(lights(&place, "--integrator path --background 0,0,0"));
    assert!(lights(&place, "--background 1,1,1"), "whitted takes no light from backgrounds");
    place.write("scene.ron", scene("", "emission: gray(2)"));
    assert!(!lights(&place, "") && lights(&place, "--lights studio"));
    place.write("scene.ron", scene("background: constant(gray(0.5)), settings: (integrator: path)", ""));
    assert!(!lights(&place, ""));
    place.write("scene.ron", scene("lights: []", ""));
    assert!(!lights(&place, ""), "an empty list means none");
}

#[test]
fn a_white_surface_shows_its_albedo_under_every_integrator() {
    let place = Workplace::with("m.obj", sphere_obj());
    let matte = r#"{"pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.8, 0.8, 1], "metallicFactor": 0, "roughnessFactor": 1}}"#;
    let wall = unlit_floor(matte).replace("\"mesh\": 0}", "\"mesh\": 0, \"rotation\": [0.70710678, 0, 0, 0.70710678]}");
    place.write("wall.gltf", wall.replace(CAMERA, r#"{"camera": 0, "translation": [0, 0, 5]}"#));
    place.write(
        "scene.ron",
        r#"(nodes: [(shape: sphere(), material: "m")], materials: { "m": diffuse(albedo: gray(0.8)) })"#,
    );
    for mtl in ["newmtl m\nKd 0.8 0.8 0.8\nillum 1\n", "newmtl m\nKd 0.8 0.8 0.8\nPr 1\nPm 0\n"] {
        place.write("m.mtl", mtl);
        for integrator in LIGHT_TRANSPORT {
            for model in ["m.obj", "scene.ron"] {
                place.succeed(&format!("render {model} --integrator {integrator} --size 32x32 --spp 64 -o out.exr -q"));
                let film = place.film("out.exr");
                let mut values: Vec<f64> =
                    film.pixels().iter().map(|pixel| Rgb::from(pixel.map(f64::from)).luminance()).collect();
                values.sort_by(|a, b| b.total_cmp(a));
                let brightest = values[..60].iter().sum::<f64>() / 60.0;
                assert!((brightest - 0.8).abs() < 0.1, "{model}, {mtl:?}, {integrator}: {brightest}");
                let is_clipped = film.pixels().iter().flatten().any(|c| *c >= 1.0);
                assert!(!is_clipped, "{model}, {mtl:?}, {integrator}: {}", values[0]);
            }
        }
    }
    for integrator in LIGHT_TRANSPORT {
        let seen = mean(&place, &format!("wall.gltf --integrator {integrator} --size 4x4 --spp 1024"));
        assert!([seen.r, seen.g, seen.b].iter().all(|c| (c - 0.8).abs() < 0.1), "{integrator}: {seen:?}");
    }
}

#[test]
fn bare_models_of_physical_materials_are_path_traced() {
    let place = Workplace::with("m.gltf", unlit_floor(WHITE));
    place.write("pbr.obj", "mtllib pbr.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n");
    place.write("pbr.mtl", "newmtl m\nKd 0.8 0.8 0.8\nPr 0.5\nPm 1\n");
    place.write("phong.obj", "mtllib phong.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n");
    place.write("phong.mtl", "newmtl m\nKd 0.8 0.8 0.8\n");
    let explained = |arguments: &str| place.succeed(&format!("explain {arguments}")).stdout;
    for model in ["m.gltf", "pbr.obj"] {
        let plan = explained(model);
        assert!(plan.contains("path") && plan.contains("64 samples"), "{plan}");
        let run = place.succeed(&format!("render {model} --size 8x8 --spp 1 --integrator whitted -o out.png"));
        assert_eq!(notes(&run, "physically based").len(), 1, "{run:?}");
        assert_eq!(notes(&run, "`whitted` shows").len(), 1, "{run:?}");
        let run = place.succeed(&format!("render {model} --size 8x8 --spp 1 --integrator path -o out.png"));
        assert!(notes(&run, "in full").is_empty(), "{run:?}");
    }
    assert!(explained("phong.obj").contains("whitted"));
}

#[test]
fn convert_keeps_physical_materials() {
    let place = Workplace::new();
    let metal = r#"{"name": "gold", "pbrMetallicRoughness": {"baseColorFactor": [0.9, 0.6, 0.2, 1], "metallicFactor": 1, "roughnessFactor": 0.25},
        "emissiveFactor": [0.1, 0, 0], "doubleSided": true}"#;
    let coated = r#"{"name": "coated", "extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 1}}}"#;
    place.write("m.gltf", unlit_floor(metal));
    place.write("coated.gltf", unlit_floor(coated));
    place.succeed("convert m.gltf -o m.ron");
    let text = String::from_utf8(place.read("m.ron")).expect("text");
    assert!(text.contains("\"gold\": metallic_roughness("), "{text}");
    assert!(!text.contains("phong("), "{text}");
    let run = place.succeed("convert coated.gltf -o coated.ron");
    assert_eq!(notes(&run, "\"coated\" stays in the model").len(), 1, "{run:?}");
    for model in ["m", "coated"] {
        for options in ["", "--integrator whitted", "--integrator distributed"] {
            place.succeed(&format!("render {model}.gltf --size 8x8 --spp 16 {options} -o model.exr -q"));
            place.succeed(&format!("render {model}.ron --size 8x8 --spp 16 {options} -o scene.exr -q"));
            assert_eq!(place.read("scene.exr"), place.read("model.exr"), "{model} {options}");
        }
    }
}

#[test]
fn exposure_suits_the_lights() {
    let place = Workplace::with("m.gltf", lit_floor(WHITE, r#""KHR_materials_specular""#));
    place.write("sky.hdr", sky([128, 64, 32, 128]));
    let run = place.succeed("render m.gltf --size 8x8 --spp 1 -o out.png");
    assert_eq!(notes(&run, "lx; exposure").len(), 1, "{run:?}");
    // An environment of radiance about 1 outweighs faint lights.
    let run = place.succeed("render m.gltf --size 8x8 --spp 1 --env sky.hdr -o out.png");
    assert!(notes(&run, "lx; exposure -0.0").len() == 1 || notes(&run, "lx; exposure 0 ").len() == 1, "{run:?}");
    let run = place.succeed("explain m.gltf");
    assert!(run.stdout.contains("1 delta light, 1 with shadows"), "nothing is added: {run:?}");
}

#[test]
fn suns_without_shadows_reach_absorbing_water() {
    let place = Workplace::new();
    let scene = r#"(
        camera: (look_from: (0, 3, 0), look_at: (0, 0, 0), up: (0, 0, -1), orthographic: 1, medium: "sea"),
        background: constant(0),
        lights: [directional(direction: (0, -1, 0), intensity: 0.5, casts_shadows: SHADOWS)],
        materials: {
            "sea": phong(color: 0, transmission: 1, ior: 1, absorption: (0.5, 0.5, 0.5)),
            "floor": diffuse(albedo: 1),
        },
        nodes: [(shape: plane(), material: "floor")],
    )"#;
    // The way to the camera absorbs; that to a light at infinity has no length.
    let expected = 0.5 * rt_math::transcendental::exp(-1.5);
    for shadows in ["true", "false"] {
        place.write("sea.ron", scene.replace("SHADOWS", shadows));
        for integrator in ["whitted", "path", "direct", "distributed"] {
            let seen = mean(&place, &format!("sea.ron --integrator {integrator} --size 4x4 --spp 1")).g;
            assert!((seen - expected).abs() < 1e-4, "{integrator}, shadows {shadows}: {seen}, not {expected}");
        }
    }
}

/// A sun above a slab of smoke, in which there is a bubble of air: half a unit of smoke is on its way.
#[test]
fn suns_shine_through_smoke() {
    let place = Workplace::new();
    let scene = r#"(
        camera: (look_from: (0, 0.5, 0), look_at: (0, 0, 0), up: (0, 0, -1), orthographic: 1),
        background: constant(0),
        lights: [directional(direction: (0, -1, 0), intensity: 0.5)],
        materials: {
            "smoke": SMOKE,
            "air": glass(ior: 1, priority: 1),
            "floor": diffuse(albedo: 1),
        },
        nodes: [
            (shape: plane(), material: "floor"),
            (shape: box(min: (-5, 1, -5), max: (5, 2, 5)), material: "smoke"),
            (shape: box(min: (-4, 1.25, -4), max: (4, 1.75, 4)), material: "air"),
        ],
    )"#;
    let expected = 0.5 * rt_math::transcendental::exp(-0.25);
    for smoke in ["glass(ior: 1, absorption: 0.5)", "phong(color: 0, transmission: 1, ior: 1, absorption: 0.5)"] {
        place.write("smoke.ron", scene.replace("SMOKE", smoke));
        for integrator in ["whitted", "path", "direct", "distributed", "path-caustics", "path-reference"] {
            let seen = mean(&place, &format!("smoke.ron --integrator {integrator} --size 4x4 --spp 1")).g;
            assert!((seen - expected).abs() < 1e-4, "{smoke}, {integrator}: {seen}, not {expected}");
        }
    }
}

/// The first object of coincident faces is hit. A wall behind it still casts its shadow, and each of many overlapping clouds lets light pass.
#[test]
fn smoke_hides_no_wall_and_any_number_of_clouds_dims() {
    let place = Workplace::new();
    let scene = |clouds: &str, walls: &str| {
        format!(
            r#"(
                camera: (look_from: (0, 0.5, 0), look_at: (0, 0, 0), up: (0, 0, -1), orthographic: 0.01),
                background: constant(0),
                lights: [directional(direction: (0, -1, 0), intensity: 1)],
                materials: {{"smoke": glass(ior: 1, absorption: 0.5), "floor": diffuse(albedo: 1)}},
                nodes: [{clouds} (shape: plane(), material: "floor"), {walls}],
            )"#
        )
    };
    let slab = r#"(shape: box(min: (-5, 1, -5), max: (5, 2, 5)), material: "smoke"),"#;
    let wall = r#"(shape: box(min: (-5, 2, -5), max: (5, 2.5, 5)), material: "floor")"#;
    let cloud =
        |at: u32| format!("(shape: sphere(center: (0, 2, 0), radius: 1), material: \"smoke\", name: \"{at}\"),");
    let clouds: String = (0..100).map(cloud).collect();
    let passed = rt_math::transcendental::exp(-1.0);
    for (text, expected) in [(scene(slab, wall), 0.0), (scene(&clouds, ""), passed)] {
        place.write("smoke.ron", text);
        for integrator in ["whitted", "path", "direct", "path-caustics", "path-reference"] {
            let options = "--size 2x2 --spp 1 --max-depth 0";
            let seen = mean(&place, &format!("smoke.ron --integrator {integrator} {options}")).g;
            assert!((seen - expected).abs() < 1e-4, "{integrator}: {seen}, not {expected}");
        }
    }
}

#[test]
fn layered_materials_are_lit_once_under_distributed() {
    let place = Workplace::with("floor.gltf", unlit_floor(WHITE));
    for integrator in ["path", "direct", "distributed"] {
        let options = format!("--integrator {integrator} --background white --size 8x8 --spp 64");
        let seen = mean(&place, &format!("floor.gltf {options}")).g;
        assert!((seen - 1.0).abs() < 0.03, "{integrator}: {seen}");
    }
}

#[test]
fn environment_images_replace_ambient_light_under_distributed() {
    let place = Workplace::with("sky.hdr", sky([128, 128, 128, 129]));
    let scene = r#"(
        camera: (look_from: (0, 3, 0), look_at: (0, 0, 0), up: (0, 0, -1), orthographic: 1),
        background: image(file: "sky.hdr"),
        lights: [ambient(1)],
        materials: { "floor": phong(diffuse: 0.5, ambient: 0.5, specular: 0) },
        nodes: [(shape: plane(), material: "floor")],
    )"#;
    place.write("scene.ron", scene);
    let seen = mean(&place, "scene.ron --integrator distributed --size 8x8 --spp 64").g;
    assert!((seen - 0.5).abs() < 0.03, "{seen}");
}
