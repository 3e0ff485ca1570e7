//! Bounding volume hierarchy.

mod node;
mod refit;
mod spatial_splits;
mod traverse;
mod validate;

use core::ops::ControlFlow;

use glam::DVec3;
use rt_geometry::{Primitives, Probe};
use rt_math::Aabb;

use crate::binned_sah::{best_split, bounds_of, centroid_bounds, relative_cost, split_set};
use crate::node_ref::NodeRef;
use crate::prim_bounds::PrimBounds;
use crate::ray_query::is_finite;
use crate::top_down::{SliceSplit, Subtree, build_in_place};
use crate::{Accelerator, BuildError, BuildStats, RayQuery, RegionQuery, ValidationError};
use node::BvhNode;
pub(crate) use node::{Aabb32, SlabRay32};
use spatial_splits::SplitRef;

/// Criterion by which a set of primitives is split.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SplitMethod {
    /// At the median centre along the widest axis (Kay and Kajiya 1986). The fastest to build, and the slowest to trace
    /// unless primitives are evenly distributed.
    Median,
    /// At the minimum of the surface area heuristic (MacDonald and Booth 1990), over bins (Wald 2007).
    #[default]
    SurfaceArea,
    /// [`SurfaceArea`](Self::SurfaceArea), but where the boxes of both sides would overlap, a plane may cut through
    /// primitives, which both sides then list. See Stich, Friedrich and Dietrich, "Spatial Splits in Bounding Volume
    /// Hierarchies", 2009. Slower to build, on one thread, with up to 50 % more references. Recommended where large
    /// primitives extend through many small ones.
    Spatial,
}

/// Binary tree of boxes: O(log n) per ray for most scenes, for any sizes of primitives.
///
/// Built top-down by a [`SplitMethod`]. Nodes are cache lines of 64 bytes. They hold the boxes of both children as
/// `f32`, relative to the centre of the tree and rounded outward. All culling arithmetic is `f64`. No leaf is deeper
/// than 60, so that a traversal needs a small fixed stack and never allocates.
///
/// The tree is a pure function of the primitives, with or without the feature `parallel`.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(remote = "Self"))]
pub struct Bvh {
    nodes: Vec<BvhNode>,
    /// Bounded primitives, leaf by leaf.
    indices: Vec<u32>,
    root: NodeRef,
    /// Origin of all boxes in world space.
    centre: DVec3,
    unbounded: Vec<u32>,
    leaves: usize,
    max_depth: u32,
    /// Number of bounded primitives.
    bounded: u32,
    /// Cells of the references to primitives with several references.
    split_refs: Vec<SplitRef>,
}

impl Bvh {
    /// Builds the tree: O(n log n) time, 25 to 45 bytes per primitive afterwards.
    ///
    /// # Errors
    ///
    /// [`BuildError`] if bounds are NaN, inverted or infinite, or the primitives exceed 32-bit indices.
    pub fn build<P: Primitives>(primitives: &P) -> Result<Self, BuildError> {
        Self::build_with(primitives, SplitMethod::default())
    }

    /// Builds the tree by a given method.
    ///
    /// # Errors
    ///
    /// Those of [`build`](Self::build).
    pub fn build_with<P: Primitives>(primitives: &P, method: SplitMethod) -> Result<Self, BuildError> {
        let PrimBounds { bounded, unbounded, union } = PrimBounds::collect(primitives)?;
        let centre = if bounded.is_empty() { DVec3::ZERO } else { union.centre() };
        let mut items: Vec<_> =
            bounded.into_iter().map(|(index, own)| (index, Aabb32::enclosing(&own, centre))).collect();
        let (Subtree { nodes, indices, root, height }, split_refs) = match method {
            SplitMethod::Spatial => spatial_splits::build(&items),
            SplitMethod::Median | SplitMethod::SurfaceArea => (build(&mut items, method), Vec::new()),
        };
        Ok(Self {
            leaves: if items.is_empty() { 0 } else { nodes.len() + 1 },
            nodes,
            indices,
            root,
            centre,
            unbounded,
            max_depth: height,
            bounded: items.len() as u32,
            split_refs,
        })
    }

    /// Expected cost by the surface area heuristic, in visits of a node.
    fn sah_cost(&self) -> Option<f64> {
        let boxes = |node: &BvhNode| [0, 1].map(|side| (node.child_box(side).half_area(), node.children[side].count));
        let [left, right] = [0, 1].map(|side| self.nodes.first().map(|root| root.child_box(side)));
        let whole = left?.union(right?).half_area();
        let below: f64 = self.nodes.iter().flat_map(boxes).map(|(area, count)| area * relative_cost(count)).sum();
        (whole > 0.0 && whole < f64::INFINITY).then(|| 1.0 + below / whole)
    }

