//! Ambient occlusion.

use crate::{
    RadianceSample, SceneQueries,
    bsdf::cosine_hemisphere,
    viewed_surface::{ViewedSurface, is_inside},
};
use rt_geometry::{InteractionFlags, RayKind};
use rt_math::{Frame, Interval, Ray, Rgb, Sampler};

/// Shows the part of the sky that each point of a surface sees, weighted by the cosine: ∫ V(ω) cos θ / π dω. It is 1 on an
/// open plain, and the image is white where no surface is. Source: Zhukov, Iones and Kronin, "An ambient light illumination
/// model", 1998.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AmbientOcclusion {
    /// Maximum distance of occluders in world units; infinite for no limit.
    pub reach: f64,
}

/// Buffers reused between waves. Keep one per thread.
#[derive(Clone, Debug, Default)]
pub struct OcclusionWave {
    rays: Vec<(Ray, Interval)>,
    /// The camera ray that each belongs to.
    places: Vec<u32>,
    blocked: Vec<bool>,
}

impl OcclusionWave {
    /// An estimate from one direction for each camera ray: `seen[i]` answers `rays[i]`, which draws from `samplers[i]`.
    pub fn radiance_of<S: Sampler + Clone>(
        &mut self,
        view: &AmbientOcclusion,
        world: &mut impl SceneQueries,
        rays: &[(Ray, Interval)],
        samplers: &[S],
        seen: &mut [RadianceSample],
    ) {
        self.rays.clear();
        self.places.clear();
        let needs = InteractionFlags { shading_normal: true, ..InteractionFlags::NONE };
        world.closest_batch(rays, RayKind::Primary, needs, |at, hit| {
            seen[at] = RadianceSample { radiance: Rgb::WHITE, hit: hit.is_some() };
            let (Some(hit), Some(sampler)) = (hit, samplers.get(at)) else { return };
            let ray = &rays[at].0;
            let direction = ray.direction.normalize();
            let inside = is_inside(direction, &hit.interaction);
            let surface = ViewedSurface::new(direction, inside, &mut hit.interaction);
            let towards = Frame::from_z(surface.normal).from_local(cosine_hemisphere(sampler.clone().next_2d()));
            if towards.dot(surface.surface.geometric_normal) * if inside { -1.0 } else { 1.0 } <= 0.0 {
                // Below the actual surface, where an interpolated normal reaches.
                seen[at].radiance = Rgb::BLACK;
                return;
            }
            let spawned = surface.surface.spawn_ray(towards, ray.time);
            self.rays.push((spawned, Interval { max: view.reach, ..Interval::SPAWNED }));
            self.places.push(at as u32);
        });
        self.blocked.clear();
        self.blocked.resize(self.rays.len(), false);
        world.occluded_batch(&self.rays, &mut self.blocked);
        for (place, _) in self.places.iter().zip(&self.blocked).filter(|(_, blocked)| **blocked) {
            seen[*place as usize].radiance = Rgb::BLACK;
        }
    }
}
