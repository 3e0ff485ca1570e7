//! Views of the first surface: properties of its geometry.

use crate::{RadianceSample, StreamQueries, SurfaceHit};
use rt_geometry::{HitStream, InteractionFlags, RayKind, RayStream};
use rt_math::{DVec3, Rgb};

/// Shows a property of the first surface that a camera ray hits; black for a miss.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AovIntegrator {
    /// The shading normal in world space, as (n + 1) / 2.
    Normals,
    /// The ray parameter, which for the rays of a camera is depth along the view axis: white at `near`, black at `far`
    /// and beyond.
    Depth {
        /// Depth shown white.
        near: f64,
        /// Depth shown black.
        far: f64,
    },
    /// Texture coordinates, modulo 1, as red and green.
    Uv,
}

impl AovIntegrator {
    /// Computes the result of camera rays: `radiances[i]` is that of ray `i`. `hits` is a buffer.
    pub fn radiance_of(
        &self,
        world: &mut dyn StreamQueries,
        rays: &RayStream,
        hits: &mut HitStream,
        radiances: &mut [RadianceSample],
    ) {
        let needs = InteractionFlags {
            uv: matches!(self, Self::Uv | Self::Normals),
            shading_normal: matches!(self, Self::Normals),
            detail: matches!(self, Self::Normals),
        };
        world.closest_stream(rays, RayKind::Primary, hits);
        for (at, radiance_sample) in radiances.iter_mut().enumerate().take(rays.len()) {
            let hit = world.surface(&rays.get(at).0, hits, at, needs);
            *radiance_sample =
                hit.map_or(RadianceSample::MISS, |hit| RadianceSample { radiance: self.shown(&hit), hit: true });
        }
    }

    fn shown(&self, hit: &SurfaceHit) -> Rgb {
        let surface = &hit.interaction;
        match *self {
            Self::Normals => Rgb::from(((surface.shading_normal + DVec3::ONE) * 0.5).to_array()),
            Self::Depth { near, far } => Rgb::gray(((far - hit.t) / (far - near)).clamp(0.0, 1.0)),
            Self::Uv => Rgb::new(surface.uv[0].rem_euclid(1.0), surface.uv[1].rem_euclid(1.0), 0.0),
        }
    }
}
