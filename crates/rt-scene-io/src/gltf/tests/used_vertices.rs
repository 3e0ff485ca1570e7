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
