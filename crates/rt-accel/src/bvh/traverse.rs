//! Traversal along rays and through regions.

use core::ops::ControlFlow;

use rt_geometry::{Primitives, Probe};
use rt_math::Aabb;

use super::Bvh;
use super::node::SlabRay32;
use crate::node_ref::NodeRef;
use crate::traversal::{traverse, traverse_by_distance};
use crate::{RayQuery, RegionQuery};

impl Bvh {
    pub(super) fn traverse_bounded<P: Primitives, Q: RayQuery, S: Probe>(
        &self,
        primitives: &P,
        query: &mut Q,
        probe: &mut S,
    ) -> ControlFlow<()> {
        let node_ray = SlabRay32::new(query.ray(), self.centre);
        traverse(
            query,
            (0.0, self.root),
            |query, (_, child)| {
                if child.count > 0 {
                    query.test_leaf(primitives, self.leaf(child), probe)?;
                } else if let Some(node) = self.nodes.get(child.first as usize) {
                    probe.node();
                    return ControlFlow::Continue(node_ray.clip(node, query.span()).nearer_first(node.children));
                }
                ControlFlow::Continue(None)
            },
            // Inclusive: an equally near primitive of lower index must still be found.
            |query, entry| (entry.0 <= query.span().max).then_some(entry),
        )
    }

    /// Distance of bounds, unless the query culls them. With spatial splits only the bounding box of the query may
    /// cull. The corner that identifies the owner of a primitive lies in it, but perhaps not in the region.
    fn distance_to<Q: RegionQuery>(&self, query: &Q, bounds: &Aabb) -> Option<f64> {
        if self.split_refs.is_empty() {
            query.distance_to(bounds)
        } else {
            query.bounds().overlaps(bounds).then(|| bounds.distance_squared(query.query_point()))
        }
    }

    fn test_region_leaf<Q: RegionQuery>(&self, leaf: NodeRef, query: &mut Q) -> ControlFlow<()> {
        if self.split_refs.is_empty() {
            return query.test_leaf(self.leaf(leaf));
        }
        let first = self.split_refs.partition_point(|split_ref| split_ref.position < leaf.first);
        let mut split_refs = self.split_refs[first..].iter().peekable();
        for (position, &index) in (leaf.first..).zip(self.leaf(leaf)) {
            let split_ref = split_refs.next_if(|split_ref| split_ref.position == position);
            query.test_primitive(index, |point| {
                split_ref.is_none_or(|split_ref| split_ref.cell.owns(point, self.centre))
            })?;
        }
        ControlFlow::Continue(())
    }

    pub(super) fn traverse_bounded_region<Q: RegionQuery>(&self, query: &mut Q) -> ControlFlow<()> {
        traverse_by_distance(
            query,
            (self.root, Aabb::EMPTY),
            |query, (child, _)| {
                if child.count > 0 {
                    self.test_region_leaf(child, query)?;
                }
                let node = self.nodes.get(child.first as usize).filter(|_| child.count == 0);
                ControlFlow::Continue(
                    node.map(|node| [0, 1].map(|side| (node.children[side], node.child_box(side).at(self.centre)))),
                )
            },
            |query, bounds| self.distance_to(query, bounds),
        )
    }
}
