//! Meshes from the arrays of model files, with a warning for each kind of repair.

use rt_geometry::{MeshData, MeshError, TriangleMesh};

use crate::Warning;

/// Builds a mesh; `None`, with a warning, if no triangle is left.
pub(crate) fn build_mesh(
    data: MeshData,
    place: &str,
    warnings: &mut Vec<Warning>,
) -> Result<Option<TriangleMesh>, MeshError> {
    let total = data.triangles.len();
    let (mesh, repairs) = TriangleMesh::build(data)?;
    let triangles = [
        (repairs.degenerate, "triangles without area were dropped"),
        (repairs.non_finite, "triangles with a NaN or infinite vertex were dropped"),
    ];
    let attributes = [
        (repairs.bad_normals, "normals that are zero or not finite were replaced by those of a triangle"),
        (repairs.bad_uvs, "texture coordinates that are not finite were set to zero"),
        (repairs.bad_colors, "vertex colours that are negative or not finite were set to white"),
        (repairs.bad_tangents, "tangents that are zero or not finite were ignored"),
    ];
    let mut warn = |message| warnings.push(Warning { place: place.to_owned(), message });
    for (count, what) in triangles.into_iter().filter(|(count, _)| *count > 0) {
        warn(format!("{what}: {count} of {total}"));
    }
    for (count, what) in attributes.into_iter().filter(|(count, _)| *count > 0) {
        warn(format!("{what}: {count}"));
    }
    if mesh.data().triangles.is_empty() {
        warn("no triangles are left; the mesh is left out".to_owned());
        return Ok(None);
    }
    Ok(Some(mesh))
}
