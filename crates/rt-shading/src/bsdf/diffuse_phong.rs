//! A diffuse lobe with a Phong lobe, as classical materials have them, also for lanes.

use super::{
    Bxdf, Mix, OrenNayar, PhongLobe,
    lambert::cosine_hemisphere_lanes,
    oren_nayar::oren_nayar_lanes,
    phong_lobe::{phong_direction_lanes, phong_lobe_lanes, reflect_dir_lanes},
};
use crate::wavefront::is_in_range;
use core::f64::consts::FRAC_1_PI;
use rt_math::{Float64, Mask, Vector3};

/// Largest exponent in lanes: the power multiplies the rounding error of the cosine by it.
const MAX_EXPONENT: f64 = 1000.0;

/// Diffuse lobe, and a Phong lobe if there is one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DiffusePhong {
    pub(crate) diffuse: OrenNayar,
    pub(crate) highlight: Option<WeightedPhong>,
}

/// Phong lobe in a [`Mix`] with a diffuse lobe. Weights and probabilities are of the diffuse lobe and the Phong lobe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct WeightedPhong {
    pub(crate) lobe: PhongLobe,
    pub(crate) weights: [f64; 2],
    /// Probabilities of the lobes when both are sampled, not 0.
    pub(crate) probabilities: [f64; 2],
}

impl DiffusePhong {
    /// A diffuse lobe alone.
    pub(crate) const fn diffuse(diffuse: OrenNayar) -> Self {
        Self { diffuse, highlight: None }
    }

    /// True if all parameters are in the usual range of `f32`, and the highlight is wide enough for directions in it.
    pub(crate) fn is_usual(&self) -> bool {
        let is_usual =
            |phong: WeightedPhong| is_in_range(phong.lobe.reflectance) && phong.lobe.clamped_exponent() <= MAX_EXPONENT;
        is_in_range(self.diffuse.albedo) && self.highlight.is_none_or(is_usual)
    }

    /// The lobes of a mix, if it has these alone, in this order, and samples both.
    pub(super) fn of_mix(mix: &Mix) -> Option<Self> {
        let &[(diffuse_weight, diffuse), (phong_weight, Bxdf::Phong(lobe))] = mix.lobes() else { return None };
        let probabilities = *mix.probabilities().first_chunk()?;
        let highlight = WeightedPhong { lobe, weights: [diffuse_weight, phong_weight], probabilities };
        let samples_both = probabilities.iter().all(|&probability| probability > 0.0);
        samples_both.then_some(Self { diffuse: diffuse.as_diffuse()?, highlight: Some(highlight) })
    }
}

/// Lobes of a [`DiffusePhong`] with a highlight, for one number or for lanes.
#[derive(Clone, Copy)]
pub(crate) struct DiffusePhongLanes<R: Float64> {
    pub(crate) albedo: Vector3<R>,
    pub(crate) roughness: R,
    pub(crate) reflectance: Vector3<R>,
    /// [Exponent](PhongLobe::exponent) within its bounds.
    pub(crate) exponent: R,
    pub(crate) weights: [R; 2],
    pub(crate) probabilities: [R; 2],
}

/// Values of the two lobes, without the cosine, and densities of their samples.
pub(crate) struct LobeValues<R: Float64> {
    pub(crate) diffuse: Vector3<R>,
    pub(crate) phong: Vector3<R>,
    pub(crate) diffuse_pdf: R,
    pub(crate) phong_pdf: R,
}

impl<R: Float64> DiffusePhongLanes<R> {
    /// Weighted values and densities for directions above the surface.
    #[inline(always)]
    pub(crate) fn values(&self, wo: Vector3<R>, wi: Vector3<R>) -> LobeValues<R> {
        let (phong, phong_pdf) = phong_lobe_lanes(self.reflectance, self.exponent, reflect_dir_lanes(wo).dot(wi));
        LobeValues {
            diffuse: self.diffuse_value(wo, wi) * self.weights[0],
            phong: phong * self.weights[1],
            diffuse_pdf: wi.z * FRAC_1_PI,
            phong_pdf,
        }
    }

    /// Value of the diffuse lobe without its weight, for directions above the surface. What is 0 without roughness is skipped.
    #[inline(always)]
    pub(crate) fn diffuse_value(&self, wo: Vector3<R>, wi: Vector3<R>) -> Vector3<R> {
        if self.roughness.gt(wo.z.splat(0.0)).any() {
            oren_nayar_lanes(self.albedo, self.roughness, wo, wi)
        } else {
            self.albedo * wo.z.splat(FRAC_1_PI)
        }
    }

    /// Density of the samples of both lobes.
    #[inline(always)]
    pub(crate) fn pdf(&self, values: &LobeValues<R>) -> R {
        self.probabilities[0] * values.diffuse_pdf + self.probabilities[1] * values.phong_pdf
    }

    /// True where the number chooses the diffuse lobe.
    #[inline(always)]
    pub(crate) fn chooses_diffuse(&self, u: R) -> R::Mask {
        (u / self.probabilities[0]).lt(u.splat(1.0))
    }

    /// Directions sampled from one of the lobes.
    #[inline(always)]
    pub(crate) fn sample(&self, wo: Vector3<R>, is_diffuse: R::Mask, u: [R; 2]) -> Vector3<R> {
        if is_diffuse.all() {
            return cosine_hemisphere_lanes(u);
        }
        let around_mirrored = phong_direction_lanes(self.exponent, wo, u);
        if is_diffuse.any() {
            Vector3::select(is_diffuse, cosine_hemisphere_lanes(u), around_mirrored)
        } else {
            around_mirrored
        }
    }
}
