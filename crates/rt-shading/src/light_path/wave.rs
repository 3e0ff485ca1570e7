//! What light paths keep between their surfaces, and the rays that are traced together.

use super::Course;
use crate::{
    Lighting, Needs, ShadingCounts, SurfaceHit,
    interior::{Crossing, absorb},
    meeting::{FREE_PASSAGES, Meeting},
    view::is_inside,
};
use rt_math::{DVec2, Ray, RayKind, Rgb};

pub(super) use crate::path::wave::Queue;

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
            let medium = self.course.interior.medium(&lighting.appearance.materials);
            absorb(&mut self.light, medium.absorption, (1.0 - self.course.medium_start) * ray.direction.length());
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
        let phong = &materials.get(hit.material as usize)?.phong;
        if !needs.refraction || phong.transmission.is_none() {
            return None;
        }
        let inside = is_inside(ray.direction, &hit.interaction);
        match Meeting::with_body(&mut self.course.interior, materials, phong, hit, inside) {
            Meeting::Nothing(crossing) => {
                let length = ray.direction.length();
                self.course.pass(crossing.as_ref(), hit, length, &mut self.light, counts);
                // The camera would have lost the path here as well.
                (self.course.passages <= FREE_PASSAGES).then(|| hit.beyond(ray).min)
            }
            _ => None,
        }
    }
}

impl Course {
    /// Goes through a surface that does nothing to the ray, whose direction has this length, and takes off what the medium before
    /// it has absorbed.
    pub(super) fn pass(
        &mut self,
        crossing: Option<&Crossing>,
        hit: &SurfaceHit,
        length: f64,
        light: &mut Rgb,
        counts: &mut ShadingCounts,
    ) {
        if let Some(crossing) = crossing {
            if crossing.before.absorption != crossing.after.absorption {
                absorb(light, crossing.before.absorption, (hit.t - self.medium_start) * length);
                self.medium_start = hit.t;
            }
            self.interior.cross(crossing);
        } else {
            counts.interior_overflows += 1;
        }
        counts.passages += 1;
        self.passages += 1;
    }
}

/// The rays of all paths, by kind: each path has one. Connections are traced after them.
#[derive(Clone, Debug, Default)]
pub(super) struct Flow {
    pub(super) reflected: Queue,
    pub(super) refracted: Queue,
    pub(super) diffuse: Queue,
    pub(super) connections: Queue,
}

impl Flow {
    pub(super) fn queues(&self) -> [(RayKind, &Queue); 3] {
        [
            (RayKind::Reflection, &self.reflected),
            (RayKind::Refraction, &self.refracted),
            (RayKind::Diffuse, &self.diffuse),
        ]
    }

    pub(super) fn is_empty(&self) -> bool {
        self.queues().iter().all(|(_, queue)| queue.rays.is_empty())
    }

    pub(super) fn clear(&mut self) {
        for queue in [&mut self.reflected, &mut self.refracted, &mut self.diffuse, &mut self.connections] {
            queue.clear();
        }
    }
}
