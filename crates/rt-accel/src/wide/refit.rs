//! Refitting of boxes and leaves to moved primitives.

use rt_geometry::Primitives;

use super::build::PrimStats;
use super::leaf::{LeafKind, LeafWriter};
use super::node::{Child, WideNode};
use super::triangle_list::TriangleList;
use super::{BuildParams, WideBvh};
use crate::{BuildError, Refit, bvh::Aabb32, erased::DynPrimitives, prim_bounds::validate_lists};

impl Refit for WideBvh {
    /// Builds a new tree with default parameters if another kind of leaf suits the triangles, as after a move far from the
    /// origin.
    fn refit<P: Primitives>(&mut self, primitives: &P) -> Result<(), BuildError> {
        if !self.refit_leaves_of_same_kind(primitives)? {
            *self = Self::build_with(primitives, &BuildParams::default())?.with_level(self.level());
        }
        Ok(())
    }
}

impl WideBvh {
    /// Fits all bounds and leaves; false, without a change, if another kind of leaf suits the primitives.
    pub(crate) fn refit_leaves_of_same_kind<P: Primitives>(&mut self, primitives: &P) -> Result<bool, BuildError> {
        self.refit_erased(&DynPrimitives::new(primitives))
    }

    fn refit_erased(&mut self, primitives: &DynPrimitives<'_>) -> Result<bool, BuildError> {
        let stats = PrimStats::of(primitives)?;
        let built = self.bounded + self.unbounded.len() as u32;
        validate_lists(primitives, built, &self.unbounded).map_err(BuildError::Changed)?;
        let (centre, size) = (stats.centre(), stats.size());
        let kind = LeafKind::of(stats.layouts, centre, size);
        if kind != self.leaves.kind {
            return Ok(false);
        }
        (self.centre, self.size) = (centre, size);
        let filling = LeafWriter { primitives, centre, kind };
        // Children come after their parents.
        for number in (0..self.nodes.len()).rev() {
            let mut node = WideNode::EMPTY;
            for (lane, child) in self.nodes[number].lanes() {
                node.set(lane, &self.fit(child, &filling), child);
            }
            self.nodes[number] = node;
        }
        self.list = TriangleList::of(primitives, kind, centre, size);
        Ok(true)
    }

    /// Refits a leaf, or joins the boxes of a node that is already fitted; returns the bounds.
    fn fit<P: Primitives>(&mut self, child: Child, filling: &LeafWriter<'_, P>) -> Aabb32 {
        if child.is_node() {
            return self.nodes[child.number()].children().fold(Aabb32::EMPTY, |all, (bounds, _)| all.union(bounds));
        }
        self.leaves.refill(child, filling);
        self.leaves.indices(child).iter().map(|&index| filling.own(index)).fold(Aabb32::EMPTY, Aabb32::union)
    }
}
