//! Queues of rays that are traced together, each for a path `P`: the path itself, or its index.

use crate::bsdf::{BsdfSample, Scattering};
use rt_geometry::RayKind;
use rt_math::{Interval, Ray};

/// Rays of one kind, with their paths.
#[derive(Clone, Debug)]
pub(crate) struct RayQueue<P> {
    pub(crate) rays: Vec<(Ray, Interval)>,
    pub(crate) paths: Vec<P>,
}

impl<P> Default for RayQueue<P> {
    fn default() -> Self {
        Self { rays: Vec::new(), paths: Vec::new() }
    }
}

impl<P> RayQueue<P> {
    #[inline(always)]
    pub(crate) fn push(&mut self, ray: Ray, span: Interval, path: P) {
        self.rays.push((ray, span));
        self.paths.push(path);
    }

    pub(crate) fn clear(&mut self) {
        self.rays.clear();
        self.paths.clear();
    }
}

/// Continuation rays of paths, one per path, by kind: rays of a kind are coherent, and counted as such.
#[derive(Clone, Debug)]
pub(crate) struct RayQueues<P> {
    pub(crate) reflected: RayQueue<P>,
    pub(crate) refracted: RayQueue<P>,
    pub(crate) diffuse: RayQueue<P>,
}

impl<P> Default for RayQueues<P> {
    fn default() -> Self {
        Self { reflected: RayQueue::default(), refracted: RayQueue::default(), diffuse: RayQueue::default() }
    }
}

impl<P> RayQueues<P> {
    pub(crate) fn queues(&self) -> [(RayKind, &RayQueue<P>); 3] {
        [
            (RayKind::Reflection, &self.reflected),
            (RayKind::Refraction, &self.refracted),
            (RayKind::Diffuse, &self.diffuse),
        ]
    }

    /// Adds a ray emitted by a light, or scattered by a surface.
    #[inline(always)]
    pub(crate) fn push(&mut self, sample: Option<&BsdfSample>, ray: Ray, span: Interval, path: P) {
        let queue = match kind_of(sample) {
            RayKind::Refraction => &mut self.refracted,
            RayKind::Reflection => &mut self.reflected,
            _ => &mut self.diffuse,
        };
        queue.push(ray, span, path);
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.queues().iter().all(|(_, queue)| queue.rays.is_empty())
    }

    pub(crate) fn clear(&mut self) {
        for queue in [&mut self.reflected, &mut self.refracted, &mut self.diffuse] {
            queue.clear();
        }
    }
}

/// Kind of a ray that a light has emitted, or that a surface has scattered.
#[inline(always)]
pub(crate) fn kind_of(sample: Option<&BsdfSample>) -> RayKind {
    match sample {
        Some(BsdfSample { kind: Scattering::Transmission, .. }) => RayKind::Refraction,
        Some(BsdfSample { is_diffuse: false, .. }) => RayKind::Reflection,
        _ => RayKind::Diffuse,
    }
}
