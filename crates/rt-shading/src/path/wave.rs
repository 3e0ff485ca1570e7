//! State of paths between vertices, and the queue of shadow rays.

use crate::{RadianceSample, SurfaceHit, medium_tracker::MediumTracker};
use rt_math::{DVec3, Interval, Ray, Rgb};

/// Previous vertex of a path, for the MIS weights of lights that it hits.
#[derive(Clone, Copy, Debug)]
pub(super) struct PrevVertex {
    pub(super) point: DVec3,
    /// Normal for the sampling of lights there.
    pub(super) normal: Option<DVec3>,
    /// Density of the path's direction; `None` for a delta direction, which has no competing light sample.
    pub(super) pdf: Option<f64>,
}

/// State of a path.
#[derive(Clone, Debug)]
pub(super) struct Path {
    pub(super) medium_tracker: MediumTracker,
    /// Throughput (β): weight of radiance in the pixel.
    pub(super) throughput: Rgb,
    /// Accumulated η² from refraction (pbrt's `etaScale`); Russian roulette uses `throughput * eta_scale`.
    pub(super) eta_scale: f64,
    pub(super) prev: PrevVertex,
    /// Number of surfaces that have scattered it.
    pub(super) bounces: u32,
    /// True if the first of them sampled a non-delta lobe.
    pub(super) first_bounce_nonspecular: bool,
    /// True if the path ends after the emission of the next surface.
    pub(super) emission_only: bool,
}

const CAMERA_VERTEX: PrevVertex = PrevVertex { point: DVec3::ZERO, normal: None, pdf: None };

impl Default for Path {
    fn default() -> Self {
        Self {
            medium_tracker: MediumTracker::default(),
            throughput: Rgb::WHITE,
            eta_scale: 1.0,
            prev: CAMERA_VERTEX,
            bounces: 0,
            first_bounce_nonspecular: false,
            emission_only: false,
        }
    }
}

impl Path {
    /// Restarts the path and keeps its memory.
    pub(super) fn reset(&mut self) {
        let mut medium_tracker = core::mem::take(&mut self.medium_tracker);
        medium_tracker.reset();
        *self = Self { medium_tracker, ..Self::default() };
    }

    /// True if [`LightTracingIntegrator`](crate::LightTracingIntegrator) computes the emission of this hit. It belongs to a sampled
    /// light, the last bounce was specular, and the first was not.
    pub(super) fn is_caustic_of(&self, hit: &SurfaceHit) -> bool {
        hit.light.is_some() && self.first_bounce_nonspecular && self.prev.pdf.is_none()
    }
}

/// Sampled direct light and its shadow rays.
#[derive(Clone, Debug, Default)]
pub(super) struct ShadowRayQueue {
    rays: Vec<(Ray, Interval)>,
    /// Path of each ray, and its contribution if the ray is unoccluded.
    sampled: Vec<(u32, Rgb)>,
    /// Indices into `sampled` of clamped indirect light, in order; empty without a bound.
    indirect: Vec<u32>,
    blocked: Vec<bool>,
}

impl ShadowRayQueue {
    #[inline(always)]
    pub(super) fn push(&mut self, ray: (Ray, Interval), path: u32, radiance: Rgb, is_clamped: bool) {
        if is_clamped {
            self.indirect.push(self.sampled.len() as u32);
        }
        self.rays.push(ray);
        self.sampled.push((path, radiance));
    }

    /// Traces the rays and adds unoccluded light to the radiance of the paths, clamped where it is indirect.
    pub(super) fn resolve(
        &mut self,
        mut occluded: impl FnMut(&[(Ray, Interval)], &mut [bool]),
        mut bounded: impl FnMut(Rgb) -> Rgb,
        seen: &mut [RadianceSample],
    ) {
        if self.rays.is_empty() {
            return;
        }
        self.blocked.clear();
        self.blocked.resize(self.rays.len(), false);
        occluded(&self.rays, &mut self.blocked);
        for &at in &self.indirect {
            if !self.blocked[at as usize] {
                let radiance = &mut self.sampled[at as usize].1;
                *radiance = bounded(*radiance);
            }
        }
        self.indirect.clear();
        for ((path, radiance), is_blocked) in self.sampled.iter().zip(&self.blocked) {
            if !is_blocked {
                seen[*path as usize].radiance += *radiance;
            }
        }
        self.rays.clear();
        self.sampled.clear();
    }
}
