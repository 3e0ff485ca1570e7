//! Shading of hits one by one: emission with its MIS weight, and BSDF sampling.

use super::{
    gathered::HitGroups,
    inputs::PathInputs,
    path_stream::{PathRecord, PrevVertex},
    transport::Transport,
    wave::{PathWave, SpawnedPaths},
};
use crate::{
    RadianceSample, SurfaceHit,
    bsdf::Scattering,
    hit_context::HitContext,
    interior_list::MediumInterface,
    lane_set::Element,
    light::LightId,
    mis::{pdf_behind, power_heuristic},
    russian_roulette::russian_roulette,
    vertex::{Vertex, bsdf_at},
    viewed_surface::ViewedSurface,
};
use rt_math::{DVec3, Rgb, Sampler};

/// A path at a hit that is shaded by itself.
pub(super) struct HitPath<'a, E: Element> {
    pub(super) wave: &'a PathWave<'a, E>,
    /// Index of the ray.
    pub(super) at: usize,
    /// Index of the camera ray.
    pub(super) sample: u32,
    /// Throughput, after absorption.
    pub(super) throughput: Rgb,
    /// Media on both sides of a surface that transmits light.
    pub(super) interface: Option<&'a MediumInterface>,
    /// True if light samples of a previous vertex have passed the surface, which transmits light and casts no shadow. Light that it
    /// transmits is left out.
    pub(super) is_passed_by_light: bool,
}

