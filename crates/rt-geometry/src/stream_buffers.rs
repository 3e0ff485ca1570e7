//! Streams that each thread keeps for rays in the space of an instance.

use std::cell::RefCell;

use rt_math::Transform;

use crate::{HitStream, RayStream, StreamArray};

/// Streams of rays and of their results. Their numbers are left from earlier use.
#[derive(Clone, Debug, Default)]
pub struct StreamBuffers {
    /// Rays.
    pub rays: RayStream,
    /// Closest hits.
    pub hits: HitStream,
    /// True for rays that something occludes.
    pub occluded: StreamArray<bool>,
}

thread_local! {
    /// Buffers of this thread that are not in use. Nested instances need more than one.
    static UNUSED: RefCell<Vec<StreamBuffers>> = const { RefCell::new(Vec::new()) };
}

/// Calls `trace` with buffers that no other call uses. The thread keeps their memory of some 27 KiB for the next call.
pub fn with_stream_buffers(trace: &mut dyn FnMut(&mut StreamBuffers)) {
    let mut buffers = UNUSED.try_with(|unused| unused.borrow_mut().pop()).ok().flatten().unwrap_or_default();
    buffers.rays.clear();
    trace(&mut buffers);
    // There is nothing to keep while the thread ends.
    let _ = UNUSED.try_with(|unused| unused.borrow_mut().push(buffers));
}

/// Calls `trace` with the rays in the space below a transform; without one, with the rays as they are.
pub fn with_local_rays(rays: &RayStream, parent_from_local: Option<&Transform>, trace: &mut dyn FnMut(&RayStream)) {
    let Some(transform) = parent_from_local else { return trace(rays) };
    with_stream_buffers(&mut |buffers| {
        buffers.rays.set_mapped(rays, |ray| transform.inverse_ray(ray));
        trace(&buffers.rays);
    });
}
