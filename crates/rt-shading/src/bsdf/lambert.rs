//! Lambertian reflection.

use super::{
    BsdfSample, Scattering,
    side::{Side, same_side},
};
use core::f64::consts::{FRAC_1_PI, FRAC_PI_2, FRAC_PI_4};
use rt_math::{DVec3, Rgb, transcendental};

/// Lambertian reflection: f = albedo / π (Lambert 1760).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lambert {
    /// Albedo, per channel in \[0, 1\].
    pub albedo: Rgb,
}

impl Lambert {
    /// Implements [`super::Bsdf::eval`].
    #[inline]
    pub fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        same_side(wo, wi).map_or(Rgb::BLACK, |_| self.albedo * FRAC_1_PI)
    }

    /// Implements [`super::Bsdf::pdf`]: cos θ(wi) / π.
    #[inline]
    pub fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        same_side(wo, wi).map_or(0.0, |(_, wi)| cosine_pdf(wi))
    }

    /// Implements [`super::Bsdf::sample`]; the weight is the albedo.
    #[inline]
    pub fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        let (_, side) = Side::of(wo, u)?;
        let wi = cosine_hemisphere([u[1], u[2]]);
        BsdfSample {
            wi: side.restore(wi),
            value: self.albedo * FRAC_1_PI,
            pdf: cosine_pdf(wi),
            kind: Scattering::Reflection,
            is_delta: false,
            is_diffuse: true,
            eta: 1.0,
        }
        .if_finite()
    }
}

/// Density of [`cosine_hemisphere`] over solid angle.
#[inline]
pub(super) fn cosine_pdf(w: DVec3) -> f64 {
    w.z * FRAC_1_PI
}

/// Cosine-weighted direction above the surface: a point of the unit disk, projected to the hemisphere (Malley 1988). The
/// concentric map of the square to the disk keeps neighbours together (Shirley, Chiu 1997).
#[inline]
pub(crate) fn cosine_hemisphere(u: [f64; 2]) -> DVec3 {
    let [x, y] = u.map(|u| 2.0 * u - 1.0);
    if x == 0.0 && y == 0.0 {
        return DVec3::Z;
    }
    let (radius, angle) =
        if x.abs() > y.abs() { (x, FRAC_PI_4 * (y / x)) } else { (y, FRAC_PI_2 - FRAC_PI_4 * (x / y)) };
    let (sin, cos) = transcendental::sincos(angle);
    DVec3::new(radius * cos, radius * sin, ((1.0 - radius) * (1.0 + radius)).sqrt())
}
