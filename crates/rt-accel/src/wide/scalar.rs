//! Traversal in `f64`, one box at a time: for rays outside the range of the filters, and for all other queries. Tests
//! compare the filters with it.

use core::ops::ControlFlow;

use rt_geometry::{Primitives, Probe};
use rt_math::{Aabb, Interval};

use super::WideBvh;
use super::node::{Child, WideNode};
use super::stack::STACK;
use crate::{RayQuery, RegionQuery, bvh::SlabRay32, erased, ray_query::is_finite};

/// Deferred children with their sort keys, the farthest of a node deepest.
struct ScalarStack {
    entries: [(f64, Child, NodeLane); STACK],
    len: usize,
}

/// Parent node and lane of a child.
type NodeLane = (u32, u8);

impl ScalarStack {
    const fn new() -> Self {
        Self { entries: [(0.0, Child::node(0), (0, 0)); STACK], len: 0 }
    }

    /// Inserts an entry in descending order among those of the same node, which begin at `first`.
    fn insert(&mut self, first: usize, entry: (f64, Child, NodeLane)) {
        debug_assert!(self.len < STACK, "the tree is deeper than its builder promises");
        let end = self.len.min(STACK - 1);
        let first = first.min(end);
        let at = first + self.entries[first..end].partition_point(|known| known.0 > entry.0);
        self.entries[at..=end].rotate_right(1);
        self.entries[at] = entry;
        self.len = end + 1;
    }

    fn pop(&mut self) -> Option<(f64, Child, NodeLane)> {
        self.len = self.len.checked_sub(1)?;
        Some(self.entries[self.len])
    }
}

impl WideBvh {
    /// Leaves in the order of their nodes.
    pub(super) fn leaves(&self) -> impl Iterator<Item = Child> + '_ {
        self.nodes.iter().flat_map(WideNode::children).filter_map(|(_, child)| (!child.is_node()).then_some(child))
    }

    /// Traverses the bounded primitives in `f64`: rays outside the range of the filters, and queries without filters.
    pub(super) fn walk_bounded_erased<P: Primitives, Q: RayQuery, S: Probe>(
        &self,
        primitives: &P,
        query: &mut Q,
        probe: &mut S,
    ) -> ControlFlow<()> {
        erased::traverse_ray(primitives, query, probe, |primitives, query, probe| {
            self.walk_bounded(primitives, query, probe)
        })
    }

    pub(super) fn walk_bounded<P: Primitives, Q: RayQuery, S: Probe>(
        &self,
        primitives: &P,
        query: &mut Q,
        probe: &mut S,
    ) -> ControlFlow<()> {
        if is_finite(&query.ray().ray) {
            return self.descend(primitives, query, probe);
        }
        for leaf in self.leaves() {
            query.test_leaf(primitives, &self.leaves.indices(leaf), probe)?;
        }
        ControlFlow::Continue(())
    }

    fn descend<P: Primitives, Q: RayQuery, S: Probe>(
        &self,
        primitives: &P,
        query: &mut Q,
        probe: &mut S,
    ) -> ControlFlow<()> {
        let node_ray = SlabRay32::new(query.ray(), self.centre);
        let mut stack = ScalarStack::new();
        stack.insert(0, (f64::NEG_INFINITY, self.root, (0, 0)));
        while let Some((enter, child, _)) = stack.pop() {
            // Strictly: an equally near primitive of lower index must still be found.
            if enter > query.span().max {
                continue;
            }
            if !child.is_node() {
                query.test_leaf(primitives, &self.leaves.indices(child), probe)?;
                continue;
            }
            let Some(node) = self.nodes.get(child.number()) else { continue };
            probe.node();
            let first = stack.len;
            for (bounds, child) in node.children() {
                let Interval { min: enter, max: leave } = node_ray.cross(&bounds, query.span());
                if enter <= leave && enter <= query.span().max {
                    stack.insert(first, (enter, child, (0, 0)));
                }
            }
        }
        ControlFlow::Continue(())
    }

    pub(super) fn descend_region<Q: RegionQuery>(&self, query: &mut Q) -> ControlFlow<()> {
        let mut stack = ScalarStack::new();
        stack.insert(0, (0.0, self.root, (u32::MAX, 0)));
        while let Some((_, child, child_lane)) = stack.pop() {
            // The query may have shrunk since the push.
            if self.box_at(child_lane).is_some_and(|bounds| query.distance_to(&bounds).is_none()) {
                continue;
            }
            if !child.is_node() {
                query.test_leaf(&self.leaves.indices(child))?;
                continue;
            }
            let Some(node) = self.nodes.get(child.number()) else { continue };
            let first = stack.len;
            for lane in 0..8 {
                let child_lane = (child.number() as u32, lane);
                if let Some(reach) = self.box_at(child_lane).and_then(|bounds| query.distance_to(&bounds)) {
                    stack.insert(first, (reach, node.children[usize::from(lane)], child_lane));
                }
            }
        }
        ControlFlow::Continue(())
    }

    /// World-space box of a child; `None` for the root.
    fn box_at(&self, (node, lane): NodeLane) -> Option<Aabb> {
        let bounds = self.nodes.get(node as usize)?.child_box(usize::from(lane))?;
        Some(bounds.at(self.centre))
    }
}
