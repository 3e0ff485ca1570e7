//! Lambertian reflection.

use super::{
    BsdfSample,
    side::{Side, same_side},
};
use core::f64::consts::{FRAC_1_PI, FRAC_PI_2, FRAC_PI_4};
use rt_math::{DVec3, Float64, Rgb, Vector3, transcendental};

/// Lambertian reflection: f = albedo / π (Lambert 1760).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lambert {
    /// Albedo, per channel in \[0, 1\].
    pub albedo: Rgb,
}

impl Lambert {
    /// Implements [`super::Bsdf::eval_with_pdf`]; the density is cos θ(wi) / π.
    #[inline]
    pub fn eval_with_pdf(&self, wo: DVec3, wi: DVec3) -> (Rgb, f64) {
        same_side(wo, wi).map_or((Rgb::BLACK, 0.0), |(_, wi)| (self.albedo * FRAC_1_PI, cosine_pdf(wi)))
    }

    /// Implements [`super::Bsdf::sample`]; the weight is the albedo.
    #[inline]
    pub fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        let (_, side) = Side::of(wo, u)?;
        let wi = cosine_hemisphere([u[1], u[2]]);
        BsdfSample { is_diffuse: true, ..BsdfSample::new(side.restore(wi), self.albedo * FRAC_1_PI, cosine_pdf(wi)) }
            .if_finite()
    }
}

/// Density of [`cosine_hemisphere`] over solid angle.
#[inline]
pub(super) fn cosine_pdf(w: DVec3) -> f64 {
    w.z * FRAC_1_PI
}

/// Cosine-weighted direction above the surface.
#[inline]
pub(crate) fn cosine_hemisphere(u: [f64; 2]) -> DVec3 {
    cosine_hemisphere_lanes(u).into()
}

/// Cosine-weighted directions above the surface, for one number or for lanes: points of the unit disk, projected to the hemisphere (Malley
/// 1988). The concentric map of the square to the disk keeps neighbours together (Shirley, Chiu 1997).
#[inline(always)]
pub(crate) fn cosine_hemisphere_lanes<R: Float64>([u, v]: [R; 2]) -> Vector3<R> {
    let (zero, one) = (u.splat(0.0), u.splat(1.0));
    let (x, y) = (u * 2.0 - 1.0, v * 2.0 - 1.0);
    let is_steep = y.abs().lt(x.abs());
    let radius = R::select(is_steep, x, y);
    let slope = R::select(is_steep, y, x) / radius * FRAC_PI_4;
    let angle = R::select(is_steep, slope, u.splat(FRAC_PI_2) - slope);
    let (sin, cos) = transcendental::sincos(angle);
    let height = ((one - radius) * (one + radius)).sqrt();
    let is_centre = x.eq(zero) & y.eq(zero);
    let at = |x: R| R::select(is_centre, zero, x);
    Vector3::new(at(radius * cos), at(radius * sin), height)
}
