//! Entry points of traversal, compiled for each output.

use core::cell::OnceCell;
use core::marker::PhantomData;

use rt_geometry::{Hit, RayStream};
use rt_math::{Interval, Ray};

use super::WideBvh;
use super::f64x8::PACKET;
use super::filter::{BoxTest, LeafTest, SphereTest, TriangleTest};
use super::leaf::LeafKind;
use super::list_traversal::{ListStream, TriangleListQuery};
use super::query::{Output, TraversalStats};
use super::simd::take_lane;
use super::single_ray::{SingleContext, SingleTraversal};
use super::stream_rays::{ALL_PACKETS, N_PACKETS, StreamRays};
use super::stream_traversal::{StreamContext, StreamTraversal};

/// Queries of a tree.
pub(super) trait TreeQuery: TriangleListQuery {
    /// Traces one ray through a tree. Compiled once here, and not in every crate that traces rays.
    fn trace(tree: &WideBvh, context: &mut SingleContext<'_, Self>, ray: &Ray, span: Interval);

    /// Traces the rays of a stream through a tree.
    fn trace_stream(
        tree: &WideBvh,
        context: &mut StreamContext<'_, Self>,
        rays: &RayStream,
        outputs: &mut Self::OfStream,
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
        fn trace_stream(
            tree: &WideBvh,
            context: &mut StreamContext<'_, Self>,
            rays: &RayStream,
            outputs: &mut Self::OfStream,
        ) {
            let mut packets = ALL_PACKETS;
            if let Some(list) = tree.list.as_ref().filter(|_| !context.counts_work) {
                let mut open = [0; N_PACKETS];
                let mut coherent = 0;
                let traversal = ListStream { tree, list, open: &mut open, coherent: &mut coherent };
                if Self::trace_list(traversal, tree.level, rays, outputs) {
                    packets = coherent;
                    for (packet, open) in open.into_iter().enumerate() {
                        trace_one_by_one((tree, &mut *context), rays, (packet, open.into()), outputs);
                    }
                }
            }
            if packets != 0 && !trace_packets((tree, &mut *context), rays, packets, outputs) {
                for packet in 0..rays.len().div_ceil(PACKET) {
                    trace_one_by_one((tree, &mut *context), rays, (packet, 0xff), outputs);
                }
            }
        }
    };
}

#[inline(always)]
fn trace_ray<O: Output, F: LeafTest>(tree: &WideBvh, context: &mut SingleContext<'_, O>, ray: &Ray, span: Interval) {
    tree.level.dispatch(SingleTraversal { tree, context, leaf_test: PhantomData::<F> }, ray, span);
}

/// Traces some packets of a stream. False, without a result, if kernels for packets are not compiled for this level.
#[inline(never)]
fn trace_packets<O: Output>(
    (tree, context): (&WideBvh, &mut StreamContext<'_, O>),
    rays: &RayStream,
    packets: u32,
    outputs: &mut O::OfStream,
) -> bool {
    let copies = [const { OnceCell::new() }; N_PACKETS];
    let (rays, packets) = (StreamRays::new(rays, &copies), (packets, outputs));
    match tree.leaves.kind {
        LeafKind::Watertight => trace_leaves::<O, TriangleTest<true>>(tree, context, rays, packets),
        LeafKind::Triangles => trace_leaves::<O, TriangleTest<false>>(tree, context, rays, packets),
        LeafKind::Spheres => trace_leaves::<O, SphereTest>(tree, context, rays, packets),
        LeafKind::Boxes => trace_leaves::<O, BoxTest>(tree, context, rays, packets),
    }
}

#[inline(always)]
fn trace_leaves<O: Output, F: LeafTest>(
    tree: &WideBvh,
    context: &mut StreamContext<'_, O>,
    rays: StreamRays<'_>,
    (packets, outputs): (u32, &mut O::OfStream),
) -> bool {
    tree.level.dispatch_packets(StreamTraversal { tree, context, packets, leaf_test: PhantomData::<F> }, rays, outputs)
}

/// Traces some rays of a packet, a bit for each, as single rays.
fn trace_one_by_one<O: TreeQuery>(
    (tree, context): (&WideBvh, &mut StreamContext<'_, O>),
    rays: &RayStream,
    (packet, mut mask): (usize, u32),
    outputs: &mut O::OfStream,
) {
    while mask != 0 {
        let at = packet * PACKET + take_lane(&mut mask);
        if at >= rays.len() {
            return;
        }
        let ((ray, span), mut output) = (rays.get(at), O::default());
        let stats = TraversalStats::default();
        let mut single = SingleContext { tester: &mut *context.tester, stats, output: &mut output };
        O::trace(tree, &mut single, &ray, span);
        context.stats += single.stats;
        output.write(outputs, at);
    }
}

impl TreeQuery for Option<Hit> {
    entry_points!();
}

impl TreeQuery for bool {
    entry_points!();
}
