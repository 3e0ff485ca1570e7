//! Bounding interval hierarchy.

mod lazy;
mod planes;
mod split;
mod walk;

use core::ops::ControlFlow;

use glam::DVec3;
use rt_geometry::{Primitives, Probe};
use rt_math::Aabb;

use crate::tree::{Child, Place, Tree};
use crate::{
    AcceleratorQueries, BuildError, BuildStats, RayQuery, Refit, RegionQuery, ValidationError, own_boxes::PrimBounds,
    structure::accelerator_by_walk,
};
pub use lazy::LazyBih;
use planes::Planes;
use walk::{Hierarchy, Step};

/// A binary tree that keeps two planes per node: where its left side ends and where its right side begins.
///
/// Wächter and Keller, "Instant Ray Tracing: The Bounding Interval Hierarchy" (EGSR 2006). It is built about as fast as
/// a list is sorted, because a cell is halved without weighing any cost: take it where the scene changes all the time
/// and there are few rays to ask about each state. Each primitive is listed once, and a query takes O(log n) nodes for
/// most scenes, about as many as of a [`Bvh`](crate::Bvh), but tests ten times as many primitives: leaves are bounded
/// on few sides. [`LazyBih`] is the same tree, built where
/// rays go.
///
/// No leaf is deeper than 60 and none has more than 4 primitives.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Bih {
    /// Around all bounded primitives.
    bounds: Aabb,
    tree: Tree<Planes>,
}

impl Bih {
    /// Builds the tree: O(n log n) time, about 20 bytes per primitive afterwards.
    ///
    /// # Errors
    ///
    /// [`BuildError`] if bounds are NaN, inverted or infinite, or 32 bits cannot number the primitives.
    pub fn build<P: Primitives>(primitives: &P) -> Result<Self, BuildError> {
        let boxes = PrimBounds::collect(primitives)?;
        let bounds = bounds_of(&boxes);
        Ok(Self { bounds, tree: Tree::grow(boxes, bounds, split::split) })
    }
}

impl<'h> Hierarchy<'h> for &'h Bih {
    type Way = Child;

    fn bounds(self) -> &'h Aabb {
        &self.bounds
    }

    fn unbounded(self) -> &'h [u32] {
        &self.tree.unbounded
    }

    fn primitives(self) -> u32 {
        self.tree.primitives()
    }

    fn root(self) -> Child {
        self.tree.root
    }

    #[inline(always)]
    fn follow(self, way: Child) -> Step<'h, Child> {
        match self.tree.place(way) {
            Place::Leaf(indices) => Step::Leaf(indices),
            Place::Node(node) => Step::Node(&node.content, node.children),
        }
    }
}

impl AcceleratorQueries for Bih {
    fn walk<P: Primitives, Q: RayQuery, S: Probe>(
        &self,
        primitives: &P,
        query: &mut Q,
        probe: &mut S,
    ) -> ControlFlow<()> {
        walk::walk(self, primitives, query, probe)
    }

    fn search<Q: RegionQuery>(&self, query: &mut Q) -> ControlFlow<()> {
        walk::search(self, query)
    }

    fn memory(&self) -> usize {
        size_of::<Self>() + self.tree.heap()
    }

    fn build_stats(&self) -> BuildStats {
        self.tree.stats()
    }

    fn validate<P: Primitives>(&self, primitives: &P) -> Result<(), ValidationError> {
        self.tree.validate(primitives, Planes::encloses)?;
        encloses_all(&self.bounds, primitives)
    }

    fn for_each_box(&self, mut visit: impl FnMut(Aabb, u32)) {
        if !self.tree.indices.is_empty() {
            self.tree.for_each_child(self.bounds, Planes::cut, |_, aabb, depth| visit(aabb, depth));
        }
    }
}

accelerator_by_walk!(Bih);

/// The box around all; around the origin if there is nothing, so that it can be saved.
fn bounds_of(boxes: &PrimBounds) -> Aabb {
    if boxes.bounded.is_empty() { Aabb::new(DVec3::ZERO, DVec3::ZERO) } else { boxes.union }
}

impl Refit for Bih {
    /// O(n log n), but a fraction of the time of building.
    fn refit<P: Primitives>(&mut self, primitives: &P) -> Result<(), BuildError> {
        let boxes = self.tree.refit(primitives, |planes, sides| {
            let [left, right] = sides.map(|boxes| boxes.iter().copied().fold(Aabb::EMPTY, Aabb::union));
            Planes::around(planes.axis, &left, &right)
        })?;
        self.bounds = bounds_of(&boxes);
        Ok(())
    }
}

/// Checks that a box contains the own boxes of all bounded primitives.
fn encloses_all<P: Primitives>(bounds: &Aabb, primitives: &P) -> Result<(), ValidationError> {
    let reaches_out =
        |&index: &u32| rt_geometry::padded_bounds(primitives, index).is_some_and(|own| !bounds.encloses(&own));
    match (0..primitives.len() as u32).find(reaches_out) {
        Some(primitive) => Err(ValidationError::Outside { primitive }),
        None => Ok(()),
    }
}
