//! Triangles of small meshes as instances of their own.

use std::sync::Arc;

use rt_geometry::TriangleMesh;
use rt_math::Vec3;
use rt_shading::StreamTriangle;

/// Triangle of a small mesh without transform and normal map.
#[derive(Debug)]
pub(crate) struct InlinedTriangle {
    pub(crate) mesh: Arc<TriangleMesh>,
    /// Index in the mesh.
    pub(crate) index: u32,
    pub(crate) shape: StreamTriangle,
}

impl InlinedTriangle {
    /// Triangle of a mesh by its index; `None` for an invalid one.
    pub(crate) fn new(mesh: &Arc<TriangleMesh>, index: u32) -> Option<Self> {
        let (vertices, normal) = (mesh.vertices(index)?, mesh.unit_normal(index)?);
        let are_interpolated = |normals: &[Vec3; 3]| normals.iter().any(|vertex| *vertex != normal.as_vec3());
        let vertex_normals = mesh.vertex_normals(index).filter(are_interpolated);
        Some(Self { mesh: Arc::clone(mesh), index, shape: StreamTriangle { vertices, normal, vertex_normals } })
    }
}
