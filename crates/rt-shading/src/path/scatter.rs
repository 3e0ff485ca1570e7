//! What happens where a path meets a surface.

use super::{
    Follows, Lighting, PathTracer,
    wave::{Origin, Path, Queue},
};
use crate::{
    Seen, SurfaceHit,
    bsdf::{BsdfSample, Scattering},
    interior::{Crossing, absorb},
    meeting::{FREE_PASSAGES, Meeting},
    vertex::{Vertex, bsdf_at, power_heuristic},
    view::{View, is_inside},
};
use core::f64::consts::PI;
use rt_math::{DVec3, Interval, Ray, Sampler};

/// Paths go on with at most this chance once roulette is played, so that none goes on for ever. Where all surfaces reflect ρ
/// of the light, what paths carry has a finite variance only if ρ² is less than this chance.
pub(crate) const MOST_LIKELY: f64 = 0.999;

impl<S: Sampler + Clone> PathTracer<S> {
    /// Adds the light of what the ray has met to what the path sees, draws light there, and sends the path on.
    pub(super) fn meet(
        &mut self,
        lighting: Lighting<'_>,
        id: u32,
        ray: &Ray,
        hit: Option<&mut SurfaceHit>,
        seen: &mut Seen,
    ) {
        let follows = self.settings.follows;
        let path = &mut self.paths[id as usize];
        let Some(hit) = hit else {
            let weight = path.weight * environment_weight(lighting, path, ray.direction);
            seen.radiance += weight * lighting.appearance.background.radiance(ray.direction);
            return;
        };
        let materials = &lighting.appearance.materials;
        let Some(material) = materials.get(hit.material as usize) else {
            seen.hit = true;
            return;
        };
        let length = ray.direction.length();
        let direction = ray.direction / length;
        let inside = is_inside(direction, &hit.interaction);
        let meeting = if self.needs.refraction && material.phong.transmission.is_some() {
            Meeting::with_body(&mut path.interior, materials, &material.phong, hit, inside)
        } else {
            Meeting::Opaque
        };
        let way = (hit.t - path.medium_start) * length;
        let crossing = match meeting {
            Meeting::Nothing(crossing) => return self.pass(hit, ray, crossing.as_ref(), way, id, seen),
            Meeting::Transparent(crossing) => Some(crossing),
            Meeting::Opaque => None,
        };
        seen.hit = true;
        if self.needs.absorption {
            let medium = crossing.map_or_else(|| path.interior.medium(materials), |c| c.before);
            absorb(&mut path.weight, medium.absorption, way);
        }
        if self.needs.emission {
            let emitted = material.emission(&lighting.appearance.textures, hit.interaction.uv, inside);
            let is_left_out = follows == Follows::AllButCaustics && path.is_caustic_of(hit);
            if !emitted.is_black() && !is_left_out {
                seen.radiance += path.weight * emitted * emitter_weight(lighting, path, hit);
            }
        }
        if path.is_last {
            return;
        }
        let view = View::new(direction, inside, &mut hit.interaction);
        let bsdf = bsdf_at(lighting.appearance, material, &view, crossing.as_ref());
        let vertex = Vertex::new(view, bsdf, ray.time);
        let vertex = if follows == Follows::Reflections { vertex.without_diffuse() } else { vertex };
        if follows == Follows::Reflections && self.needs.ambient {
            let ambient = material.phong.ambient.at(&lighting.appearance.textures, vertex.view.surface.uv);
            seen.radiance += path.weight * ambient * lighting.appearance.ambient;
        }
        self.draw_lights(lighting, id, &vertex, seen);
        self.scatter(id, &vertex, crossing.as_ref());
    }

    /// Goes on along the same ray, through a surface that does nothing to it.
    fn pass(&mut self, hit: &SurfaceHit, ray: &Ray, crossing: Option<&Crossing>, way: f64, id: u32, seen: &mut Seen) {
        let path = &mut self.paths[id as usize];
        if let Some(crossing) = crossing {
            if crossing.before.absorption != crossing.after.absorption {
                seen.hit |= absorb(&mut path.weight, crossing.before.absorption, way);
                path.medium_start = hit.t;
            }
            path.interior.cross(crossing);
        } else {
            self.counts.interior_overflows += 1;
        }
        self.counts.passages += 1;
        path.passages += 1;
        path.bounces += u32::from(path.passages > FREE_PASSAGES);
        if path.bounces > self.settings.max_depth + u32::from(path.is_last) {
            self.counts.depth_limited += 1;
            return;
        }
        self.next.refracted.push(*ray, hit.beyond(ray), id);
    }

    /// Asks all lights without extent and one of those with, and leaves it to shadow rays whether they count.
    fn draw_lights(&mut self, lighting: Lighting<'_>, id: u32, vertex: &Vertex<'_>, seen: &mut Seen) {
        let path = &mut self.paths[id as usize];
        let surface = vertex.view.surface;
        let shadow_rays = surface.shadow_rays(vertex.view.is_inside);
        if vertex.bsdf.is_delta() {
            return;
        }
        for light in &lighting.appearance.lights {
            let Some(lit) = light.illuminate(surface.point) else { continue };
            let scattered = vertex.scattered(lit.direction);
            // A classical surface reflects kd of a light, and not kd / π of it.
            let radiance = path.weight * scattered * lit.strength * PI;
            if radiance.is_black() {
                self.counts.shadow_rays_spared += u64::from(light.casts_shadows);
            } else if light.casts_shadows {
                self.shadows.push(light.shadow_ray(&shadow_rays, &lit, vertex.time), id, radiance);
            } else {
                seen.radiance += radiance;
            }
        }
        if lighting.emitters.is_empty() {
            return;
        }
        let u = path.sampler.next_2d();
        let choice = if lighting.emitters.emitters().len() > 1 { path.sampler.next_1d() } else { 0.0 };
        let Some(light) = lighting.emitters.sample(surface.point, vertex.normal, choice, u) else {
            self.counts.shadow_rays_spared += 1;
            return;
        };
        let scattered = vertex.scattered_and_weighted(light.sample.direction, light.pdf);
        if scattered.is_black() {
            self.counts.shadow_rays_spared += 1;
            return;
        }
        let radiance = path.weight * scattered * light.sample.radiance / light.pdf;
        let ray = match light.sample.shadow_target() {
            Some(target) => (shadow_rays.to(target, vertex.time), Interval::SEGMENT),
            None => (shadow_rays.towards(light.sample.direction, vertex.time), Interval::SPAWNED),
        };
        self.shadows.push(ray, id, radiance);
    }

