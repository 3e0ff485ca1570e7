//! What light paths keep between their surfaces and on the way to the camera.

use crate::{Lighting, Needs, ShadingCounts, SurfaceHit, hit_context::HitContext, medium_tracker::MediumTracker};
use rt_math::{DVec2, Ray, Rgb};

/// A path on its way from a light.
#[derive(Clone, Debug)]
pub(super) struct LightPath<S> {
    pub(super) sampler: S,
    pub(super) medium_tracker: MediumTracker,
    /// Power at the light.
    pub(super) power: Rgb,
    /// What is left of it.
    pub(super) throughput: Rgb,
    /// Surfaces that have scattered it.
    pub(super) bounces: u32,
    /// World units from the light, for light that does not weaken on its way: none once it has been spread.
    pub(super) no_falloff_distance: Option<f64>,
}

/// Light on its last way, to the camera.
#[derive(Clone, Debug)]
pub(super) struct Connection {
    pub(super) medium_tracker: MediumTracker,
    pub(super) raster: DVec2,
    /// What arrives if nothing is in the way.
    pub(super) light: Rgb,
}

impl Connection {
    /// What arrives at the end of the ray.
    pub(super) fn arriving(&mut self, lighting: Lighting<'_>, needs: &Needs, ray: &Ray) -> Rgb {
        if needs.absorption {
            let materials = &lighting.appearance.materials;
            self.medium_tracker.absorb(materials, None, 1.0, ray.direction.length(), &mut self.light);
        }
        self.light
    }

    /// Where on the ray the connection goes on beyond a surface that does nothing to it; `None` if the surface stops it.
    pub(super) fn skip_interface(
        &mut self,
        lighting: Lighting<'_>,
        needs: &Needs,
        ray: &Ray,
        hit: &SurfaceHit,
        counts: &mut ShadingCounts,
    ) -> Option<f64> {
        let materials = &lighting.appearance.materials;
        let context = HitContext::new(needs, materials, ray, hit)?;
        let interface = context.interface(&mut self.medium_tracker.interior, materials, hit);
        if context.is_visible(interface.as_ref()) {
            return None;
        }
        self.medium_tracker.skip_interface(interface.as_ref(), hit, context.length, &mut self.light, counts);
        // The camera would have lost the path here as well.
        (!self.medium_tracker.null_limit_exceeded()).then(|| hit.span_after(ray).min)
    }
}
