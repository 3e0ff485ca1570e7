//! Next-event estimation: light samples at path vertices, with MIS weights, and their shadow rays.

use super::{inputs::PathInputs, shade::HitPath, wave::SpawnedPaths};
use crate::{
    InteriorList, RadianceSample, bsdf::Scattering, interior_list::MediumInterface, lane_set::Element, medium::Medium,
    medium_tracker::MediumTracker, vertex::Vertex, wavefront::streams::ShadowRayStream,
};
use rt_math::{DVec3, Interval, Ray, Rgb, Sampler};

impl<E: Element> SpawnedPaths<E> {
    /// Samples all delta lights and one area or environment light, and queues their shadow rays.
    pub(super) fn sample_direct_lighting(
        &mut self,
        inputs: &PathInputs<'_>,
        path: &HitPath<'_, E>,
        vertex: &Vertex<'_>,
        sampler: &mut dyn Sampler,
        radiance_sample: &mut RadianceSample,
    ) {
        if vertex.bsdf.is_delta() {
            return;
        }
        let materials = &inputs.lighting.appearance.materials;
        let tracker = &self.states[path.sample as usize].medium_tracker;
        let media = if inputs.materials.has_shadow_media {
            MediaAround::of_interface(tracker, path.interface)
        } else if inputs.features.absorption {
            MediaAround::Uniform(tracker.media(materials, path.interface))
        } else {
            MediaAround::Clear
        };
        self.sample_delta_lights(inputs, path, vertex, &media, radiance_sample);
        self.sample_light(inputs, path, vertex, &media, sampler);
    }

    /// Queues shadow rays to all delta lights, with `media` on both sides of the surface.
    fn sample_delta_lights(
        &mut self,
        inputs: &PathInputs<'_>,
        path: &HitPath<'_, E>,
        vertex: &Vertex<'_>,
        media: &MediaAround,
        radiance_sample: &mut RadianceSample,
    ) {
        let (clamp, bounces) = (inputs.settings.clamp, path.wave.bounces);
        let surface = vertex.view.surface;
        let shadow_rays = surface.shadow_rays(vertex.view.is_inside);
        let mut lights = inputs.lighting.lights.delta_lights();
        for stream in &mut self.delta.streams {
            for light in lights.by_ref().take(self.delta.lights_per_stream) {
                let Some(lit) = light.sample_li(surface.point) else { continue };
                if path.omits_light_from(vertex, lit.direction) {
                    continue;
                }
                let scattered = vertex.eval(lit.direction);
                // Cancels the 1/π of BSDFs for lights in classical units.
                let radiance = path.throughput * scattered * lit.strength * light.units.irradiance_factor();
                if radiance.is_black() {
                    self.counts.shadow_rays_skipped += u64::from(light.casts_shadows);
                } else if light.casts_shadows {
                    let ray = light.shadow_ray(&shadow_rays, &lit, vertex.time);
                    media.push(stream, vertex, (lit.direction, lit.distance), (ray, path.sample, radiance));
                } else {
                    radiance_sample.radiance += clamp.apply(bounces + 1, radiance, &mut self.counts);
                }
            }
        }
    }

    /// Samples one area or environment light, with `media` on both sides of the surface.
    fn sample_light(
        &mut self,
        inputs: &PathInputs<'_>,
        path: &HitPath<'_, E>,
        vertex: &Vertex<'_>,
        media: &MediaAround,
        sampler: &mut dyn Sampler,
    ) {
        let lights = inputs.lighting.lights;
        let surface = vertex.view.surface;
        let shadow_rays = surface.shadow_rays(vertex.view.is_inside);
        let n_sampled = lights.sampled_lights().len();
        if n_sampled == 0 {
            return;
        }
        let u = sampler.next_2d();
        let choice = if n_sampled > 1 { sampler.next_1d() } else { 0.0 };
        let Some(light) = lights.sample_li(surface.point, vertex.normal, choice, u) else {
            self.counts.shadow_rays_skipped += 1;
            return;
        };
        let scattered = vertex.eval_mis(light.sample.direction, light.pdf);
        if scattered.is_black() || path.omits_light_from(vertex, light.sample.direction) {
            self.counts.shadow_rays_skipped += 1;
            return;
        }
        let radiance = path.throughput * scattered * light.sample.radiance / light.pdf;
        let ray = match light.sample.shadow_target() {
            Some(target) => (shadow_rays.to(target, vertex.time), Interval::SEGMENT),
            None => (shadow_rays.towards(light.sample.direction, vertex.time), Interval::SPAWNED),
        };
        let distance = light.sample.point.map_or(f64::INFINITY, |point| (point - surface.point).length());
        let to_light = (light.sample.direction, distance);
        media.push(&mut self.sampled, vertex, to_light, (ray, path.sample, radiance));
    }
}

impl<E: Element> HitPath<'_, E> {
    /// True for a direction behind a surface that light samples of a previous vertex have passed: they have found this light.
    fn omits_light_from(&self, vertex: &Vertex<'_>, direction: DVec3) -> bool {
        self.is_passed_by_light && vertex.view.is_on_side_of(Scattering::Transmission, direction)
    }
}

/// Media on the near and the far side of a vertex, for its shadow rays.
enum MediaAround {
    /// None absorbs.
    Clear,
    /// Shadow rays end at any surface that casts shadows, so that one medium fills their whole length. The end of the medium towards a
    /// light at infinity is unknown: such light is not attenuated.
    Uniform([Medium; 2]),
    /// Shadow rays pass some surfaces. On both sides are the media of the path.
    OfPath,
    /// Shadow rays pass some surfaces. Each side has its media.
    Sides([InteriorList; 2]),
}

impl MediaAround {
    /// Media for shadow rays that pass surfaces.
    fn of_interface(tracker: &MediumTracker, interface: Option<&MediumInterface>) -> Self {
        match interface {
            None => Self::OfPath,
            _ => Self::Sides(
                [Scattering::Reflection, Scattering::Transmission].map(|kind| tracker.side(interface, kind)),
            ),
        }
    }

    /// Queues a shadow ray, which leaves the vertex in a direction to a light at a distance.
    #[inline]
    fn push<E: Element>(
        &self,
        stream: &mut ShadowRayStream<E>,
        vertex: &Vertex<'_>,
        (direction, distance): (DVec3, f64),
        (ray, sample, radiance): ((Ray, Interval), u32, Rgb),
    ) {
        let is_near = || vertex.view.is_on_side_of(Scattering::Reflection, direction);
        match self {
            Self::Uniform([near, far]) if distance.is_finite() => {
                let medium = if is_near() { near } else { far };
                stream.push_ray(ray, sample, radiance * medium.transmittance(distance));
            }
            Self::Clear | Self::Uniform(_) | Self::OfPath => stream.push_ray(ray, sample, radiance),
            Self::Sides([near, far]) => {
                stream.push_ray(ray, sample, radiance);
                stream.start_in(if is_near() { near } else { far }.clone());
            }
        }
    }
}
