//! Errors of ready-made geometry.

use core::fmt;

use crate::{BuildError, MAX_COORDINATE};

/// Error of [`TriangleMesh`](crate::TriangleMesh): arrays that are no triangle mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum MeshError {
    /// A triangle refers to a vertex that does not exist.
    VertexIndex {
        /// Index of the triangle.
        triangle: usize,
        /// The invalid index of a vertex.
        index: u32,
        /// Number of vertices.
        n_vertices: usize,
    },
    /// A coordinate of a vertex is NaN, or of a magnitude above [`MAX_COORDINATE`].
    Coordinate {
        /// Index of the vertex.
        vertex: usize,
    },
    /// More triangles than a 32-bit index can address.
    TooMany {
        /// Number of triangles.
        count: usize,
    },
}

impl fmt::Display for MeshError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::VertexIndex { triangle, index, n_vertices } => {
                write!(f, "triangle {triangle}: vertex index {index} is out of range: there are {n_vertices} vertices")
            }
            Self::Coordinate { vertex } => {
                write!(
                    f,
                    "vertex {vertex} has a coordinate that is not a finite number of magnitude at most {MAX_COORDINATE:e}"
                )
            }
            Self::TooMany { count } => write!(f, "{count} triangles exceed the limit of 4294967295; split the mesh"),
        }
    }
}

impl core::error::Error for MeshError {}

/// Error of [`SceneBuilder`](crate::SceneBuilder): a scene that cannot be built.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum SceneError {
    /// No accelerator can be built over a geometry.
    Geometry {
        /// Index of the geometry: the lowest that was free.
        geometry: u32,
        /// The reason; primitives are those of the geometry.
        source: BuildError,
    },
    /// No accelerator can be built over the instances.
    Instances(BuildError),
    /// The builder has no geometry of this index.
    UnknownGeometry {
        /// Index of the geometry.
        geometry: u32,
    },
    /// No instance has this index.
    UnknownInstance {
        /// Index of the instance.
        instance: u32,
    },
    /// A transform has a NaN or infinite number.
    Transform {
        /// Index of the instance.
        instance: u32,
    },
    /// A transform would turn spheres into ellipsoids.
    NotUniform {
        /// Index of the geometry.
        geometry: u32,
    },
    /// A geometry without vertices was given new ones.
    NotAMesh {
        /// Index of the geometry.
        geometry: u32,
    },
    /// New vertices do not fit the triangles of a mesh.
    Vertices {
        /// Index of the geometry.
        geometry: u32,
        /// The reason.
        source: MeshError,
    },
    /// A geometry cannot be removed while it has instances.
    InUse {
        /// Index of the geometry.
        geometry: u32,
        /// The first of its instances.
        instance: u32,
    },
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Geometry { geometry, source } => write!(f, "geometry {geometry}: {source}"),
            Self::Instances(source) => write!(f, "instances: {source}"),
            Self::UnknownGeometry { geometry } => write!(f, "geometry {geometry} does not exist in this scene"),
            Self::UnknownInstance { instance } => write!(f, "instance {instance} does not exist in this scene"),
            Self::NotAMesh { geometry } => {
                write!(f, "geometry {geometry} has no vertices to replace: it is a list of spheres")
            }
            Self::Vertices { geometry, source } => write!(f, "geometry {geometry}: {source}"),
            Self::InUse { geometry, instance } => {
                write!(f, "geometry {geometry} has instances: remove instance {instance} first")
            }
            Self::Transform { instance } => {
                write!(f, "instance {instance}: the transform has a NaN or infinite number")
            }
            Self::NotUniform { geometry } => {
                write!(
                    f,
                    "geometry {geometry}: the transform is not uniform; scale spheres by the same factor on all axes"
                )
            }
        }
    }
}

impl core::error::Error for SceneError {
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        match self {
            Self::Geometry { source, .. } | Self::Instances(source) => Some(source),
            Self::Vertices { source, .. } => Some(source),
            Self::UnknownGeometry { .. }
            | Self::UnknownInstance { .. }
            | Self::Transform { .. }
            | Self::NotUniform { .. }
            | Self::NotAMesh { .. }
            | Self::InUse { .. } => None,
        }
    }
}
