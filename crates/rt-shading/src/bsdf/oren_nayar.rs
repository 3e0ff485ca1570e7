//! Rough diffuse reflection.

use super::{
    BsdfSample,
    lambert::{cosine_hemisphere, cosine_pdf},
    side::{Side, same_side},
};
use core::f64::consts::{FRAC_1_PI, PI};
use rt_math::{DVec3, Float64, Rgb, Vector3, transcendental};

/// The energy-preserving Oren–Nayar model of a rough diffuse surface.
///
/// Source: Portsmouth, Kutz, Hill, "EON: a practical energy-preserving rough diffuse BRDF", JCGT 14(1), 2025.
///
/// ```text
/// f  = ρ/π · A · (1 + r·s/t)  +  ρ'/π · A·r · (c₁ − g(wo)) · (c₁ − g(wi)) / (c₁ − c₂)
///
/// s  = wo·wi − cos cos       t = max(cos, cos) if s > 0, else 1        A  = 1 / (1 + c₁·r)
/// c₁ = 1/2 − 2/3π            c₂ = 2/3 − 28/15π                         ρ' = ρ²·Ē / (1 − ρ·(1 − Ē)),   Ē = A·(1 + c₂·r)
/// ```
///
/// The first term is single scattering (Fujii's form of Oren, Nayar 1994), of which a white surface reflects A·(1 + r·g)
/// and not 1. The second term is multiple scattering, which is multiplied by the albedo at each bounce. Roughness 0 is
/// Lambert's law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrenNayar {
    /// Single-scattering albedo, per channel in \[0, 1\].
    pub albedo: Rgb,
    /// Roughness r in \[0, 1\], to which it is clamped; NaN counts as 0.
    pub roughness: f64,
}

/// 1/A − 1 for r = 1.
const C1: f64 = 0.5 - 2.0 / (3.0 * PI);
/// Cosine-weighted mean of g over the hemisphere.
const C2: f64 = 2.0 / 3.0 - 28.0 / (15.0 * PI);

impl OrenNayar {
    /// Implements [`super::Bsdf::eval_with_pdf`]; the density is cos θ(wi) / π.
    pub fn eval_with_pdf(&self, wo: DVec3, wi: DVec3) -> (Rgb, f64) {
        same_side(wo, wi).map_or((Rgb::BLACK, 0.0), |(wo, wi)| (self.value(wo, wi), cosine_pdf(wi)))
    }

    /// Implements [`super::Bsdf::sample`].
    pub fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        let (wo, side) = Side::of(wo, u)?;
        let wi = cosine_hemisphere([u[1], u[2]]);
        BsdfSample { is_diffuse: true, ..BsdfSample::new(side.restore(wi), self.value(wo, wi), cosine_pdf(wi)) }
            .if_finite()
    }

    /// f for two directions above the surface.
    fn value(&self, wo: DVec3, wi: DVec3) -> Rgb {
        let albedo = Vector3::from(DVec3::from(self.albedo.to_array()));
        let value = oren_nayar_lanes(albedo, self.clamped_roughness(), wo.into(), wi.into());
        DVec3::from(value).to_array().into()
    }

    /// Roughness in \[0, 1\].
    pub(crate) fn clamped_roughness(&self) -> f64 {
        if self.roughness > 0.0 { self.roughness.min(1.0) } else { 0.0 }
    }
}

/// f of [`OrenNayar`] for directions above the surface, for one number or for lanes. Roughness 0 has the bits of [`super::Lambert`].
#[inline(always)]
pub(crate) fn oren_nayar_lanes<R: Float64>(
    albedo: Vector3<R>,
    roughness: R,
    wo: Vector3<R>,
    wi: Vector3<R>,
) -> Vector3<R> {
    let (one, c1) = (roughness.splat(1.0), roughness.splat(C1));
    let s = wo.x * wi.x + wo.y * wi.y;
    let s_over_t = R::select(s.gt(s.splat(0.0)), s / wo.z.max(wi.z), s);
    let a = (roughness * C1 + 1.0).recip();
    let single = a * (roughness * s_over_t + 1.0);
    let multiple = a * roughness * (c1 - groove(wo.z)) * (c1 - groove(wi.z)) / one.splat(C1 - C2);
    let mean = a * (roughness * C2 + 1.0);
    let again = albedo.scaled_by(albedo) * mean;
    let rest = Vector3::new(one, one, one) - albedo * (one - mean);
    let again = Vector3::new(again.x / rest.x, again.y / rest.y, again.z / rest.z);
    (albedo * single + again * multiple) * one.splat(FRAC_1_PI)
}

/// g(θ) = (sin θ · (θ − sin θ cos θ) + ⅔ · tan θ · (1 − sin³ θ) − ⅔ · sin θ) / π, with the tangent cancelled.
#[inline(always)]
fn groove<R: Float64>(cos: R) -> R {
    let one = cos.splat(1.0);
    let cos = cos.min(one);
    let sin = ((one - cos) * (one + cos)).sqrt();
    let angle = transcendental::atan2(sin, cos);
    let tangent_term = sin * cos * (sin + 1.0 + sin * sin) / (sin + 1.0);
    (sin * (angle - sin * cos) + (tangent_term - sin) * (2.0 / 3.0)) * FRAC_1_PI
}
