//! Reference path integrator: the first file to read.
//!
//! [`ReferencePathTracer::li`] follows one path from vertex to vertex, in scalar `f64`. It is written for reading, in the order of
//! `PathIntegrator::Li` of pbrt (Pharr, Jakob, Humphreys, PBR 4th ed., 13.4). The steps of each vertex:
//!
//! ```text
//!   camera ────● x₁ ─ ─ ─ ─ □ light      1. find the closest surface x; on a miss add the environment, and end
//!               ╲                        2. add the emission of x, with its MIS weight
//!                ● x₂ ─ ─ ─ □            3. sample lights, and add those that x sees, with the other MIS weight
//!                 ╲                      4. sample the next direction by the BSDF
//!                  ● x₃                  5. end the path by Russian roulette
//! ```
//!
//! [`PathTracer`](crate::PathTracer) takes the same steps for many paths at a time. In `f64` ([`PathTracer::in_f64`](crate::PathTracer::in_f64))
//! both return the same radiance to 10⁻⁹, as tests verify. This file evaluates every feature ([`ShadingFeatures::ALL`]) and computes each
//! BSDF at the hit. It thus also verifies that features left out of a plan, and cached BSDFs, change nothing.
//!
//! Read next: `mis.rs` (weights), `bsdf/mod.rs` (BSDFs), `light/light_set.rs` (lights), `vertex.rs`, `hit_context.rs` (sides and
//! media of a surface), and then the waves: `path.rs`, `path/shade.rs`.

use crate::{
    Appearance, InteriorList, Lighting, PathSettings, RadianceSample, SceneQueries, ShadingCounts, ShadingFeatures,
    SurfaceHit, Transport,
    bsdf::Scattering,
    hit_context::HitContext,
    interior_list::MediumInterface,
    medium_tracker::MediumTracker,
    mis::{PDF_OF_WEIGHT_ONE, pdf_behind, power_heuristic},
    path::PrevVertex,
    ray_kind::kind_of,
    russian_roulette::russian_roulette,
    shadow_media::ShadowMedia,
    vertex::{Vertex, bsdf_at},
    viewed_surface::ViewedSurface,
};
use rt_geometry::{RayKind, SurfaceInteraction};
use rt_math::{DVec3, Interval, Ray, Rgb, Sampler};

/// Path integrator for one path at a time: reference for [`PathTracer`](crate::PathTracer), without batches of rays.
///
/// It implements [`Transport::Full`] and [`Transport::NonCaustic`]. [`Transport::Specular`], of distribution ray tracing, is rendered as
/// `Full`.
#[derive(Clone, Debug)]
pub struct ReferencePathTracer<'a> {
    /// Depth, Russian roulette and clamping.
    pub settings: PathSettings,
    /// Materials and lights. The cache of BSDFs is ignored.
    pub lighting: Lighting<'a>,
    /// Media around the camera; `default()` for air.
    pub camera_media: InteriorList,
    /// Null interfaces, ignored dielectrics and clamped light of all paths so far. Other counts stay as they are.
    pub counts: ShadingCounts,
}

/// State of a path between two vertices.
struct PathState {
    /// Radiance so far.
    radiance_sample: RadianceSample,
    /// Throughput (β): factor of further radiance.
    throughput: Rgb,
    /// Accumulated η² of refraction, which Russian roulette excludes from the throughput (pbrt's `etaScale`).
    eta_scale: f64,
    /// Surfaces that have scattered the path.
    bounces: u32,
    /// True until the first of these surfaces has sampled a non-delta lobe.
    starts_specular: bool,
    /// Media that the path is inside of.
    media: MediumTracker,
    /// Previous vertex; `None` for the camera and for delta lobes, whose directions light sampling cannot find.
    prev: Option<PrevVertex>,
    /// True if the light samples of a previous vertex have passed all objects since then: their lights are not added again.
    omits_sampled_lights: bool,
}

