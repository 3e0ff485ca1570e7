//! Walks: down to the nearer child first, back to the one that was put off.

use core::ops::ControlFlow;

use rt_geometry::{Primitives, Probe};
use rt_math::Aabb;

use super::Bvh;
use super::node::{Child, NodeRay};
use crate::{RayQuery, RegionQuery, bounded_depth::Stack};

impl Bvh {
    pub(super) fn descend<P: Primitives, Q: RayQuery, S: Probe>(
        &self,
        primitives: &P,
        query: &mut Q,
        probe: &mut S,
    ) -> ControlFlow<()> {
        let node_ray = NodeRay::new(query.ray(), self.centre);
        let mut stack = Stack::new((0.0, Child::leaf(0, 0)));
        let mut child = self.root;
        loop {
            if child.count > 0 {
                query.offer_all(primitives, self.leaf(child), probe)?;
            } else if let Some(node) = self.nodes.get(child.first as usize) {
                probe.node();
                let crossings = node_ray.clip(node, query.span());
                if let Some((near, both)) = crossings.nearer() {
                    let far = near ^ 1;
                    stack.push_if(both, (crossings.enter[far], node.children[far]));
                    child = node.children[near];
                    continue;
                }
            }
            child = loop {
                let Some((enter, child)) = stack.pop() else { return ControlFlow::Continue(()) };
                // Strictly: an equally near primitive of lower index must still be found.
                if enter <= query.span().max {
                    break child;
                }
            };
        }
    }

    /// How far off a box is, if anything in it can matter. Where primitives are listed several times, the query's box
    /// decides, as the corner that tells which of the places offers them lies in it, but maybe not in the region.
    fn reach<Q: RegionQuery>(&self, query: &Q, bounds: &Aabb) -> Option<f64> {
        if self.pieces.is_empty() {
            query.reach(bounds)
        } else {
            query.bounds().overlaps(bounds).then(|| bounds.distance_squared(query.focus()))
        }
    }

    fn offer_leaf<Q: RegionQuery>(&self, leaf: Child, query: &mut Q) -> ControlFlow<()> {
        if self.pieces.is_empty() {
            return query.offer_all(self.leaf(leaf));
        }
        let first = self.pieces.partition_point(|piece| piece.position < leaf.first);
        let mut pieces = self.pieces[first..].iter().peekable();
        for (position, &index) in (leaf.first..).zip(self.leaf(leaf)) {
            let piece = pieces.next_if(|piece| piece.position == position);
            query.offer(index, |point| piece.is_none_or(|piece| piece.cell.owns(point, self.centre)))?;
        }
        ControlFlow::Continue(())
    }

    pub(super) fn descend_region<Q: RegionQuery>(&self, query: &mut Q) -> ControlFlow<()> {
        let mut stack = Stack::new((Aabb::EMPTY, Child::leaf(0, 0)));
        let mut child = self.root;
        loop {
            if child.count > 0 {
                self.offer_leaf(child, query)?;
            } else if let Some(node) = self.nodes.get(child.first as usize) {
                let boxes = [0, 1].map(|side| node.child_box(side).at(self.centre));
                let reach = boxes.map(|bounds| self.reach(query, &bounds));
                let near = match reach {
                    [Some(left), Some(right)] => Some(usize::from(right < left)),
                    [left, right] => left.map(|_| 0).or(right.map(|_| 1)),
                };
                if let Some(near) = near {
                    stack.push_if(reach[near ^ 1].is_some(), (boxes[near ^ 1], node.children[near ^ 1]));
                    child = node.children[near];
                    continue;
                }
            }
            child = loop {
                let Some((bounds, child)) = stack.pop() else { return ControlFlow::Continue(()) };
                // The query may have become more particular since.
                if self.reach(query, &bounds).is_some() {
                    break child;
                }
            };
        }
    }
}
