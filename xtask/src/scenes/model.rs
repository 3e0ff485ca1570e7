//! A mesh from a file.

use std::path::Path;

use rt_geometry::{MeshData, TriangleMesh};
use rt_math::Vec3;

use super::{Scene, mesh, other};
use crate::error::TaskError;

/// All triangles of an OBJ file.
pub(crate) fn model(path: &Path) -> Result<Scene<TriangleMesh>, TaskError> {
    let options = tobj::LoadOptions { triangulate: true, single_index: true, ..tobj::LoadOptions::default() };
    let (models, _) = tobj::load_obj(path, &options).map_err(other)?;
    let mut data = MeshData::default();
    for tobj::Model { mesh, .. } in &models {
        let first = data.positions.len() as u32;
        data.positions.extend(mesh.positions.chunks_exact(3).map(Vec3::from_slice));
        data.triangles.extend(mesh.indices.chunks_exact(3).map(|t| [t[0] + first, t[1] + first, t[2] + first]));
    }
    Ok(Scene::whole("model", mesh(data)?))
}
