//! Ambient occlusion.

use crate::{
    RadianceSample, StreamQueries,
    bsdf::cosine_hemisphere,
    viewed_surface::{ViewedSurface, is_inside},
};
use rt_geometry::{HitStream, InteractionFlags, RayKind, RayStream, STREAM_CAPACITY, StreamArray};
use rt_math::{Frame, Interval, Rgb, Sampler};

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
    hits: HitStream,
    rays: RayStream,
    /// Index of the camera ray of each.
    samples: StreamArray<u32>,
}

impl OcclusionWave {
    /// Estimates occlusion by one direction per camera ray: `radiances[i]` is that of ray `i`, which uses `samplers[i]`. Does nothing
    /// with fewer samplers or entries of `radiances` than rays.
    pub fn radiance_of(
        &mut self,
        view: &AmbientOcclusion,
        world: &mut dyn StreamQueries,
        rays: &RayStream,
        samplers: &mut [impl Sampler],
        radiances: &mut [RadianceSample],
    ) {
        if samplers.len().min(radiances.len()) < rays.len() {
            return;
        }
        self.rays.clear();
        let needs = InteractionFlags { shading_normal: true, ..InteractionFlags::NONE };
        world.closest_stream(rays, RayKind::Primary, &mut self.hits);
        for (at, (radiance_sample, sampler)) in radiances.iter_mut().zip(samplers).enumerate().take(rays.len()) {
            let (ray, _) = rays.get(at);
            let hit = world.surface(&ray, &self.hits, at, needs);
            *radiance_sample = RadianceSample { radiance: Rgb::WHITE, hit: hit.is_some() };
            let Some(mut hit) = hit else { continue };
            let direction = ray.direction.normalize();
            let inside = is_inside(direction, &hit.interaction);
            let surface = ViewedSurface::new(direction, inside, &mut hit.interaction);
            let towards = Frame::from_z(surface.normal).from_local(cosine_hemisphere(sampler.next_2d()));
            if towards.dot(surface.surface.geometric_normal) * if inside { -1.0 } else { 1.0 } <= 0.0 {
                // Below the actual surface, where an interpolated normal reaches.
                radiance_sample.radiance = Rgb::BLACK;
                continue;
            }
            self.samples.set(self.rays.len(), at as u32);
            let span = Interval { max: view.reach, ..Interval::SPAWNED };
            self.rays.push(&surface.surface.spawn_ray(towards, ray.time), span);
        }
        let mut occluded = [false; STREAM_CAPACITY];
        let occluded = &mut occluded[..self.rays.len()];
        world.occluded_stream(&self.rays, occluded);
        for (sample, _) in self.samples.as_slice().iter().zip(occluded).filter(|(_, occluded)| **occluded) {
            radiances[*sample as usize].radiance = Rgb::BLACK;
        }
    }
}
