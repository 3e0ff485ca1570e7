//! Views of the first surface: to look at geometry rather than light.

use crate::{Seen, Tracer};
use rt_geometry::SurfaceNeeds;
use rt_math::{DVec3, Interval, Ray, RayKind, Rgb};

/// Shows a property of the first surface that a camera ray meets; black where there is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FirstHitView {
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

impl FirstHitView {
    /// What a camera ray sees.
    pub fn radiance(&self, world: &mut impl Tracer, ray: &Ray) -> Seen {
        let needs = SurfaceNeeds { uv: matches!(self, Self::Uv), shading_normal: matches!(self, Self::Normals) };
        let Some(hit) = world.closest(ray, Interval::FORWARD, RayKind::Primary, needs) else {
            return Seen { radiance: Rgb::BLACK, hit: false };
        };
        let surface = &hit.interaction;
        let radiance = match *self {
            Self::Normals => Rgb::from(((surface.shading_normal + DVec3::ONE) * 0.5).to_array()),
            Self::Depth { near, far } => Rgb::gray(((far - hit.t) / (far - near)).clamp(0.0, 1.0)),
            Self::Uv => Rgb::new(surface.uv[0].rem_euclid(1.0), surface.uv[1].rem_euclid(1.0), 0.0),
        };
        Seen { radiance, hit: true }
    }
}
