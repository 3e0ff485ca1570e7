//! What an integrator may ask of the world.

use rt_geometry::{SurfaceInteraction, SurfaceNeeds};
use rt_math::{Interval, Ray, RayKind, Rgb};

/// The surface that a ray met first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceHit {
    /// Ray parameter of the hit.
    pub t: f64,
    /// The surface, in world space.
    pub interaction: SurfaceInteraction,
    /// Index into [`Appearance::materials`](crate::Appearance::materials).
    pub material: u32,
}

/// The world as an integrator sees it: it answers rays and counts them.
pub trait Tracer {
    /// The first surface along the ray, with what is needed of it; `None` if the ray leaves the world.
    fn closest(&mut self, ray: &Ray, kind: RayKind, needs: SurfaceNeeds) -> Option<SurfaceHit>;

    /// True if something that casts shadows lies on the ray within `span`.
    fn occluded(&mut self, ray: &Ray, span: Interval) -> bool;
}

/// What a camera ray saw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Radiance towards the camera.
    pub radiance: Rgb,
    /// False if the camera ray left the world, and `radiance` is the background's.
    pub hit: bool,
}
