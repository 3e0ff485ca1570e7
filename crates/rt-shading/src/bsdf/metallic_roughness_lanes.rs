//! The metallic-roughness BSDF in SIMD lanes.

use super::{
    Coupling, Ggx, MetallicRoughness,
    albedo_table::{LayerAlbedo, directional_lanes},
    ggx::{IsotropicGgx, normalize_or_up},
    lambert::cosine_hemisphere_lanes,
    schlick::{dielectric_fresnel, schlick_weight},
};
use crate::{
    lanes::{LANES, LaneArray, LaneMask, Lanes, Simd},
    optics::reflect_lanes,
};
use core::f64::consts::FRAC_1_PI;
use rt_math::{Mask, Real, Vector3};

/// Rough [`MetallicRoughness`] with [`Coupling::Albedo`] and finite parameters, and the albedo of its layer.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MetallicRoughnessLayer {
    pub(crate) surface: MetallicRoughness,
    pub(crate) albedo: LayerAlbedo,
}

impl MetallicRoughnessLayer {
    /// The surface, if it can be shaded in lanes.
    pub(super) fn new(surface: &MetallicRoughness) -> Option<Self> {
        let MetallicRoughness { base_color, coupling, roughness, .. } = *surface;
        Ggx::from_roughness(roughness)?;
        let is_usual = coupling == Coupling::Albedo && base_color.is_finite() && roughness.is_finite();
        is_usual.then(|| Self { surface: *surface, albedo: LayerAlbedo::new(roughness) })
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
    /// Sets the parameters of one lane.
    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, layer: &MetallicRoughnessLayer) {
        self.metallic[lane] = layer.surface.clamped_metallic();
        self.albedos[lane] = Some(layer.albedo);
        self.transmitted[lane] = 1.0 - layer.albedo.mean();
    }
}

/// Eight surfaces from the side of their viewers.
pub(crate) struct MetallicRoughnessLanes<S: Simd> {
    simd: S,
    albedos: [Option<LayerAlbedo>; LANES],
    /// 1 − Ē.
    transmitted: Lanes<S>,
    base_color: Vector3<Lanes<S>>,
    metallic: Lanes<S>,
    facets: IsotropicGgx<Lanes<S>>,
    wo: Vector3<Lanes<S>>,
    /// S(wo) of [`Ggx`].
    stretched: Lanes<S>,
    /// 1 − E(wo).
    passes: Lanes<S>,
    /// Probability with which the specular lobe is sampled.
    chance: Lanes<S>,
}

/// Directions sampled from these surfaces.
pub(crate) struct MetallicRoughnessSample<S: Simd> {
    pub(crate) wi: Vector3<Lanes<S>>,
    pub(crate) value: Vector3<Lanes<S>>,
    pub(crate) pdf: Lanes<S>,
    pub(crate) is_diffuse: LaneMask<S>,
}

impl<S: Simd> MetallicRoughnessLanes<S> {
    /// Surfaces of these colours and roughnesses, seen from directions above the surface.
    #[inline(always)]
    pub(crate) fn new(
        simd: S,
        block: &MetallicRoughnessBlock,
        base_color: Vector3<Lanes<S>>,
        roughness: Lanes<S>,
        wo: Vector3<Lanes<S>>,
    ) -> Self {
        let (zero, one) = (Lanes::splat(simd, 0.0), Lanes::splat(simd, 1.0));
        let metallic = Lanes::load(simd, &block.metallic);
        let roughness = roughness.min(one);
        let facets = IsotropicGgx { alpha: roughness * roughness };
        let layer = directional_lanes(simd, &block.albedos, wo.z);
        let color = base_color.x.max(base_color.y).max(base_color.z);
        let specular = (one - metallic) * layer + metallic * color;
        let diffuse = (one - metallic) * (one - layer) * color;
        let chance = Real::select(diffuse.gt(zero), specular / (specular + diffuse), one);
        let (stretched, passes) = (facets.stretched_length(wo), one - layer);
        let (albedos, transmitted) = (block.albedos, Lanes::load(simd, &block.transmitted));
        Self { simd, albedos, transmitted, base_color, metallic, facets, wo, stretched, passes, chance }
    }

    /// Value without the cosine, and density, for directions above the surface with the normalised half vectors `m`.
    #[inline(always)]
    fn value_with_pdf(&self, wi: Vector3<Lanes<S>>, m: Vector3<Lanes<S>>) -> (Vector3<Lanes<S>>, Lanes<S>) {
        let (zero, one) = (Lanes::splat(self.simd, 0.0), Lanes::splat(self.simd, 1.0));
        let dielectric = one - self.metallic;
        let d = self.facets.d(m);
        let facets = d / ((self.wo.z * self.facets.stretched_length(wi) + wi.z * self.stretched) * 2.0);
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
            let passes = self.passes * (one - directional_lanes(self.simd, &self.albedos, wi.z));
            value = self.base_color * (dielectric * (passes / self.transmitted)) * Lanes::splat(self.simd, FRAC_1_PI)
                + value;
        }
        let of_facets = d / ((self.wo.z + self.stretched) * 2.0);
        (value, self.chance * of_facets + (one - self.chance) * (wi.z * FRAC_1_PI))
    }

    /// Value without the cosine, and density, for directions above the surface.
    #[inline(always)]
    pub(crate) fn eval_with_pdf(&self, wi: Vector3<Lanes<S>>) -> (Vector3<Lanes<S>>, Lanes<S>) {
        self.value_with_pdf(wi, normalize_or_up(self.wo + wi))
    }

    /// Samples directions, some of which are below the surface, by numbers for the choice of a lobe and for the direction.
    #[inline(always)]
    pub(crate) fn sample(&self, u_lobe: Lanes<S>, u: [Lanes<S>; 2]) -> MetallicRoughnessSample<S> {
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
        MetallicRoughnessSample { wi, value, pdf, is_diffuse }
    }
}