impl<E: Element> SpawnedPaths<E> {
    /// Adds emission at the hit of a ray, samples direct light there, and samples the next ray of the path. For a surface that can be
    /// shaded in lanes, only the emission is added, and the surface is pushed; returns true for it.
    pub(super) fn shade_hit(
        &mut self,
        inputs: &PathInputs<'_>,
        (wave, at): (&PathWave<'_, E>, usize),
        hit: &mut SurfaceHit,
        (groups, sampler): (&mut HitGroups, &mut dyn Sampler),
        radiance_sample: &mut RadianceSample,
    ) -> bool {
        let &PathInputs { settings, features, lighting, .. } = inputs;
        let materials = &lighting.appearance.materials;
        let (ray, _) = wave.paths.rays.get(at);
        let Some(context) = HitContext::new(features, materials, &ray, hit) else {
            radiance_sample.hit = true;
            return false;
        };
        let sample = wave.paths.sample.get(at);
        let state = &mut self.states[sample as usize];
        let interface = context.interface(&mut state.medium_tracker.interior, materials, hit.medium_entry());
        let interface = interface.as_ref();
        let HitContext { material, direction, length, is_inside, .. } = context;
        let is_passed = state.omits_sampled_lights || wave.paths.pdf.get(at).into() > 0.0;
        let is_passed_by_light = is_passed && context.transmits_light() && context.is_passed_by_shadow_rays(hit);
        let throughput = wave.paths.throughput(at);
        let mut path = HitPath { wave, at, sample, throughput, interface, is_passed_by_light };
        if !context.is_visible(interface) {
            self.skip_interface(inputs, path, hit, length, radiance_sample);
            return false;
        }
        radiance_sample.hit = true;
        let was_absorbed = features.absorption && state.medium_tracker.absorbs(materials);
        if features.absorption {
            state.medium_tracker.absorb(materials, interface, hit.t, length, &mut path.throughput);
        }
        if features.emission {
            let textures = &lighting.appearance.textures;
            let emitted = material.emitted_radiance_towards(-direction, textures, &hit.interaction, is_inside);
            let is_omitted = hit.light.is_some() && self.states[sample as usize].omits_sampled_lights;
            if !emitted.is_black() && !is_omitted && !self.is_caustic(inputs, wave, at, hit.light.is_some()) {
                let surface = &hit.interaction;
                let (point, normal) = (surface.point, surface.geometric_normal);
                let weight = self.mis_weight_area(inputs, wave, at, hit.light, (point, normal));
                let radiance = path.throughput * emitted * weight;
                radiance_sample.radiance += settings.clamp.apply(wave.bounces, radiance, &mut self.counts);
            }
        }
        let state = &self.states[sample as usize];
        let is_seen_through = lighting.lights.is_seen_through_objects && !state.omits_sampled_lights;
        if is_seen_through && context.is_passed_by_shadow_rays(hit) {
            let from = wave.paths.prev_vertex(at, state);
            self.look_behind(&ray, hit, (sample, path.throughput), from);
        }
        if wave.bounces > settings.max_depth || self.states[sample as usize].emission_only {
            return false;
        }
        let shading_normal = hit.interaction.shading_normal;
        let view = ViewedSurface::new(direction, is_inside, &mut hit.interaction);
        let cached = lighting.bsdfs.get(hit.material);
        // A BSDF is large: one that is computed here is not moved.
        let (computed, surface, specular);
        let (bsdf, in_lanes) = match cached {
            Some(cached) => (&cached.bsdf, &cached.in_lanes),
            None => {
                computed = bsdf_at(lighting.appearance, material, &view, interface);
                surface = computed.as_lane_surface();
                (&computed, &surface)
            }
        };
        if inputs.has_ambient_light(bsdf.is_diffuse_below_layer()) {
            let ambient = material.ambient(&material.to_phong(), &lighting.appearance.textures, view.surface);
            self.add_ambient(inputs, wave.bounces, path.throughput * ambient, radiance_sample);
        }
        if let Some(surface) = in_lanes
            && inputs.materials.has_lanes
            && interface.is_none()
            && !was_absorbed
        {
            hit.interaction.shading_normal = shading_normal;
            self.states[sample as usize].omits_sampled_lights = false;
            groups.push_surface(&hit.interaction, surface);
            return true;
        }
        let vertex = Vertex::new(view, bsdf, ray.time);
        let vertex = match cached {
            _ if !inputs.follows_specular_only() => vertex,
            Some(cached) => vertex.with_sampled_lobes(cached.without_diffuse.as_ref()),
            None => {
                specular = bsdf.without_diffuse();
                vertex.with_sampled_lobes(specular.as_ref())
            }
        };
        self.sample_direct_lighting(inputs, &path, &vertex, sampler, radiance_sample);
        self.sample_bsdf(inputs, &path, &vertex, sampler);
        false
    }

    /// True for the emission of a light that [`LightTracingIntegrator`](crate::LightTracingIntegrator) computes: the last bounce was
    /// specular, and the first was not.
    pub(super) fn is_caustic(
        &self,
        inputs: &PathInputs<'_>,
        wave: &PathWave<'_, E>,
        at: usize,
        is_sampled_light: bool,
    ) -> bool {
        let state = &self.states[wave.paths.sample.get(at) as usize];
        let is_delta = wave.paths.pdf.get(at).into() == 0.0;
        let is_omitted = inputs.settings.transport == Transport::NonCaustic && is_sampled_light;
        is_omitted && state.first_bounce_nonspecular && is_delta
    }

    /// MIS weight of the emission of a surface that a BSDF sample has hit, at a point with its unit normal on the outside.
    pub(super) fn mis_weight_area(
        &self,
        inputs: &PathInputs<'_>,
        wave: &PathWave<'_, E>,
        at: usize,
        light: Option<LightId>,
        (on_light, light_normal): (DVec3, DVec3),
    ) -> f64 {
        let PrevVertex { point, normal, pdf } =
            wave.paths.prev_vertex(at, &self.states[wave.paths.sample.get(at) as usize]);
        let Some(light) = light.filter(|_| pdf > 0.0) else { return 1.0 };
        power_heuristic(pdf, inputs.lighting.lights.pdf_li(point, normal, light, on_light, light_normal))
    }

    /// Continues the same ray behind a null interface.
    pub(super) fn skip_interface(
        &mut self,
        inputs: &PathInputs<'_>,
        path: HitPath<'_, E>,
        hit: &SurfaceHit,
        length: f64,
        radiance_sample: &mut RadianceSample,
    ) {
        let HitPath { wave, at, sample, mut throughput, interface, .. } = path;
        let state = &mut self.states[sample as usize];
        state.omits_sampled_lights &= !hit.casts_shadow;
        let tracker = &mut state.medium_tracker;
        radiance_sample.hit |= tracker.skip_interface(interface, hit, length, &mut throughput, &mut self.counts);
        let bounces = wave.bounces + tracker.null_interface_bounces();
        if bounces > inputs.settings.max_depth.saturating_add(u32::from(state.emission_only)) {
            self.counts.depth_limited += 1;
            return;
        }
        let (ray, _) = wave.paths.rays.get(at);
        let record = wave.paths.get(at);
        let pdf = pdf_behind(hit, record.pdf);
        self.null_interface_paths.push(&ray, hit.span_after(&ray), &PathRecord { throughput, pdf, ..record });
    }

    /// Samples the next direction of the path.
    fn sample_bsdf(
        &mut self,
        inputs: &PathInputs<'_>,
        path: &HitPath<'_, E>,
        vertex: &Vertex<'_>,
        sampler: &mut dyn Sampler,
    ) {
        let settings = inputs.settings;
        let bounces = path.wave.bounces;
        let state = &mut self.states[path.sample as usize];
        let Some(bsdf) = vertex.sampled_lobes() else { return };
        let [u, v] = sampler.next_2d();
        let lobe = if bsdf.uses_component_sample() { sampler.next_1d() } else { 0.0 };
        let Some(sample) = bsdf.sample_along(vertex.wo, [lobe, u, v], path.throughput) else { return };
        // Light paths do not find the reverse of a direction that was kept on its side. So only purely specular paths from the
        // camera take it: `NonCaustic` and light tracing must sum to all light.
        let Some(wi) = vertex.continued(&sample, !state.first_bounce_nonspecular) else { return };
        let ends_behind_diffuse = inputs.ends_behind_diffuse() && sample.is_diffuse;
        let ends = bounces >= settings.max_depth || ends_behind_diffuse;
        if ends && !inputs.scene_emits() {
            self.counts.depth_limited += 1;
            return;
        }
        let mut throughput = path.throughput * sample.weight();
        state.eta_scale *= sample.eta * sample.eta;
        if throughput.is_black() {
            return;
        }
        if inputs.uses_russian_roulette(bounces) && !russian_roulette(&mut throughput, state.eta_scale, sampler) {
            return;
        }
        if bounces == 0 {
            state.first_bounce_nonspecular = !sample.is_delta;
        }
        state.emission_only = ends;
        state.omits_sampled_lights = path.is_passed_by_light && sample.kind == Scattering::Transmission;
        state.omits_background = ends_behind_diffuse && !inputs.gathers_background(bsdf.is_diffuse_below_layer());
        state.vertex = Some(vertex.view.surface.point);
        state.medium_tracker.scatter(path.interface, sample.kind);
        let ray = vertex.view.surface.spawn_ray(wi, vertex.time);
        // In `f32`, the density must not be rounded to that of a delta direction.
        let pdf = if sample.is_delta { 0.0 } else { sample.pdf.max(f64::from(f32::MIN_POSITIVE)) };
        let normal = vertex.normal.unwrap_or(DVec3::ZERO);
        self.paths.push(&sample, &ray, &PathRecord { sample: path.sample, throughput, pdf, normal });
    }
}
