//! Shading of path vertices one by one: emission with its MIS weight, and BSDF sampling.

use super::{
    Lighting, PathSettings, PathTracer, Transport,
    vertex_queue::{LazyShapeHit, QueueKind},
    wave::{Path, PrevVertex},
};
use crate::{
    RadianceSample, SurfaceHit,
    bsdf::LaneSurface,
    bsdf_cache::LaneMaterial,
    hit_context::HitContext,
    interior_list::MediumInterface,
    mis::power_heuristic,
    russian_roulette::russian_roulette,
    vertex::{Vertex, bsdf_at},
    viewed_surface::ViewedSurface,
};
use rt_math::{DVec3, Interval, Ray, Sampler};

impl<S: Sampler + Clone> PathTracer<S> {
    /// Adds the background behind all surfaces to the radiance of a path.
    #[inline(always)]
    pub(super) fn shade_miss(&mut self, lighting: Lighting<'_>, id: u32, ray: &Ray, seen: &mut RadianceSample) {
        let path = &self.paths[id as usize];
        let throughput = path.throughput * mis_weight_env(lighting, path, ray.direction);
        let radiance = throughput * lighting.appearance.background.radiance(ray.direction);
        seen.radiance += self.settings.clamp.apply(path.bounces, radiance, &mut self.counts);
    }

