//! Scene files as people write them, and what is said about the first mistakes that they make.

use std::path::Path;

use rt_math::Rgb;
use rt_scene_io::format::{SceneFile, parse_json, parse_ron};
use rt_scene_io::{LoadError, LoadOptions, Scene, resolve};
use rt_shading::{Background, ColorTexture, MaterialModel, Texture};

fn resolved(file: Result<SceneFile, LoadError>, text: &str) -> Scene {
    let file = file.unwrap_or_else(|error| panic!("{text}\n{error}"));
    resolve(&file, Path::new("scene.ron"), &LoadOptions::default()).unwrap_or_else(|error| panic!("{text}\n{error}"))
}

fn ron(text: &str) -> Scene {
    resolved(parse_ron(text, Path::new("scene.ron")), text)
}

fn json(text: &str) -> Scene {
    resolved(parse_json(text, Path::new("scene.json")), text)
}

fn albedo(scene: &Scene) -> ColorTexture {
    match scene.appearance.materials[0].model {
        MaterialModel::Diffuse { albedo, .. } => albedo,
        ref other => panic!("{other:?}"),
    }
}

/// The albedo that this text stands for.
fn albedo_in_ron(text: &str) -> ColorTexture {
    let materials = format!("materials: {{\"m\": diffuse(albedo: {text})}}");
    albedo(&ron(&format!("({materials}, nodes: [(shape: sphere(), material: \"m\")])")))
}

fn albedo_in_json(text: &str) -> ColorTexture {
    let materials = format!("\"materials\": {{\"m\": {{\"diffuse\": {{\"albedo\": {text}}}}}}}");
    albedo(&json(&format!("{{{materials}, \"nodes\": [{{\"shape\": {{\"sphere\": {{}}}}, \"material\": \"m\"}}]}}")))
}

#[test]
fn the_emission_of_a_mix_is_the_sum_of_its_parts() {
    let folder = tempfile::tempdir().expect("a folder");
    image::RgbImage::new(1, 1).save(folder.path().join("a.png")).expect("written");
    let emission = |parts: &str| {
        let nodes = "nodes: [(shape: sphere(), material: \"m\")]";
        let path = folder.path().join("scene.ron");
        let file = parse_ron(&format!("(materials: {{\"m\": mix([{parts}])}}, {nodes})"), &path).expect("a scene");
        resolve(&file, &path, &LoadOptions::default()).expect(parts).appearance.materials[0].emission
    };
    let image = "diffuse(emission: image(file: \"a.png\"))";
    let gray = |x: f64| ColorTexture::Constant(Rgb::gray(x));
    assert_eq!(emission("(0.5, diffuse(emission: 4)), (0.25, diffuse(emission: 8))"), gray(4.0));
    let ColorTexture::Textured(id, half) = emission(&format!("(0.5, {image})")) else { panic!("a texture") };
    let twice = emission(&format!("(0.5, {image}), (0.5, {image})"));
    assert_eq!(twice, ColorTexture::Textured(id, half + half));
    assert_eq!(emission(&format!("(0, {image}), (0.5, light(radiance: 4))")), gray(2.0));
}

#[test]
fn colours_are_written_as_people_write_them() {
    let red = ColorTexture::Constant(Rgb::new(1.0, 0.0, 0.0));
    for text in
        ["(1, 0, 0)", "( 1.0 ,0,\n0, )", "[1, 0, 0]", "\"#ff0000\"", "\"#F00\"", "rgb(1, 0, 0)", "hex(\"#ff0000\")"]
    {
        assert_eq!(albedo_in_ron(text), red, "{text}");
    }
    for text in ["[1, 0, 0]", "\"#ff0000\"", "\"#f00\"", "{\"rgb\": [1, 0, 0]}", "{\"hex\": \"#ff0000\"}"] {
        assert_eq!(albedo_in_json(text), red, "{text}");
    }
    let gray = ColorTexture::Constant(Rgb::gray(0.25));
    for text in ["0.25", " +.25 /* a quarter */", "25e-2 // a quarter\n", "gray(0.25)", "grey(0.25)"] {
        assert_eq!(albedo_in_ron(text), gray, "{text}");
    }
    assert_eq!(albedo_in_ron("1"), ColorTexture::Constant(Rgb::WHITE));
    assert_eq!((albedo_in_json("0.25"), albedo_in_json("{\"gray\": 0.25}")), (gray, gray));
    assert_eq!(albedo_in_json("1"), ColorTexture::Constant(Rgb::WHITE));
}