    #[inline]
    fn leaf(&self, child: NodeRef) -> &[u32] {
        &self.indices[child.first as usize..][..child.count as usize]
    }
}

fn build(items: &mut [(u32, Aabb32)], method: SplitMethod) -> Subtree<BvhNode> {
    let bounds = bounds_of(items);
    build_in_place(items, bounds, |items, bounds, depth| {
        let centroids = centroid_bounds(items);
        let best = match method {
            SplitMethod::Median => None,
            _ => best_split(items, &centroids, depth, spatial_splits::bin_cost),
        };
        let (middle, bounds) = split_set(items, &centroids, bounds.half_area(), best)?;
        Some(SliceSplit { middle, payload: bounds, states: bounds })
    })
}

impl Accelerator for Bvh {
    fn traverse_ray<P: Primitives, Q: RayQuery, S: Probe>(
        &self,
        primitives: &P,
        query: &mut Q,
        probe: &mut S,
    ) -> ControlFlow<()> {
        query.test_leaf(primitives, &self.unbounded, probe)?;
        if is_finite(&query.ray().ray) {
            self.traverse_bounded(primitives, query, probe)
        } else {
            query.test_leaf(primitives, &self.indices, probe)
        }
    }

    fn traverse_region<Q: RegionQuery>(&self, query: &mut Q) -> ControlFlow<()> {
        query.test_leaf(&self.unbounded)?;
        self.traverse_bounded_region(query)
    }

    fn memory(&self) -> usize {
        size_of::<Self>()
            + self.nodes.capacity() * size_of::<BvhNode>()
            + (self.indices.capacity() + self.unbounded.capacity()) * size_of::<u32>()
            + self.split_refs.capacity() * size_of::<SplitRef>()
    }

    fn build_stats(&self) -> BuildStats {
        BuildStats {
            primitives: self.bounded as usize + self.unbounded.len(),
            unbounded: self.unbounded.len(),
            nodes: self.nodes.len(),
            leaves: self.leaves,
            max_depth: self.max_depth as usize,
            references: self.indices.len(),
            sah_cost: self.sah_cost(),
        }
    }

    fn validate<P: Primitives>(&self, primitives: &P) -> Result<(), ValidationError> {
        self.check(primitives)
    }

    fn for_each_box(&self, mut visit: impl FnMut(Aabb, u32)) {
        let mut pending = vec![(self.root, 0)];
        while let Some((child, depth)) = pending.pop() {
            let Some(node) = self.nodes.get(child.first as usize).filter(|_| child.count == 0) else { continue };
            for side in [1, 0] {
                visit(node.child_box(side).at(self.centre), depth + 1);
                pending.push((node.children[side], depth + 1));
            }
        }
    }
}

#[cfg(feature = "serde")]
crate::checked_serde::impl_checked_serde!(Bvh, Bvh::check_shape);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::binned_sah::MAX_LEAF;
    use glam::Vec3A;
    use rt_math::random::{hash, unit};

    #[test]
    fn bounds_of_infinite_area_have_no_cost() {
        let boxes = [Aabb::new(DVec3::splat(-1e307), DVec3::splat(1e307)), Aabb::new(DVec3::ZERO, DVec3::ONE)];
        assert_eq!(Bvh::build(&crate::Boxes(&boxes)).expect("boxes").build_stats().sah_cost, None);
    }

    fn items(count: u32) -> Vec<(u32, Aabb32)> {
        let item = |index: u32| {
            let draw = |axis| unit(hash(&[u64::from(index), axis])) as f32;
            // Coarse coordinates, so that many centroids coincide.
            let min = Vec3A::new((draw(0) * 40.0).round(), (draw(1) * 9.0).round(), draw(2));
            (index, Aabb32 { min, max: min + 0.1 * draw(3) })
        };
        (0..count).map(item).collect()
    }

    #[test]
    fn leaves_are_small_and_hold_each_primitive_once() {
        let tree = build(&mut items(5000), SplitMethod::SurfaceArea);
        let counts: Vec<_> =
            tree.nodes.iter().flat_map(|node| node.children).map(|child| child.count as usize).collect();
        assert!(counts.iter().all(|&count| count <= MAX_LEAF));
        assert_eq!(counts.iter().filter(|&&count| count > 0).count(), tree.nodes.len() + 1);
        assert_eq!(counts.iter().sum::<usize>(), 5000);
        let mut all = tree.indices;
        all.sort_unstable();
        assert_eq!(all, (0..5000).collect::<Vec<_>>());
    }
}
