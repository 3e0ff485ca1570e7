//! BSDFs of eight path vertices in lanes, one type for each queue of vertices.

use super::vertex_block::{Block, FollowedLobes};
use crate::{
    bsdf::{DiffusePhongLanes, MetallicRoughnessLanes, MetallicRoughnessSample, cosine_hemisphere_lanes},
    lanes::{LaneMask, Lanes, Simd},
    mis::power_heuristic,
};
use core::f64::consts::FRAC_1_PI;
use rt_math::{Real, Vector3};

/// BSDFs of eight vertices. All directions are above the surface.
pub(super) trait LaneBsdf<S: Simd>: Sized {
    /// BSDFs of the block, seen from `wo`.
    fn load(simd: S, block: &Block, wo: Vector3<Lanes<S>>) -> Self;

    /// Values without the cosine.
    fn eval(&self, wi: Vector3<Lanes<S>>) -> Vector3<Lanes<S>>;

    /// Values for light that is sampled with density `pdf`, with its MIS weight.
    fn eval_mis(&self, wi: Vector3<Lanes<S>>, pdf: Lanes<S>, lobes: FollowedLobes) -> Vector3<Lanes<S>>;

    /// Samples the next directions, by numbers for the choice of a lobe and for the direction. Not called for [`FollowedLobes::Nothing`].
    fn sample(&self, u_lobe: Lanes<S>, u: [Lanes<S>; 2], lobes: FollowedLobes) -> SampledLanes<S>;
}

/// Directions sampled from BSDFs.
pub(super) struct SampledLanes<S: Simd> {
    /// In the shading frame; not above the surface where the light is absorbed.
    pub(super) local: Vector3<Lanes<S>>,
    /// Values without the cosine.
    pub(super) value: Vector3<Lanes<S>>,
    pub(super) pdf: Lanes<S>,
    /// False where the sample is not valid.
    pub(super) is_valid: LaneMask<S>,
    /// Lanes that have sampled a diffuse lobe.
    pub(super) diffuse: u8,
}

/// A diffuse lobe.
pub(super) struct Diffuse<S: Simd> {
    lobe: DiffusePhongLanes<Lanes<S>>,
    wo: Vector3<Lanes<S>>,
}

impl<S: Simd> LaneBsdf<S> for Diffuse<S> {
    #[inline(always)]
    fn load(simd: S, block: &Block, wo: Vector3<Lanes<S>>) -> Self {
        Self { lobe: block.load_bsdf(simd, false), wo }
    }

    #[inline(always)]
    fn eval(&self, wi: Vector3<Lanes<S>>) -> Vector3<Lanes<S>> {
        self.lobe.diffuse_value(self.wo, wi)
    }

    #[inline(always)]
    fn eval_mis(&self, wi: Vector3<Lanes<S>>, pdf: Lanes<S>, lobes: FollowedLobes) -> Vector3<Lanes<S>> {
        let value = self.eval(wi);
        if lobes == FollowedLobes::All { value * power_heuristic(pdf, wi.z * FRAC_1_PI) } else { value }
    }

    #[inline(always)]
    fn sample(&self, _: Lanes<S>, u: [Lanes<S>; 2], _: FollowedLobes) -> SampledLanes<S> {
        let local = cosine_hemisphere_lanes(u);
        let pdf = local.z * FRAC_1_PI;
        let is_valid = pdf.gt(pdf.splat(0.0));
        SampledLanes { local, value: self.eval(local), pdf, is_valid, diffuse: !0 }
    }
}

/// A diffuse lobe and a Phong lobe.
pub(super) struct DiffuseAndPhong<S: Simd> {
    simd: S,
    lobes: DiffusePhongLanes<Lanes<S>>,
    wo: Vector3<Lanes<S>>,
}

impl<S: Simd> LaneBsdf<S> for DiffuseAndPhong<S> {
    #[inline(always)]
    fn load(simd: S, block: &Block, wo: Vector3<Lanes<S>>) -> Self {
        Self { simd, lobes: block.load_bsdf(simd, true), wo }
    }

    #[inline(always)]
    fn eval(&self, wi: Vector3<Lanes<S>>) -> Vector3<Lanes<S>> {
        let values = self.lobes.values(self.wo, wi);
        values.diffuse + values.phong
    }

    #[inline(always)]
    fn eval_mis(&self, wi: Vector3<Lanes<S>>, pdf: Lanes<S>, lobes: FollowedLobes) -> Vector3<Lanes<S>> {
        let values = self.lobes.values(self.wo, wi);
        let all = values.diffuse + values.phong;
        if lobes == FollowedLobes::All {
            all * power_heuristic(pdf, self.lobes.pdf(&values))
        } else {
            all - values.phong * (pdf.splat(1.0) - power_heuristic(pdf, values.phong_pdf))
        }
    }

    #[inline(always)]
    fn sample(&self, u_lobe: Lanes<S>, u: [Lanes<S>; 2], lobes: FollowedLobes) -> SampledLanes<S> {
        let samples_diffuse = lobes == FollowedLobes::All;
        let is_diffuse =
            if samples_diffuse { self.lobes.chooses_diffuse(u_lobe) } else { LaneMask::from_bits(self.simd, 0) };
        let local = self.lobes.sample(self.wo, is_diffuse, u);
        let values = self.lobes.values(self.wo, local);
        let own_pdf = Real::select(is_diffuse, values.diffuse_pdf, values.phong_pdf);
        let (value, pdf) = if samples_diffuse {
            (values.diffuse + values.phong, self.lobes.pdf(&values))
        } else {
            (values.phong, values.phong_pdf)
        };
        let is_valid = own_pdf.gt(pdf.splat(0.0)) & is_density(pdf) & value.is_finite();
        SampledLanes { local, value, pdf, is_valid, diffuse: is_diffuse.bits() }
    }
}

impl<S: Simd> LaneBsdf<S> for MetallicRoughnessLanes<S> {
    #[inline(always)]
    fn load(simd: S, block: &Block, wo: Vector3<Lanes<S>>) -> Self {
        let (color, roughness) = (Lanes::load_vector(simd, &block.albedo), Lanes::load(simd, &block.roughness));
        Self::new(simd, &block.layer, color, roughness, wo)
    }

    #[inline(always)]
    fn eval(&self, wi: Vector3<Lanes<S>>) -> Vector3<Lanes<S>> {
        self.eval_with_pdf(wi).0
    }

    #[inline(always)]
    fn eval_mis(&self, wi: Vector3<Lanes<S>>, pdf: Lanes<S>, lobes: FollowedLobes) -> Vector3<Lanes<S>> {
        let (value, own_pdf) = self.eval_with_pdf(wi);
        let weight = power_heuristic(pdf, own_pdf);
        if lobes == FollowedLobes::All { value * weight } else { value - value * (pdf.splat(1.0) - weight) }
    }

    #[inline(always)]
    fn sample(&self, u_lobe: Lanes<S>, u: [Lanes<S>; 2], _: FollowedLobes) -> SampledLanes<S> {
        let MetallicRoughnessSample { wi: local, value, pdf, is_diffuse } =
            MetallicRoughnessLanes::sample(self, u_lobe, u);
        let is_valid = is_density(pdf) & value.is_finite() & local.is_finite();
        SampledLanes { local, value, pdf, is_valid, diffuse: is_diffuse.bits() }
    }
}

/// True for a positive and finite density.
#[inline(always)]
fn is_density<R: Real>(pdf: R) -> R::Mask {
    pdf.gt(pdf.splat(0.0)) & pdf.le(pdf.splat(f64::MAX))
}
