//! Binary space partition.

use rt_math::Aabb;

use super::node::PartitionNode;
use super::split_plane::SplitPlane;
use crate::BuildStats;

/// Binary space partition by planes of type `C`. Leaves tile all of space, and a primitive is listed in every leaf that
/// its padded bounds touch.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(remote = "Self"))]
pub(crate) struct BspPartition<C> {
    /// In depth-first order; never empty.
    pub(super) nodes: Vec<PartitionNode<C>>,
    /// Bounded primitives leaf by leaf, by rising index in each.
    pub(super) indices: Vec<u32>,
    /// Union of all padded bounds.
    pub(super) bounds: Aabb,
    pub(super) unbounded: Vec<u32>,
    pub(super) primitives: u32,
}

impl<C: SplitPlane> BspPartition<C> {
    pub(crate) fn memory(&self) -> usize {
        size_of::<Self>()
            + self.nodes.capacity() * size_of::<PartitionNode<C>>()
            + (self.indices.capacity() + self.unbounded.capacity()) * size_of::<u32>()
    }

    pub(crate) fn build_stats(&self) -> BuildStats {
        let mut max_depth = 0;
        self.for_each_box(|_, depth| max_depth = max_depth.max(depth as usize));
        BuildStats {
            primitives: self.primitives as usize,
            unbounded: self.unbounded.len(),
            nodes: self.nodes.len() / 2,
            leaves: if self.indices.is_empty() { 0 } else { self.nodes.len().div_ceil(2) },
            max_depth,
            references: self.indices.len(),
            sah_cost: None,
        }
    }

    /// Visits the bounds of all parts of the scene's bounds, the whole first.
    pub(crate) fn for_each_box(&self, mut visit: impl FnMut(Aabb, u32)) {
        if self.indices.is_empty() {
            return;
        }
        let mut pending = vec![(self.bounds, 0)];
        for node in &self.nodes {
            let Some((cell, depth)) = pending.pop() else { return };
            visit(cell, depth);
            if let PartitionNode::Split { plane, .. } = node {
                let [below, above] = plane.split_bounds(&cell);
                pending.extend([(above, depth + 1), (below, depth + 1)]);
            }
        }
    }

    pub(super) fn leaf(&self, first: u32, count: u32) -> &[u32] {
        &self.indices[first as usize..][..count as usize]
    }
}
