//! Entry points of traversal, compiled for each output.

use core::marker::PhantomData;

use rt_geometry::Hit;
use rt_math::{Interval, Ray};

use super::WideBvh;
use super::batch::{BatchContext, BatchTraversal};
use super::filter::{BoxTest, LeafTest, SphereTest, TriangleTest};
use super::leaf::LeafKind;
use super::query::{Output, TraversalStats};
use super::single_ray::{SingleContext, SingleTraversal};

/// Queries of a tree.
pub(super) trait TreeQuery: Output {
    /// Traces one ray through a tree. Compiled once here, and not in every crate that traces rays.
    fn trace(tree: &WideBvh, context: &mut SingleContext<'_, Self>, ray: &Ray, span: Interval);

    /// Traces many rays through a tree.
    fn trace_batch(
        tree: &WideBvh,
        context: &mut BatchContext<'_, Self>,
        rays: &[(Ray, Interval)],
        outputs: &mut [Self],
    );
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
    let traversal = BatchTraversal { tree, context: &mut *context, leaf_test: PhantomData::<F> };
    if tree.level.dispatch_packets(traversal, rays, &mut *outputs) {
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

impl TreeQuery for Option<Hit> {
    entry_points!();
}

impl TreeQuery for bool {
    entry_points!();
}
