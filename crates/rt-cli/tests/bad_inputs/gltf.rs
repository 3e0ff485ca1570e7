//! glTF documents that contradict themselves.

use crate::input::Input;

/// A document with these parts, of which arrays of a triangle are given: 36 bytes of positions, 6 of indices.
fn gltf(parts: &str) -> Input {
    Input::file("m.gltf", format!(r#"{{"asset": {{"version": "2.0"}}, {parts}}}"#))
}

/// A triangle whose accessors, views and buffers may be replaced.
fn triangle(accessors: &str, views: &str, buffers: &str) -> Input {
    gltf(&format!(
        r#""nodes": [{{"mesh": 0}}], "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "indices": 1}}]}}],
           "accessors": [{accessors}], "bufferViews": [{views}], "buffers": [{buffers}]"#
    ))
}

const POSITIONS: &str = r#"{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}"#;
const INDICES: &str = r#"{"bufferView": 1, "componentType": 5121, "count": 3, "type": "SCALAR"}"#;
const VIEWS: &str = r#"{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 4}"#;
/// Nine zeros as floats and four bytes.
const BUFFER: &str = r#"{"byteLength": 40, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAECAA=="}"#;

/// A triangle with other accessors.
fn accessors(accessors: &str) -> Input {
    triangle(accessors, VIEWS, BUFFER)
}

/// An accessor in place of that of the positions.
fn positions(accessor: &str) -> Input {
    accessors(&format!("{accessor}, {INDICES}"))
}

pub(crate) fn node_cycle_or_two_parents() -> Vec<Input> {
    vec![
        gltf(r#""nodes": [{"children": [1]}, {"children": [0]}]"#).refused(&["m.gltf: nodes", "cycle"]),
        gltf(r#""nodes": [{"children": [0]}]"#).refused(&["m.gltf: nodes"]),
        gltf(r#""nodes": [{"children": [2]}, {"children": [2]}, {}]"#)
            .refused(&["m.gltf: nodes[2]: has two parents, 0 and 1"]),
    ]
}

pub(crate) fn node_depth_50_000() -> Input {
    let links: Vec<String> = (1..50_000).map(|child| format!(r#"{{"children": [{child}]}}"#)).collect();
    gltf(&format!(r#""nodes": [{}, {{}}]"#, links.join(","))).refused(&["m.gltf", "1025, above the limit of 1024"])
}

pub(crate) fn child_index_out_of_range() -> Input {
    gltf(r#""nodes": [{"children": [7]}]"#).refused(&["m.gltf", "nodes[0].children[0]"])
}

pub(crate) fn accessor_count_zero() -> Input {
    positions(&POSITIONS.replace("\"count\": 3", "\"count\": 0")).refused(&["m.gltf: accessors[0]"])
}

pub(crate) fn count_times_stride_overflow() -> Vec<Input> {
    let with = |count: &str| positions(&POSITIONS.replace("\"count\": 3", &format!("\"count\": {count}")));
    vec![
        with("4000000000").refused(&["m.gltf: ", "4000000000 elements of 12 bytes"]),
        with("18446744073709551615").refused(&["m.gltf: "]),
        positions(&POSITIONS.replace("\"count\"", "\"byteOffset\": 18446744073709551615, \"count\""))
            .refused(&["m.gltf: "]),
    ]
}

pub(crate) fn buffer_view_past_buffer() -> Input {
    let views = VIEWS.replace("36}", "36000}");
    triangle(&format!("{POSITIONS}, {INDICES}"), &views, BUFFER).refused(&["m.gltf: bufferViews[0]"])
}

pub(crate) fn byte_length_of_a_terabyte() -> Input {
    let buffer = r#"{"byteLength": 1000000000000, "uri": "data:application/octet-stream;base64,AAAAAA=="}"#;
    triangle(&format!("{POSITIONS}, {INDICES}"), VIEWS, buffer).refused(&["m.gltf: buffers[0]"])
}

pub(crate) fn float_indices() -> Input {
    let indices = INDICES.replace("5121", "5126").replace("\"bufferView\": 1", "\"bufferView\": 0");
    accessors(&format!("{POSITIONS}, {indices}"))
        .refused(&["m.gltf: meshes[0].primitives[0].indices: ", "must hold unsigned"])
}

pub(crate) fn missing_position() -> Input {
    gltf(r#""nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {}}]}]"#)
        .refused(&["m.gltf: meshes[0].primitives[0]", "POSITION"])
}

pub(crate) fn sparse_accessor_out_of_range() -> Vec<Input> {
    let sparse = r#""sparse": {"count": 1, "indices": {"bufferView": 0, "byteOffset": 36, "componentType": 5121}, "values": {"bufferView": 0}}, "count""#;
    let big = r#""sparse": {"count": 9, "indices": {"bufferView": 1, "componentType": 5121}, "values": {"bufferView": 0}}, "count""#;
    [sparse, big].map(|sparse| positions(&POSITIONS.replace("\"count\"", sparse)).refused(&["m.gltf: "])).into()
}

/// A container of these chunks, whose header claims `length` bytes.
fn glb(chunks: &[(&[u8; 4], &str)], length: Option<u32>) -> Vec<u8> {
    let mut body = Vec::new();
    for (kind, data) in chunks {
        body.extend((data.len() as u32).to_le_bytes());
        body.extend(*kind);
        body.extend(data.as_bytes());
    }
    let length = length.unwrap_or(body.len() as u32 + 12);
    [&b"glTF"[..], &2_u32.to_le_bytes(), &length.to_le_bytes(), &body].concat()
}

const DOCUMENT: &str = r#"{"asset": {"version": "2.0"} }"#;

pub(crate) fn container_length_lies() -> Vec<Input> {
    let with = |length| Input::file("m.glb", glb(&[(b"JSON", &format!("{DOCUMENT}  "))], Some(length)));
    [0, 11, 20, u32::MAX].map(|length| with(length).refused(&["m.glb: "])).into()
}

pub(crate) fn chunk_order_wrong() -> Vec<Input> {
    let json = format!("{DOCUMENT}  ");
    vec![
        Input::file("m.glb", glb(&[(b"BIN\0", "abcd"), (b"JSON", &json)], None)).refused(&["m.glb: "]),
        Input::file("m.glb", glb(&[(b"BIN\0", "abcd")], None)).refused(&["m.glb: "]),
    ]
}

pub(crate) fn bad_base64() -> Input {
    let buffer = BUFFER.replace("AAEC", "A*EC");
    triangle(&format!("{POSITIONS}, {INDICES}"), VIEWS, &buffer).refused(&["m.gltf: buffers[0]", "base64"])
}

pub(crate) fn unknown_required_extension() -> Input {
    gltf(r#""extensionsUsed": ["EXT_not_there"], "extensionsRequired": ["EXT_not_there"]"#)
        .refused(&["m.gltf", "EXT_not_there"])
}

pub(crate) fn version_9() -> Input {
    Input::file("m.gltf", r#"{"asset": {"version": "9.0"}}"#).refused(&["m.gltf: asset", "9.0"])
}

pub(crate) fn scene_without_nodes() -> Input {
    let scene = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"name": "empty"}]}"#;
    Input::file("m.gltf", scene).shown(&["m.gltf: scene: there are no triangles in the scene"])
}
