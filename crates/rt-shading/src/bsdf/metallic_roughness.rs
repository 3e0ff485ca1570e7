//! The metallic-roughness BSDF of glTF.

use super::{
    BsdfSample, Ggx,
    albedo_table::LayerAlbedo,
    lambert::{cosine_hemisphere, cosine_pdf},
    mirror,
    schlick::{dielectric_fresnel, schlick_weight},
    side::{Side, same_side},
};
use crate::optics;
use core::f64::consts::FRAC_1_PI;
use rt_math::{DVec3, Rgb};

/// The metallic-roughness BSDF of glTF 2.0, appendix B.
///
/// ```text
/// α = roughness²     m = wo + wi, normalised     w = (1 − |wo·m|)⁵                   Schlick 1994
///
/// dielectric = passes · baseColor / π + (0.04 + 0.96 w) · D·G₂ / (4 cos cos)
/// metal      = (baseColor + (1 − baseColor) w) · D·G₂ / (4 cos cos)
/// f          = mix(dielectric, metal, metallic)
/// ```
///
/// The layer passes (1 − E(wo)) · (1 − E(wi)) / (1 − Ē) to the base, with its directional albedo E and the mean Ē of E. The specification
/// recommends this (Kulla, Conty 2017). The albedo of white plastic is 1 ± 0.001 at all angles; with the 1 − F of appendix B.3 it would be
/// up to 1.36. Smooth surfaces have a delta lobe and a diffuse lobe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MetallicRoughness {
    /// Albedo of the diffuse lobe, or reflectance of the metal at normal incidence, per channel in \[0, 1\].
    pub base_color: Rgb,
    /// 0 for a dielectric, 1 for metal; clamped to \[0, 1\], NaN counts as 0.
    pub metallic: f64,
    /// Roughness in \[0, 1\], as in [`Ggx::from_roughness`].
    pub roughness: f64,
}

impl MetallicRoughness {
    /// Implements [`super::Bsdf::eval_with_pdf`].
    pub fn eval_with_pdf(&self, wo: DVec3, wi: DVec3) -> (Rgb, f64) {
        let Some((wo, wi)) = same_side(wo, wi) else { return (Rgb::BLACK, 0.0) };
        let m = (wo + wi).normalize_or(DVec3::Z);
        (self.value(wo, wi, m), self.density(wo, wi, m))
    }

    /// Implements [`super::Bsdf::sample`].
    pub fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        let (wo, side) = Side::of(wo, u)?;
        let chance = self.specular_probability(wo.z);
        let facets = Ggx::from_roughness(self.roughness);
        let (wi, m) = if u[0] < chance {
            let Some(facets) = facets else {
                return mirror::reflection(wo, side, self.specular(wo.z), chance);
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
            is_diffuse: u[0] >= chance,
            ..BsdfSample::new(side.restore(wi), self.value(wo, wi, m), self.density(wo, wi, m))
        }
        .if_finite()
    }

    /// Metallic part, in \[0, 1\].
    pub(super) fn clamped_metallic(&self) -> f64 {
        if self.metallic > 0.0 { self.metallic.min(1.0) } else { 0.0 }
    }

    /// Reflectance of the microfacets at a cosine.
    fn specular(&self, cos: f64) -> Rgb {
        let w = schlick_weight(cos);
        let metallic = self.clamped_metallic();
        self.base_color.map(|f0| (1.0 - metallic) * dielectric_fresnel(cos) + metallic * (f0 + (1.0 - f0) * w))
    }

    /// Albedo of the diffuse lobe below the layer.
    fn diffuse(&self, wo: DVec3, wi: DVec3) -> Rgb {
        let dielectric = 1.0 - self.clamped_metallic();
        if dielectric == 0.0 {
            return Rgb::BLACK;
        }
        let layer = LayerAlbedo::new(self.roughness);
        let passes = |cos| 1.0 - layer.directional(cos);
        self.base_color * (dielectric * (passes(wo.z) * passes(wi.z) / (1.0 - layer.mean())))
    }

    /// Probability with which `sample` chooses the specular lobe: its part of the albedo.
    fn specular_probability(&self, cos: f64) -> f64 {
        let metallic = self.clamped_metallic();
        if metallic == 1.0 {
            return 1.0;
        }
        let layer = LayerAlbedo::new(self.roughness).directional(cos);
        let specular = (1.0 - metallic) * layer + metallic * self.base_color.max_component();
        let diffuse = (1.0 - metallic) * (1.0 - layer) * self.base_color.max_component();
        if diffuse > 0.0 { specular / (specular + diffuse) } else { 1.0 }
    }

    fn value(&self, wo: DVec3, wi: DVec3, m: DVec3) -> Rgb {
        let facets = Ggx::from_roughness(self.roughness).map_or(0.0, |facets| facets.reflection(wo, wi, m));
        self.diffuse(wo, wi) * FRAC_1_PI + self.specular(wo.dot(m)) * facets
    }

    fn density(&self, wo: DVec3, wi: DVec3, m: DVec3) -> f64 {
        let chance = self.specular_probability(wo.z);
        let facets = Ggx::from_roughness(self.roughness).map_or(0.0, |facets| facets.reflection_pdf(wo, m));
        chance * facets + (1.0 - chance) * cosine_pdf(wi)
    }
}
