//! Errors of ready-made geometry.

use crate::{BuildError, MAX_COORDINATE};

/// Error of [`TriangleMesh`](crate::TriangleMesh): arrays that are no triangle mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// A triangle refers to a vertex that does not exist.
    #[error("triangle {triangle}: vertex index {index} is out of range: there are {n_vertices} vertices")]
    VertexIndex {
        /// Index of the triangle.
        triangle: usize,
        /// The invalid index of a vertex.
        index: u32,
        /// Number of vertices.
        n_vertices: usize,
    },
    /// A coordinate of a vertex is NaN, or of a magnitude above [`MAX_COORDINATE`].
    #[error("vertex {vertex} has a coordinate that is not a finite number of magnitude at most {MAX_COORDINATE:e}")]
    Coordinate {
        /// Index of the vertex.
        vertex: usize,
    },
    /// More triangles than a 32-bit index can address.
    #[error("{count} triangles exceed the limit of 4294967295; split the mesh")]
    TooMany {
        /// Number of triangles.
        count: usize,
    },
}

/// Error of [`SceneBuilder`](crate::SceneBuilder): a scene that cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// No accelerator can be built over a geometry.
    #[error("geometry {geometry}: {source}")]
    Geometry {
        /// Index of the geometry: the lowest that was free.
        geometry: u32,
        /// The reason; primitives are those of the geometry.
        source: BuildError,
    },
    /// No accelerator can be built over the instances.
    #[error("instances: {0}")]
    Instances(#[source] BuildError),
    /// The builder has no geometry of this index.
    #[error("geometry {geometry} does not exist in this scene")]
    UnknownGeometry {
        /// Index of the geometry.
        geometry: u32,
    },
    /// No instance has this index.
    #[error("instance {instance} does not exist in this scene")]
    UnknownInstance {
        /// Index of the instance.
        instance: u32,
    },
    /// A transform has a NaN or infinite number.
    #[error("instance {instance}: the transform has a NaN or infinite number")]
    Transform {
        /// Index of the instance.
        instance: u32,
    },
    /// A transform would turn spheres into ellipsoids.
    #[error("geometry {geometry}: the transform is not uniform; scale spheres by the same factor on all axes")]
    NotUniform {
        /// Index of the geometry.
        geometry: u32,
    },
    /// A geometry without vertices was given new ones.
    #[error("geometry {geometry} has no vertices to replace: it is a list of spheres")]
    NotAMesh {
        /// Index of the geometry.
        geometry: u32,
    },
    /// New vertices do not fit the triangles of a mesh.
    #[error("geometry {geometry}: {source}")]
    Vertices {
        /// Index of the geometry.
        geometry: u32,
        /// The reason.
        source: MeshError,
    },
    /// A geometry cannot be removed while it has instances.
    #[error("geometry {geometry} has instances: remove instance {instance} first")]
    InUse {
        /// Index of the geometry.
        geometry: u32,
        /// The first of its instances.
        instance: u32,
    },
}
