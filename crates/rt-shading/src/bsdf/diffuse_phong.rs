//! A diffuse lobe with a Phong lobe, as classical materials have them, also for lanes.

use super::{
    Bxdf, LaneSample, Mix, OrenNayar, PhongLobe,
    lambert::cosine_hemisphere_lanes,
    oren_nayar::oren_nayar_lanes,
    phong_lobe::{phong_direction_lanes, phong_lobe_lanes, reflect_dir_lanes},
};
use crate::{
    lane_set::{LaneSet, set_color},
    lanes::{LANES, LaneArray},
    wavefront::is_in_range,
};
use core::f64::consts::FRAC_1_PI;
use rt_math::{Float64, Mask, Real, Rgb, Vector3};

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

    /// True if all reflectances are in range ([`is_in_range`]), and the highlight is wide enough for directions in `f32`.
    pub(crate) fn fits_f32(&self) -> bool {
        let highlight_fits_f32 =
            |phong: WeightedPhong| is_in_range(phong.lobe.reflectance) && phong.lobe.clamped_exponent() <= MAX_EXPONENT;
        is_in_range(self.diffuse.albedo) && self.highlight.is_none_or(highlight_fits_f32)
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

/// A diffuse lobe, a Phong lobe, or both, and a mirror that is sampled after them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MirrorMix {
    /// A missing lobe is black, and its probability 0.
    pub(crate) lobes: DiffusePhong,
    /// Reflectance of the mirror, with its weight in the mix.
    pub(crate) reflectance: Rgb,
    /// Probability of the mirror when all lobes are sampled, not 0.
    pub(crate) probability: f64,
}

impl MirrorMix {
    /// The lobes of a mix, if it has these alone, in this order, and can be shaded in lanes.
    pub(super) fn of_mix(mix: &Mix) -> Option<Self> {
        let (&(mirror_weight, Bxdf::Mirror(mirror)), others) = mix.lobes().split_last()? else { return None };
        let (&probability, of_others) = mix.probabilities().split_last()?;
        let mut diffuse = OrenNayar { albedo: Rgb::BLACK, roughness: 0.0 };
        let mut lobe = PhongLobe { reflectance: Rgb::BLACK, exponent: 1.0 };
        let (mut weights, mut probabilities) = ([0.0; 2], [0.0; 2]);
        let part = match others {
            [(_, Bxdf::Phong(phong))] => {
                lobe = *phong;
                1
            }
            [(_, other)] => {
                diffuse = other.as_diffuse()?;
                0
            }
            [(_, first), (_, Bxdf::Phong(phong))] => {
                (diffuse, lobe) = (first.as_diffuse()?, *phong);
                0
            }
            _ => return None,
        };
        for (at, ((weight, _), of_lobe)) in (part..).zip(others.iter().zip(of_others)) {
            (weights[at], probabilities[at]) = (*weight, *of_lobe);
        }
        let lobes = DiffusePhong { diffuse, highlight: Some(WeightedPhong { lobe, weights, probabilities }) };
        let reflectance = mirror.reflectance * mirror_weight;
        let is_sampled = probability > 0.0 && of_others.iter().all(|&probability| probability > 0.0);
        let fits_f32 = lobes.fits_f32() && is_in_range(reflectance);
        (is_sampled && fits_f32).then_some(Self { lobes, reflectance, probability })
    }
}

/// Parameters of the mirrors of eight [`MirrorMix`]es.
#[derive(Clone, Debug, Default)]
pub(crate) struct MirrorBlock {
    /// Lanes with a mirror.
    pub(crate) all: u8,
    reflectance: [LaneArray; 3],
    probability: LaneArray,
}

impl MirrorBlock {
    /// Sets the mirror of one lane, once.
    pub(crate) fn set(&mut self, lane: usize, mix: &MirrorMix) {
        self.all |= 1 << lane;
        set_color(&mut self.reflectance, lane, mix.reflectance);
        self.probability[lane % LANES] = mix.probability;
    }
}

/// Mirrors next to the lobes of [`DiffusePhongLanes`].
pub(crate) struct MirrorLanes<L: LaneSet> {
    lanes: L,
    all: u8,
    reflectance: Vector3<L::D>,
    probability: L::D,
}

impl<L: LaneSet> MirrorLanes<L> {
    #[inline(always)]
    pub(crate) fn new(lanes: L, block: &MirrorBlock) -> Self {
        let reflectance = lanes.load_coordinates(&block.reflectance);
        Self { lanes, all: block.all, reflectance, probability: lanes.load_f64(&block.probability) }
    }

    /// Probability of the Phong lobe where it and the mirror alone are sampled; 1 in lanes without a mirror.
    #[inline(always)]
    pub(crate) fn phong_probability(&self, lobes: &DiffusePhongLanes<L::D>) -> L::D {
        let phong = lobes.probabilities[1];
        let one = self.lanes.splat_f64(1.0);
        Real::select(self.lanes.mask_f64(self.all), phong / (phong + self.probability), one)
    }

    /// Replaces samples of the other lobes by mirrored directions where the number chooses these. Diffuse lobes are sampled as well unless
    /// `phong_probability` is given.
    #[inline(always)]
    pub(crate) fn replace(
        &self,
        (lobes, wo): (&DiffusePhongLanes<L::D>, Vector3<L::D>),
        u_lobe: L::D,
        phong_probability: Option<L::D>,
        sample: &mut LaneSample<L>,
    ) {
        let lanes = self.lanes;
        let one = lanes.splat_f64(1.0);
        let [of_diffuse, of_phong] = lobes.probabilities;
        let (within, pdf) = match phong_probability {
            Some(of_phong) => (u_lobe / of_phong, one - of_phong),
            None => ((u_lobe - of_diffuse) / of_phong, self.probability),
        };
        let chosen = self.all & !sample.diffuse & !lanes.bits_f64(within.lt(one));
        let is_mirror = lanes.mask_f64(chosen);
        sample.wi = Vector3::select(is_mirror, reflect_dir_lanes(wo), sample.wi);
        sample.weight = Vector3::select(is_mirror, self.reflectance / pdf, sample.weight);
        sample.pdf = Real::select(is_mirror, pdf, sample.pdf);
        sample.valid |= chosen;
        sample.delta |= chosen;
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
