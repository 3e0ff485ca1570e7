//! What happens where a light path begins, and where it meets a surface.

use super::{
    CameraWiSample, LightTracingIntegrator, LightTracingScene,
    sources::Departing,
    wave::{Connection, Photon},
};
use crate::{
    Lighting, SurfaceHit, Tracer,
    bsdf::{BsdfSample, Scattering},
    course::Course,
    interior::Crossing,
    meeting::Meeting,
    roulette::survives,
    vertex::{Vertex, bsdf_at},
    view::{View, is_inside},
};
use rt_geometry::SurfaceInteraction;
use rt_math::{DVec3, Interval, Ray, Rgb, Sampler};

/// A surface that light has come to.
struct Arrival<'a> {
    vertex: Vertex<'a>,
    /// The surface with its own shading normal, which is bent in a view.
    surface: SurfaceInteraction,
    crossing: Option<Crossing>,
}

impl<S: Sampler> LightTracingIntegrator<S> {
    /// Begins a path.
    pub(super) fn depart(&mut self, world: &mut impl Tracer, scene: LightTracingScene<'_>, mut sampler: S, time: f64) {
        let Some(departing) = scene.sources.depart(scene.lighting, time, &mut sampler) else { return };
        let Departing { ray, span, power, is_unweakened } = departing;
        let mut course = Course::default();
        if self.needs.refraction {
            let materials = &scene.lighting.appearance.materials;
            course.interior.look_around_within(scene.sources.bodies(), world, materials, &ray);
        }
        let unweakened_way = is_unweakened.then_some(0.0);
        self.flow.push(None, ray, span, self.photons.len() as u32);
        self.photons.push(Photon { sampler, course, power, weight: Rgb::WHITE, bounces: 0, unweakened_way });
    }

    /// Shows the light to the camera where the surface spreads it, and sends it on.
    pub(super) fn meet(
        &mut self,
        lighting: Lighting<'_>,
        id: u32,
        ray: &Ray,
        hit: &mut SurfaceHit,
        sight: &impl Fn(DVec3, f64, &mut S) -> Option<CameraWiSample>,
    ) {
        let Some(photon) = self.photons.get_mut(id as usize) else { return };
        let materials = &lighting.appearance.materials;
        let Some(meeting) = Meeting::new(&self.needs, materials, ray, hit) else { return };
        let crossing = meeting.crossing(&mut photon.course.interior, materials, hit);
        let is_noticed = meeting.is_noticed(crossing.as_ref());
        let Meeting { material, direction, length, is_inside, .. } = meeting;
        if !is_noticed {
            return self.pass(hit, ray, length, crossing.as_ref(), id);
        }
        if self.needs.absorption {
            photon.course.absorb(materials, crossing.as_ref(), hit.t, length, &mut photon.weight);
        }
        if let Some(way) = &mut photon.unweakened_way {
            *way += hit.t * length;
        }
        let surface = hit.interaction;
        let view = View::new(direction, is_inside, &mut hit.interaction);
        let mut made = None;
        let constant = lighting.bsdfs.get(hit.material).map(|constant| &constant.bsdf);
        let bsdf =
            constant.unwrap_or_else(|| made.insert(bsdf_at(lighting.appearance, material, &view, crossing.as_ref())));
        let arrival = Arrival { vertex: Vertex::new(view, bsdf, ray.time), surface, crossing };
        if photon.bounces > 0 && !arrival.vertex.bsdf.is_delta() {
            if let Some(way) = photon.unweakened_way.take() {
                photon.power = photon.power * (way * way);
            }
            self.show(id, &arrival, sight);
        }
        self.scatter(id, &arrival);
    }

    /// Goes on along the same ray, through a surface that does nothing to it.
    fn pass(&mut self, hit: &SurfaceHit, ray: &Ray, length: f64, crossing: Option<&Crossing>, id: u32) {
        let Some(photon) = self.photons.get_mut(id as usize) else { return };
        photon.course.pass(crossing, hit, length, &mut photon.weight, &mut self.counts);
        photon.bounces += u32::from(photon.course.is_tired());
        if photon.bounces > self.settings.max_depth {
            self.counts.depth_limited += 1;
            return;
        }
        self.next.refracted.push(*ray, hit.beyond(ray), id);
    }

    /// Sends what the surface scatters to the camera on its way there, if the camera looks at it.
    fn show(&mut self, id: u32, arrival: &Arrival<'_>, sight: &impl Fn(DVec3, f64, &mut S) -> Option<CameraWiSample>) {
        let Some(photon) = self.photons.get_mut(id as usize) else { return };
        let Arrival { vertex, crossing, .. } = arrival;
        let mut surface = arrival.surface;
        let Some(sight) = sight(surface.point, vertex.time, &mut photon.sampler) else { return };
        let Some(to_camera) = (sight.origin - surface.point).try_normalize() else { return };
        // As the camera's ray would see it.
        let normal = surface.geometric_normal;
        let inside = is_inside(-to_camera, &surface);
        let from = -vertex.view.direction;
        let seen = Vertex::new(View::new(-to_camera, inside, &mut surface), vertex.bsdf, vertex.time);
        let cosines = to_camera.dot(normal).abs() / from.dot(normal).abs();
        let light = photon.power * photon.weight * seen.scattered(from) * (cosines * sight.importance);
        if light.is_black() {
            self.counts.shadow_rays_spared += 1;
            return;
        }
        let mut course = photon.course.clone();
        let is_behind = inside != vertex.view.is_inside;
        course.turn(crossing.as_ref(), if is_behind { Scattering::Transmission } else { Scattering::Reflection });
        let origin = surface.spawn_ray(to_camera, vertex.time).origin;
        let ray = Ray { origin, direction: sight.origin - origin, time: vertex.time };
        self.to_camera.push(ray, Interval::SEGMENT, self.connections.len() as u32);
        self.connections.push(Connection { course, raster: sight.raster, light });
    }

    /// Chooses the direction in which the path goes on, if it does.
    fn scatter(&mut self, id: u32, arrival: &Arrival<'_>) {
        let Some(photon) = self.photons.get_mut(id as usize) else { return };
        let vertex = &arrival.vertex;
        if photon.bounces >= self.settings.max_depth {
            self.counts.depth_limited += 1;
            return;
        }
        let [u, v] = photon.sampler.next_2d();
        let lobe = if vertex.bsdf.chooses() { photon.sampler.next_1d() } else { 0.0 };
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
        photon.weight *= sample.weight() * correction(vertex, &sample, wi);
        photon.bounces += 1;
        if photon.weight.is_black() {
            return;
        }
        let is_old = photon.bounces > self.settings.roulette_from;
        if is_old && !survives(&mut photon.weight, 1.0, &mut photon.sampler) {
            return;
        }
        photon.course.turn(arrival.crossing.as_ref(), sample.kind);
        let ray = surface.spawn_ray(wi, vertex.time);
        self.next.push(Some(&sample), ray, Interval::SPAWNED, id);
    }
}

/// What an interpolated normal adds to f of light that is traced forwards, over what it adds to its cosines (Veach 1997,
/// 5.3.2): 1 where it is the actual normal.
fn correction(vertex: &Vertex<'_>, sample: &BsdfSample, wi: DVec3) -> f64 {
    let surface = vertex.view.surface;
    if surface.shading_normal == surface.geometric_normal {
        return 1.0;
    }
    let normal = surface.geometric_normal;
    let (wo, from) = (vertex.wo, -vertex.view.direction);
    (wo.z * wi.dot(normal) / (from.dot(normal) * sample.wi.z)).abs()
}