    /// Chooses the direction in which the path goes on, if it does.
    fn scatter(&mut self, id: u32, vertex: &Vertex<'_>, crossing: Option<&Crossing>) {
        let path = &mut self.paths[id as usize];
        let Some(bsdf) = vertex.followed() else { return };
        let [u, v] = path.sampler.next_2d();
        let lobe = if bsdf.chooses() { path.sampler.next_1d() } else { 0.0 };
        let Some(sample) = bsdf.sample(vertex.wo, [lobe, u, v]) else { return };
        let wi = vertex.frame.from_local(sample.wi);
        let surface = vertex.view.surface;
        if (sample.wi.z > 0.0) != (wi.dot(surface.geometric_normal) > 0.0) {
            return;
        }
        let ends = path.bounces >= self.settings.max_depth
            || (self.settings.follows == Follows::Reflections && sample.is_diffuse);
        if ends && !self.finds_light {
            self.counts.depth_limited += 1;
            return;
        }
        path.weight *= sample.weight();
        path.squeezed *= sample.eta * sample.eta;
        path.began_spread = if path.bounces == 0 { !sample.is_delta } else { path.began_spread };
        path.bounces += 1;
        path.passages = 0;
        path.medium_start = 0.0;
        path.is_last = ends;
        path.origin =
            Origin { point: surface.point, normal: vertex.normal, pdf: (!sample.is_delta).then_some(sample.pdf) };
        if path.weight.is_black() || !survives(path, self.settings.roulette_from) {
            return;
        }
        if let (Some(crossing), Scattering::Transmission) = (crossing, sample.kind) {
            path.interior.cross(crossing);
        }
        let ray = surface.spawn_ray(wi, vertex.time);
        self.queue_of(&sample).push(ray, Interval::SPAWNED, id);
    }

    fn queue_of(&mut self, sample: &BsdfSample) -> &mut Queue {
        match sample.kind {
            Scattering::Transmission => &mut self.next.refracted,
            Scattering::Reflection if sample.is_diffuse => &mut self.next.diffuse,
            Scattering::Reflection => &mut self.next.reflected,
        }
    }
}

/// Russian roulette, once the path is old enough; what survives counts more.
fn survives<S: Sampler>(path: &mut Path<S>, roulette_from: u32) -> bool {
    if path.bounces <= roulette_from {
        return true;
    }
    let chance = (path.weight.max_component() * path.squeezed).min(MOST_LIKELY);
    if path.sampler.next_1d() >= chance {
        return false;
    }
    path.weight = path.weight / chance;
    true
}

/// By how much the light of a surface counts that a path has met, as it might have been drawn.
fn emitter_weight<S>(lighting: Lighting<'_>, path: &Path<S>, hit: &SurfaceHit) -> f64 {
    let (Some(light), Some(pdf)) = (hit.emitter, path.origin.pdf) else { return 1.0 };
    let Origin { point, normal, .. } = path.origin;
    let surface = &hit.interaction;
    let drawn = lighting.emitters.pdf(point, normal, light, surface.point, surface.geometric_normal);
    power_heuristic(pdf, drawn)
}

/// The same for the environment.
fn environment_weight<S>(lighting: Lighting<'_>, path: &Path<S>, direction: DVec3) -> f64 {
    let (Some(_), Some(pdf)) = (lighting.emitters.environment(), path.origin.pdf) else { return 1.0 };
    power_heuristic(pdf, lighting.emitters.environment_pdf(path.origin.point, path.origin.normal, direction))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rt_math::Rgb;

    /// Draws the same number for ever.
    struct Constant(f64);

    impl Sampler for Constant {
        fn next_1d(&mut self) -> f64 {
            self.0
        }

        fn next_2d(&mut self) -> [f64; 2] {
            [self.0; 2]
        }
    }

    /// With a chance of 0.95 at most, what a path carried grew by 4 % at each wall of 0.99, and the variance was infinite.
    #[test]
    fn roulette_does_not_let_the_weight_grow_among_walls_that_are_almost_white() {
        let mut path = Path::new(Constant(0.5));
        for _ in 0..1000 {
            path.weight *= Rgb::gray(0.99);
            path.bounces += 1;
            assert!(survives(&mut path, 3));
            assert!(path.weight.g <= 1.0 + 1e-9, "{} after {} bounces", path.weight.g, path.bounces);
        }
    }

    #[test]
    fn roulette_keeps_the_mean() {
        let (mut sum, count) = (0.0, 100_000);
        for index in 0..count {
            let mut path = Path::new(Constant((f64::from(index) + 0.5) / f64::from(count)));
            (path.weight, path.bounces) = (Rgb::gray(0.3), 4);
            sum += if survives(&mut path, 3) { path.weight.g } else { 0.0 };
        }
        assert!((sum / f64::from(count) - 0.3).abs() < 1e-4, "{}", sum / f64::from(count));
    }
}
