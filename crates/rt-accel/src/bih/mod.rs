//! Bounding interval hierarchy.

pub(crate) mod lazy;
mod planes;
mod split;
mod traverse;

use core::ops::ControlFlow;

use rt_geometry::{Primitives, Probe};
use rt_math::Aabb;

use crate::node_ref::NodeRef;
use crate::prim_bounds::{PrimBounds, validate_union};
use crate::tree::{NodeKind, Tree};
use crate::{Accelerator, BuildError, BuildStats, RayQuery, Refit, RegionQuery, ValidationError};
use planes::Planes;
use traverse::{BihNode, Hierarchy};

/// Binary tree with two planes per node: the end of its left side and the beginning of its right side.
///
/// Wächter and Keller, "Instant Ray Tracing: The Bounding Interval Hierarchy" (EGSR 2006). Building takes about as long
/// as sorting a list, because a cell is halved without evaluating costs. Recommended for scenes that change constantly,
/// with few rays per state. Each primitive is listed once. A query takes O(log n) nodes for most scenes, about as many
/// as of a [`Bvh`](crate::Bvh). It tests ten times as many primitives, because leaves are bounded on few sides.
/// [`LazyBih`](crate::LazyBih) is the same tree, built on demand.
///
/// No leaf is deeper than 60 and none has more than 4 primitives.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Bih {
    /// Bounds of all bounded primitives.
    bounds: Aabb,
    tree: Tree<Planes>,
}

impl Bih {
    /// Builds the tree: O(n log n) time, about 20 bytes per primitive afterwards.
    ///
    /// # Errors
    ///
    /// [`BuildError`] if bounds are NaN, inverted or infinite, or the primitives exceed 32-bit indices.
    pub fn build<P: Primitives>(primitives: &P) -> Result<Self, BuildError> {
        let boxes = PrimBounds::collect(primitives)?;
        let bounds = boxes.finite_union();
        Ok(Self { bounds, tree: Tree::build(boxes, bounds, split::split) })
    }
}

impl<'h> Hierarchy<'h> for &'h Bih {
    type Node = NodeRef;

    fn bounds(self) -> &'h Aabb {
        &self.bounds
    }

    fn unbounded(self) -> &'h [u32] {
        &self.tree.unbounded
    }

    fn primitives(self) -> u32 {
        self.tree.primitives()
    }

    fn root(self) -> NodeRef {
        self.tree.root
    }

    #[inline(always)]
    fn resolve(self, node: NodeRef) -> BihNode<'h, NodeRef> {
        match self.tree.resolve(node) {
            NodeKind::Leaf(indices) => BihNode::Leaf(indices),
            NodeKind::Inner(node) => BihNode::Inner(&node.payload, node.children),
        }
    }
}

impl Accelerator for Bih {
    fn traverse_ray<P: Primitives, Q: RayQuery, S: Probe>(
        &self,
        primitives: &P,
        query: &mut Q,
        probe: &mut S,
    ) -> ControlFlow<()> {
        traverse::traverse_ray(self, primitives, query, probe)
    }

    fn traverse_region<Q: RegionQuery>(&self, query: &mut Q) -> ControlFlow<()> {
        traverse::traverse_region(self, query)
    }

    fn memory(&self) -> usize {
        size_of::<Self>() + self.tree.heap()
    }

    fn build_stats(&self) -> BuildStats {
        self.tree.stats()
    }

    fn validate<P: Primitives>(&self, primitives: &P) -> Result<(), ValidationError> {
        self.tree.validate(primitives, Planes::encloses)?;
        validate_union(&self.bounds, primitives)
    }

    fn for_each_box(&self, mut visit: impl FnMut(Aabb, u32)) {
        if !self.tree.indices.is_empty() {
            self.tree.for_each_child(self.bounds, Planes::cut, |_, aabb, depth| visit(aabb, depth));
        }
    }
}

impl Refit for Bih {
    /// O(n log n), in a fraction of the build time.
    fn refit<P: Primitives>(&mut self, primitives: &P) -> Result<(), BuildError> {
        let boxes = self.tree.refit(primitives, |planes, sides| {
            let [left, right] = sides.map(|boxes| boxes.iter().copied().fold(Aabb::EMPTY, Aabb::union));
            Planes::around(planes.axis, &left, &right)
        })?;
        self.bounds = boxes.finite_union();
        Ok(())
    }
}
