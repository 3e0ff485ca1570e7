//! Emission of light paths, and their scattering at surfaces.

use super::{
    CameraWiSample, LightTracingIntegrator, LightTracingScene,
    sources::LeSample,
    wave::{Connection, LightPath},
};
use crate::{
    Lighting, SurfaceHit, Tracer,
    bsdf::{BsdfSample, Scattering},
    hit_context::HitContext,
    interior_list::MediumInterface,
    medium_tracker::MediumTracker,
    russian_roulette::russian_roulette,
    vertex::{Vertex, bsdf_at},
    viewed_surface::{ViewedSurface, is_inside},
};
use rt_geometry::SurfaceInteraction;
use rt_math::{DVec3, Interval, Ray, Rgb, Sampler};

/// A surface that light has come to.
struct LightVertex<'a> {
    vertex: Vertex<'a>,
    /// The surface with its own shading normal, which is bent in a view.
    surface: SurfaceInteraction,
    interface: Option<MediumInterface>,
}

impl<S: Sampler> LightTracingIntegrator<S> {
    /// Begins a path.
    pub(super) fn sample_le(
        &mut self,
        world: &mut impl Tracer,
        scene: LightTracingScene<'_>,
        mut sampler: S,
        time: f64,
    ) {
        let Some(departing) = scene.sources.sample_le(scene.lighting, time, &mut sampler) else { return };
        let LeSample { ray, span, power, no_falloff } = departing;
        let mut medium_tracker = MediumTracker::default();
        if self.needs.refraction {
            let materials = &scene.lighting.appearance.materials;
            medium_tracker.interior.find_enclosing_media_within(scene.sources.bodies(), world, materials, &ray);
        }
        let no_falloff_distance = no_falloff.then_some(0.0);
        self.ray_queues.push(None, ray, span, self.paths.len() as u32);
        self.paths.push(LightPath {
            sampler,
            medium_tracker,
            power,
            throughput: Rgb::WHITE,
            bounces: 0,
            no_falloff_distance,
        });
    }

    /// Shows the light to the camera where the surface spreads it, and sends it on.
    pub(super) fn shade_hit(
        &mut self,
        lighting: Lighting<'_>,
        id: u32,
        ray: &Ray,
        hit: &mut SurfaceHit,
        sight: &impl Fn(DVec3, f64, &mut S) -> Option<CameraWiSample>,
    ) {
        let Some(photon) = self.paths.get_mut(id as usize) else { return };
        let materials = &lighting.appearance.materials;
        let Some(context) = HitContext::new(&self.needs, materials, ray, hit) else { return };
        let interface = context.interface(&mut photon.medium_tracker.interior, materials, hit);
        let is_visible = context.is_visible(interface.as_ref());
        let HitContext { material, direction, length, is_inside, .. } = context;
        if !is_visible {
            return self.skip_interface(hit, ray, length, interface.as_ref(), id);
        }
        if self.needs.absorption {
            photon.medium_tracker.absorb(materials, interface.as_ref(), hit.t, length, &mut photon.throughput);
        }
        if let Some(way) = &mut photon.no_falloff_distance {
            *way += hit.t * length;
        }
        let surface = hit.interaction;
        let view = ViewedSurface::new(direction, is_inside, &mut hit.interaction);
        let mut made = None;
        let constant = lighting.bsdfs.get(hit.material).map(|constant| &constant.bsdf);
        let bsdf =
            constant.unwrap_or_else(|| made.insert(bsdf_at(lighting.appearance, material, &view, interface.as_ref())));
        let arrival = LightVertex { vertex: Vertex::new(view, bsdf, ray.time), surface, interface };
        if photon.bounces > 0 && !arrival.vertex.bsdf.is_delta() {
            if let Some(way) = photon.no_falloff_distance.take() {
                photon.power = photon.power * (way * way);
            }
            self.connect_to_camera(id, &arrival, sight);
        }
        self.sample_bsdf(id, &arrival);
    }

