//! Emission of light paths, and their scattering at surfaces.

use super::{
    LightTracingScene,
    sources::LightLeSample,
    wave::{Connection, LightPath, LightPaths},
};
use crate::{
    Lighting, SceneQueries, SurfaceHit,
    bsdf::{BsdfSample, Scattering},
    hit_context::HitContext,
    interior_list::MediumInterface,
    medium_tracker::MediumTracker,
    russian_roulette::russian_roulette,
    vertex::{Vertex, bsdf_at},
    viewed_surface::{ViewedSurface, is_inside},
};
use rt_geometry::SurfaceInteraction;
use rt_math::{CameraWiSample, DVec3, Interval, Ray, Rgb, Sampler};

struct LightVertex<'a> {
    vertex: Vertex<'a>,
    /// Surface with its original shading normal; a view turns it.
    surface: SurfaceInteraction,
    interface: Option<MediumInterface>,
}

impl<S: Sampler> LightPaths<S> {
    /// Starts a path.
    pub(super) fn sample_le(
        &mut self,
        world: &mut impl SceneQueries,
        scene: LightTracingScene<'_>,
        mut sampler: S,
        time: f64,
    ) {
        let Some(sample) = scene.sources.sample_le(scene.lighting, time, &mut sampler) else { return };
        let LightLeSample { ray, span, power, no_falloff } = sample;
        let mut medium_tracker = MediumTracker::default();
        if self.features.refraction {
            let materials = &scene.lighting.appearance.materials;
            // The path begins at the start of its span: shadow rays end there.
            let start = Ray { origin: ray.at(span.min), ..ray };
            let bounds = scene.sources.dielectric_bounds();
            medium_tracker.interior.find_enclosing_media_within(bounds, world, materials, &start);
        }
        let no_falloff_distance = no_falloff.then_some(0.0);
        self.next.push(None, &ray, span, self.paths.len() as u32);
        self.paths.push(LightPath {
            sampler,
            medium_tracker,
            power,
            throughput: Rgb::WHITE,
            bounces: 0,
            is_passed_by_light: true,
            no_falloff_distance,
        });
    }

    /// Connects a non-specular vertex to the camera, and samples the next ray of the path.
    pub(super) fn shade_hit(
        &mut self,
        lighting: Lighting<'_>,
        id: u32,
        ray: &Ray,
        hit: &mut SurfaceHit,
        sample_wi: &impl Fn(DVec3, f64, &mut S) -> Option<CameraWiSample>,
    ) {
        let Some(path) = self.paths.get_mut(id as usize) else { return };
        let materials = &lighting.appearance.materials;
        let Some(context) = HitContext::new(&self.features, materials, ray, hit) else { return };
        let interface = context.interface(&mut path.medium_tracker.interior, materials, hit.medium_entry());
        let is_visible = context.is_visible(interface.as_ref());
        let HitContext { material, direction, length, is_inside, .. } = context;
        if !is_visible {
            return self.skip_interface(hit, ray, length, interface.as_ref(), id);
        }
        if self.features.absorption {
            path.medium_tracker.absorb(materials, interface.as_ref(), hit.t, length, &mut path.throughput);
        }
        if let Some(distance) = &mut path.no_falloff_distance {
            *distance += hit.t * length;
        }
        let is_passed_by_shadow_rays = context.is_passed_by_shadow_rays(hit);
        let surface = hit.interaction;
        let view = ViewedSurface::new(direction, is_inside, &mut hit.interaction);
        let mut made = None;
        let constant = lighting.bsdfs.get(hit.material).map(|constant| &constant.bsdf);
        let bsdf =
            constant.unwrap_or_else(|| made.insert(bsdf_at(lighting.appearance, material, &view, interface.as_ref())));
        let light_vertex = LightVertex { vertex: Vertex::new(view, bsdf, ray.time), surface, interface };
        // Camera paths find light that has passed all surfaces.
        if path.bounces > 0 && !path.is_passed_by_light && !light_vertex.vertex.bsdf.is_delta() {
            if let Some(distance) = path.no_falloff_distance.take() {
                path.power = path.power * (distance * distance);
            }
            self.connect_to_camera(id, &light_vertex, sample_wi);
        }
        self.sample_bsdf(id, &light_vertex, is_passed_by_shadow_rays);
    }