#[test]
fn hex_digits_are_display_colours() {
    let ColorTexture::Constant(middle) = albedo_in_ron("\"#808080\"") else { panic!("a colour") };
    assert!((middle.g - 0.215_860_5).abs() < 1e-7, "{middle:?}");
    assert_eq!(albedo_in_ron("\"#4a8\""), albedo_in_ron("\"#44aa88\""));
}

#[test]
fn colours_in_textures_lights_and_backgrounds_are_colours_too() {
    let scene = ron("(
        lights: [point(position: (0, 1, 0), intensity: \"#fff\"), ambient((0.5, 0.25, 0)), ambient(0.5), ambient(gray(0.5))],
        background: constant((0, 0, 1)),
        materials: {\"m\": diffuse(albedo: checker(even: 1, odd: \"#f00\"))},
        nodes: [(shape: sphere(), material: \"m\")],
    )");
    let checker = Texture::Checker { even: Rgb::WHITE, odd: Rgb::new(1.0, 0.0, 0.0), size: 1.0 };
    assert!(matches!(albedo(&scene), ColorTexture::Textured(_, Rgb::WHITE)));
    assert_eq!(scene.appearance.textures, [checker]);
    assert_eq!(scene.appearance.lights[0].intensity, Rgb::WHITE);
    assert_eq!(scene.appearance.ambient, Rgb::new(1.5, 1.25, 1.0));
    assert!(matches!(scene.appearance.background, Background::Constant(blue) if blue == Rgb::new(0.0, 0.0, 1.0)));
    let scene = json(
        r##"{"lights": [{"ambient": [1, 0, 0]}, {"ambient": 0.5}], "background": {"gradient": {"bottom": 0, "top": "#00f"}},
             "nodes": [{"shape": {"sphere": {}}}]}"##,
    );
    assert_eq!(scene.appearance.ambient, Rgb::new(1.5, 0.5, 0.5));
    let gradient = Background::Gradient { bottom: Rgb::BLACK, top: Rgb::new(0.0, 0.0, 1.0) };
    assert_eq!(format!("{:?}", scene.appearance.background), format!("{gradient:?}"));
}

#[test]
fn a_schema_may_be_named_in_json() {
    json(r#"{"$schema": "scene.schema.json", "nodes": [{"shape": {"sphere": {}}}]}"#);
}

#[test]
fn a_material_may_stand_at_a_node() {
    let scene = ron("(nodes: [
        (shape: sphere(), material: diffuse(albedo: 0.8)),
        (material: diffuse(albedo: (1, 0, 0)), children: [(shape: sphere()), (shape: sphere())]),
    ])");
    let albedo_of = |index: u32| match scene.appearance.materials[index as usize].model {
        MaterialModel::Diffuse { albedo, .. } => albedo,
        ref other => panic!("{other:?}"),
    };
    assert_eq!(albedo_of(scene.nodes[0].material.0), ColorTexture::Constant(Rgb::gray(0.8)));
    let children = &scene.nodes[1].children;
    assert_eq!(albedo_of(children[0].material.0), ColorTexture::Constant(Rgb::new(1.0, 0.0, 0.0)));
    assert_eq!(children[0].material, children[1].material, "one material, and not one for each child");
    assert_eq!(scene.appearance.materials.len(), 2);
    let scene = json(r#"{"nodes": [{"shape": {"sphere": {}}, "material": {"diffuse": {"albedo": 0.8}}}]}"#);
    assert_eq!(albedo(&scene), ColorTexture::Constant(Rgb::gray(0.8)));
    assert_eq!(scene.settings.integrator, rt_scene_io::Integrator::Path, "as for materials with a name");
}

#[test]
fn a_scene_with_materials_at_nodes_is_written_and_read_again() {
    let text =
        "(nodes: [(shape: sphere(), material: metallic_roughness(base_color: \"#ff8000\", emission: (1, 2, 3)))])";
    let file = parse_ron(text, Path::new("scene.ron")).unwrap();
    assert_eq!(parse_ron(&file.to_ron(), Path::new("scene.ron")).unwrap(), file, "{}", file.to_ron());
    assert_eq!(parse_json(&file.to_json(), Path::new("scene.json")).unwrap(), file, "{}", file.to_json());
}

#[test]
fn one_missing_texture_of_a_material_at_a_node_is_one_error() {
    let text = "(nodes: [(material: diffuse(albedo: image(file: \"none.png\")), children: [(shape: sphere()), (shape: sphere())])])";
    let file = parse_ron(text, Path::new("scene.ron")).unwrap();
    let error = resolve(&file, Path::new("scene.ron"), &LoadOptions::default()).unwrap_err();
    assert_eq!(error.diagnostics().len(), 1, "{error}");
    assert!(error.to_string().starts_with("scene.ron: nodes[0].material.albedo: `none.png`"), "{error}");
}

/// Error of a scene, in JSON if it begins like it.
fn said(text: &str) -> String {
    let is_json = text.starts_with("{\"");
    let path = Path::new(if is_json { "scene.json" } else { "scene.ron" });
    let parsed = if is_json { parse_json(text, path) } else { parse_ron(text, path) };
    match parsed {
        Err(error) => error.to_string(),
        Ok(file) => resolve(&file, path, &LoadOptions::default()).expect_err(text).to_string(),
    }
}

/// The first mistakes of newcomers to the format, found by making them. Each has the words that must be said.
const MISTAKES: &[(&str, &str)] = &[
    ("(camera: (position: (0, 1, 5)), nodes: [])", "unknown field `position` in camera; did you mean `look_from`?"),
    ("(camera: (eye: (0, 1, 5)), nodes: [])", "did you mean `look_from`?"),
    ("(camera: (look_from: (0, 1, 5), target: (0, 0, 0)), nodes: [])", "did you mean `look_at`?"),
    (r#"{"camera": {"origin": [0, 1, 5]}, "nodes": []}"#, "did you mean `look_from`?"),
    ("(camera: (look_from: [0, 1, 5]), nodes: [])", "expected (x, y, z) for `look_from`, found [0, 1, 5]"),
    ("(camera: (look_from: (0, 1)), nodes: [])", "expected (x, y, z) for `look_from`, found (0, 1)"),
    ("(camera: (look_from: 5), nodes: [])", "expected (x, y, z) for `look_from`, found 5"),
    ("(camera: (fov: \"40\"), nodes: [])", "expected a number for `fov`, found \"40\""),
    ("(nodes: [(shape: cube(size: 1))])", "unknown choice `cube` for `shape`; did you mean `box`?"),
    ("(nodes: [(shape: \"sphere\")])", "write `sphere` without quotes"),
    ("(nodes: [(shape: sphere)])", "needs parentheses: `sphere()`"),
    ("(nodes: [(shape: sphere(position: (0, 1, 0)))])", "did you mean `center`?"),
    ("(nodes: [(shape: sphere(), translate: (0, 1, 0))])", "write `transform: [translate(x, y, z)]`"),
    (
        "(nodes: [(shape: sphere(), transform: translate(0, 1, 0))])",
        "expected a list of steps in brackets for `transform`",
    ),
    ("(nodes: [(shape: sphere(), color: (1, 0, 0))])", "write `material: diffuse(albedo: ...)`"),
    ("(materials: {\"red\": diffuse(albedo: \"red\")}, nodes: [])", "expected a colour"),
    ("(materials: {\"red\": diffuse(albedo: (1, 0))}, nodes: [])", "(r, g, b)"),
    ("(materials: {\"red\": diffuse(albedo: \"#ff000080\")}, nodes: [])", "has an alpha component"),
    ("(materials: {red: diffuse(albedo: 1)}, nodes: [])", "put the name in quotes: \"red\""),
    ("(materials: [diffuse(albedo: 1)], nodes: [])", "expected names and values in braces"),
    ("(materials: {\"m\": lambert(color: 1)}, nodes: [])", "did you mean `diffuse`?"),
    ("(materials: {\"m\": diffuse(emissive: 1)}, nodes: [])", "did you mean `emission`?"),
    ("(materials: {\"m\": metal(metal: gold, alpha: 0.1)}, nodes: [])", "did you mean `roughness`?"),
    ("(nodes: [(shape: sphere(), material: red)])", "put the name of a material in quotes: \"red\""),
    ("(lights: [point(intensity: 1)], nodes: [])", "`point` needs the field `position`"),
    ("(lights: [sun(direction: (0, -1, 0))], nodes: [])", "did you mean `directional`?"),
    ("(lights: point(position: (0, 1, 0)), nodes: [])", "expected a list in brackets for `lights`"),
    ("(film: (width: 640, height: 480), nodes: [])", "write `size: (width, height)`"),
    ("(settings: (samples: 64), nodes: [])", "did you mean `spp`?"),
    ("(objects: [])", "did you mean `nodes`?"),
    ("(camera: (look_from: (0, 1, 5) look_at: (0, 0, 0)), nodes: [])", "expected a comma"),
    ("(nodes: [(shape: sphere()])", "`)` is missing"),
    ("(camera = (fov: 40), nodes: [])", "expected `:` after the name of a field"),
    ("{nodes: []}", "expected a scene, which begins with `(`"),
    (r#"{"nodes": [{"shape": "sphere"}]}"#, "{\"sphere\": {}}"),
    (r#"{"camera": {"look_from": "0 1 5"}, "nodes": []}"#, "expected [x, y, z] for `look_from`, found \"0 1 5\""),
    (r#"{"camera": {"look_from": [0, 1]}, "nodes": []}"#, "expected [x, y, z] for `look_from`, found [0, 1]"),
    (r#"{"materials": {"m": {"diffuse": {"albedo": true}}}, "nodes": []}"#, "expected a colour"),
    (r#"{"materials": {"m": {"diffuse": {"albedo": [1, 0]}}}, "nodes": []}"#, "[r, g, b]"),
    (r#"{"nodes": [{"shape": {"sphere": {}}, "material": 3}]}"#, "expected a material"),
    (r#"{"nodes": [],}"#, "comma"),
    ("(settings: (spp: 1.5), nodes: [])", "expected a whole number from 0 up for `spp`, found 1.5"),
    ("(film: (size: (120.5, 90)), nodes: [])", "expected a whole number from 0 up for `size`, found 120.5"),
    ("(materials: {\"m\": diffuse(albedo: gray(0.5, 0.2))}, nodes: [])", "`gray` takes one value: remove this one"),
    ("(nodes: [(shape: sphere(), transform: [translate(1, 2)])])", "`translate` takes 3 values, found translate(1, 2)"),
    ("(materials: {\"m\": diffuse(albedo: texture(\"a.png\"))}, nodes: [])", "write `image(file: \"...\")`"),
    ("(materials: {\"m\": glass(ior: 1.5, priority: 2.5)}, nodes: [])", "for `priority`, found 2.5"),
    (r#"{"settings": {"integrator": 7}, "nodes": []}"#, "expected one of `whitted`, "),
    (r#"{"nodes": [{"shape": 5}]}"#, "for `shape`, found 5"),
    (r#"{"nodes": [{"shape": }]}"#, "expected a value"),
];

/// Messages that advised what was written, or what was refused next. Null as the value of a choice was accepted.
#[test]
fn advice_on_choices_can_be_followed() {
    for (text, words) in [
        ("(film: (filter: gaussian), nodes: [])", "`gaussian` needs a value in parentheses, `gaussian(...)`: a number"),
        ("(film: (filter: gaussian()), nodes: [])", "`gaussian` needs a value in its parentheses: a number"),
        ("(film: (encoding: gamma()), nodes: [])", "`gamma` needs a value in its parentheses: a number"),
        ("(background: constant(), nodes: [])", "`constant` needs a value in its parentheses: a colour: a number, "),
        ("(lights: [ambient()], nodes: [])", "`ambient` needs a value in its parentheses: a colour: a number, "),
        ("(materials: {\"m\": mix()}, nodes: [])", "`mix` needs a value in its parentheses: a list in brackets"),
        ("(nodes: [(material: mix())])", "`mix` needs a value in its parentheses: a list in brackets"),
        ("(nodes: [(transform: [rotate_x()])])", "`rotate_x` needs a value in its parentheses: a number"),
        ("(nodes: [(transform: [translate])])", "needs a value in parentheses, `translate(...)`: 3 values"),
        ("(lights: [point], nodes: [])", "`point` needs parentheses: `point(position: ...)`"),
        ("(film: (filter: \"gaussian\"), nodes: [])", "write `gaussian(...)` without quotes, with a number"),
        ("(settings: (integrator: path()), nodes: [])", "this choice takes no value: remove the parentheses"),
        ("(film: (filter: box()), nodes: [])", "this choice takes no value: remove the parentheses"),
        (r#"{"film": {"filter": "gaussian"}, "nodes": []}"#, "write {\"gaussian\": ...}, with a number"),
        (r#"{"lights": ["point"], "nodes": []}"#, "write {\"point\": {\"position\": ...}}"),
        (r#"{"film": {"filter": {"gaussian": {}}}, "nodes": []}"#, "expected a number for `gaussian`, found {}"),
        (r#"{"film": {"filter": {"box": {}}}, "nodes": []}"#, "`box` takes no value: write \"box\""),
        (r#"{"settings": {"integrator": {"path": {}}}, "nodes": []}"#, "`path` takes no value: write \"path\""),
        (r#"{"film": {"filter": { "box" : null } }, "nodes": []}"#, "`box` takes no value: write \"box\" instead of"),
        (r#"{"nodes": [{"material": {"metal": {"metal": {"gold": null}}}}]}"#, "`gold` takes no value: write \"gold\""),
    ] {
        assert!(said(text).contains(words), "{text}\n{words}\n{}", said(text));
    }
}

/// Hints named fields that the material does not have.
#[test]
fn hints_name_fields_that_the_material_has() {
    for (material, words) in [
        ("mirror(metalness: 0.5)", "unknown field `metalness` in mirror; known are `reflectance`"),
        ("glass(metalness: 0.5)", "in glass; known are `ior`"),
        ("glossy(rough: 0.5)", "did you mean `exponent`?"),
        ("mirror(rough: 0.5)", "in mirror; known are `reflectance`"),
        ("thin_glass(rough: 0.5)", "in thin_glass; known are `ior`, `transmittance`"),
        ("glossy(eta: 1.5)", "in glossy; known are `diffuse`"),
        ("thin_glass(albedo: 1)", "did you mean `transmittance`?"),
        ("metallic_roughness(metalness: 1)", "did you mean `metallic`?"),
    ] {
        let said = said(&format!("(materials: {{\"m\": {material}}}, nodes: [])"));
        assert!(said.contains(words), "{material}\n{words}\n{said}");
    }
}

/// `Path` was taken for a synonym of `file`, and capitals were as far from their words as other letters.
#[test]
fn words_in_capitals_are_recognised() {
    for (text, word) in [
        ("(settings: (integrator: Path), nodes: [])", "path"),
        ("(settings: (integrator: PATH), nodes: [])", "path"),
        ("(settings: (accel: BVH), nodes: [])", "bvh"),
        ("(settings: (accel: KD), nodes: [])", "kd"),
        ("(film: (tone: ACES), nodes: [])", "aces"),
        ("(film: (filter: BOX), nodes: [])", "box"),
        ("(film: (encoding: sRGB), nodes: [])", "srgb"),
        ("(materials: {\"red\": mirror()}, nodes: [(material: \"rde\")])", "red"),
        (r#"{"settings": {"integrator": "Path"}, "nodes": []}"#, "path"),
    ] {
        let words = format!("did you mean `{word}`?");
        assert!(said(text).contains(&words), "{text}\n{words}\n{}", said(text));
    }
}

/// The note on decimals followed any number in place of a name.
#[test]
fn only_commas_between_digits_are_taken_for_decimal_points() {
    for (text, words, is_decimal) in [
        ("(background: 0.5, nodes: [])", "expected one of `constant`, `gradient`, `image` for `background`", false),
        (
            "(nodes: [(shape: sphere(2))])",
            "expected the name of a field, found `2`; known are `center`, `radius`",
            false,
        ),
        ("(nodes: [(material: diffuse(0.8))])", "found `0.8`; known are `albedo`", false),
        ("(nodes: [(material: diffuse(albedo: checker(0.1, 0.5)))])", "found `0.1`; known are `even`", false),
        ("(nodes: [(shape: sphere(radius: 1,5))])", "expected the name of a field, found `5` (decimals", true),
    ] {
        let said = said(text);
        assert!(said.contains(words), "{text}\n{words}\n{said}");
        assert_eq!(said.contains("decimals"), is_decimal, "{text}\n{said}");
    }
}

/// Objects in place of other values were an "unexpected value".
#[test]
fn objects_in_place_of_lists_are_explained() {
    for (text, words) in [
        (r#"{"nodes": {"shape": {"sphere": {}}}}"#, "expected a list in brackets for `nodes`"),
        (r#"{"nodes": [{"transform": {"translate": [1, 0, 0]}}]}"#, "expected a list of steps in brackets"),
        (r#"{"lights": {"ambient": 0.2}, "nodes": []}"#, "expected a list in brackets for `lights`"),
        (r#"{"nodes": [{"shape": {"triangle": {}}}]}"#, "expected 3 values in brackets for `triangle`, found {}"),
        (r#"{"film": {"size": {"w": 3}}, "nodes": []}"#, "expected two values: [a, b] for `size`"),
        (r#"{"nodes": [[null]]}"#, "expected fields in braces"),
    ] {
        assert!(said(text).contains(words), "{text}\n{words}\n{}", said(text));
    }
}

/// Messages of JSON scenes with an array in place of an object. Its order of fields was that of the source.
#[test]
fn arrays_in_place_of_objects_are_refused() {
    for (text, field) in [
        (r#"{"nodes": [{"shape": {"sphere": [[5, 0, 0], 2]}}]}"#, "for `sphere`, found [[5, 0, 0], 2]"),
        (r#"{"nodes": [{"shape": {"box": [[0, 0, 0], [1, 1, 1]]}}]}"#, "for `box`, found [[0, 0, 0], [1, 1, 1]]"),
        (r#"{"nodes": [["a"]]}"#, "for `nodes`, found [\"a\"]"),
        (r#"{"nodes": [[]]}"#, "for `nodes`, found []"),
        (r#"{"nodes": [], "film": [[16, 10]]}"#, "for `film`, found [[16, 10]]"),
        (r#"{"nodes": [], "settings": ["path"]}"#, "for `settings`, found [\"path\"]"),
        (r#"{"nodes": [], "camera": ["cam", [0, 1, 5]]}"#, "for `camera`, found [\"cam\", [0, 1, 5]]"),
        (r#"{"nodes": [], "materials": {"m": {"diffuse": [0.5]}}}"#, "for `diffuse`, found [0.5]"),
        (r#"{"nodes": [{"material": {"diffuse": [0.5]}}]}"#, "for `diffuse`, found [0.5]"),
        (r#"{"nodes": [{"material": {"diffuse": {"albedo": {"checker": [1, 0]}}}}]}"#, "for `checker`, found [1, 0]"),
        (r#"{"nodes": [{"transform": [{"rotate": [[0, 1, 0], 5]}]}]}"#, "for `rotate`, found [[0, 1, 0], 5]"),
    ] {
        let said = said(text);
        let expected = format!("expected fields in braces: {{\"name\": value, ...}} {field}");
        assert!(said.contains(&expected), "{text}\n{said}");
    }
    let error = parse_json(r#"[null, "name"]"#, Path::new("scene.json")).expect_err("an array").to_string();
    assert!(error.contains("expected a scene, which begins with `{`"), "{error}");
}

/// Words of Rust and of the libraries behind the parser.
const FOREIGN: [&str; 19] = [
    "serde",
    "enum",
    "struct",
    "untagged",
    "variant",
    "f64",
    "u64",
    "tuple",
    "identifier",
    "Option",
    "Some",
    "newtype",
    "sequence",
    "SceneFile",
    "RawValue",
    "deserial",
    "float",
    "integer",
    "type:",
];

#[test]
fn the_first_mistakes_are_explained_in_words_of_the_format() {
    let mut faults = Vec::new();
    for (text, words) in MISTAKES {
        let said = said(text);
        let first = said.lines().next().unwrap_or_default();
        let foreign = FOREIGN.iter().find(|word| first.contains(*word));
        if !first.contains(words) || foreign.is_some() {
            faults.push(format!(
                "{text}\n    expected: {words}; foreign: {foreign:?}\n    {}",
                said.replace('\n', "\n    ")
            ));
        }
    }
    assert!(faults.is_empty(), "{} of {}\n{}", faults.len(), MISTAKES.len(), faults.join("\n"));
}

/// A group of a cycle was reported once more where it is placed, as unknown.
#[test]
fn groups_that_contain_each_other_are_one_error() {
    let said = said("(groups: {\"a\": [(instance: \"b\")], \"b\": [(instance: \"a\")]}, nodes: [(instance: \"a\")])");
    assert_eq!(said, "scene.ron: groups: groups contain each other: a -> b -> a; remove one of the instances");
}

#[test]
fn the_line_is_shown_with_a_caret() {
    let said = said("(\n    camera: (fov: \"40\"),\n    nodes: [],\n)");
    let expected = "scene.ron:2:19: expected a number for `fov`, found \"40\"\n    2 |     camera: (fov: \"40\"),\n      |                   ^";
    assert_eq!(said, expected);
}

#[test]
fn of_a_long_line_the_part_around_the_mistake_is_shown() {
    let numbers = "(0, 0, 0), ".repeat(10_000);
    let said = said(&format!("(nodes: [(shape: strip([{numbers}(0, \"a\", 0)]))])"));
    assert!(said.len() < 500, "{} bytes", said.len());
    let lines: Vec<&str> = said.lines().collect();
    assert_eq!(lines.len(), 3, "{said}");
    let caret = lines[2].chars().position(|c| c == '^').unwrap();
    assert_eq!(lines[1].chars().skip(caret).take(3).collect::<String>(), "\"a\"", "{said}");
}

#[test]
fn orders_for_terminals_in_the_line_are_written_out() {
    let said = said("(\tname: \"\u{1b}[2J\", fov: 40, nodes: [])");
    assert!(!said.contains('\u{1b}') && !said.contains('\t'), "{said:?}");
    let lines: Vec<&str> = said.lines().collect();
    let caret = lines[2].chars().position(|c| c == '^').unwrap();
    assert!(lines[1].chars().skip(caret).collect::<String>().starts_with("fov"), "{said}");
}
