//! Entry points of traversal, compiled for each output.

use core::marker::PhantomData;

use rt_geometry::Hit;
use rt_math::{Interval, Ray};

use super::WideBvh;
use super::batch::{BatchContext, BatchTraversal};
use super::coherence::is_coherent;
use super::f64x8::PACKET;
use super::filter::{BoxTest, LeafTest, SphereTest, TriangleTest};
use super::leaf::LeafKind;
use super::list_traversal::{LIST_BATCH, TriangleListTraversal};
use super::query::{Output, TraversalStats};
use super::single_ray::{SingleContext, SingleTraversal};
use super::triangle_list::TriangleList;

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
            if let Some(list) = &tree.list
                && !context.counts_work
                && trace_small(tree, list, context, rays, outputs)
            {
                return;
            }
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
        context.stats += single.stats;
    }
}

/// Traces a batch through a small tree: coherent packets through its nodes, all other rays through its list. False, without a
/// result, if kernels for batches are not compiled for this level.
#[inline(always)]
fn trace_small<O: TreeQuery>(
    tree: &WideBvh,
    list: &TriangleList,
    context: &mut BatchContext<'_, O>,
    rays: &[(Ray, Interval)],
    outputs: &mut [O],
) -> bool {
    let mut rest = (rays, outputs);
    while !rest.0.is_empty() {
        let (n, is_coherent) = leading_packets(rest.0);
        let ((rays, later), (outputs, later_outputs)) = (rest.0.split_at(n), rest.1.split_at_mut(n));
        rest = (later, later_outputs);
        if is_coherent {
            trace_batch::<O, TriangleTest<true>>(tree, context, rays, outputs);
            continue;
        }
        let mut open = 0;
        let traversal = TriangleListTraversal { tree, list, context: &mut *context, open: &mut open };
        if !tree.level.dispatch_lists(traversal, rays, &mut *outputs) {
            return false;
        }
        while open != 0 {
            let at = open.trailing_zeros() as usize;
            open &= open - 1;
            if let (Some((ray, span)), Some(output)) = (rays.get(at), outputs.get_mut(at)) {
                let stats = TraversalStats::default();
                let mut single = SingleContext { tester: &mut *context.tester, stats, output };
                O::trace(tree, &mut single, ray, *span);
                context.stats += single.stats;
            }
        }
    }
    true
}

/// Number of leading rays in packets that are all coherent, or at most [`LIST_BATCH`] in packets that are not, and true if
/// they are.
#[inline(always)]
fn leading_packets(rays: &[(Ray, Interval)]) -> (usize, bool) {
    let is_packet_coherent = |rays: &[(Ray, Interval)]| rays.first_chunk().is_some_and(is_coherent);
    let is_coherent = is_packet_coherent(rays);
    let most = if is_coherent { rays.len() } else { rays.len().min(LIST_BATCH) };
    let mut n = PACKET.min(most);
    while n < most && is_packet_coherent(&rays[n..]) == is_coherent {
        n = most.min(n + PACKET);
    }
    (n, is_coherent)
}

impl TreeQuery for Option<Hit> {
    entry_points!();
}

impl TreeQuery for bool {
    entry_points!();
}
