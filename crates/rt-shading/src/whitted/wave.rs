//! Waves of rays, and deferred rays.
//!
//! ```text
//!            ┌──────────────── next wave ────────────────┐
//!            ▼                                           │
//!   paths ──> intersect ──> shade ──> shadow rays ──> resolve ──> samples
//!                             └─> deferred rays of each sample ─┘
//! ```

use crate::{
    InteriorList, Seen,
    interior_list::{InteriorListStack, MediumInterface},
    ray_queues::RayQueues,
};
use rt_math::{Interval, Ray, Rgb};

/// Current path in a ray tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct TreePath {
    /// Index of its camera ray.
    pub(super) sample: u32,
    /// Bounces so far.
    pub(super) depth: u32,
    /// Null interfaces that its ray has passed.
    pub(super) passages: u32,
    /// Weight of its radiance in the pixel.
    pub(super) weight: Rgb,
    /// Absorption is accounted for up to this parameter of its ray.
    pub(super) start: f64,
}

/// Refracted ray that is traced after the tree of the mirrored one.
#[derive(Clone, Copy, Debug)]
struct DeferredRay {
    ray: Ray,
    path: TreePath,
    /// Length of its list of enclosing dielectrics.
    bodies: u32,
}

/// State of the ray tree of a camera ray between waves. The tree is traversed depth first, and each wave holds one path of it. The
/// order of sums thus does not depend on the rest of the wave.
#[derive(Clone, Debug, Default)]
pub(super) struct RayTree {
    deferred: Vec<DeferredRay>,
    /// Media around the rays in `deferred`.
    interiors: InteriorListStack,
    /// Media around the current path.
    pub(super) interior: InteriorList,
}

impl RayTree {
    /// Defers a ray that crosses a surface.
    #[inline(always)]
    pub(super) fn defer(&mut self, ray: Ray, path: &TreePath, interface: &MediumInterface) {
        let bodies = self.interiors.push(&self.interior, interface);
        self.deferred.push(DeferredRay { ray, path: *path, bodies });
    }

    /// Moves the ray that was deferred last into the wave, if there is one.
    #[inline]
    pub(super) fn pop_deferred(&mut self, wave: &mut RayQueues<TreePath>) {
        if let Some(DeferredRay { ray, path, bodies }) = self.deferred.pop() {
            self.interiors.pop(&mut self.interior, bodies);
            wave.refracted.push(ray, Interval::SPAWNED, path);
        }
    }
}

/// Shaded hit whose shadow rays are not traced yet.
#[derive(Clone, Copy, Debug)]
struct ShadedHit {
    sample: u32,
    weight: Rgb,
    /// Radiance that needs no shadow ray.
    radiance: Rgb,
    /// End of its lights in [`DirectLighting::reflected`].
    end: u32,
}

/// Shadow rays to one light: they are coherent.
#[derive(Clone, Debug, Default)]
struct ShadowBatch {
    rays: Vec<(Ray, Interval)>,
    blocked: Vec<bool>,
}

/// Direct light on the surfaces of a wave, and its shadow rays.
#[derive(Clone, Debug, Default)]
pub(super) struct DirectLighting {
    surfaces: Vec<ShadedHit>,
    /// Unoccluded reflected radiance, with the light and index of its shadow ray.
    reflected: Vec<(Rgb, Option<(u32, u32)>)>,
    shadows: Vec<ShadowBatch>,
}

impl DirectLighting {
    /// Adds light that the current surface reflects, without a shadow ray.
    #[inline]
    pub(super) fn push(&mut self, reflected: Rgb) {
        self.reflected.push((reflected, None));
    }

    /// Adds light that the current surface reflects if the shadow ray is unoccluded.
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
    pub(super) fn end_surface(&mut self, path: &TreePath, radiance: Rgb) {
        let end = self.reflected.len() as u32;
        self.surfaces.push(ShadedHit { sample: path.sample, weight: path.weight, radiance, end });
    }

    /// Traces the shadow rays and adds unoccluded light to the radiance of the samples.
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
