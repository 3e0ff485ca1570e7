//! Queries: the closest hit of a ray, or any hit.
//!
//! The type of the [`Output`] selects between them at compile time: `Option<Hit>` or `bool`.

mod packet_results;
mod ray_state;
mod tester;

use core::marker::PhantomData;

use rt_geometry::Hit;
use rt_math::{Interval, Ray};

pub(super) use packet_results::PacketResults;
pub(super) use ray_state::RayState;
pub(super) use tester::{PrimitiveTester, Tester};

use super::WideBvh;
use super::batch::{BatchContext, BatchTraversal};
use super::leaf::{BoxTest, FilterTRange, Lane, LeafKind, LeafTest, RayF64, SphereTest, TriangleTest};
use super::node::Child;
use super::ray::RayF32;
use super::simd::Simd;
use super::single_ray::{SingleContext, SingleTraversal, TraversalStats};
use super::sphere_list::{ListContext, ListTraversal, SphereList};

/// Result of a query for one ray.
pub(crate) trait Output: Copy + Default {
    /// True if any hit ends the query; otherwise the closest is wanted.
    const ANY_HIT: bool;

    /// Output of an any-hit query that ends with a hit.
    const HIT: Self;

    fn from_hit(hit: Option<Hit>) -> Self;

    /// The hit; a placeholder for an any-hit query.
    fn to_hit(self) -> Option<Hit>;

