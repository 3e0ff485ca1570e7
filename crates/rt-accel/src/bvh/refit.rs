//! Refitting of the binary tree: new boxes for the same topology. That of `WideBvh` is in `wide/refit.rs`.

use rt_geometry::Primitives;

use super::Bvh;
use super::node::{Aabb32, BvhNode};
use crate::node_ref::NodeRef;
use crate::prim_bounds::{PrimBounds, validate_lists};
use crate::{BuildError, Refit};

impl Refit for Bvh {
    /// Boxes that spatial splits had clipped lose that: each leaf with a reference to a primitive encloses the whole primitive.
    fn refit<P: Primitives>(&mut self, primitives: &P) -> Result<(), BuildError> {
        let built = self.bounded + self.unbounded.len() as u32;
        let PrimBounds { bounded, union, .. } = PrimBounds::collect(primitives)?;
        validate_lists(primitives, built, &self.unbounded).map_err(BuildError::Changed)?;
        self.centre = if bounded.is_empty() { self.centre } else { union.centre() };
        let mut boxes = vec![Aabb32::EMPTY; built as usize];
        for (index, own) in &bounded {
            boxes[*index as usize] = Aabb32::enclosing(own, self.centre);
        }
        // Children come after their parents.
        for number in (0..self.nodes.len()).rev() {
            let children = self.nodes[number].children;
            let around = children.map(|child| self.box_around(child, &boxes));
            self.nodes[number] = BvhNode::new(around, children);
        }
        Ok(())
    }
}

impl Bvh {
    /// Bounds of a leaf, or of a node whose children are fitted.
    fn box_around(&self, child: NodeRef, boxes: &[Aabb32]) -> Aabb32 {
        if child.count > 0 {
            let listed = self.leaf(child).iter().map(|&index| boxes[index as usize]);
            return listed.fold(Aabb32::EMPTY, Aabb32::union);
        }
        let node = &self.nodes[child.first as usize];
        node.child_box(0).union(node.child_box(1))
    }
}
