//! New boxes, and new copies in the leaves, for the same tree.

use rt_geometry::Primitives;

use super::build::PrimStats;
use super::leaf::{LeafKind, LeafWriter};
use super::node::{Child, Node};
use super::{BuildParams, WideBvh};
use crate::{BuildError, Refit, bvh::NodeBox, own_boxes::validate_lists};

impl Refit for WideBvh {
    /// Leaves of triangles that no longer suit, as the scene has gone far from the origin, make it build a new tree.
    fn refit<P: Primitives>(&mut self, primitives: &P) -> Result<(), BuildError> {
        let stats = PrimStats::of(primitives)?;
        let built = self.bounded + self.unbounded.len() as u32;
        validate_lists(primitives, built, &self.unbounded).map_err(BuildError::Changed)?;
        let (centre, size) = (stats.centre(), stats.size());
        let kind = LeafKind::of(stats.layouts, centre, size);
        if kind != self.leaves.kind {
            *self = Self::build_with(primitives, &BuildParams::default())?.with_level(self.level());
            return Ok(());
        }
        (self.centre, self.size) = (centre, size);
        let filling = LeafWriter { primitives, centre, kind };
        // Children come after their parents.
        for number in (0..self.nodes.len()).rev() {
            let mut node = Node::EMPTY;
            for (lane, child) in self.nodes[number].lanes() {
                node.set(lane, &self.fit(child, &filling), child);
            }
            self.nodes[number] = node;
        }
        Ok(())
    }
}

impl WideBvh {
    /// The box around a leaf, which is filled anew, or around what is below a node that has been fitted.
    fn fit<P: Primitives>(&mut self, child: Child, filling: &LeafWriter<'_, P>) -> NodeBox {
        if child.is_node() {
            return self.nodes[child.number()].children().fold(NodeBox::EMPTY, |all, (bounds, _)| all.union(bounds));
        }
        self.leaves.refill(child, filling);
        self.leaves.indices(child).iter().map(|&index| filling.own(index)).fold(NodeBox::EMPTY, NodeBox::union)
    }
}
