use super::*;
use crate::default_scene::scene_for_model;
use crate::{LoadOptions, format};
use rt_geometry::Shape;
use rt_shading::ColorTexture;

const HEAD: &str = "b 0.1 0.2 0.3\nv\nfrom 0 0 5\nat 0 0 0\nup 0 1 0\nangle 45\nhither 1\nresolution 32 24\n";
const FILL: &str = "f 1 0.5 0 0.8 0.2 12 0 0\n";

fn load_text(text: &str) -> Result<Model, LoadError> {
    load_bytes(text.as_bytes(), Path::new("m.nff"))
}

fn refused(text: &str) -> String {
    load_text(text).expect_err("a bad file").to_string()
}

#[test]
fn a_whole_file_becomes_a_model() {
    let text = format!(
        "# c\n{HEAD}l 1 2 3\nl 4 5 6 0.5 0.25 0\n{FILL}s 0 0 0 1 # ball\nc\n0 0 0 1\n0 1 0 0.5\np 3\n0 0 0\n1 0 0\n0 1 0\n"
    );
    let model = load_text(&text).expect("a model");
    assert_eq!((model.cameras.len(), model.image_size), (1, Some([32, 24])));
    assert_eq!(model.background, Some(Background::Constant(Color::from_rgb([0.1, 0.2, 0.3]))));
    let root = 1.0 / 2f64.sqrt();
    let lights: Vec<_> = model.lights.iter().map(|light| light.intensity).collect();
    assert_eq!(lights, [Rgb::gray(root), Rgb::new(0.5, 0.25, 0.0)]);
    assert_eq!(
        model.notes,
        ["1 of 2 lights have no colour in the file: each has the intensity 1/sqrt(number of lights) = 0.707."]
    );
    let shapes: Vec<_> = model.nodes.iter().map(|node| (node.name.as_str(), node.content.as_ref())).collect();
    assert!(matches!(shapes[0], ("line 13", Some(Content::Shape(Shape::Sphere(_))))));
    assert!(matches!(shapes[1], ("line 14", Some(Content::Shape(Shape::Frustum(_))))));
    assert!(matches!(shapes[2], ("line 17", Some(Content::Shape(Shape::Triangle(_))))));
    assert_eq!(model.materials[0].to_phong().mirror, ColorTexture::Constant(Rgb::gray(0.2)));
    assert_eq!(model.warnings, []);
}

#[test]
fn a_bare_file_keeps_its_lights_as_they_are() {
    let model = load_text(&format!("{HEAD}l 1 2 3\n{FILL}s 0 0 0 1")).expect("a model");
    let (file, _) = scene_for_model(&model, &model, "m.nff", &LoadOptions::default());
    assert_eq!((file.film.exposure, file.film.tone), (0.0, format::Film::default().tone));
    assert_eq!(file.film.size, (32, 24));
    assert_eq!(file.background, model.background);
    let lights = file.lights.expect("lights");
    assert!(matches!(&lights[..], [format::Light::Point { falloff: format::Falloff::None, .. }]), "{lights:?}");
}

#[test]
fn equal_fills_are_one_material() {
    let other = "f 0 1 0 1 0 1 0 0\n";
    let model = load_text(&format!("{FILL}s 0 0 0 1\n{other}s 2 0 0 1\n{FILL}s 4 0 0 1")).expect("a model");
    let ids: Vec<_> = model.nodes.iter().map(|node| node.material.0).collect();
    assert_eq!(ids, [0, 1, 0]);
}

#[test]
fn many_polygons_of_a_fill_become_one_mesh() {
    let quads: String = (0..40).map(|x| format!("p 4 {x} 0 0 {} 0 0 {} 1 0 {x} 1 0\n", x + 1, x + 1)).collect();
    let model = load_text(&format!("{FILL}{quads}")).expect("a model");
    assert_eq!((model.nodes.len(), model.meshes.len()), (1, 1));
    let data = model.mesh_data(0);
    assert_eq!((data.triangles.len(), data.positions.len()), (80, 82));
}