impl ReferencePathTracer<'_> {
    /// Estimates the radiance along a camera ray, whose direction need not be of unit length. Non-finite scenes give non-finite radiance.
    pub fn li(&mut self, world: &mut dyn SceneQueries, ray: &Ray, sampler: &mut dyn Sampler) -> RadianceSample {
        let Lighting { appearance, lights, .. } = self.lighting;
        let PathSettings { max_depth, rr_start_depth, transport, .. } = self.settings;
        let materials = &appearance.materials;
        let mut path = PathState::new(&self.camera_media);
        let (mut ray, mut span, mut kind) = (*ray, Interval::FORWARD, RayKind::Primary);
        loop {
            // Find the closest surface. On a miss, add the radiance of the environment.
            let Some(mut hit) = world.closest(&ray, span, kind, ShadingFeatures::ALL.surface()) else {
                if path.omits_sampled_lights && lights.environment().is_some() {
                    return path.radiance_sample;
                }
                let direction = ray.direction;
                let weight = path.mis_weight(|from| lights.pdf_li_environment(from.point, from.normal, direction));
                let radiance = path.throughput * weight * appearance.background.radiance(direction);
                self.add(radiance, path.bounces, &mut path);
                return path.radiance_sample;
            };
            let Some(context) = HitContext::new(&ShadingFeatures::ALL, materials, &ray, &hit) else {
                path.radiance_sample.hit = true;
                return path.radiance_sample;
            };
            let HitContext { material, direction, length, is_inside, .. } = context;

            // Pass a null interface: the same ray goes on behind it.
            let interface = context.interface(&mut path.media.interior, materials, hit.medium_entry());
            let interface = interface.as_ref();
            if !context.is_visible(interface) {
                let is_dimmed =
                    path.media.skip_interface(interface, &hit, length, &mut path.throughput, &mut self.counts);
                path.radiance_sample.hit |= is_dimmed;
                path.omits_sampled_lights &= !hit.casts_shadow;
                if path.media.null_limit_exceeded() && path.bounces + path.media.null_interface_bounces() > max_depth {
                    return path.radiance_sample;
                }
                if let Some(prev) = &mut path.prev {
                    prev.pdf = pdf_behind(&hit, prev.pdf);
                }
                (span, kind) = (hit.span_after(&ray), RayKind::Refraction);
                continue;
            }
            path.radiance_sample.hit = true;

            // Apply the absorption of the medium before the surface.
            path.media.absorb(materials, interface, hit.t, length, &mut path.throughput);

            // Add the emission of the surface. That of caustics may be left to light tracing.
            let textures = &appearance.textures;
            let emitted = material.emitted_radiance_towards(-direction, textures, &hit.interaction, is_inside);
            let is_caustic = hit.light.is_some() && !path.starts_specular && path.prev.is_none();
            let is_omitted =
                is_caustic && transport == Transport::NonCaustic || hit.light.is_some() && path.omits_sampled_lights;
            if !emitted.is_black() && !is_omitted {
                let SurfaceInteraction { point, geometric_normal, .. } = hit.interaction;
                let light_pdf =
                    |from: &PrevVertex, light| lights.pdf_li(from.point, from.normal, light, point, geometric_normal);
                let weight = path.mis_weight(|from| hit.light.map_or(0.0, |light| light_pdf(from, light)));
                self.add(path.throughput * emitted * weight, path.bounces, &mut path);
            }
            // Light samples pass objects that cast no shadow, so that the light behind them is looked up for sampled directions. The light
            // that glass transmits is then left out.
            let is_passed_by_shadow_rays = context.is_passed_by_shadow_rays(&hit);
            if is_passed_by_shadow_rays && lights.is_seen_through_objects && !path.omits_sampled_lights {
                self.add_lights_behind(world, &ray, &hit, &mut path);
            }
            let is_passed = path.omits_sampled_lights || path.prev.is_some();
            let is_passed_by_light = is_passed && is_passed_by_shadow_rays && context.transmits_light();
            if path.bounces > max_depth {
                return path.radiance_sample;
            }

            // Sample lights.
            let view = ViewedSurface::new(direction, is_inside, &mut hit.interaction);
            let bsdf = bsdf_at(appearance, material, &view, interface);
            let vertex = Vertex::new(view, &bsdf, ray.time);
            let at = LitVertex { vertex: &vertex, interface, is_passed_by_light };
            self.sample_direct_lighting(world, &at, sampler, &mut path);

            // Sample the next direction by the BSDF.
            let [u, v] = sampler.next_2d();
            let component = if bsdf.uses_component_sample() { sampler.next_1d() } else { 0.0 };
            let Some(sample) = bsdf.sample_along(vertex.wo, [component, u, v], path.throughput) else {
                return path.radiance_sample;
            };
            let Some(wi) = vertex.continued(&sample, path.starts_specular) else { return path.radiance_sample };
            path.throughput *= sample.weight();
            path.eta_scale *= sample.eta * sample.eta;
            path.starts_specular = if path.bounces == 0 { sample.is_delta } else { path.starts_specular };
            path.bounces += 1;
            let (point, normal) = (vertex.view.surface.point, vertex.normal);
            path.prev = (!sample.is_delta).then_some(PrevVertex { point, normal, pdf: sample.pdf });
            path.omits_sampled_lights = is_passed_by_light && sample.kind == Scattering::Transmission;
            if path.throughput.is_black() {
                return path.radiance_sample;
            }

            // Russian roulette: end most paths of little throughput, and raise that of the others.
            let is_old = path.bounces > rr_start_depth;
            if is_old && !russian_roulette(&mut path.throughput, path.eta_scale, sampler) {
                return path.radiance_sample;
            }
            path.media.scatter(interface, sample.kind);
            let next = vertex.view.surface.spawn_ray(wi, ray.time);
            (ray, span, kind) = (next, Interval::SPAWNED, kind_of(Some(&sample)));
        }
    }

    /// Next-event estimation: adds the light of all delta lights, and of one area or environment light.
    fn sample_direct_lighting(
        &mut self,
        world: &mut dyn SceneQueries,
        at: &LitVertex<'_>,
        sampler: &mut dyn Sampler,
        path: &mut PathState,
    ) {
        let vertex = at.vertex;
        if vertex.bsdf.is_delta() {
            return;
        }
        let lights = self.lighting.lights;
        let (surface, time) = (vertex.view.surface, vertex.time);
        let shadow_rays = surface.shadow_rays(vertex.view.is_inside);

        // Add all delta lights. BSDF samples cannot hit them: their MIS weight is 1. Those without shadows come first, as the
        // order of a sum determines its last bit.
        for casts_shadows in [false, true] {
            for light in lights.delta_lights().filter(|light| light.casts_shadows == casts_shadows) {
                let Some(lit) = light.sample_li(surface.point) else { continue };
                if at.omits_light_from(lit.direction) {
                    continue;
                }
                let scattered = vertex.eval(lit.direction);
                let radiance = path.throughput * scattered * lit.strength * light.units.irradiance_factor();
                if radiance.is_black() {
                    continue;
                }
                let shadow_ray = light.shadow_ray(&shadow_rays, &lit, time);
                let media = casts_shadows.then(|| path.shadow_media(at, lit.direction));
                let transmittance = media.map_or(Rgb::WHITE, |media| self.transmittance(world, shadow_ray, media));
                self.add(radiance * transmittance, path.bounces + 1, path);
            }
        }

        // Add one area or environment light, with its MIS weight.
        let n_sampled = lights.sampled_lights().len();
        if n_sampled == 0 {
            return;
        }
        let u = sampler.next_2d();
        let choice = if n_sampled > 1 { sampler.next_1d() } else { 0.0 };
        let Some(light) = lights.sample_li(surface.point, vertex.normal, choice, u) else { return };
        let wi = light.sample.direction;
        if at.omits_light_from(wi) {
            return;
        }
        let Some(local) = vertex.local(wi) else { return };
        let (f, bsdf_pdf) = vertex.bsdf.eval_with_pdf(vertex.wo, local);
        if f.is_black() {
            return;
        }
        let scattered = f * power_heuristic(light.pdf, bsdf_pdf) * local.z.abs();
        let radiance = path.throughput * scattered * light.sample.radiance / light.pdf;
        let shadow_ray = match light.sample.shadow_target() {
            Some(target) => (shadow_rays.to(target, time), Interval::SEGMENT),
            None => (shadow_rays.towards(wi, time), Interval::SPAWNED),
        };
        let media = path.shadow_media(at, wi);
        let transmittance = self.transmittance(world, shadow_ray, media);
        self.add(radiance * transmittance, path.bounces + 1, path);
    }

    /// Part of the light that arrives along a shadow ray, which starts in these media: 0 if something occludes it.
    fn transmittance(&mut self, world: &mut dyn SceneQueries, (ray, span): (Ray, Interval), media: ShadowMedia) -> Rgb {
        let Appearance { materials, .. } = self.lighting.appearance;
        if world.occluded(&ray, span) {
            Rgb::BLACK
        } else if self.lighting.appearance.has_shadow_media(&ShadingFeatures::ALL) {
            media.follow(world, (&ShadingFeatures::ALL, materials), (&ray, span), &mut self.counts)
        } else {
            // One medium fills the whole ray.
            media.transmittance_to(materials, &ray, ShadowMedia::span(span).max)
        }
    }

    /// Adds the light of sampled lights behind a hit, up to the next object that casts a shadow.
    fn add_lights_behind(&mut self, world: &mut dyn SceneQueries, ray: &Ray, hit: &SurfaceHit, path: &mut PathState) {
        let Some(from) = path.prev else { return };
        let features = &ShadingFeatures::ALL;
        let materials = &self.lighting.appearance.materials;
        let mut media = ShadowMedia::of_path(&path.media, hit.t);
        let (mut rest, mut radiance) = (Some(hit.span_after(ray)), Rgb::BLACK);
        while let Some(span) = rest.filter(|_| from.pdf < PDF_OF_WEIGHT_ONE) {
            let behind = world.closest(ray, span, RayKind::Shadow, features.surface());
            let t = behind.as_ref().map_or(f64::INFINITY, |hit| hit.t);
            let emitted = from.light_behind(&self.lighting, ray.direction, hit.object, behind.as_ref());
            radiance += emitted * media.transmittance_to(materials, ray, t);
            let passed = behind.filter(|hit| !hit.casts_shadow);
            rest = passed.and_then(|hit| media.pass((features, materials), (ray, span), &hit, &mut self.counts));
        }
        self.add(path.throughput * radiance, path.bounces, path);
    }

    /// Adds radiance that this many surfaces have scattered, clamped if it is indirect.
    fn add(&mut self, radiance: Rgb, scattered: u32, path: &mut PathState) {
        let clamp = self.settings.clamp;
        path.radiance_sample.radiance += clamp.apply(scattered, radiance, &mut self.counts);
    }
}

