//! Rays in waves: what is traced together, and what waits.
//!
//! ```text
//!            ┌──────────────── next wave ────────────────┐
//!            ▼                                           │
//!   paths ──> intersect ──> shade ──> shadow rays ──> gather ──> samples
//!                             └─> waiting rays of each sample ─┘
//! ```

use crate::{
    InteriorList, Seen,
    interior_list::{InteriorListStack, MediumInterface},
    ray_queues::RayQueues,
};
use rt_math::{Interval, Ray, Rgb};

/// A path from the camera, as far as the ray that is traced for it now.
#[derive(Clone, Copy, Debug)]
pub(super) struct Path {
    /// Index of its camera ray.
    pub(super) sample: u32,
    /// Bounces so far.
    pub(super) depth: u32,
    /// Surfaces that its ray has passed because they do nothing to it.
    pub(super) passages: u32,
    /// Part of its radiance that reaches the camera.
    pub(super) weight: Rgb,
    /// Absorption is accounted for up to this parameter of its ray.
    pub(super) start: f64,
}

/// A refracted ray that waits until the mirrored one, and all that comes of it, has been followed.
#[derive(Clone, Copy, Debug)]
struct DeferredRay {
    ray: Ray,
    path: Path,
    /// Length of its list of the bodies that it is inside of.
    bodies: u32,
}

/// State of the ray tree of a camera ray between waves. The tree is traversed depth first, and each wave holds one path of it,
/// so that what the camera ray sees adds up in the same order whatever else is in the wave.
#[derive(Clone, Debug, Default)]
pub(super) struct PixelTree {
    deferred: Vec<DeferredRay>,
    /// Media around the rays in `deferred`.
    interiors: InteriorListStack,
    /// Media around the current path.
    pub(super) interior: InteriorList,
}

impl PixelTree {
    /// Has a ray wait that goes on through the surface of a crossing.
    #[inline(always)]
    pub(super) fn defer(&mut self, ray: Ray, path: &Path, interface: &MediumInterface) {
        let bodies = self.interiors.push(&self.interior, interface);
        self.deferred.push(DeferredRay { ray, path: *path, bodies });
    }

    /// Puts the ray that has waited least into the wave, if there is one.
    #[inline]
    pub(super) fn pop_deferred(&mut self, wave: &mut RayQueues<Path>) {
        if let Some(DeferredRay { ray, path, bodies }) = self.deferred.pop() {
            self.interiors.pop(&mut self.interior, bodies);
            wave.refracted.push(ray, Interval::SPAWNED, path);
        }
    }
}

/// A surface that was met, until its shadow rays are answered.
#[derive(Clone, Copy, Debug)]
struct ShadedHit {
    sample: u32,
    weight: Rgb,
    /// Radiance that needs no shadow ray.
    radiance: Rgb,
    /// End of its lights in [`DirectLighting::reflected`].
    end: u32,
}

/// Shadow rays to one light: they run alike.
#[derive(Clone, Debug, Default)]
struct ShadowBatch {
    rays: Vec<(Ray, Interval)>,
    blocked: Vec<bool>,
}

/// Light on the surfaces of a wave, and the shadow rays that decide about it.
#[derive(Clone, Debug, Default)]
pub(super) struct DirectLighting {
    surfaces: Vec<ShadedHit>,
    /// Unoccluded reflected radiance, with the light and index of its shadow ray.
    reflected: Vec<(Rgb, Option<(u32, u32)>)>,
    shadows: Vec<ShadowBatch>,
}

impl DirectLighting {
    /// Light that the surface at hand reflects, whatever is in the way.
    #[inline]
    pub(super) fn push(&mut self, reflected: Rgb) {
        self.reflected.push((reflected, None));
    }

    /// Light that the surface at hand reflects, if nothing blocks the shadow ray.
    #[inline(always)]
    pub(super) fn push_shadowed(&mut self, light: usize, reflected: Rgb, ray: Ray, span: Interval) {
        if self.shadows.len() <= light {
            self.shadows.resize_with(light + 1, ShadowBatch::default);
        }
        let rays = &mut self.shadows[light].rays;
        rays.push((ray, span));
        self.reflected.push((reflected, Some((light as u32, rays.len() as u32 - 1))));
    }

    /// Ends the lights of a surface, and adds its emission.
    #[inline]
    pub(super) fn end_surface(&mut self, path: &Path, radiance: Rgb) {
        let end = self.reflected.len() as u32;
        self.surfaces.push(ShadedHit { sample: path.sample, weight: path.weight, radiance, end });
    }

    /// Traces the shadow rays and adds what is left of the light to what the samples see.
    pub(super) fn resolve(&mut self, mut occluded: impl FnMut(&[(Ray, Interval)], &mut [bool]), seen: &mut [Seen]) {
        for ShadowBatch { rays, blocked } in &mut self.shadows {
            blocked.clear();
            blocked.resize(rays.len(), false);
            if !rays.is_empty() {
                occluded(rays, blocked);
            }
            rays.clear();
        }
        let is_blocked = |light: u32, ray: u32| self.shadows[light as usize].blocked[ray as usize];
        let mut reflected = self.reflected.iter();
        let mut start = 0;
        for met in &self.surfaces {
            let mut radiance = met.radiance;
            for (light, decided_by) in reflected.by_ref().take((met.end - start) as usize) {
                if !decided_by.is_some_and(|(light, ray)| is_blocked(light, ray)) {
                    radiance += *light;
                }
            }
            start = met.end;
            seen[met.sample as usize].radiance += met.weight * radiance;
        }
        self.surfaces.clear();
        self.reflected.clear();
    }
}
