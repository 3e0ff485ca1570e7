//! What light paths keep between their surfaces and on the way to the camera.

use crate::{Lighting, Needs, ShadingCounts, SurfaceHit, course::Course, meeting::Meeting};
use rt_math::{DVec2, Ray, Rgb};

/// A path on its way from a light.
#[derive(Clone, Debug)]
pub(super) struct Photon<S> {
    pub(super) sampler: S,
    pub(super) course: Course,
    /// Power at the light.
    pub(super) power: Rgb,
    /// What is left of it.
    pub(super) weight: Rgb,
    /// Surfaces that have scattered it.
    pub(super) bounces: u32,
    /// World units from the light, for light that does not weaken on its way: none once it has been spread.
    pub(super) unweakened_way: Option<f64>,
}

/// Light on its last way, to the camera.
#[derive(Clone, Debug)]
pub(super) struct Connection {
    pub(super) course: Course,
    pub(super) raster: DVec2,
    /// What arrives if nothing is in the way.
    pub(super) light: Rgb,
}

impl Connection {
    /// What arrives at the end of the ray.
    pub(super) fn arriving(&mut self, lighting: Lighting<'_>, needs: &Needs, ray: &Ray) -> Rgb {
        if needs.absorption {
            let materials = &lighting.appearance.materials;
            self.course.absorb(materials, None, 1.0, ray.direction.length(), &mut self.light);
        }
        self.light
    }

    /// Where on the ray the connection goes on beyond a surface that does nothing to it; `None` if the surface stops it.
    pub(super) fn pass(
        &mut self,
        lighting: Lighting<'_>,
        needs: &Needs,
        ray: &Ray,
        hit: &SurfaceHit,
        counts: &mut ShadingCounts,
    ) -> Option<f64> {
        let materials = &lighting.appearance.materials;
        let meeting = Meeting::new(needs, materials, ray, hit)?;
        let crossing = meeting.crossing(&mut self.course.interior, materials, hit);
        if meeting.is_noticed(crossing.as_ref()) {
            return None;
        }
        self.course.pass(crossing.as_ref(), hit, meeting.length, &mut self.light, counts);
        // The camera would have lost the path here as well.
        (!self.course.is_tired()).then(|| hit.beyond(ray).min)
    }
}