/// Vertex at which lights are sampled.
struct LitVertex<'a> {
    vertex: &'a Vertex<'a>,
    /// Media on both sides of a surface that transmits light.
    interface: Option<&'a MediumInterface>,
    /// True if light samples of a previous vertex have passed the surface, which transmits light and casts no shadow.
    is_passed_by_light: bool,
}

impl LitVertex<'_> {
    /// True for a direction behind the surface, if light samples of a previous vertex have passed it: they have found this light.
    fn omits_light_from(&self, wi: DVec3) -> bool {
        self.is_passed_by_light && self.vertex.view.is_on_side_of(Scattering::Transmission, wi)
    }
}

impl PathState {
    /// Path that starts at the camera, in these media.
    fn new(camera_media: &InteriorList) -> Self {
        let mut media = MediumTracker::default();
        media.restart(camera_media);
        let (radiance_sample, throughput) = (RadianceSample::MISS, Rgb::WHITE);
        Self {
            radiance_sample,
            throughput,
            eta_scale: 1.0,
            bounces: 0,
            starts_specular: true,
            media,
            prev: None,
            omits_sampled_lights: false,
        }
    }

    /// Media of a shadow ray in this direction from a vertex.
    fn shadow_media(&self, at: &LitVertex<'_>, wi: DVec3) -> ShadowMedia {
        let is_near = at.vertex.view.is_on_side_of(Scattering::Reflection, wi);
        let kind = if is_near { Scattering::Reflection } else { Scattering::Transmission };
        ShadowMedia::new(self.media.side(at.interface, kind))
    }

    /// MIS weight of light that the ray in the direction of the BSDF sample has found.
    ///
    /// `light_pdf` is the density of this direction by light sampling; 0 if light sampling cannot find the light.
    fn mis_weight(&self, light_pdf: impl FnOnce(&PrevVertex) -> f64) -> f64 {
        self.prev.as_ref().map_or(1.0, |from| power_heuristic(from.pdf, light_pdf(from)))
    }
}
