//! Faces and materials of OBJ files.

use crate::input::{Content, Input};

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

fn obj(rest: &str) -> Input {
    Input::file("m.obj", format!("{SQUARE}{rest}"))
}

pub(crate) fn face_index_zero() -> Input {
    obj("f 0 1 2\n").refused(&["m.obj:5: vertex 0 of the face is out of range: 4 come before it (indices start at 1)"])
}

pub(crate) fn face_index_beyond_count() -> Vec<Input> {
    vec![
        obj("f 1 2 5\n").refused(&["m.obj:5: vertex 5 of the face is out of range: 4 come before it"]),
        obj("f 1 2 5\nf 1 2 3\nf 1 2 6\n").refused(&["m.obj:5: ", "m.obj:7: "]),
    ]
}

pub(crate) fn negative_face_index_beyond_start() -> Input {
    obj("f 1 2 -5\n").refused(&["m.obj:5: vertex -5 of the face is out of range: 4 come before it"])
}

pub(crate) fn face_index_overflow() -> Input {
    obj("f 1 2 9223372036854775808\n").refused(&["m.obj:5: `9223372036854775808` is not a whole number of 64 bits"])
}

pub(crate) fn face_with_two_vertices() -> Input {
    obj("f 1 2\nf 1 2 3\n").shown(&["m.obj:5: face with fewer than three corners: left out\n"])
}

pub(crate) fn face_with_repeated_vertex() -> Input {
    obj("f 1 2 2\nf 1 2 3\n").shown(&["m.obj", "triangles without area were dropped: 1 of 2"])
}

pub(crate) fn million_sided_polygon() -> Input {
    let face = Content { head: format!("{SQUARE}f").into(), part: " 1 2 3 4".into(), times: 250_000, tail: Vec::new() };
    Input::long("m.obj", face).refused(&["m.obj:5: a face has 1000000 corners; it may have at most 100000"])
}

pub(crate) fn bent_or_crossed_polygon() -> Vec<Input> {
    let polygon = |points: &str| Input::node(&format!("shape: polygon(points: [{points}])"));
    vec![
        polygon("(0, 0, 0), (1, 0, 0), (1, 1, 0.5), (0, 1, 0)").refused(&[
            "scene.ron:1:",
            ": nodes[0].shape: the polygon is not flat",
            "off its plane",
        ]),
        polygon("(0, 0, 0), (2, 0, 0), (0, 1, 0), (2, 1, 0)")
            .refused(&["scene.ron:1:", ": nodes[0].shape: the outline of the polygon has no area"]),
        obj("v 2 0.5 0.7\nf 1 2 5 3 4\n").shown(&["m.obj", "faces with more than four corners are not flat: 1"]),
    ]
}

pub(crate) fn zero_or_missing_normals() -> Vec<Input> {
    vec![
        obj("vn 0 0 0\nf 1//1 2//1 3//1\n")
            .shown(&["m.obj", "normals that are zero or not finite were replaced by those of a triangle: 3"]),
        obj("vn 0 0 1\nf 1//7 2//1 3//1\n").shown(&["m.obj:6: missing normal or texture coordinate: left out"]),
    ]
}

pub(crate) fn missing_material_library() -> Vec<Input> {
    vec![
        Input::file("m.obj", format!("mtllib none.mtl\n{SQUARE}usemtl red\nf 1 2 3\n"))
            .shown(&["m.obj:1: the material library `none.mtl` does not exist; plain grey is used for its materials"]),
        obj("usemtl red\nf 1 2 3\n").shown(&["the material `red` is not defined in a library"]),
    ]
}

/// `rt-scene-io/tests/strictness.rs` has more of them, in PLY and pbrt files as well.
pub(crate) fn surplus_of_models() -> Input {
    Input::file("m.obj", format!("mtllib m.mtl\n{SQUARE}usemtl a\nf 1 2 3\n"))
        .with_file("m.mtl", "newmtl a\nKd 1 0 0\nKm 0.5\n")
        .shown(&["m.mtl:3: unsupported statement `Km`: left out"])
}

pub(crate) fn absolute_texture_of_mtl() -> Input {
    Input::file("m.obj", format!("mtllib m.mtl\n{SQUARE}usemtl a\nf 1 2 3\n"))
        .with_file("m.mtl", "newmtl a\nKd 1 0 0\nmap_Kd /absolute.png\n")
        .shown(&["the path of the image `/absolute.png` is absolute; the plain colour is used"])
}
