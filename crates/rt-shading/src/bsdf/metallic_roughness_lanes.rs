//! The metallic-roughness BSDF in lanes.

use super::{
    LaneSample, MetallicRoughness,
    albedo_table::{LayerAlbedo, directional_lanes},
    ggx::{IsotropicGgx, MIN_LANE_ROUGHNESS, normalize_or_up},
    lambert::cosine_hemisphere_lanes,
    schlick::{dielectric_fresnel, schlick_weight},
};
use crate::{
    lane_set::LaneSet,
    lanes::{ALL_LANES, LANES, LaneArray},
    optics::reflect_lanes,
    wavefront::is_in_range,
};
use core::f64::consts::FRAC_1_PI;
use rt_math::{Mask, Real, Vector3};

/// Rough [`MetallicRoughness`] with parameters in range, and the albedo of its layer.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MetallicRoughnessLayer {
    pub(crate) surface: MetallicRoughness,
    pub(crate) albedo: LayerAlbedo,
}

impl MetallicRoughnessLayer {
    /// The surface, if it can be shaded in lanes.
    pub(super) fn new(surface: &MetallicRoughness) -> Option<Self> {
        let MetallicRoughness { base_color, roughness, .. } = *surface;
        let fits_lanes = is_in_range(base_color) && roughness >= MIN_LANE_ROUGHNESS;
        fits_lanes.then(|| Self { surface: *surface, albedo: LayerAlbedo::new(roughness) })
    }
}

/// Parameters of eight [`MetallicRoughnessLayer`]s.
#[derive(Clone, Debug, Default)]
pub(crate) struct MetallicRoughnessBlock {
    /// In \[0, 1\].
    pub(crate) metallic: LaneArray,
    albedos: [Option<LayerAlbedo>; LANES],
    /// 1 − Ē.
    transmitted: LaneArray,
}

impl MetallicRoughnessBlock {
    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, layer: &MetallicRoughnessLayer) {
        self.metallic[lane] = layer.surface.clamped_metallic();
        self.albedos[lane] = Some(layer.albedo);
        self.transmitted[lane] = 1.0 - layer.albedo.mean();
    }
}

/// Eight surfaces from the side of their viewers.
pub(crate) struct MetallicRoughnessLanes<L: LaneSet> {
    lanes: L,
    albedos: [Option<LayerAlbedo>; LANES],
    /// 1 − Ē.
    transmitted: L::D,
    base_color: Vector3<L::D>,
    metallic: L::D,
    facets: IsotropicGgx<L::D>,
    wo: Vector3<L::D>,
    /// S(wo) of [`Ggx`].
    stretched: L::D,
    /// 1 − E(wo).
    passes: L::D,
    /// Probability with which the specular lobe is sampled.
    chance: L::D,
}

impl<L: LaneSet> MetallicRoughnessLanes<L> {
    /// Surfaces of these colours and roughnesses, seen from directions above the surface.
    #[inline(always)]
    pub(crate) fn new(
        lanes: L,
        block: &MetallicRoughnessBlock,
        base_color: Vector3<L::D>,
        roughness: L::D,
        wo: Vector3<L::D>,
    ) -> Self {
        let (zero, one) = (lanes.splat_f64(0.0), lanes.splat_f64(1.0));
        let metallic = lanes.load_f64(&block.metallic);
        let roughness = roughness.min(one);
        let facets = IsotropicGgx { alpha: roughness * roughness };
        let layer = directional_lanes(lanes, &block.albedos, wo.z);
        let color = base_color.x.max(base_color.y).max(base_color.z);
        let specular = (one - metallic) * layer + metallic * color;
        let diffuse = (one - metallic) * (one - layer) * color;
        let chance = Real::select(diffuse.gt(zero), specular / (specular + diffuse), one);
        let (stretched, passes) = (facets.stretched_length(wo), one - layer);
        let (albedos, transmitted) = (block.albedos, lanes.load_f64(&block.transmitted));
        Self { lanes, albedos, transmitted, base_color, metallic, facets, wo, stretched, passes, chance }
    }

    /// Value without the cosine, and density, for directions above the surface with the normalised half vectors `m`.
    #[inline(always)]
    fn value_with_pdf(&self, wi: Vector3<L::D>, m: Vector3<L::D>) -> (Vector3<L::D>, L::D) {
        let (zero, one) = (self.lanes.splat_f64(0.0), self.lanes.splat_f64(1.0));
        let dielectric = one - self.metallic;
        let (facets, of_facets) = self.facets.reflection_with_pdf((self.wo, self.stretched), wi, m);
        let cos = self.wo.dot(m);
        let (w, fresnel) = (schlick_weight(cos), dielectric_fresnel(cos));
        let Vector3 { x, y, z } = self.base_color;
        let of_dielectric = dielectric * fresnel;
        let specular = Vector3::new(
            of_dielectric + self.metallic * (x + (one - x) * w),
            of_dielectric + self.metallic * (y + (one - y) * w),
            of_dielectric + self.metallic * (z + (one - z) * w),
        );
        let mut value = specular * facets;
        if dielectric.gt(zero).any() {
            let passes = self.passes * (one - directional_lanes(self.lanes, &self.albedos, wi.z));
            value =
                self.base_color * (dielectric * (passes / self.transmitted)) * self.lanes.splat_f64(FRAC_1_PI) + value;
        }
        (value, self.chance * of_facets + (one - self.chance) * (wi.z * FRAC_1_PI))
    }

    /// Value without the cosine, and density, for directions above the surface.
    #[inline(always)]
    pub(crate) fn eval_with_pdf(&self, wi: Vector3<L::D>) -> (Vector3<L::D>, L::D) {
        self.value_with_pdf(wi, normalize_or_up(self.wo + wi))
    }

    /// Samples directions, some of which are below the surface, by numbers for the choice of a lobe and for the direction.
    #[inline(always)]
    pub(crate) fn sample(&self, u_lobe: L::D, u: [L::D; 2]) -> LaneSample<L> {
        let is_diffuse = !u_lobe.lt(self.chance);
        let mut m = self.wo;
        let mut wi = self.wo;
        if !is_diffuse.all() {
            m = self.facets.sample(self.wo, u);
            wi = reflect_lanes(-self.wo, m);
        }
        if is_diffuse.any() {
            let diffuse = cosine_hemisphere_lanes(u);
            wi = Vector3::select(is_diffuse, diffuse, wi);
            m = Vector3::select(is_diffuse, normalize_or_up(self.wo + diffuse), m);
        }
        let (value, pdf) = self.value_with_pdf(wi, m);
        let diffuse = self.lanes.bits_f64(is_diffuse);
        LaneSample { wi, weight: value * (wi.z / pdf), pdf, valid: ALL_LANES, diffuse, delta: 0 }
    }
}