    /// Goes on along the same ray, through a surface that does nothing to it.
    fn skip_interface(
        &mut self,
        hit: &SurfaceHit,
        ray: &Ray,
        length: f64,
        interface: Option<&MediumInterface>,
        id: u32,
    ) {
        let Some(photon) = self.paths.get_mut(id as usize) else { return };
        photon.medium_tracker.skip_interface(interface, hit, length, &mut photon.throughput, &mut self.counts);
        photon.bounces += u32::from(photon.medium_tracker.null_limit_exceeded());
        if photon.bounces > self.settings.max_depth {
            self.counts.depth_limited += 1;
            return;
        }
        self.next.refracted.push(*ray, hit.span_after(ray), id);
    }

    /// Sends what the surface scatters to the camera on its way there, if the camera looks at it.
    fn connect_to_camera(
        &mut self,
        id: u32,
        arrival: &LightVertex<'_>,
        sight: &impl Fn(DVec3, f64, &mut S) -> Option<CameraWiSample>,
    ) {
        let Some(photon) = self.paths.get_mut(id as usize) else { return };
        let LightVertex { vertex, interface, .. } = arrival;
        let mut surface = arrival.surface;
        let Some(sight) = sight(surface.point, vertex.time, &mut photon.sampler) else { return };
        let Some(to_camera) = (sight.origin - surface.point).try_normalize() else { return };
        // As the camera's ray would see it.
        let normal = surface.geometric_normal;
        let inside = is_inside(-to_camera, &surface);
        let from = -vertex.view.direction;
        let seen = Vertex::new(ViewedSurface::new(-to_camera, inside, &mut surface), vertex.bsdf, vertex.time);
        let cosines = to_camera.dot(normal).abs() / from.dot(normal).abs();
        let light = photon.power * photon.throughput * seen.eval(from) * (cosines * sight.importance);
        if light.is_black() {
            self.counts.shadow_rays_spared += 1;
            return;
        }
        let mut medium_tracker = photon.medium_tracker.clone();
        let is_behind = inside != vertex.view.is_inside;
        medium_tracker
            .scatter(interface.as_ref(), if is_behind { Scattering::Transmission } else { Scattering::Reflection });
        let origin = surface.spawn_ray(to_camera, vertex.time).origin;
        let ray = Ray { origin, direction: sight.origin - origin, time: vertex.time };
        self.to_camera.push(ray, Interval::SEGMENT, self.connections.len() as u32);
        self.connections.push(Connection { medium_tracker, raster: sight.raster, light });
    }

    /// Chooses the direction in which the path goes on, if it does.
    fn sample_bsdf(&mut self, id: u32, arrival: &LightVertex<'_>) {
        let Some(photon) = self.paths.get_mut(id as usize) else { return };
        let vertex = &arrival.vertex;
        if photon.bounces >= self.settings.max_depth {
            self.counts.depth_limited += 1;
            return;
        }
        let [u, v] = photon.sampler.next_2d();
        let lobe = if vertex.bsdf.uses_component_sample() { photon.sampler.next_1d() } else { 0.0 };
        let Some(sample) = vertex.bsdf.sample_importance(vertex.wo, [lobe, u, v]) else { return };
        // Light that the first surface spreads is found from the camera.
        if photon.bounces == 0 && !sample.is_delta {
            return;
        }
        let wi = vertex.frame.from_local(sample.wi);
        let surface = vertex.view.surface;
        if !vertex.view.is_on_side_of(sample.kind, wi) {
            return;
        }
        photon.throughput *= sample.weight() * shading_normal_correction(vertex, &sample, wi);
        photon.bounces += 1;
        if photon.throughput.is_black() {
            return;
        }
        let is_old = photon.bounces > self.settings.rr_start_depth;
        if is_old && !russian_roulette(&mut photon.throughput, 1.0, &mut photon.sampler) {
            return;
        }
        photon.medium_tracker.scatter(arrival.interface.as_ref(), sample.kind);
        let ray = surface.spawn_ray(wi, vertex.time);
        self.next.push(Some(&sample), ray, Interval::SPAWNED, id);
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
