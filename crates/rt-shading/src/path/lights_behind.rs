//! Lights behind objects that cast no shadow.
//!
//! Light samples pass such an object, weighted against the density with which the BSDF samples their direction. A direction that the BSDF
//! has sampled ends at the object. So its light is looked up behind the object, and the weights of both techniques sum to 1.

use super::{
    inputs::PathInputs,
    path_stream::{LightBehind, PrevVertex},
    settings::Lighting,
    wave::SpawnedPaths,
};
use crate::{
    RadianceSample, StreamQueries, SurfaceHit,
    lane_set::Element,
    mis::{PDF_OF_WEIGHT_ONE, power_heuristic},
    shadow_media::ShadowMedia,
    viewed_surface::is_inside,
};
use rt_geometry::{HitStream, RayKind, RayStream, STREAM_CAPACITY};
use rt_math::{DVec3, Ray, Rgb};

impl<E: Element> SpawnedPaths<E> {
    /// Notes the ray of a path behind its hit, unless light sampling does not compete for its direction.
    pub(super) fn look_behind(
        &mut self,
        ray: &Ray,
        hit: &SurfaceHit,
        (sample, throughput): (u32, Rgb),
        from: PrevVertex,
    ) {
        if from.pdf > 0.0 && from.pdf < PDF_OF_WEIGHT_ONE {
            let span = hit.span_after(ray);
            let media = ShadowMedia::of_path(&self.states[sample as usize].medium_tracker, hit.t);
            self.behind.push(LightBehind { ray: *ray, span, sample, throughput, from, object: hit.object, media });
        }
    }

    /// Adds the light of sampled lights on these rays, up to the next object that ends shadow rays.
    pub(super) fn add_lights_behind(
        &mut self,
        inputs: &PathInputs<'_>,
        world: &mut dyn StreamQueries,
        bounces: u32,
        radiances: &mut [RadianceSample],
    ) {
        if self.behind.is_empty() {
            return;
        }
        let (mut rays, mut hits) = (RayStream::default(), HitStream::default());
        while !self.behind.is_empty() {
            for waiting in core::mem::take(&mut self.behind).chunks_mut(STREAM_CAPACITY) {
                rays.clear();
                waiting.iter().for_each(|behind| rays.push(&behind.ray, behind.span));
                world.closest_stream(&rays, RayKind::Shadow, &mut hits);
                for (at, behind) in waiting.iter_mut().enumerate() {
                    let hit = world.surface(&behind.ray, &hits, at, inputs.features.surface());
                    let LightBehind { ray, span, throughput, from, object, media, .. } = behind;
                    let emitted = from.light_behind(&inputs.lighting, ray.direction, *object, hit.as_ref());
                    if !emitted.is_black() {
                        let t = hit.as_ref().map_or(f64::INFINITY, |hit| hit.t);
                        let radiance = *throughput * media.transmittance_to(inputs.scene().1, ray, t) * emitted;
                        radiances[behind.sample as usize].radiance +=
                            inputs.settings.clamp.apply(bounces, radiance, &mut self.counts);
                    }
                    let behind_hit = hit.filter(|hit| !hit.casts_shadow);
                    let rest =
                        behind_hit.and_then(|hit| media.pass(inputs.scene(), (ray, *span), &hit, &mut self.counts));
                    if let Some(rest) = rest {
                        *span = rest;
                        self.behind.push(behind.clone());
                    }
                }
            }
        }
    }
}

impl PrevVertex {
    /// Radiance of a sampled light at a hit behind an object, or of the environment, with its MIS weight. The object's own light is not
    /// behind it.
    pub(crate) fn light_behind(
        &self,
        lighting: &Lighting<'_>,
        direction: DVec3,
        object: u32,
        hit: Option<&SurfaceHit>,
    ) -> Rgb {
        let Lighting { appearance, lights, .. } = lighting;
        let (emitted, light_pdf) = match hit {
            None => {
                let light_pdf = lights.pdf_li_environment(self.point, self.normal, direction);
                (appearance.background.radiance(direction), light_pdf)
            }
            Some(hit) => {
                let material = appearance.materials.get(hit.material as usize);
                let (Some(light), Some(material)) = (hit.light.filter(|_| hit.object != object), material) else {
                    return Rgb::BLACK;
                };
                let surface = &hit.interaction;
                let (on_light, light_normal) = (surface.point, surface.geometric_normal);
                let light_pdf = lights.pdf_li(self.point, self.normal, light, on_light, light_normal);
                let is_inside = is_inside(direction, surface);
                (material.emitted_radiance(&appearance.textures, surface, is_inside), light_pdf)
            }
        };
        if light_pdf > 0.0 { emitted * power_heuristic(self.pdf, light_pdf) } else { Rgb::BLACK }
    }
}
