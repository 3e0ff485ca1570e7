//! Traversal along rays and through regions.

use core::ops::ControlFlow;

use rt_geometry::{Primitives, Probe};
use rt_math::Aabb;

use super::VolumeTree;
use super::volume::BoundingVolume;
use crate::traversal::{Descent, traverse, traverse_by_distance};
use crate::{RayQuery, RegionQuery, tree::NodeKind};

impl<V: BoundingVolume> VolumeTree<V> {
    pub(super) fn traverse_bounded<P: Primitives, Q: RayQuery, S: Probe>(
        &self,
        primitives: &P,
        query: &mut Q,
        probe: &mut S,
    ) -> ControlFlow<()> {
        traverse(
            query,
            (0.0, self.tree.root),
            |query, (_, child)| {
                ControlFlow::Continue(match self.tree.resolve(child) {
                    NodeKind::Leaf(indices) => {
                        query.test_leaf(primitives, indices, probe)?;
                        None
                    }
                    NodeKind::Inner(node) => {
                        probe.node();
                        let enter = node.payload.map(|volume| volume.enter(query.ray(), query.span()));
                        let entry = |side: usize| (enter[side].unwrap_or(0.0), node.children[side]);
                        Descent::by_key(enter, [entry(0), entry(1)])
                    }
                })
            },
            // Inclusive: an equally near primitive of lower index must still be found.
            |query, entry| (entry.0 <= query.span().max).then_some(entry),
        )
    }

    pub(super) fn traverse_bounded_region<Q: RegionQuery>(&self, query: &mut Q) -> ControlFlow<()> {
        traverse_by_distance(
            query,
            (self.tree.root, Aabb::EMPTY),
            |query, (child, _)| {
                ControlFlow::Continue(match self.tree.resolve(child) {
                    NodeKind::Leaf(indices) => {
                        query.test_leaf(indices)?;
                        None
                    }
                    NodeKind::Inner(node) => {
                        Some([0, 1].map(|side| (node.children[side], node.payload[side].bounds())))
                    }
                })
            },
            |query, bounds| query.distance_to(bounds),
        )
    }
}
