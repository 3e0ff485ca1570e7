//! Primitives that use few vertices of their accessors.

use super::*;

/// Each primitive read all vertices of its accessors: 3000 primitives of one triangle over 200,000 vertices took half a minute.
#[test]
fn primitives_of_few_indices_read_only_the_vertices_that_they_use() {
    let numbers: Vec<f32> = (0..300).map(|i| (i * i % 97) as f32).collect();
    let mut arrays = Arrays::default().with("VEC3", &numbers).with("VEC3", &numbers);
    arrays.push("SCALAR", 5121, 6, &[7, 3, 90, 90, 3, 8]);
    let model = arrays.model(
        r#""meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2}]}], "nodes": [{"mesh": 0}]"#,
    );
    let data = model.mesh_data(0);
    assert_eq!(data.triangles, [[1, 0, 3], [3, 0, 2]]);
    let vertex = |i: usize| Vec3::from_slice(&numbers[3 * i..]);
    assert_eq!(data.positions, [3, 7, 8, 90].map(vertex));
    assert_eq!(data.normals, [3, 7, 8, 90].map(|i| vertex(i).as_dvec3().normalize().as_vec3()));
}

/// Twelve vertices, of which two positions are sparse, and colours with gaps between them.
fn load_indices(indices: &[u8]) -> Result<Model, LoadError> {
    let position = |i: usize| [i as f32, (i * i % 7) as f32, (i % 3) as f32];
    let mut bytes: Vec<u8> = (0..12).flat_map(position).flat_map(f32::to_le_bytes).collect();
    bytes.extend((0..12).flat_map(|i: u8| [20 * i, 255 - 20 * i, 7, 255, 1, 2, 3, 4]));
    bytes.extend([5, 9, 0, 0]);
    bytes.extend([0.5, 40.0, -3.0, 80.0, 81.0, 82.0_f32].into_iter().flat_map(f32::to_le_bytes));
    bytes.extend(indices);
    let json = format!(
        r#"{{"asset": {{"version": "2.0"}}, "buffers": [{{"byteLength": {}}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 144}},
            {{"buffer": 0, "byteOffset": 144, "byteLength": 96, "byteStride": 8}},
            {{"buffer": 0, "byteOffset": 240, "byteLength": 2}}, {{"buffer": 0, "byteOffset": 244, "byteLength": 24}},
            {{"buffer": 0, "byteOffset": 268, "byteLength": {count}}}],
        "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 12, "type": "VEC3", "sparse": {{"count": 2,
                "indices": {{"bufferView": 2, "componentType": 5121}}, "values": {{"bufferView": 3}}}}}},
            {{"bufferView": 1, "componentType": 5121, "normalized": true, "count": 12, "type": "VEC4"}},
            {{"bufferView": 4, "componentType": 5121, "count": {count}, "type": "SCALAR"}}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0, "COLOR_0": 1}}, "indices": 2}}]}}],
        "nodes": [{{"mesh": 0}}]}}"#,
        bytes.len(),
        count = indices.len(),
    );
    load_glb(json, &bytes, &LoadOptions::default())
}

/// With as many indices as vertices, all vertices are read.
#[test]
fn used_vertices_have_the_numbers_that_they_have_among_all() {
    const FEW: [u8; 6] = [5, 1, 7, 1, 7, 11];
    let corners = |indices: &[u8]| {
        let data = load_indices(indices).expect("a model").mesh_data(0).clone();
        assert_eq!(data.positions.len(), data.colors.len());
        let of_corner = |corner: u32| (data.positions[corner as usize], data.colors[corner as usize]);
        (data.positions.len(), data.triangles.iter().map(|corners| corners.map(of_corner)).collect::<Vec<_>>())
    };
    let (n_few, of_few) = corners(&FEW);
    let (n_all, of_all) = corners(&FEW.repeat(2));
    assert_eq!((n_few, n_all), (4, 12));
    assert_eq!([&of_few[..], &of_few[..]].concat(), of_all);
    assert_eq!(of_few[0][0].0, Vec3::new(0.5, 40.0, -3.0), "the sparse position");
}

#[test]
fn few_indices_out_of_range_have_the_message_of_many() {
    let message = |indices: &[u8]| load_indices(indices).expect_err("an index out of range").to_string();
    assert_eq!(message(&[5, 1, 99]), message(&[5, 1, 99].repeat(4)));
}
