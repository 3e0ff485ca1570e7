//! Rays of slices as streams.

use std::cell::RefCell;

use rt_geometry::{Hit, HitStream, RayStream, STREAM_CAPACITY};
use rt_math::{Interval, Ray};

/// A stream of rays and its closest hits.
#[derive(Default)]
struct StreamBuffers {
    rays: RayStream,
    hits: HitStream,
}

thread_local! {
    /// Buffers of this thread that are not in use. Instances need more than one.
    static UNUSED: RefCell<Vec<StreamBuffers>> = const { RefCell::new(Vec::new()) };
}

/// Calls `trace` with the rays of a slice in streams, the index of the first ray of each, and space for hits.
fn for_each_stream(rays: &[(Ray, Interval)], trace: &mut dyn FnMut(usize, &RayStream, &mut HitStream)) {
    let mut buffers = UNUSED.try_with(|unused| unused.borrow_mut().pop()).ok().flatten().unwrap_or_default();
    for (at, rays) in rays.chunks(STREAM_CAPACITY).enumerate() {
        buffers.rays.clear();
        rays.iter().for_each(|(ray, span)| buffers.rays.push(ray, *span));
        trace(at * STREAM_CAPACITY, &buffers.rays, &mut buffers.hits);
    }
    // There is nothing to keep while the thread ends.
    let _ = UNUSED.try_with(|unused| unused.borrow_mut().push(buffers));
}

/// Finds the closest hits of the rays of a slice. Rays and hits beyond the shorter slice are ignored.
pub(crate) fn closest_in_streams(
    rays: &[(Ray, Interval)],
    hits: &mut [Option<Hit>],
    trace: &mut dyn FnMut(&RayStream, &mut HitStream),
) {
    let rays = &rays[..rays.len().min(hits.len())];
    for_each_stream(rays, &mut |first, rays, of_stream| {
        trace(rays, of_stream);
        for (at, hit) in hits[first..first + rays.len()].iter_mut().enumerate() {
            *hit = of_stream.get(at);
        }
    });
}

/// Version of [`closest_in_streams`] for occlusion.
pub(crate) fn occluded_in_streams(
    rays: &[(Ray, Interval)],
    occluded: &mut [bool],
    trace: &mut dyn FnMut(&RayStream, &mut [bool]),
) {
    let rays = &rays[..rays.len().min(occluded.len())];
    for_each_stream(rays, &mut |first, rays, _| trace(rays, &mut occluded[first..first + rays.len()]));
}