    /// Traces one ray through a tree. Compiled once here, and not in every crate that traces rays.
    fn trace(tree: &WideBvh, context: &mut SingleContext<'_, Self>, ray: &Ray, span: Interval);

    /// Traces many rays through a tree.
    fn trace_batch(
        tree: &WideBvh,
        context: &mut BatchContext<'_, Self>,
        rays: &[(Ray, Interval)],
        outputs: &mut [Self],
    );

    /// Traces one ray through a list.
    fn trace_list(list: &SphereList, context: &mut ListContext<'_, Self>, ray: &Ray, span: Interval);

    /// True if no other primitive can change the result.
    #[inline(always)]
    fn is_final(self) -> bool {
        Self::ANY_HIT && self.to_hit().is_some()
    }

    /// End of the interval in which further hits matter.
    #[inline(always)]
    fn t_max(self, max: f64) -> f64 {
        match self.to_hit() {
            Some(hit) if !Self::ANY_HIT => hit.t,
            _ => max,
        }
    }

    /// Merges the result for another primitive.
    #[inline(always)]
    fn merge(&mut self, other: Self) {
        if let Some(hit) = other.to_hit()
            && (Self::ANY_HIT || self.to_hit().is_none_or(|closest| hit.precedes(&closest)))
        {
            *self = other;
        }
    }
}

/// Entry points of a query, compiled for a concrete output.
macro_rules! entry_points {
    () => {
        #[inline(never)]
        fn trace(tree: &WideBvh, context: &mut SingleContext<'_, Self>, ray: &Ray, span: Interval) {
            // One kernel for each kind of leaf: the time to compile a kernel grows faster than its size.
            match tree.leaves.kind {
                LeafKind::Watertight => trace_ray::<Self, TriangleTest<true>>(tree, context, ray, span),
                LeafKind::Triangles => trace_ray::<Self, TriangleTest<false>>(tree, context, ray, span),
                LeafKind::Spheres => trace_ray::<Self, SphereTest>(tree, context, ray, span),
                LeafKind::Boxes => trace_ray::<Self, BoxTest>(tree, context, ray, span),
            }
        }

        #[inline(never)]
        fn trace_batch(
            tree: &WideBvh,
            context: &mut BatchContext<'_, Self>,
            rays: &[(Ray, Interval)],
            outputs: &mut [Self],
        ) {
            match tree.leaves.kind {
                LeafKind::Watertight => trace_batch::<Self, TriangleTest<true>>(tree, context, rays, outputs),
                LeafKind::Triangles => trace_batch::<Self, TriangleTest<false>>(tree, context, rays, outputs),
                LeafKind::Spheres => trace_batch::<Self, SphereTest>(tree, context, rays, outputs),
                LeafKind::Boxes => trace_batch::<Self, BoxTest>(tree, context, rays, outputs),
            }
        }

        #[inline(never)]
        fn trace_list(list: &SphereList, context: &mut ListContext<'_, Self>, ray: &Ray, span: Interval) {
            list.level().dispatch(ListTraversal { list, context }, ray, span);
        }
    };
}

#[inline(always)]
fn trace_ray<O: Output, F: LeafTest>(tree: &WideBvh, context: &mut SingleContext<'_, O>, ray: &Ray, span: Interval) {
    tree.level.dispatch(SingleTraversal { tree, context, leaf_test: PhantomData::<F> }, ray, span);
}

#[inline(always)]
fn trace_batch<O: Output, F: LeafTest>(
    tree: &WideBvh,
    context: &mut BatchContext<'_, O>,
    rays: &[(Ray, Interval)],
    outputs: &mut [O],
) {
    if tree.level.has_packets() {
        tree.level.dispatch_packets(BatchTraversal { tree, context, leaf_test: PhantomData::<F> }, rays, outputs);
        return;
    }
    for ((ray, span), output) in rays.iter().zip(outputs) {
        let mut single = SingleContext { tester: &mut *context.tester, stats: TraversalStats::default(), output };
        trace_ray::<O, F>(tree, &mut single, ray, *span);
        let TraversalStats { nodes, tests, hits } = single.stats;
        context.stats.nodes += nodes;
        context.stats.tests += tests;
        context.stats.hits += hits;
    }
}

impl Output for Option<Hit> {
    const ANY_HIT: bool = false;
    const HIT: Self = Some(NO_HIT);
    entry_points!();

    #[inline(always)]
    fn from_hit(hit: Option<Hit>) -> Self {
        hit
    }

    #[inline(always)]
    fn to_hit(self) -> Option<Hit> {
        self
    }
}

impl Output for bool {
    const ANY_HIT: bool = true;
    const HIT: Self = true;
    entry_points!();

    #[inline(always)]
    fn from_hit(hit: Option<Hit>) -> Self {
        hit.is_some()
    }

    #[inline(always)]
    fn to_hit(self) -> Option<Hit> {
        self.then_some(NO_HIT)
    }
}

/// Placeholder for a hit that is unknown or does not matter.
const NO_HIT: Hit = Hit { t: f64::INFINITY, instance: 0, primitive: 0, uv: [0.0; 2] };

/// A ray prepared for the boxes of nodes and the primitives of leaves.
pub(super) struct TravRay<'r, S: Simd, F> {
    pub(super) ray: RayF64<'r, S>,
    pub(super) boxes: RayF32,
    pub(super) min: f32,
    pub(super) leaf_test: F,
}

impl<'r, S: Simd, F: LeafTest> TravRay<'r, S, F> {
    /// `None` where the proofs of the filters do not apply.
    #[inline(always)]
    pub(super) fn new(simd: S, tree: &WideBvh, ray: &'r Ray, span: Interval) -> Option<Self> {
        let ray = RayF64::new(simd, ray);
        let boxes = RayF32::new(simd, &ray.lanes, span, tree.centre, tree.size)?;
        let span = FilterTRange::new(simd, span);
        Some(Self { min: span.min(), leaf_test: F::new(simd, &ray, &boxes, span, tree), ray, boxes })
    }
}

/// Removes the lowest lane from a mask that is not 0, and returns it.
#[inline(always)]
pub(super) fn take_lane(mask: &mut u32) -> usize {
    let lane = mask.trailing_zeros() as usize;
    *mask &= *mask - 1;
    lane & 7
}

/// Leaf and lane of a primitive.
#[derive(Clone, Copy)]
pub(super) struct PrimSlot {
    leaf: Child,
    lane: Lane,
}

impl PrimSlot {
    /// # Safety
    ///
    /// The child must be a leaf of the tree that the slot is used with.
    #[inline(always)]
    pub(super) const unsafe fn new(leaf: Child, lane: Lane) -> Self {
        Self { leaf, lane }
    }

    /// A leaf of the tree.
    #[inline(always)]
    pub(super) const fn leaf(self) -> Child {
        self.leaf
    }

    #[inline(always)]
    pub(super) const fn lane(self) -> Lane {
        self.lane
    }
}
