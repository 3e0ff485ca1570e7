//! The highlight of Phong as a lobe of a BSDF.

use super::{
    BsdfSample, Scattering,
    side::{Side, reflect_dir, same_side},
};
use core::f64::consts::TAU;
use rt_math::{DVec3, Frame, Rgb, transcendental};

/// Lobe around the mirrored direction: f = reflectance · (n + 2)/2π · cosⁿ α, where α is the angle to it.
///
/// Phong 1975, in the reciprocal and bounded form of Lafortune and Willems 1994. A lobe of reflectance 1 reflects all light
/// at normal incidence. At 45° it reflects about 1/√2 if the exponent is high, since part of the lobe is below the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhongLobe {
    /// Albedo at normal incidence, per channel in \[0, 1\].
    pub reflectance: Rgb,
    /// Exponent n in [0, 10¹²], to which it is clamped; NaN counts as 0.
    pub exponent: f64,
}

/// Maximum exponent: the lobe is a millionth of a radian wide, near the resolution of the cosine.
const MAX_EXPONENT: f64 = 1e12;

impl PhongLobe {
    /// Implements [`super::Bsdf::eval`].
    pub fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        self.eval_with_pdf(wo, wi).0
    }

    /// Implements [`super::Bsdf::pdf`]: (n + 1)/2π · cosⁿ α. The part below the surface is missing.
    pub fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.eval_with_pdf(wo, wi).1
    }

    /// Implements [`super::Bsdf::eval_with_pdf`].
    pub fn eval_with_pdf(&self, wo: DVec3, wi: DVec3) -> (Rgb, f64) {
        same_side(wo, wi).map_or((Rgb::BLACK, 0.0), |(wo, wi)| self.value_with_pdf(reflect_dir(wo).dot(wi)))
    }

    /// Implements [`super::Bsdf::sample`]; `None` for directions below the surface.
    pub fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        let (wo, side) = Side::of(wo, u)?;
        let cos = transcendental::pow(u[1], 1.0 / (self.exponent() + 1.0));
        let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
        let (sin_phi, cos_phi) = transcendental::sincos(TAU * u[2]);
        let wi = Frame::from_z(reflect_dir(wo)).from_local(DVec3::new(sin * cos_phi, sin * sin_phi, cos)).normalize();
        if !(wi.z > 0.0) {
            return None;
        }
        let (value, pdf) = self.value_with_pdf(reflect_dir(wo).dot(wi));
        BsdfSample {
            wi: side.restore(wi),
            value,
            pdf,
            kind: Scattering::Reflection,
            is_delta: false,
            is_diffuse: false,
            eta: 1.0,
        }
        .if_finite()
    }

    fn exponent(&self) -> f64 {
        if self.exponent > 0.0 { self.exponent.min(MAX_EXPONENT) } else { 0.0 }
    }

    fn value_with_pdf(&self, cos: f64) -> (Rgb, f64) {
        let (n, power) = (self.exponent(), self.power(cos));
        (self.reflectance * ((n + 2.0) / TAU * power), (n + 1.0) / TAU * power)
    }

    /// cosⁿ, 0 behind the lobe.
    fn power(&self, cos: f64) -> f64 {
        if cos > 0.0 { transcendental::pow(cos.min(1.0), self.exponent()) } else { 0.0 }
    }
}