    /// Adds emission at the hit of a ray, samples direct light there, and samples the next ray of the path.
    pub(super) fn shade_hit(
        &mut self,
        lighting: Lighting<'_>,
        id: u32,
        ray: &Ray,
        hit: &mut SurfaceHit,
        seen: &mut RadianceSample,
    ) {
        let PathSettings { transport, clamp, .. } = self.settings;
        let path = &mut self.paths[id as usize];
        let materials = &lighting.appearance.materials;
        let Some(context) = HitContext::new(&self.features, materials, ray, hit) else {
            seen.hit = true;
            return;
        };
        let interface = context.interface(&mut path.medium_tracker.interior, materials, hit.body());
        let interface = interface.as_ref();
        let is_visible = context.is_visible(interface);
        let HitContext { material, direction, length, is_inside, .. } = context;
        if !is_visible {
            return self.skip_interface(hit, ray, length, interface, id, seen);
        }
        seen.hit = true;
        if self.features.absorption {
            path.medium_tracker.absorb(materials, interface, hit.t, length, &mut path.throughput);
        }
        if self.features.emission {
            let emitted = material.emitted_radiance(&lighting.appearance.textures, &hit.interaction, is_inside);
            let is_omitted = transport == Transport::NonCaustic && path.is_caustic_of(hit);
            if !emitted.is_black() && !is_omitted {
                let radiance = path.throughput * emitted * mis_weight_area(lighting, path, hit);
                seen.radiance += clamp.apply(path.bounces, radiance, &mut self.counts);
            }
        }
        if path.emission_only {
            return;
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
        let only_reflects = transport == Transport::Specular;
        if only_reflects && self.features.ambient && !gathers_background(lighting, bsdf.is_diffuse_below_layer()) {
            let ambient = material.ambient(&material.to_phong(), &lighting.appearance.textures, view.surface);
            let radiance = path.throughput * ambient * lighting.appearance.ambient;
            seen.radiance += clamp.apply(path.bounces + 1, radiance, &mut self.counts);
        }
        if self.lanes.is_some()
            && let Some(surface) = in_lanes
            && interface.is_none()
            && view.surface.shading_normal == shading_normal
            && !(self.features.absorption && path.medium_tracker.absorbs(materials))
        {
            let queue = &mut self.queues[QueueKind::of(surface) as usize];
            return queue.push((id, path), &view, surface, ray.time, self.settings.rr_start_depth);
        }
        let vertex = Vertex::new(view, bsdf, ray.time);
        let vertex = match cached {
            _ if !only_reflects => vertex,
            Some(cached) => vertex.with_sampled_lobes(cached.without_diffuse.as_ref()),
            None => {
                specular = bsdf.without_diffuse();
                vertex.with_sampled_lobes(specular.as_ref())
            }
        };
        self.scatter(lighting, id, &vertex, interface, seen);
    }

    /// Version of [`shade_hit`](Self::shade_hit) for a shape whose surface is computed in lanes if its material allows that.
    #[inline(always)]
    pub(super) fn shade_lazily(
        &mut self,
        lighting: Lighting<'_>,
        id: u32,
        ray: &Ray,
        hit: LazyShapeHit<'_>,
        seen: &mut RadianceSample,
    ) {
        let material = if self.features.absorption { None } else { lighting.bsdfs.in_lanes(hit.material()) };
        let Some(LaneMaterial { surface, ambient }) = material else {
            return self.shade_hit(lighting, id, ray, &mut hit.surface(ray), seen);
        };
        seen.hit = true;
        let PathSettings { transport, clamp, rr_start_depth, .. } = self.settings;
        let path = &self.paths[id as usize];
        if path.emission_only {
            return;
        }
        let is_layered = matches!(surface, LaneSurface::MetallicRoughness(_));
        if self.features.ambient && transport == Transport::Specular && !gathers_background(lighting, is_layered) {
            let radiance = path.throughput * *ambient * lighting.appearance.ambient;
            seen.radiance += clamp.apply(path.bounces + 1, radiance, &mut self.counts);
        }
        let queue = &mut self.queues[QueueKind::of(surface) as usize];
        queue.push_hit((id, path), hit, surface, ray, rr_start_depth);
    }

    /// Samples direct light and the next direction of the path.
    pub(super) fn scatter(
        &mut self,
        lighting: Lighting<'_>,
        id: u32,
        vertex: &Vertex<'_>,
        interface: Option<&MediumInterface>,
        seen: &mut RadianceSample,
    ) {
        self.sample_direct_lighting(lighting, id, vertex, interface, seen);
        self.sample_bsdf(id, vertex, interface);
    }

    /// Continues the same ray behind a null interface.
    fn skip_interface(
        &mut self,
        hit: &SurfaceHit,
        ray: &Ray,
        length: f64,
        interface: Option<&MediumInterface>,
        id: u32,
        seen: &mut RadianceSample,
    ) {
        let path = &mut self.paths[id as usize];
        seen.hit |= path.medium_tracker.skip_interface(interface, hit, length, &mut path.throughput, &mut self.counts);
        path.bounces += u32::from(path.medium_tracker.null_limit_exceeded());
        if path.bounces > self.settings.max_depth + u32::from(path.emission_only) {
            self.counts.depth_limited += 1;
            return;
        }
        self.next.refracted.push(*ray, hit.span_after(ray), id);
    }

    /// Samples the next direction of the path.
    fn sample_bsdf(&mut self, id: u32, vertex: &Vertex<'_>, interface: Option<&MediumInterface>) {
        let path = &mut self.paths[id as usize];
        let Some(bsdf) = vertex.sampled_lobes() else { return };
        let sampler = &mut self.samplers[id as usize];
        let [u, v] = sampler.next_2d();
        let lobe = if bsdf.uses_component_sample() { sampler.next_1d() } else { 0.0 };
        let Some(sample) = bsdf.sample(vertex.wo, [lobe, u, v]) else { return };
        // Light paths do not find the reverse of a direction that was kept on its side. So only purely specular paths from the
        // camera take it: `NonCaustic` and light tracing must sum to all light.
        let Some(wi) = vertex.continued(&sample, !path.first_bounce_nonspecular) else { return };
        let surface = vertex.view.surface;
        let ends = path.bounces >= self.settings.max_depth
            || (self.settings.transport == Transport::Specular && sample.is_diffuse);
        if ends && !self.scene_emits {
            self.counts.depth_limited += 1;
            return;
        }
        path.throughput *= sample.weight();
        path.eta_scale *= sample.eta * sample.eta;
        path.first_bounce_nonspecular =
            if path.bounces == 0 { !sample.is_delta } else { path.first_bounce_nonspecular };
        path.bounces += 1;
        path.emission_only = ends;
        path.prev =
            PrevVertex { point: surface.point, normal: vertex.normal, pdf: (!sample.is_delta).then_some(sample.pdf) };
        if path.throughput.is_black() {
            return;
        }
        let is_old = path.bounces > self.settings.rr_start_depth;
        if is_old && !russian_roulette(&mut path.throughput, path.eta_scale, sampler) {
            return;
        }
        path.medium_tracker.scatter(interface, sample.kind);
        let ray = surface.spawn_ray(wi, vertex.time);
        self.next.push(Some(&sample), ray, Interval::SPAWNED, id);
    }
}

/// True where the diffuse part of a surface is followed to the background or lit by samples of it. Elsewhere ambient light stands for
/// the background.
#[inline(always)]
fn gathers_background(lighting: Lighting<'_>, is_diffuse_below_layer: bool) -> bool {
    let follows_background = is_diffuse_below_layer || lighting.lights.environment().is_some();
    !lighting.appearance.background.is_black() && follows_background
}

/// MIS weight of the emission of a surface that a BSDF sample has hit.
fn mis_weight_area(lighting: Lighting<'_>, path: &Path, hit: &SurfaceHit) -> f64 {
    let (Some(light), Some(pdf)) = (hit.light, path.prev.pdf) else { return 1.0 };
    let PrevVertex { point, normal, .. } = path.prev;
    let surface = &hit.interaction;
    let light_pdf = lighting.lights.pdf_li(point, normal, light, surface.point, surface.geometric_normal);
    power_heuristic(pdf, light_pdf)
}

/// MIS weight of the environment that a BSDF sample has hit.
fn mis_weight_env(lighting: Lighting<'_>, path: &Path, direction: DVec3) -> f64 {
    let (Some(_), Some(pdf)) = (lighting.lights.environment(), path.prev.pdf) else { return 1.0 };
    power_heuristic(pdf, lighting.lights.pdf_li_environment(path.prev.point, path.prev.normal, direction))
}
