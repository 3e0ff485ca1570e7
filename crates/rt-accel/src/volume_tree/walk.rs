//! Walks: down to the nearer child first, back to the one that was put off.

use core::ops::ControlFlow;

use rt_geometry::{Primitives, Probe};
use rt_math::Aabb;

use super::VolumeTree;
use super::volume::BoundingVolume;
use crate::{RayQuery, RegionQuery, bounded_depth::Stack, tree::Place};

/// The side to go to first, if there is any: the one with the lesser number.
#[inline(always)]
fn nearer(numbers: [Option<f64>; 2]) -> Option<usize> {
    match numbers {
        [Some(left), Some(right)] => Some(usize::from(right < left)),
        [left, right] => left.map(|_| 0).or(right.map(|_| 1)),
    }
}

impl<V: BoundingVolume> VolumeTree<V> {
    pub(super) fn descend<P: Primitives, Q: RayQuery, S: Probe>(
        &self,
        primitives: &P,
        query: &mut Q,
        probe: &mut S,
    ) -> ControlFlow<()> {
        let mut child = self.tree.root;
        let mut stack = Stack::new((0.0, child));
        loop {
            match self.tree.place(child) {
                Place::Leaf(indices) => query.offer_all(primitives, indices, probe)?,
                Place::Node(node) => {
                    probe.node();
                    let enter = [0, 1].map(|side| node.content[side].enter(query.ray(), query.span()));
                    if let Some(near) = nearer(enter) {
                        let far = near ^ 1;
                        stack.push_if(enter[far].is_some(), (enter[far].unwrap_or(0.0), node.children[far]));
                        child = node.children[near];
                        continue;
                    }
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

    pub(super) fn descend_region<Q: RegionQuery>(&self, query: &mut Q) -> ControlFlow<()> {
        let mut child = self.tree.root;
        let mut stack = Stack::new((Aabb::EMPTY, child));
        loop {
            match self.tree.place(child) {
                Place::Leaf(indices) => query.offer_all(indices)?,
                Place::Node(node) => {
                    let boxes = node.content.map(|volume| volume.bounds());
                    let reach = boxes.map(|aabb| query.reach(&aabb));
                    if let Some(near) = nearer(reach) {
                        stack.push_if(reach[near ^ 1].is_some(), (boxes[near ^ 1], node.children[near ^ 1]));
                        child = node.children[near];
                        continue;
                    }
                }
            }
            child = loop {
                let Some((bounds, child)) = stack.pop() else { return ControlFlow::Continue(()) };
                // The query may have become more particular since.
                if query.reach(&bounds).is_some() {
                    break child;
                }
            };
        }
    }
}
