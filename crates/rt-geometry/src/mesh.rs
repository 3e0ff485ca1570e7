//! Triangle meshes.

use rt_math::Vec3;

/// The plain arrays of a mesh, as files hold them. Vertices stay `f32` in local space.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshData {
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// Vertex indices of each triangle; counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// One normal for each position (any non-zero length), or empty for flat shading.
    pub normals: Vec<Vec3>,
    /// One texture coordinate for each position, `v` upwards, or empty.
    pub uvs: Vec<[f32; 2]>,
}

/// Why a mesh cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MeshError {
    /// A triangle names a vertex that is not there.
    #[error("triangle {triangle} refers to vertex {vertex}, but there are {count}")]
    BadIndex {
        /// Which triangle.
        triangle: usize,
        /// The vertex that it names.
        vertex: u32,
        /// Number of vertices.
        count: usize,
    },
    /// The number of normals or texture coordinates differs from that of positions.
    #[error("{count} {what} for {positions} positions")]
    CountMismatch {
        /// "normals" or "texture coordinates".
        what: &'static str,
        /// How many there are.
        count: usize,
        /// How many there should be.
        positions: usize,
    },
    /// More than 2³² − 1 vertices or triangles.
    #[error("the mesh has more than 2^32 - 1 vertices or triangles")]
    TooLarge,
}

/// What was mended when a mesh was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MeshRepairs {
    /// Triangles without area (repeated or collinear vertices), dropped.
    pub degenerate: usize,
    /// Triangles with a NaN or infinite vertex, dropped.
    pub not_finite: usize,
    /// Zero or non-finite normals, replaced by the normal of a triangle at that vertex.
    pub bad_normals: usize,
}

/// A validated triangle mesh: a set of [`Primitives`](rt_math::Primitives), one for each triangle.
#[derive(Clone, Debug)]
pub struct TriangleMesh {
    pub(crate) data: MeshData,
}

impl TriangleMesh {
    /// The arrays of the mesh.
    pub const fn data(&self) -> &MeshData {
        &self.data
    }
}
