//! The material of glTF.

use super::{
    BsdfSample, Ggx, Scattering,
    lambert::{cosine_hemisphere, cosine_pdf},
    side::{Side, mirrored, same_side},
};
use crate::optics;
use core::f64::consts::FRAC_1_PI;
use rt_math::{DVec3, Rgb};

/// The metallic-roughness material as the equations of glTF 2.0 state it, appendix B.3.
///
/// ```text
/// α = roughness²     m = wo + wi, normalised     w = (1 − |wo·m|)⁵                   Schlick 1994
///
/// dielectric = mix(baseColor / π, D·G₂ / (4 cos cos), 0.04 + 0.96 w)
/// metal      = (baseColor + (1 − baseColor) w) · D·G₂ / (4 cos cos)
/// f          = mix(dielectric, metal, metallic)
/// ```
///
/// The specification says of this mix that it is simple and breaks the conservation of energy: the diffuse part keeps its
/// light at grazing angles, where the layer above reflects nearly all. White plastic of roughness 0.3 reflects 1.0010 of
/// the light that comes at 45°, 1.149 at 75°, and 1.357 at 89°. Metal and dark plastic never reflect more than 1.
///
/// Smooth surfaces reflect into a single direction, beside the diffuse part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MetallicRoughness {
    /// Albedo of the diffuse part, or reflectance of the metal along the normal, per channel in \[0, 1\].
    pub base_color: Rgb,
    /// 0 for a dielectric, 1 for metal; what is out of it is taken for the nearer end, NaN for 0.
    pub metallic: f64,
    /// Roughness in \[0, 1\], as in [`Ggx::from_roughness`].
    pub roughness: f64,
}

/// Reflectance along the normal of a dielectric of index 1.5.
const DIELECTRIC_F0: f64 = 0.04;

impl MetallicRoughness {
    /// As [`super::Bsdf::eval`].
    pub fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        same_side(wo, wi).map_or(Rgb::BLACK, |(wo, wi)| self.value(wo, wi, (wo + wi).normalize_or(DVec3::Z)))
    }

    /// As [`super::Bsdf::pdf`].
    pub fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        same_side(wo, wi).map_or(0.0, |(wo, wi)| self.density(wo, wi, (wo + wi).normalize_or(DVec3::Z)))
    }

    /// As [`super::Bsdf::sample`].
    pub fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        let (wo, side) = Side::of(wo, u)?;
        let chance = self.chance_of_specular(wo.z);
        let facets = Ggx::from_roughness(self.roughness);
        let (wi, m) = if u[0] < chance {
            let Some(facets) = facets else {
                return self.mirrored(wo, side, chance);
            };
            let m = facets.sample(wo, [u[1], u[2]]);
            (optics::reflect(-wo, m), m)
        } else {
            let wi = cosine_hemisphere([u[1], u[2]]);
            (wi, (wo + wi).normalize_or(DVec3::Z))
        };
        if !(wi.z > 0.0) {
            return None;
        }
        BsdfSample {
            wi: side.restore(wi),
            value: self.value(wo, wi, m),
            pdf: self.density(wo, wi, m),
            kind: Scattering::Reflection,
            is_delta: false,
            eta: 1.0,
        }
        .if_finite()
    }

    fn mirrored(&self, wo: DVec3, side: Side, chance: f64) -> Option<BsdfSample> {
        BsdfSample {
            wi: side.restore(mirrored(wo)),
            value: self.specular(wo.z) / wo.z,
            pdf: chance,
            kind: Scattering::Reflection,
            is_delta: true,
            eta: 1.0,
        }
        .if_finite()
    }

    fn metallic(&self) -> f64 {
        if self.metallic > 0.0 { self.metallic.min(1.0) } else { 0.0 }
    }

    /// What facets reflect at the angle of the cosine to them.
    fn specular(&self, cos: f64) -> Rgb {
        let w = schlick_weight(cos);
        let metallic = self.metallic();
        let dielectric = DIELECTRIC_F0 + (1.0 - DIELECTRIC_F0) * w;
        self.base_color.map(|f0| (1.0 - metallic) * dielectric + metallic * (f0 + (1.0 - f0) * w))
    }

    /// Albedo of the diffuse part below facets at the angle of the cosine to them.
    fn diffuse(&self, cos: f64) -> Rgb {
        self.base_color * ((1.0 - self.metallic()) * (1.0 - DIELECTRIC_F0) * (1.0 - schlick_weight(cos)))
    }

    /// How often `sample` chooses a facet: as much of the light as a smooth surface would reflect at this angle.
    fn chance_of_specular(&self, cos: f64) -> f64 {
        let (specular, diffuse) = (self.specular(cos).max_component(), self.diffuse(cos).max_component());
        if diffuse > 0.0 { specular / (specular + diffuse) } else { 1.0 }
    }

    fn value(&self, wo: DVec3, wi: DVec3, m: DVec3) -> Rgb {
        let cos = wo.dot(m);
        let facets = Ggx::from_roughness(self.roughness).map_or(0.0, |facets| facets.reflection(wo, wi, m));
        self.diffuse(cos) * FRAC_1_PI + self.specular(cos) * facets
    }

    fn density(&self, wo: DVec3, wi: DVec3, m: DVec3) -> f64 {
        let chance = self.chance_of_specular(wo.z);
        let facets = Ggx::from_roughness(self.roughness).map_or(0.0, |facets| facets.reflection_pdf(wo, m));
        chance * facets + (1.0 - chance) * cosine_pdf(wi)
    }
}

/// (1 − cos)⁵.
fn schlick_weight(cos: f64) -> f64 {
    let x = 1.0 - cos.clamp(0.0, 1.0);
    x * x * x * x * x
}
