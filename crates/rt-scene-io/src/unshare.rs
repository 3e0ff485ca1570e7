//! Meshes whose faces share no vertices.

use rt_geometry::MeshData;

/// Replaces the vertices by copies of those in `corners`, in this order. Triangles keep their indices.
pub(crate) fn unshare(data: &mut MeshData, corners: &[u32]) {
    copy(&mut data.positions, corners);
    copy(&mut data.normals, corners);
    copy(&mut data.uvs, corners);
    copy(&mut data.second_uvs, corners);
    copy(&mut data.colors, corners);
    copy(&mut data.tangents, corners);
}

fn copy<T: Copy>(list: &mut Vec<T>, elements: &[u32]) {
    if !list.is_empty() {
        *list = elements.iter().map(|element| list[*element as usize]).collect();
    }
}
