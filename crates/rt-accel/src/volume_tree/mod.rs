//! Trees of spheres, cylinders and other bounding volumes.

mod cylinder;
mod quadric;
mod sphere;
mod split;
mod traverse;
mod volume;

use core::ops::ControlFlow;

use rt_geometry::{Primitives, Probe};
use rt_math::Aabb;

use crate::{
    Accelerator, BuildError, BuildStats, RayQuery, Refit, RegionQuery, ValidationError, prim_bounds::PrimBounds,
    ray_query::is_finite, tree::Tree,
};
pub use cylinder::BoundingCylinder;
pub use sphere::BoundingSphere;
pub use volume::BoundingVolume;

/// Binary tree of bounding volumes of one shape: O(log n) per ray for most scenes.
///
/// Hierarchies of this kind were the first (Whitted 1980; Rubin and Whitted 1980). This one is built top-down by the
/// surface area heuristic for the volume. Volumes enclose the padded bounds of primitives, as all accelerators must
/// return identical results. Boxes are therefore the tightest volumes, and [`Bvh`](crate::Bvh) is faster on nearly
/// every scene. Recommended for comparisons, and for volumes that fit a scene better than boxes.
///
/// No leaf is deeper than 60. The tree is a pure function of the primitives.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct VolumeTree<V> {
    tree: Tree<[V; 2]>,
}

/// A hierarchy of bounding spheres.
pub type SphereTree = VolumeTree<BoundingSphere>;

/// A hierarchy of bounding cylinders.
pub type CylinderTree = VolumeTree<BoundingCylinder>;

impl<V: BoundingVolume> VolumeTree<V> {
    /// Builds the tree: O(n log n) time, for spheres 15 to 50 bytes per primitive afterwards, for cylinders 45 to
    /// 85.
    ///
    /// # Errors
    ///
    /// [`BuildError`] if bounds are NaN, inverted or infinite, or the primitives exceed 32-bit indices.
    pub fn build<P: Primitives>(primitives: &P) -> Result<Self, BuildError> {
        let boxes = PrimBounds::collect(primitives)?;
        let measure = split::around::<V>(&boxes.bounded).measure();
        Ok(Self { tree: Tree::build(boxes, measure, split::split) })
    }

    /// Visits the volumes of all nodes and leaves but the root, depth first, with their depth.
    pub fn for_each_volume(&self, mut visit: impl FnMut(&V, u32)) {
        self.tree.for_each_child(
            None,
            |pair, side, _| Some(pair[side]),
            |_, volume, depth| {
                if let Some(volume) = volume {
                    visit(&volume, depth);
                }
            },
        );
    }
}

impl<V: BoundingVolume> Accelerator for VolumeTree<V> {
    fn traverse_ray<P: Primitives, Q: RayQuery, S: Probe>(
        &self,
        primitives: &P,
        query: &mut Q,
        probe: &mut S,
    ) -> ControlFlow<()> {
        query.test_leaf(primitives, &self.tree.unbounded, probe)?;
        if is_finite(&query.ray().ray) {
            self.traverse_bounded(primitives, query, probe)
        } else {
            query.test_leaf(primitives, &self.tree.indices, probe)
        }
    }

    fn traverse_region<Q: RegionQuery>(&self, query: &mut Q) -> ControlFlow<()> {
        query.test_leaf(&self.tree.unbounded)?;
        self.traverse_bounded_region(query)
    }

    fn memory(&self) -> usize {
        size_of::<Self>() + self.tree.heap()
    }

    fn build_stats(&self) -> BuildStats {
        self.tree.stats()
    }

    fn validate<P: Primitives>(&self, primitives: &P) -> Result<(), ValidationError> {
        self.tree.validate(primitives, |volumes, side, own| volumes[side].encloses(own))
    }

    /// Visits the boxes around its volumes.
    fn for_each_box(&self, mut visit: impl FnMut(Aabb, u32)) {
        self.for_each_volume(|volume, depth| visit(volume.bounds(), depth));
    }
}

impl<V: BoundingVolume> Refit for VolumeTree<V> {
    /// O(n log n), in a fraction of the build time.
    fn refit<P: Primitives>(&mut self, primitives: &P) -> Result<(), BuildError> {
        self.tree.refit(primitives, |_, sides| sides.map(|boxes| V::around(boxes.iter().copied()))).map(drop)
    }
}
