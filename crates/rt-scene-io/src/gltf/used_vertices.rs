//! Vertices that the triangles of a primitive use.

use gltf::{Primitive, Semantic};

use super::{accessor::read_indices, buffers::Buffers};

/// Vertices of a primitive that uses only some of its accessors. Many primitives may share large accessors.
pub(super) struct UsedVertices {
    /// Number of vertices of the accessors.
    pub(super) all: usize,
    /// Indices into the accessors, in ascending order.
    pub(super) vertices: Vec<u32>,
    /// Vertices of the primitive, as indices into `vertices`.
    pub(super) order: Vec<u32>,
}

impl UsedVertices {
    /// `None` for a primitive with at least as many indices as vertices: reading it as a whole takes linear time. `None` also for one with
    /// errors, which are reported then.
    pub(super) fn of(primitive: &Primitive<'_>, buffers: &Buffers<'_>) -> Option<Self> {
        let (positions, indices) = (primitive.get(&Semantic::Positions)?, primitive.indices()?);
        let all = positions.count();
        // Elements without a buffer view count each time that they are read.
        if indices.count() >= all || indices.view().is_none() {
            return None;
        }
        let mut order = read_indices(&indices, buffers).ok()?;
        let mut vertices = order.clone();
        vertices.sort_unstable();
        vertices.dedup();
        if *vertices.last()? as usize >= all {
            return None;
        }
        for vertex in &mut order {
            *vertex = vertices.binary_search(vertex).ok()? as u32;
        }
        Some(Self { all, vertices, order })
    }
}