    /// Continues the same ray behind a null interface.
    fn skip_interface(
        &mut self,
        hit: &SurfaceHit,
        ray: &Ray,
        length: f64,
        interface: Option<&MediumInterface>,
        id: u32,
    ) {
        let Some(path) = self.paths.get_mut(id as usize) else { return };
        path.is_passed_by_light &= !hit.casts_shadow;
        path.medium_tracker.skip_interface(interface, hit, length, &mut path.throughput, &mut self.counts);
        if path.bounces + path.medium_tracker.null_interface_bounces() > self.settings.max_depth {
            self.counts.depth_limited += 1;
            return;
        }
        self.next.refracted.push(ray, hit.span_after(ray), id);
    }

    /// Queues the ray from a vertex to the camera, if the vertex projects to the image.
    fn connect_to_camera(
        &mut self,
        id: u32,
        light_vertex: &LightVertex<'_>,
        sample_wi: &impl Fn(DVec3, f64, &mut S) -> Option<CameraWiSample>,
    ) {
        let Some(path) = self.paths.get_mut(id as usize) else { return };
        let LightVertex { vertex, interface, .. } = light_vertex;
        let mut surface = light_vertex.surface;
        let Some(camera) = sample_wi(surface.point, vertex.time, &mut path.sampler) else { return };
        let Some(to_camera) = (camera.origin - surface.point).try_normalize() else { return };
        // The surface as a camera ray hits it.
        let normal = surface.geometric_normal;
        let inside = is_inside(-to_camera, &surface);
        let from = -vertex.view.direction;
        let seen = Vertex::new(ViewedSurface::new(-to_camera, inside, &mut surface), vertex.bsdf, vertex.time);
        let cosines = to_camera.dot(normal).abs() / from.dot(normal).abs();
        let light = path.power * path.throughput * seen.eval(from) * (cosines * camera.importance);
        if light.is_black() {
            self.counts.shadow_rays_skipped += 1;
            return;
        }
        let mut medium_tracker = path.medium_tracker.clone();
        let is_behind = inside != vertex.view.is_inside;
        medium_tracker
            .scatter(interface.as_ref(), if is_behind { Scattering::Transmission } else { Scattering::Reflection });
        let origin = surface.spawn_ray(to_camera, vertex.time).origin;
        let ray = Ray { origin, direction: camera.origin - origin, time: vertex.time };
        self.to_camera.push(&ray, Interval::SEGMENT, self.connections.len() as u32);
        self.connections.push(Connection { medium_tracker, raster: camera.raster, light });
    }

    /// Samples the next direction of the path, at a surface that shadow rays pass or not.
    fn sample_bsdf(&mut self, id: u32, light_vertex: &LightVertex<'_>, is_passed_by_shadow_rays: bool) {
        let Some(path) = self.paths.get_mut(id as usize) else { return };
        let vertex = &light_vertex.vertex;
        if path.bounces >= self.settings.max_depth {
            self.counts.depth_limited += 1;
            return;
        }
        let [u, v] = path.sampler.next_2d();
        let lobe = if vertex.bsdf.uses_component_sample() { path.sampler.next_1d() } else { 0.0 };
        let Some(sample) = vertex.bsdf.sample_importance(vertex.wo, [lobe, u, v], path.power * path.throughput) else {
            return;
        };
        // Camera paths find the light that the first surface scatters diffusely, apart from surfaces that light samples pass.
        if (path.bounces == 0 || path.is_passed_by_light) && !sample.is_delta {
            return;
        }
        let wi = vertex.frame.from_local(sample.wi);
        let surface = vertex.view.surface;
        if !vertex.view.is_on_side_of(sample.kind, wi) {
            return;
        }
        path.throughput *= sample.weight() * shading_normal_correction(vertex, &sample, wi);
        path.bounces += 1;
        path.is_passed_by_light &= is_passed_by_shadow_rays && sample.kind == Scattering::Transmission;
        if path.throughput.is_black() {
            return;
        }
        let is_old = path.bounces > self.settings.rr_start_depth;
        if is_old && !russian_roulette(&mut path.throughput, 1.0, &mut path.sampler) {
            return;
        }
        path.medium_tracker.scatter(light_vertex.interface.as_ref(), sample.kind);
        let ray = surface.spawn_ray(wi, vertex.time);
        self.next.push(Some(&sample), &ray, Interval::SPAWNED, id);
    }
}

/// Correction of f for interpolated normals in light tracing (Veach 1997, 5.3.2); 1 without them.
fn shading_normal_correction(vertex: &Vertex<'_>, sample: &BsdfSample, wi: DVec3) -> f64 {
    let surface = vertex.view.surface;
    if surface.shading_normal == surface.geometric_normal {
        return 1.0;
    }
    let normal = surface.geometric_normal;
    let (wo, from) = (vertex.wo, -vertex.view.direction);
    (wo.z * wi.dot(normal) / (from.dot(normal) * sample.wi.z)).abs()
}
