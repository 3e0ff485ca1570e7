//! Rough diffuse reflection.

use super::{
    BsdfSample, Lambert, Scattering,
    lambert::{cosine_hemisphere, cosine_pdf},
    side::{Side, same_side},
};
use core::f64::consts::{FRAC_1_PI, PI};
use rt_math::{DVec3, Rgb, transcendental};

/// A diffuse surface of grooves, which looks flat like the moon: the energy-preserving model of Oren and Nayar ("EON";
/// Portsmouth, Kutz, Hill, "EON: a practical energy-preserving rough diffuse BRDF", JCGT 14(1), 2025).
///
/// ```text
/// f  = ρ/π · A · (1 + r·s/t)  +  ρ'/π · A·r · (c₁ − g(wo)) · (c₁ − g(wi)) / (c₁ − c₂)
///
/// s  = wo·wi − cos cos       t = max(cos, cos) if s > 0, else 1        A  = 1 / (1 + c₁·r)
/// c₁ = 1/2 − 2/3π            c₂ = 2/3 − 28/15π                         ρ' = ρ²·Ē / (1 − ρ·(1 − Ē)),   Ē = A·(1 + c₂·r)
/// ```
///
/// The first term is light that bounces once (Fujii's form of Oren, Nayar 1994), of which a white surface would reflect
/// A·(1 + r·g) and not 1; the second one is the rest, after more bounces, each of which takes the colour of the surface
/// again. With roughness 0 it is Lambert's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrenNayar {
    /// Part of the light that one bounce reflects, per channel in \[0, 1\].
    pub albedo: Rgb,
    /// Roughness r in \[0, 1\]; what is out of it is taken for the nearer end, NaN for 0.
    pub roughness: f64,
}

/// 1/A − 1 for r = 1: how much the grooves hide.
const C1: f64 = 0.5 - 2.0 / (3.0 * PI);
/// The mean of g over the hemisphere, by the cosine.
const C2: f64 = 2.0 / 3.0 - 28.0 / (15.0 * PI);

impl OrenNayar {
    /// As [`super::Bsdf::eval`].
    pub fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        same_side(wo, wi).map_or(Rgb::BLACK, |(wo, wi)| self.value(wo, wi))
    }

    /// As [`super::Bsdf::pdf`]: cos θ(wi) / π.
    pub fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        Lambert { albedo: self.albedo }.pdf(wo, wi)
    }

    /// As [`super::Bsdf::sample`].
    pub fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        let (wo, side) = Side::of(wo, u)?;
        let wi = cosine_hemisphere([u[1], u[2]]);
        BsdfSample {
            wi: side.restore(wi),
            value: self.value(wo, wi),
            pdf: cosine_pdf(wi),
            kind: Scattering::Reflection,
            is_delta: false,
            is_diffuse: true,
            eta: 1.0,
        }
        .if_finite()
    }

    /// f of two directions above the surface.
    fn value(&self, wo: DVec3, wi: DVec3) -> Rgb {
        let roughness = if self.roughness > 0.0 { self.roughness.min(1.0) } else { 0.0 };
        let s = wo.x * wi.x + wo.y * wi.y;
        let s_over_t = if s > 0.0 { s / wo.z.max(wi.z) } else { s };
        let a = 1.0 / (1.0 + C1 * roughness);
        let once = a * (1.0 + roughness * s_over_t);
        let hidden = a * roughness * (C1 - groove(wo.z)) * (C1 - groove(wi.z)) / (C1 - C2);
        let mean = a * (1.0 + C2 * roughness);
        self.albedo.map(|albedo| {
            let again = albedo * albedo * mean / (1.0 - albedo * (1.0 - mean));
            (albedo * once + again * hidden) * FRAC_1_PI
        })
    }
}

/// g(θ) = (sin θ · (θ − sin θ cos θ) + ⅔ · tan θ · (1 − sin³ θ) − ⅔ · sin θ) / π, in which the tangent is cancelled.
fn groove(cos: f64) -> f64 {
    let cos = cos.min(1.0);
    let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
    let angle = transcendental::atan2(sin, cos);
    let tangent_term = sin * cos * (1.0 + sin + sin * sin) / (1.0 + sin);
    (sin * (angle - sin * cos) + 2.0 / 3.0 * (tangent_term - sin)) * FRAC_1_PI
}
