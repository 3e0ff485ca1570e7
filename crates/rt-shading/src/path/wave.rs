//! State of paths between their surfaces, and the queue of shadow rays.

use crate::{Seen, SurfaceHit, medium_tracker::MediumTracker};
use rt_math::{DVec3, Interval, Ray, Rgb};

/// Previous vertex of a path, for the MIS weights of lights that it hits.
#[derive(Clone, Copy, Debug)]
pub(super) struct PrevVertex {
    pub(super) point: DVec3,
    /// The normal by which lights were chosen there.
    pub(super) normal: Option<DVec3>,
    /// Density of the path's direction; `None` for a single direction, of which lights that are drawn know nothing.
    pub(super) pdf: Option<f64>,
}

/// State of a path.
#[derive(Clone, Debug)]
pub(super) struct Path<S> {
    pub(super) sampler: S,
    pub(super) medium_tracker: MediumTracker,
    /// Throughput (β): weight of radiance in the pixel.
    pub(super) throughput: Rgb,
    /// Accumulated η² from refraction (pbrt's `etaScale`); Russian roulette uses `throughput * eta_scale`.
    pub(super) eta_scale: f64,
    pub(super) prev: PrevVertex,
    /// Surfaces that have scattered it.
    pub(super) bounces: u32,
    /// True if the first of them chose the direction from several, and not a single one.
    pub(super) first_bounce_nonspecular: bool,
    /// True if only the emission of the next surface counts.
    pub(super) emission_only: bool,
}

const CAMERA_VERTEX: PrevVertex = PrevVertex { point: DVec3::ZERO, normal: None, pdf: None };

impl<S> Path<S> {
    pub(super) fn new(sampler: S) -> Self {
        Self {
            sampler,
            medium_tracker: MediumTracker::default(),
            throughput: Rgb::WHITE,
            eta_scale: 1.0,
            prev: CAMERA_VERTEX,
            bounces: 0,
            first_bounce_nonspecular: false,
            emission_only: false,
        }
    }

    /// A new path in the memory of the old one.
    pub(super) fn reset(&mut self, sampler: S) {
        let mut medium_tracker = core::mem::take(&mut self.medium_tracker);
        medium_tracker.reset();
        *self = Self { medium_tracker, ..Self::new(sampler) };
    }

    /// True if the light that the path has met is one that [`LightTracingIntegrator`](crate::LightTracingIntegrator) brings to the camera: a light
    /// that can be drawn from, met in a single direction by a path that began at a surface which spreads light.
    pub(super) fn is_caustic_of(&self, hit: &SurfaceHit) -> bool {
        hit.light.is_some() && self.first_bounce_nonspecular && self.prev.pdf.is_none()
    }
}

/// Light that paths have drawn, until the shadow rays are answered that decide about it.
#[derive(Clone, Debug, Default)]
pub(super) struct ShadowRayQueue {
    rays: Vec<(Ray, Interval)>,
    /// The path of each ray, and what its pixel gets if nothing is in the way.
    drawn: Vec<(u32, Rgb)>,
    /// Places in `drawn` of indirect light that is bounded, in order; empty without a bound.
    indirect: Vec<u32>,
    blocked: Vec<bool>,
}

impl ShadowRayQueue {
    #[inline(always)]
    pub(super) fn push(&mut self, ray: (Ray, Interval), path: u32, radiance: Rgb, is_bounded: bool) {
        if is_bounded {
            self.indirect.push(self.drawn.len() as u32);
        }
        self.rays.push(ray);
        self.drawn.push((path, radiance));
    }

    /// Traces the rays and adds the light that is not blocked to what the paths see, within bounds where it is indirect.
    pub(super) fn resolve(
        &mut self,
        mut occluded: impl FnMut(&[(Ray, Interval)], &mut [bool]),
        mut bounded: impl FnMut(Rgb) -> Rgb,
        seen: &mut [Seen],
    ) {
        if self.rays.is_empty() {
            return;
        }
        self.blocked.clear();
        self.blocked.resize(self.rays.len(), false);
        occluded(&self.rays, &mut self.blocked);
        for &at in &self.indirect {
            if !self.blocked[at as usize] {
                let radiance = &mut self.drawn[at as usize].1;
                *radiance = bounded(*radiance);
            }
        }
        self.indirect.clear();
        for ((path, radiance), is_blocked) in self.drawn.iter().zip(&self.blocked) {
            if !is_blocked {
                seen[*path as usize].radiance += *radiance;
            }
        }
        self.rays.clear();
        self.drawn.clear();
    }
}
