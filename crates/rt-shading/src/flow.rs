//! Rays that are traced together, each for a path.

use crate::bsdf::{BsdfSample, Scattering};
use rt_math::{Interval, Ray, RayKind};

/// Rays of one kind, and the paths that they belong to.
#[derive(Clone, Debug, Default)]
pub(crate) struct Queue {
    pub(crate) rays: Vec<(Ray, Interval)>,
    pub(crate) paths: Vec<u32>,
}

impl Queue {
    pub(crate) fn push(&mut self, ray: Ray, span: Interval, path: u32) {
        self.rays.push((ray, span));
        self.paths.push(path);
    }

    pub(crate) fn clear(&mut self) {
        self.rays.clear();
        self.paths.clear();
    }
}

/// The rays of all paths, by kind: each path has one.
#[derive(Clone, Debug, Default)]
pub(crate) struct Flow {
    pub(crate) primary: Queue,
    reflected: Queue,
    refracted: Queue,
    diffuse: Queue,
}

impl Flow {
    pub(crate) fn queues(&self) -> [(RayKind, &Queue); 4] {
        [
            (RayKind::Primary, &self.primary),
            (RayKind::Reflection, &self.reflected),
            (RayKind::Refraction, &self.refracted),
            (RayKind::Diffuse, &self.diffuse),
        ]
    }

    /// Puts in a ray that a light sends out, or a surface as the sample says.
    pub(crate) fn push(&mut self, sample: Option<&BsdfSample>, ray: Ray, span: Interval, path: u32) {
        let queue = match sample {
            Some(BsdfSample { kind: Scattering::Transmission, .. }) => &mut self.refracted,
            Some(BsdfSample { is_diffuse: false, .. }) => &mut self.reflected,
            _ => &mut self.diffuse,
        };
        queue.push(ray, span, path);
    }

    /// Puts in the rest of a ray that has passed a surface.
    pub(crate) fn push_passing(&mut self, ray: Ray, span: Interval, path: u32) {
        self.refracted.push(ray, span, path);
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.queues().iter().all(|(_, queue)| queue.rays.is_empty())
    }

    pub(crate) fn clear(&mut self) {
        for queue in [&mut self.primary, &mut self.reflected, &mut self.refracted, &mut self.diffuse] {
            queue.clear();
        }
    }
}
