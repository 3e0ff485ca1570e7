//! Next-event estimation: light samples at path vertices, with MIS weights, and their shadow rays.

use super::{Lighting, PathTracer};
use crate::{RadianceSample, bsdf::Scattering, interior_list::MediumInterface, medium::Medium, vertex::Vertex};
use rt_math::{DVec3, Interval, Rgb, Sampler};

impl<S: Sampler + Clone> PathTracer<S> {
    /// Samples all delta lights and one area or environment light, and queues their shadow rays.
    pub(super) fn sample_direct_lighting(
        &mut self,
        lighting: Lighting<'_>,
        id: u32,
        vertex: &Vertex<'_>,
        interface: Option<&MediumInterface>,
        seen: &mut RadianceSample,
    ) {
        if vertex.bsdf.is_delta() {
            return;
        }
        let path = &self.paths[id as usize];
        let media =
            self.features.absorption.then(|| path.medium_tracker.media(&lighting.appearance.materials, interface));
        self.sample_delta_lights(lighting, id, vertex, media, seen);
        self.sample_light(lighting, id, vertex, media);
    }

    /// Queues shadow rays to all delta lights, with `media` on both sides of the surface.
    fn sample_delta_lights(
        &mut self,
        lighting: Lighting<'_>,
        id: u32,
        vertex: &Vertex<'_>,
        media: Option<[Medium; 2]>,
        seen: &mut RadianceSample,
    ) {
        let clamp = self.settings.clamp;
        let path = &self.paths[id as usize];
        let is_clamped = clamp.applies_after(path.bounces + 1);
        let surface = vertex.view.surface;
        let shadow_rays = surface.shadow_rays(vertex.view.is_inside);
        for light in lighting.lights.delta_lights() {
            let Some(lit) = light.sample_li(surface.point) else { continue };
            let scattered = vertex.eval(lit.direction);
            // Cancels the 1/π of BSDFs for lights in classical units.
            let radiance = path.throughput * scattered * lit.strength * light.units.irradiance_factor();
            if radiance.is_black() {
                self.counts.shadow_rays_skipped += u64::from(light.casts_shadows);
            } else if light.casts_shadows {
                let radiance = attenuated(radiance, vertex, media, (lit.direction, lit.distance));
                self.shadows.push(light.shadow_ray(&shadow_rays, &lit, vertex.time), id, radiance, is_clamped);
            } else {
                seen.radiance += clamp.apply(path.bounces + 1, radiance, &mut self.counts);
            }
        }
    }

    /// Samples one area or environment light, with `media` on both sides of the surface.
    fn sample_light(&mut self, lighting: Lighting<'_>, id: u32, vertex: &Vertex<'_>, media: Option<[Medium; 2]>) {
        let path = &self.paths[id as usize];
        let is_clamped = self.settings.clamp.applies_after(path.bounces + 1);
        let surface = vertex.view.surface;
        let shadow_rays = surface.shadow_rays(vertex.view.is_inside);
        let n_sampled = lighting.lights.sampled_lights().len();
        if n_sampled == 0 {
            return;
        }
        let sampler = &mut self.samplers[id as usize];
        let u = sampler.next_2d();
        let choice = if n_sampled > 1 { sampler.next_1d() } else { 0.0 };
        let Some(light) = lighting.lights.sample_li(surface.point, vertex.normal, choice, u) else {
            self.counts.shadow_rays_skipped += 1;
            return;
        };
        let scattered = vertex.eval_mis(light.sample.direction, light.pdf);
        if scattered.is_black() {
            self.counts.shadow_rays_skipped += 1;
            return;
        }
        let radiance = path.throughput * scattered * light.sample.radiance / light.pdf;
        let ray = match light.sample.shadow_target() {
            Some(target) => (shadow_rays.to(target, vertex.time), Interval::SEGMENT),
            None => (shadow_rays.towards(light.sample.direction, vertex.time), Interval::SPAWNED),
        };
        let distance = light.sample.point.map_or(f64::INFINITY, |point| (point - surface.point).length());
        let radiance = attenuated(radiance, vertex, media, (light.sample.direction, distance));
        self.shadows.push(ray, id, radiance, is_clamped);
    }
}

/// Light from a direction, attenuated by the medium on that side of a vertex; `media` are those of both sides.
///
/// Shadow rays end at any surface that casts shadows, so that one medium fills their whole length. The end of the medium towards a
/// light at infinity is unknown: such light is not attenuated.
#[inline]
fn attenuated(
    radiance: Rgb,
    vertex: &Vertex<'_>,
    media: Option<[Medium; 2]>,
    (direction, distance): (DVec3, f64),
) -> Rgb {
    match media {
        Some([near, far]) if distance.is_finite() => {
            let is_near = vertex.view.is_on_side_of(Scattering::Reflection, direction);
            radiance * (if is_near { near } else { far }).transmittance(distance)
        }
        _ => radiance,
    }
}
