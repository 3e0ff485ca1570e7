//! Invalid scene files.

use std::fmt::Write;

use crate::input::{Content, Input};

/// Places in the messages about the only node.
const SHAPE: &str = ": nodes[0].shape: ";
const TRANSFORM: &str = ": nodes[0].transform";

/// Nodes that are bad in the same way: each is refused, with its place and these parts.
fn refused_nodes(nodes: &[&str], parts: &[&'static str]) -> Vec<Input> {
    let parts = [&["scene.ron:1:"], parts].concat();
    nodes.iter().map(|node| Input::node(node).refused(&parts)).collect()
}

/// Scenes around a sphere with other fields.
fn with(fields: &str) -> Input {
    Input::scene(&format!("({fields}, nodes: [(shape: sphere())])"))
}

/// Scenes that are bad in the same way: each is refused, with its place and this part.
fn refused(fields: &[&str], part: &'static str) -> Vec<Input> {
    fields.iter().map(|fields| with(fields).refused(&["scene.ron:1:", part])).collect()
}

const MATERIAL: &str = ": materials[\"m\"]";

fn refused_materials(materials: &[&str], part: &'static str) -> Vec<Input> {
    let fields: Vec<String> = materials.iter().map(|material| format!("materials: {{\"m\": {material}}}")).collect();
    refused(&fields.iter().map(String::as_str).collect::<Vec<_>>(), part)
}

pub(crate) fn nan_coordinate() -> Vec<Input> {
    let mut inputs = refused_nodes(&["shape: sphere(center: (NaN, 0, 0))"], &[SHAPE, "NaN"]);
    inputs.push(
        Input::file("m.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 3 4\n")
            .shown(&["triangles with a NaN or infinite vertex were dropped: 1 of"]),
    );
    inputs
}

pub(crate) fn infinite_coordinate() -> Vec<Input> {
    let nodes = ["shape: sphere(center: (0, inf, 0))", "shape: box(min: (-inf, 0, 0), max: (1, 1, 1))"];
    refused_nodes(&nodes, &[SHAPE, "inf"])
}

pub(crate) fn overflowing_number() -> Vec<Input> {
    let json = r#"{"nodes": [{"shape": {"sphere": {"radius": 1e400}}}]}"#;
    let mut inputs = refused_nodes(&["shape: sphere(radius: 1e400)"], &[SHAPE, "inf"]);
    inputs.push(Input::file("scene.json", json).refused(&["scene.json:1:", "out of range"]));
    inputs
}

pub(crate) fn coordinate_beyond_1e60() -> Vec<Input> {
    refused_nodes(&["shape: sphere(center: (1e61, 0, 0))"], &[SHAPE, "magnitude at most 1e60"])
}

pub(crate) fn comma_decimals() -> Vec<Input> {
    vec![
        Input::node("shape: sphere(radius: 0,5)").refused(&["scene.ron:1:", "decimals are written with a point"]),
        Input::file("m.obj", "v 0 0 0\nv 1,5 0 0\nv 0 1 0\nf 1 2 3\n").refused(&["m.obj:2: `1,5` is not a number"]),
    ]
}

pub(crate) fn unknown_material() -> Input {
    let materials = "materials: {\"chrome\": mirror()}";
    let scene = format!("({materials}, nodes: [(shape: sphere(), material: \"crome\")])");
    Input::scene(&scene).refused(&["scene.ron:1:", ": nodes[0].material: ", "`crome`", "did you mean `chrome`"])
}

pub(crate) fn duplicate_names() -> Vec<Input> {
    ["materials: {\"m\": mirror(), \"m\": mirror()}", "cameras: [(name: \"a\"), (name: \"a\")]"]
        .map(|fields| with(fields).refused(&["scene.ron", "there are two"]))
        .into()
}

pub(crate) fn unknown_field() -> Vec<Input> {
    vec![
        Input::node("shape: sphere(raduis: 1)")
            .refused(&["scene.ron:1:", "unknown field `raduis` in sphere; did you mean `radius`?"]),
        Input::node("shape: sphare()").refused(&["scene.ron:1:", "did you mean `sphere`?"]),
    ]
}

pub(crate) fn wrong_type() -> Vec<Input> {
    vec![
        Input::node("shape: sphere(radius: \"one\")").refused(&[
            "scene.ron:1:33: expected a number for `radius`, found \"one\"\n",
            "\n      |",
            "^\n",
        ]),
        Input::scene("(nodes: 3)").refused(&["scene.ron:1:9: expected a list in brackets for `nodes`, found 3"]),
        Input::file("scene.json", "[]").refused(&["scene.json:1:"]),
    ]
}

pub(crate) fn nesting_of_100_000() -> Vec<Input> {
    let children = Content { head: "(nodes: [".into(), part: "(children: [".into(), times: 100_000, tail: Vec::new() };
    let brackets = Content { head: Vec::new(), part: "[".into(), times: 100_000, tail: Vec::new() };
    vec![
        Input::long("scene.ron", children).refused(&["scene.ron:1:", "nested deeper than 128"]),
        Input::long("scene.json", brackets).refused(&["scene.json:1:"]),
    ]
}

pub(crate) fn include_cycle() -> Vec<Input> {
    let groups = "groups: {\"a\": [(instance: \"b\")], \"b\": [(instance: \"a\")]}";
    vec![
        with(groups).refused(&["scene.ron", "groups contain each other"]),
        Input::node("model: \"scene.ron\"").refused(&["nodes[0].model: `scene.ron` is a scene file"]),
    ]
}

/// A scene cannot contain scenes at all, and so no chain of them.
pub(crate) fn include_depth() -> Input {
    Input::node("model: \"other.ron\"")
        .with_file("other.ron", "(nodes: [])")
        .refused(&["nodes[0].model: `other.ron` is a scene file, and `model` takes .obj"])
}

fn refused_matrix(matrix: &str, part: &'static str) -> Vec<Input> {
    refused_nodes(&[&format!("shape: sphere(), transform: [matrix({matrix})]")], &[TRANSFORM, part])
}

pub(crate) fn singular_matrix() -> Vec<Input> {
    refused_matrix("(1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 0, 0), (0, 0, 0, 1)", "is singular")
}

pub(crate) fn nan_matrix() -> Vec<Input> {
    refused_matrix("(1, 0, 0, NaN), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)", "NaN")
}

pub(crate) fn projective_matrix() -> Vec<Input> {
    refused_matrix("(1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 1, 1)", "row")
}

pub(crate) fn zero_or_negative_size() -> Vec<Input> {
    let nodes = [
        "shape: sphere(radius: -1)",
        "shape: sphere(radius: 0)",
        "shape: cylinder(bottom: 1, top: 1)",
        "shape: cone(height: 0)",
        "shape: cone(height: -1)",
        "shape: torus(tube_radius: 0)",
        "shape: disk(radius: 0)",
    ];
    refused_nodes(&nodes, &[SHAPE])
}

pub(crate) fn too_wide_cone() -> Vec<Input> {
    refused_nodes(
        &["shape: double_cone(slope: inf)", "shape: double_cone(slope: 0)", "shape: cone(radius: inf)"],
        &[SHAPE],
    )
}

pub(crate) fn box_min_beyond_max() -> Vec<Input> {
    refused_nodes(&["shape: box(min: (1, 0, 0), max: (0, 1, 1))"], &[SHAPE])
}

pub(crate) fn zero_scale() -> Vec<Input> {
    refused_nodes(
        &["shape: sphere(), transform: [scale(0)]", "shape: sphere(), transform: [stretch(1, 0, 1)]"],
        &[TRANSFORM],
    )
}

pub(crate) fn impossible_camera() -> Vec<Input> {
    refused(
        &[
            "camera: (look_from: (1, 2, 3), look_at: (1, 2, 3))",
            "camera: (look_from: (0, 5, 0))",
            "camera: (fov: 0)",
            "camera: (fov: 180)",
            "camera: (fov: NaN)",
            "camera: (orthographic: 0)",
        ],
        ": camera",
    )
}

pub(crate) fn impossible_lens() -> Vec<Input> {
    refused(
        &[
            "camera: (look_from: (0, 0, 5), lens: (radius: -1))",
            "camera: (look_from: (0, 0, 5), lens: (radius: 0.1, focus: 0))",
        ],
        ": camera",
    )
}

pub(crate) fn image_of_no_or_too_many_pixels() -> Vec<Input> {
    let inputs = refused(&["film: (size: (0, 48))", "film: (size: (100000, 100000))"], ": film");
    inputs.into_iter().map(Input::in_its_own_size).collect()
}

pub(crate) fn no_or_too_many_samples() -> Vec<Input> {
    refused(&["settings: (spp: 0)", "settings: (spp: 2147483649)"], ": settings.spp")
}

pub(crate) fn negative_depth() -> Vec<Input> {
    let mut inputs = refused(&["settings: (max_depth: -1)"], "from 0 up for `max_depth`");
    // Earlier spellings are explained as well.
    inputs.extend(refused(&["settings: (depth: -1)"], "from 0 up for `depth`"));
    inputs.push(with("settings: (max_depth: 10001)").refused(&["scene.ron:1:", ": settings.max_depth", "10001"]));
    inputs
}

pub(crate) fn impossible_index_of_refraction() -> Vec<Input> {
    refused_materials(&["glass(ior: 0)", "glass(ior: NaN)", "phong(transmission: gray(1), ior: -1)"], MATERIAL)
}

pub(crate) fn albedo_beyond_1() -> Vec<Input> {
    refused_materials(&["diffuse(albedo: gray(1.5))", "diffuse(albedo: rgb(0.5, -0.1, 0))"], MATERIAL)
}

pub(crate) fn impossible_exponent() -> Vec<Input> {
    refused_materials(&["phong(exponent: -1)", "phong(exponent: 2e7)"], ": materials[\"m\"].exponent: ")
}

pub(crate) fn impossible_light() -> Vec<Input> {
    refused(
        &[
            "lights: [point(position: (0, 9, 0), intensity: gray(NaN))]",
            "lights: [directional(direction: (0, 0, 0))]",
            "lights: [spot(position: (0, 9, 0), direction: (0, 0, 0))]",
            "lights: [cylinder(base: (0, 1, 0), top: (0, 1, 0), radius: 1)]",
        ],
        ": lights[0]",
    )
}

pub(crate) fn billion_instances() -> Vec<Input> {
    let mut groups = String::from("\"g0\": [(shape: sphere())],");
    for level in 1..10 {
        let instance = format!("(instance: \"g{}\"),", level - 1);
        write!(groups, "\"g{level}\": [{}],", instance.repeat(10)).expect("memory");
    }
    let scene = |top: usize| format!("(nodes: [{}], groups: {{{groups}}})", "(instance: \"g9\"),".repeat(top));
    vec![
        Input::scene(&scene(1)).refused(&["scene.ron", "10000000"]),
        Input::scene(&scene(10)).refused(&["scene.ron", "10000000000"]),
    ]
}

pub(crate) fn no_camera_and_no_lights() -> Input {
    Input::node("shape: sphere()").shown(&["note: The camera has no position", "note: The scene has no lights"])
}

/// Notations of other programs, one in each format. `rt-scene-io/tests/scene_io/friendly.rs` has all of them.
pub(crate) fn first_mistakes() -> Vec<Input> {
    vec![
        with("camera: (position: (0, 1, 5))")
            .refused(&["scene.ron:1:11: unknown field `position` in camera; did you mean `look_from`?"]),
        Input::file("scene.json", r#"{"nodes": [{"shape": "sphere"}]}"#).refused(&["write {\"sphere\": {}}"]),
        Input::scene(r#"{"nodes": []}"#).refused(&["scene.ron:1:1: ", "this is JSON: name the file .json"]),
        Input::file("scene.json", "(nodes: [])").refused(&["scene.json:1:1: ", "this is RON: name the file .ron"]),
        Input::scene("hello").refused(&["scene.ron:1:1: expected a scene, which begins with `(`", "found hello"]),
        Input::file("m.gltf", "hello").refused(&["m.gltf: is not glTF"]),
        Input::file("m.ply", "hello").refused(&["m.ply:1: is not a PLY file: the first line must be `ply`"]),
        Input::file("m.exr", "hello").refused(&["m.exr: is an image; use `develop` or `compare`"]),
        Input::file("1.part", "hello").refused(&["1.part: is a shard of an image; combine the shards by `merge`"]),
    ]
}

pub(crate) fn colour_with_alpha() -> Vec<Input> {
    vec![
        with("materials: {\"m\": diffuse(albedo: \"#ff000080\")}")
            .refused(&["scene.ron:1:", ": materials[\"m\"].albedo: \"#ff000080\" has an alpha component"]),
        with("materials: {\"m\": diffuse(albedo: \"#f008\")}").refused(&["has an alpha component"]),
        with("materials: {\"m\": diffuse(albedo: \"red\")}").refused(&["scene.ron:1:", "expected a colour"]),
        with("materials: {\"m\": diffuse(albedo: \"#ggg\")}").refused(&["is not a colour"]),
        with("materials: {\"m\": diffuse(albedo: (1, 0))}").refused(&["scene.ron:1:", "(r, g, b)"]),
    ]
}
