//! Points on lights, and densities of the directions in which they are seen.

use rt_math::float::gamma;
use rt_math::{DVec3, Rgb};

/// A point of a light, as a ray that met it knows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmitterPoint {
    /// World space.
    pub point: DVec3,
    /// Unit normal on the front side, world space.
    pub normal: DVec3,
    /// The triangle of a [`MeshLight`](super::MeshLight), in its order; ignored by other lights.
    pub triangle: u32,
}

/// A direction from which light comes, drawn at random.
///
/// The estimate of ∫ f(ω) L(ω) dω over the light is `f(direction) · radiance / pdf`, if nothing stands between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmitterSample {
    /// Unit vector towards the light, world space.
    pub direction: DVec3,
    /// Distance to the light; infinite for an environment.
    pub distance: f64,
    /// The point on the light, world space; `None` for an environment.
    pub point: Option<DVec3>,
    /// How far rounding may have put `point` off the light, per axis; zero for an environment.
    pub point_error: DVec3,
    /// Unit normal on the front side of the light; against `direction` for an environment.
    pub normal: DVec3,
    /// Light that arrives from there if nothing stands between. Never black.
    pub radiance: Rgb,
    /// Density of `direction` per unit solid angle, positive and finite.
    pub pdf: f64,
}

impl EmitterSample {
    /// What is seen of a light's surface from `from`. `None` if that is nothing: black, from the very point, and wherever a
    /// number is not usable. `extent` bounds the size of the light, for the error bound.
    pub(super) fn of_surface(from: DVec3, at: &EmitterPoint, extent: f64, radiance: Rgb, pdf: f64) -> Option<Self> {
        let offset = at.point - from;
        let distance = offset.length();
        let direction = offset / distance;
        let point_error = (at.point.abs() + DVec3::splat(extent)) * gamma(16);
        let sample = Self { direction, distance, point: Some(at.point), point_error, normal: at.normal, radiance, pdf };
        (direction.is_finite() && distance.is_finite() && is_density(pdf) && !radiance.is_black()).then_some(sample)
    }

    /// Where a shadow ray should end: `point`, moved off the light to the side that is seen by its error bound, so that
    /// the ray does not meet the light itself by rounding. `None` for an environment.
    ///
    /// Pharr, Jakob, Humphreys, PBR 4th ed., section 6.8.6, at the other end of the ray.
    pub fn shadow_target(&self) -> Option<DVec3> {
        let off = self.normal * self.normal.abs().dot(self.point_error);
        let side = if self.direction.dot(self.normal) < 0.0 { off } else { -off };
        self.point.map(|point| point + side)
    }
}

/// True if a density can be divided by.
#[inline]
pub(super) fn is_density(pdf: f64) -> bool {
    pdf > 0.0 && pdf.is_finite()
}

/// The density, or 0 where there is none.
#[inline]
pub(super) fn density(pdf: f64) -> f64 {
    if is_density(pdf) { pdf } else { 0.0 }
}

/// The density per unit solid angle of what has density `by_area` per unit area: `by_area · d² / |cos θ|`, for a point
/// at `offset` whose tangent plane is `height` away (θ is between the normal and the offset).
#[inline]
pub(super) fn by_solid_angle(by_area: f64, offset: DVec3, height: f64) -> f64 {
    let squared = offset.length_squared();
    by_area * squared * squared.sqrt() / height.abs()
}
