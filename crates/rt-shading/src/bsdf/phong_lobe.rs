//! The highlight of Phong as a lobe of a BSDF.

use super::{
    BsdfSample,
    side::{Side, reflect_dir, same_side},
};
use core::f64::consts::TAU;
use rt_math::{DVec3, Float64, Rgb, Vector3, tangents, transcendental};

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
    /// Implements [`super::Bsdf::eval_with_pdf`]; the density is (n + 1)/2π · cosⁿ α. The part below the surface is missing.
    pub fn eval_with_pdf(&self, wo: DVec3, wi: DVec3) -> (Rgb, f64) {
        same_side(wo, wi).map_or((Rgb::BLACK, 0.0), |(wo, wi)| self.value_with_pdf(reflect_dir(wo).dot(wi)))
    }

    /// Implements [`super::Bsdf::sample`]; `None` for directions below the surface.
    pub fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        let (wo, side) = Side::of(wo, u)?;
        let wi = DVec3::from(phong_direction_lanes(self.clamped_exponent(), wo.into(), [u[1], u[2]]));
        if !(wi.z > 0.0) {
            return None;
        }
        let (value, pdf) = self.value_with_pdf(reflect_dir(wo).dot(wi));
        BsdfSample::new(side.restore(wi), value, pdf).if_finite()
    }

    /// Exponent within its bounds.
    pub(crate) fn clamped_exponent(&self) -> f64 {
        if self.exponent > 0.0 { self.exponent.min(MAX_EXPONENT) } else { 0.0 }
    }

    fn value_with_pdf(&self, cos: f64) -> (Rgb, f64) {
        let reflectance = Vector3::from(DVec3::from(self.reflectance.to_array()));
        let (value, pdf) = phong_lobe_lanes(reflectance, self.clamped_exponent(), cos);
        (DVec3::from(value).to_array().into(), pdf)
    }
}

/// Value and density of a [`PhongLobe`], given the cosine of α, for one number or for lanes.
#[inline(always)]
pub(super) fn phong_lobe_lanes<R: Float64>(reflectance: Vector3<R>, exponent: R, cos: R) -> (Vector3<R>, R) {
    let (zero, one) = (cos.splat(0.0), cos.splat(1.0));
    // 0 behind the lobe.
    let is_before = cos.gt(zero);
    let power = transcendental::pow(R::select(is_before, cos.min(one), one), exponent);
    let power = R::select(is_before, power, zero);
    let turn = cos.splat(TAU);
    (reflectance * ((exponent + 2.0) / turn * power), (exponent + 1.0) / turn * power)
}

/// Directions sampled from Phong lobes of these exponents, for one number or for lanes. Some are below the surface.
#[inline(always)]
pub(super) fn phong_direction_lanes<R: Float64>(exponent: R, wo: Vector3<R>, [u, v]: [R; 2]) -> Vector3<R> {
    let one = u.splat(1.0);
    let cos = transcendental::pow(u, one / (exponent + 1.0));
    let sin = ((one - cos) * (one + cos)).sqrt();
    let (sin_phi, cos_phi) = transcendental::sincos(v * TAU);
    let axis = reflect_dir_lanes(wo);
    let [tangent, bitangent] = tangents(axis);
    (tangent * (sin * cos_phi) + bitangent * (sin * sin_phi) + axis * cos).try_normalize().0
}

/// Version of [`reflect_dir`] for one number or for lanes.
#[inline(always)]
pub(super) fn reflect_dir_lanes<R: Float64>(w: Vector3<R>) -> Vector3<R> {
    Vector3::new(-w.x, -w.y, w.z)
}
