//! Ray queries of integrators.

use crate::light::LightId;
use rt_geometry::{InteractionFlags, RayKind, SurfaceInteraction};
use rt_math::{Interval, Ray, Rgb};

/// Surface at the closest hit of a ray, in world space, with its object and material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceHit {
    /// Ray parameter of the hit.
    pub t: f64,
    /// Geometry of the surface, world space.
    pub interaction: SurfaceInteraction,
    /// Index of the object that the surface belongs to; identifies the dielectrics that a ray is inside of.
    pub object: u32,
    /// Index into [`Appearance::materials`](crate::Appearance::materials).
    pub material: u32,
    /// Area light of the surface, if it is one of the sampled lights.
    pub light: Option<LightId>,
    /// True if the object ends shadow rays. False for materials that [pass](crate::Material::passes_shadow_rays) them.
    pub casts_shadow: bool,
}

impl SurfaceHit {
    /// Hit of a surface that is no light and casts shadows.
    pub const fn new(t: f64, interaction: SurfaceInteraction, object: u32, material: u32) -> Self {
        Self { t, interaction, object, material, light: None, casts_shadow: true }
    }

    /// Interval beyond this hit, for a ray that continues as if the surface were absent.
    ///
    /// The ray is unchanged, so that hits behind it have bit-identical parameters. The interval starts beyond the error bound of the
    /// surface, as for a spawned ray: two triangles that share the hit edge are one surface.
    pub fn span_after(&self, ray: &Ray) -> Interval {
        let normal = self.interaction.geometric_normal;
        let way = normal.abs().dot(self.interaction.point_error) / normal.dot(ray.direction).abs();
        let min = if way.is_finite() { self.t + way } else { self.t }.next_up();
        // The interval beyond infinity is empty.
        Interval::new(min, if min > self.t { f64::INFINITY } else { f64::NEG_INFINITY })
    }
}

/// The world of an integrator: it answers ray queries and counts them.
pub trait SceneQueries {
    /// Closest surface along the ray within `span`, with the needed data; `None` for a miss. The ray counts
    /// as one of its `kind`.
    fn closest(&mut self, ray: &Ray, span: Interval, kind: RayKind, needs: InteractionFlags) -> Option<SurfaceHit>;

    /// True if something that casts shadows lies on the ray within `span`.
    fn occluded(&mut self, ray: &Ray, span: Interval) -> bool;
}

/// Result of a camera ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadianceSample {
    /// Radiance towards the camera.
    pub radiance: Rgb,
    /// False if the camera ray left the world, and `radiance` is the background's.
    pub hit: bool,
}

impl RadianceSample {
    /// Black, without a hit.
    pub const MISS: Self = Self { radiance: Rgb::BLACK, hit: false };
}
