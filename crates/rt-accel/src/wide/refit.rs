//! New boxes, and new copies in the leaves, for the same tree.

use rt_math::Primitives;

use super::leaf::LeafKind;
use super::node::{Child, Node};
use super::{BuildParams, WideBvh, frame};
use crate::bvh::NodeBox;
use crate::own_boxes::{OwnBoxes, validate_lists};
use crate::{BuildError, Refit};

impl Refit for WideBvh {
    /// Leaves of triangles that no longer suit, as the scene has gone far from the origin, make it build a new tree.
    fn refit<P: Primitives>(&mut self, primitives: &P) -> Result<(), BuildError> {
        let OwnBoxes { bounded, union, .. } = OwnBoxes::collect(primitives)?;
        let built = self.bounded + self.unbounded.len() as u32;
        validate_lists(primitives, built, &self.unbounded).map_err(BuildError::Changed)?;
        let (centre, size) = frame(&bounded, &union);
        let indices: Vec<u32> = bounded.iter().map(|(index, _)| *index).collect();
        if LeafKind::of(primitives, &indices, centre, size) != self.leaves.kind {
            *self = Self::build_with(primitives, &BuildParams::default())?.with_level(self.level());
            return Ok(());
        }
        (self.centre, self.size) = (centre, size);
        let mut boxes = vec![NodeBox::EMPTY; built as usize];
        for (index, own) in &bounded {
            boxes[*index as usize] = NodeBox::outward(own, centre);
        }
        // Children come after their parents.
        for number in (0..self.nodes.len()).rev() {
            let mut node = Node::EMPTY;
            for (lane, child) in self.nodes[number].lanes() {
                node.set(lane, &self.fit(primitives, child, &boxes), child);
            }
            self.nodes[number] = node;
        }
        Ok(())
    }
}

impl WideBvh {
    /// The box around a leaf, which is filled anew, or around what is below a node that has been fitted.
    fn fit<P: Primitives>(&mut self, primitives: &P, child: Child, boxes: &[NodeBox]) -> NodeBox {
        if child.is_node() {
            return self.nodes[child.number()].children().fold(NodeBox::EMPTY, |all, (bounds, _)| all.union(bounds));
        }
        let own = |index: u32| boxes[index as usize];
        self.leaves.refill(child, primitives, self.centre, own);
        self.leaves.indices(child).iter().map(|&index| own(index)).fold(NodeBox::EMPTY, NodeBox::union)
    }
}
