//! The highlight of Phong, as a BSDF.

use super::{
    BsdfSample, Scattering,
    side::{Side, reflect_dir, same_side},
};
use core::f64::consts::TAU;
use rt_math::{DVec3, Frame, Rgb, transcendental};

/// A lobe around the mirrored direction: f = reflectance · (n + 2)/2π · cosⁿ α, where α is the angle to it (Phong 1975, as
/// Lafortune and Willems 1994 made it reciprocal and bounded).
///
/// A lobe of reflectance 1 reflects all light that comes along the normal and less of what comes from aside, as part of the
/// lobe is then below the surface: about 1/√2 at 45° for sharp ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhongLobe {
    /// Part of light along the normal that is reflected, per channel in \[0, 1\].
    pub reflectance: Rgb,
    /// Exponent n in [0, 10¹²]; what is out of it is taken for the nearer end, NaN for 0.
    pub exponent: f64,
}

/// Beyond it the lobe is narrower than a millionth of a radian, and the cosine has too few digits for it.
const SHARPEST: f64 = 1e12;

impl PhongLobe {
    /// As [`super::Bsdf::eval`].
    pub fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        self.eval_with_pdf(wo, wi).0
    }

    /// As [`super::Bsdf::pdf`]: (n + 1)/2π · cosⁿ α. It lacks what is below the surface.
    pub fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.eval_with_pdf(wo, wi).1
    }

    /// As [`super::Bsdf::eval_with_pdf`].
    pub fn eval_with_pdf(&self, wo: DVec3, wi: DVec3) -> (Rgb, f64) {
        same_side(wo, wi).map_or((Rgb::BLACK, 0.0), |(wo, wi)| self.value_with_density(reflect_dir(wo).dot(wi)))
    }

    /// As [`super::Bsdf::sample`]; `None` for directions below the surface.
    pub fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        let (wo, side) = Side::of(wo, u)?;
        let cos = transcendental::pow(u[1], 1.0 / (self.exponent() + 1.0));
        let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
        let (sin_phi, cos_phi) = transcendental::sincos(TAU * u[2]);
        let wi = Frame::from_z(reflect_dir(wo)).from_local(DVec3::new(sin * cos_phi, sin * sin_phi, cos)).normalize();
        if !(wi.z > 0.0) {
            return None;
        }
        let (value, pdf) = self.value_with_density(reflect_dir(wo).dot(wi));
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
        if self.exponent > 0.0 { self.exponent.min(SHARPEST) } else { 0.0 }
    }

    fn value_with_density(&self, cos: f64) -> (Rgb, f64) {
        let (n, power) = (self.exponent(), self.power(cos));
        (self.reflectance * ((n + 2.0) / TAU * power), (n + 1.0) / TAU * power)
    }

    /// cosⁿ, 0 behind the lobe.
    fn power(&self, cos: f64) -> f64 {
        if cos > 0.0 { transcendental::pow(cos.min(1.0), self.exponent()) } else { 0.0 }
    }
}
