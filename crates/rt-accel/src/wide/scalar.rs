//! Walks in `f64`, one box at a time: for rays that filters are not proven for, and for all other queries. They are the
//! scalar twin that tests hold the filters against.

use core::ops::ControlFlow;

use rt_geometry::{Primitives, Probe};
use rt_math::{Aabb, Interval};

use super::node::{Child, Node};
use super::{STACK, WideBvh};
use crate::{RayQuery, RegionQuery, bvh::NodeRay};

/// Children that were put off, with what they are ordered by: the farthest of a node lie deepest.
struct ScalarStack {
    entries: [(f64, Child, Place); STACK],
    len: usize,
}

/// The node that a child belongs to, and its lane.
type Place = (u32, u8);

impl ScalarStack {
    const fn new() -> Self {
        Self { entries: [(0.0, Child::node(0), (0, 0)); STACK], len: 0 }
    }

    /// Pushes an entry below those of the same node that are nearer; the entries of a node begin at `first`.
    fn insert(&mut self, first: usize, entry: (f64, Child, Place)) {
        debug_assert!(self.len < STACK, "the tree is deeper than its builder promises");
        let end = self.len.min(STACK - 1);
        let first = first.min(end);
        let place = first + self.entries[first..end].partition_point(|known| known.0 > entry.0);
        self.entries[place..=end].rotate_right(1);
        self.entries[place] = entry;
        self.len = end + 1;
    }

    fn pop(&mut self) -> Option<(f64, Child, Place)> {
        self.len = self.len.checked_sub(1)?;
        Some(self.entries[self.len])
    }
}

impl WideBvh {
    /// The leaves, in the order of their nodes.
    pub(super) fn leaves(&self) -> impl Iterator<Item = Child> + '_ {
        self.nodes.iter().flat_map(Node::children).filter_map(|(_, child)| (!child.is_node()).then_some(child))
    }

    pub(super) fn descend<P: Primitives, Q: RayQuery, S: Probe>(
        &self,
        primitives: &P,
        query: &mut Q,
        probe: &mut S,
    ) -> ControlFlow<()> {
        let node_ray = NodeRay::new(query.ray(), self.centre);
        let mut stack = ScalarStack::new();
        stack.insert(0, (f64::NEG_INFINITY, self.root, (0, 0)));
        while let Some((enter, child, _)) = stack.pop() {
            // Strictly: an equally near primitive of lower index must still be found.
            if enter > query.span().max {
                continue;
            }
            if !child.is_node() {
                query.offer_all(primitives, self.leaves.indices(child), probe)?;
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
        while let Some((_, child, place)) = stack.pop() {
            // The query may have become more particular since.
            if self.box_at(place).is_some_and(|bounds| query.reach(&bounds).is_none()) {
                continue;
            }
            if !child.is_node() {
                query.offer_all(self.leaves.indices(child))?;
                continue;
            }
            let Some(node) = self.nodes.get(child.number()) else { continue };
            let first = stack.len;
            for lane in 0..8 {
                let place = (child.number() as u32, lane);
                if let Some(reach) = self.box_at(place).and_then(|bounds| query.reach(&bounds)) {
                    stack.insert(first, (reach, node.children[usize::from(lane)], place));
                }
            }
        }
        ControlFlow::Continue(())
    }

    /// The box of a child in world space; `None` for that of the root.
    fn box_at(&self, (node, lane): Place) -> Option<Aabb> {
        let bounds = self.nodes.get(node as usize)?.child_box(usize::from(lane))?;
        Some(bounds.at(self.centre))
    }
}
