//! Streams of rays from lights and to the camera.

use crate::{bsdf::BsdfSample, ray_kind::kind_of};
use rt_geometry::{RayKind, RayStream, STREAM_CAPACITY, StreamArray};
use rt_math::{Interval, Ray};

/// Rays of one kind.
#[derive(Clone, Debug, Default)]
pub(super) struct LightRayStream {
    pub(super) rays: RayStream,
    /// Index of the path or connection of each ray.
    pub(super) ids: StreamArray<u32>,
}

impl LightRayStream {
    /// Appends a ray. Nothing happens if the stream is full.
    pub(super) fn push(&mut self, ray: &Ray, span: Interval, id: u32) {
        if self.rays.len() == STREAM_CAPACITY {
            return;
        }
        self.ids.set(self.rays.len(), id);
        self.rays.push(ray, span);
    }
}

/// Next rays of paths, one of each path, by kind: rays of a kind are coherent, and counted as such.
#[derive(Clone, Debug, Default)]
pub(super) struct LightRays {
    reflected: LightRayStream,
    pub(super) refracted: LightRayStream,
    diffuse: LightRayStream,
}

impl LightRays {
    pub(super) const fn by_kind(&self) -> [(RayKind, &LightRayStream); 3] {
        [
            (RayKind::Reflection, &self.reflected),
            (RayKind::Refraction, &self.refracted),
            (RayKind::Diffuse, &self.diffuse),
        ]
    }

    /// Appends a ray emitted by a light, or scattered by a surface.
    pub(super) fn push(&mut self, sample: Option<&BsdfSample>, ray: &Ray, span: Interval, id: u32) {
        let stream = match kind_of(sample) {
            RayKind::Refraction => &mut self.refracted,
            RayKind::Reflection => &mut self.reflected,
            _ => &mut self.diffuse,
        };
        stream.push(ray, span, id);
    }

    pub(super) fn is_empty(&self) -> bool {
        self.by_kind().iter().all(|(_, stream)| stream.rays.is_empty())
    }

    pub(super) const fn clear(&mut self) {
        self.reflected.rays.clear();
        self.refracted.rays.clear();
        self.diffuse.rays.clear();
    }
}