#[test]
fn patches_have_normals() {
    let model = load_text(&format!("{FILL}pp 3\n0 0 0 0 0 1\n1 0 0 1 0 1\n0 1 0 0 0 1\n")).expect("a model");
    assert_eq!(model.mesh_data(0).normals.len(), 3);
    assert_eq!(model.nodes[0].name, "patches of fill 1");
}

#[test]
fn repairs_are_reported() {
    let model = load_text("s 0 0 0 -1\ns 0 0 4 -1\np 3 0 0 0 1 1 1 2 2 2\np 3 0 0 0 1 0 0 0 1 0").expect("a model");
    let warnings: Vec<_> = model.warnings.iter().map(|w| format!("{}: {}", w.place, w.message)).collect();
    assert_eq!(
        warnings,
        [
            "m.nff:1: an object comes before the first fill colour; plain grey is used",
            "m.nff: polygons of no fill: triangles without area were dropped: 1 of 1",
            "m.nff: polygons of no fill: no triangles are left; the mesh is left out",
            "m.nff:1: spheres and cones of negative radius are visible from both sides, not only from inside (2 times, this is the first)",
        ]
    );
    assert_eq!(model.nodes.len(), 3);
}

#[test]
fn every_bad_line_is_named() {
    let text = format!(
        "{HEAD}l 1 2\n{FILL}s 0 0 0 0\ns 1 2 x 4\ns 1 2 3 4 5\nc 0 0 0 1 0 0 0 1\np 2 0 0 0 1 1 1\nq 1 2 3\nf 1 1 1 1 1 1 0.5 0\nb 0 0 0\nv from 1 2 3\npp 3 0 0 0 0 0 1 1 0 0"
    );
    let message = refused(&text);
    assert_eq!(
        message.lines().collect::<Vec<_>>(),
        [
            "m.nff:10: `f` is not a number; expected a coordinate of the light",
            "m.nff:11: radius 0 must be positive (at least 1e-60)",
            "m.nff:12: `x` is not a number; expected a coordinate of the centre",
            "m.nff:13: `5` is one number too many for the statement before it: remove it",
            "m.nff:14: [0, 0, 0] is the middle of both ends of a cone: move one of them",
            "m.nff:15: 2 is not a number of corners: a polygon has 3 or more",
            "m.nff:16: unknown statement `q`; known are `v`, `b`, `l`, `f`, `c`, `s`, `p`, `pp`",
            "m.nff:17: 0 is not an index of refraction of a transparent material: give at least 1",
            "m.nff:18: the background is given twice: keep one",
            "m.nff:19: the view has no `at`: add it",
            "m.nff:20: the end of the file comes before a component of a normal",
        ]
    );
}

#[test]
fn files_without_objects_are_refused() {
    for text in ["# nothing", HEAD, "f 1 1 1 1 0 1 0 0"] {
        assert_eq!(refused(text), "m.nff: has no objects: none of `s`, `c`, `p` and `pp`");
    }
}

#[test]
fn after_twenty_problems_the_rest_is_counted() {
    let message = refused(&"s 0 0 0 0\n".repeat(500));
    assert_eq!(message.lines().count(), 21);
    assert!(message.ends_with("480 more errors are not listed; fix these first"), "{message}");
}

#[test]
fn line_ends_marks_and_encodings_do_not_matter() {
    let text = format!("{HEAD}{FILL}s 0 0 0 1\n");
    for variant in [text.replace('\n', "\r\n"), text.replace('\n', "\r"), format!("\u{feff}{text}")] {
        assert_eq!(load_text(&variant).expect("a model").nodes.len(), 1);
    }
    let latin = [b"# caf\xe9\n", text.as_bytes()].concat();
    assert!(load_bytes(&latin, Path::new("m.nff")).is_ok());
}
