//! The layered BSDF in lanes.

use super::{
    Ggx, LaneSample, Layered, Sheen,
    albedo_table::{LayerAlbedo, directional_by_fresnel_lanes, directional_lanes},
    ggx::{IsotropicGgx, MIN_LANE_ROUGHNESS, normalize_or_up},
    lambert::cosine_hemisphere_lanes,
    schlick::{dielectric_fresnel, schlick_weight},
    sheen::{SheenAlbedo, sheen_albedo_lanes, white_sheen},
};
use crate::{
    lane_set::{LaneSet, set_color},
    lanes::{ALL_LANES, LANES, LaneArray},
    optics::reflect_lanes,
    wavefront::is_in_range,
};
use core::f64::consts::FRAC_1_PI;
use rt_math::{DVec3, Mask, Real, Rgb, Vector3};

/// Opaque, rough and isotropic [`Layered`] with parameters in range, and the albedos of its layers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LayeredParameters {
    diffuse: Rgb,
    f0: Rgb,
    f90: Rgb,
    dielectric_reflectance: [f64; 2],
    roughness: f64,
    albedo: LayerAlbedo,
    sheen: Option<(Sheen, SheenAlbedo)>,
    clearcoat: Option<Clearcoat>,
}

/// Clearcoat with the normal of the base, rough or smooth.
#[derive(Clone, Copy, Debug)]
struct Clearcoat {
    strength: f64,
    roughness: f64,
    albedo: LayerAlbedo,
}

impl LayeredParameters {
    /// The surface, if it can be shaded in lanes.
    pub(super) fn new(surface: &Layered) -> Option<Self> {
        let &Layered { diffuse, f0, f90, dielectric_reflectance, roughness, sheen, clearcoat, .. } = surface;
        let [along, grazing] = dielectric_reflectance;
        let colors = [diffuse, f0, f90, Rgb::new(along, grazing, clearcoat)];
        let sheen_fits_lanes = |sheen: &Sheen| is_in_range(sheen.color) && !sheen.roughness.is_nan();
        let base_fits_lanes = !surface.transmits()
            && (surface.anisotropy, surface.axis) == (0.0, [1.0, 0.0])
            && roughness >= MIN_LANE_ROUGHNESS
            && colors.into_iter().all(is_in_range)
            && sheen.as_ref().is_none_or(sheen_fits_lanes);
        if !base_fits_lanes {
            return None;
        }
        let coat_roughness = surface.clearcoat_roughness;
        let coat_fits_lanes = Ggx::from_roughness(coat_roughness).is_none() || coat_roughness >= MIN_LANE_ROUGHNESS;
        if clearcoat != 0.0 && !(coat_fits_lanes && surface.clearcoat_normal == DVec3::Z) {
            return None;
        }
        let coat =
            || Clearcoat { strength: clearcoat, roughness: coat_roughness, albedo: LayerAlbedo::new(coat_roughness) };
        Some(Self {
            diffuse,
            f0,
            f90,
            dielectric_reflectance,
            roughness,
            albedo: LayerAlbedo::new(roughness),
            sheen: sheen.map(|sheen| (sheen, SheenAlbedo::new(sheen.roughness))),
            clearcoat: (clearcoat > 0.0).then(coat),
        })
    }
}

/// Parameters of eight [`LayeredParameters`].
#[derive(Clone, Debug, Default)]
pub(crate) struct LayeredBlock {
    /// Lanes of layered surfaces.
    pub(crate) all: u8,
    /// Those with a diffuse lobe, with sheen, with a clearcoat, and with a smooth clearcoat.
    diffuse: u8,
    sheen: u8,
    coated: u8,
    smooth: u8,
    albedo: [LaneArray; 3],
    f0: [LaneArray; 3],
    f90: [LaneArray; 3],
    dielectric_reflectance: [LaneArray; 2],
    /// α of [`Ggx`] of the base and of the clearcoat; 1 for a smooth clearcoat, and without one.
    alphas: [LaneArray; 2],
    base_albedos: [Option<LayerAlbedo>; LANES],
    /// Mean transmittance of the dielectric layer.
    mean_transmittance: LaneArray,
    /// Colour of sheen and exponent of its distribution; black without sheen.
    sheen_color: [LaneArray; 3],
    sheen_power: LaneArray,
    sheen_albedos: [Option<SheenAlbedo>; LANES],
    /// Strength of the clearcoat; 0 without one.
    clearcoat: LaneArray,
    coat_albedos: [Option<LayerAlbedo>; LANES],
}

impl LayeredBlock {
    pub(crate) const fn clear(&mut self) {
        (self.all, self.diffuse, self.sheen, self.coated, self.smooth) = (0, 0, 0, 0, 0);
    }

    /// Sets the parameters of one lane, once.
    pub(crate) fn set(&mut self, lane: usize, surface: &LayeredParameters) {
        let lane = lane % LANES;
        let bit = 1 << lane;
        let alpha = |roughness| Ggx::from_roughness(roughness).map_or(1.0, |facets| facets.alpha());
        self.all |= bit;
        self.diffuse |= if surface.diffuse.is_black() { 0 } else { bit };
        set_color(&mut self.albedo, lane, surface.diffuse);
        set_color(&mut self.f0, lane, surface.f0);
        set_color(&mut self.f90, lane, surface.f90);
        let [along, grazing] = surface.albedo.mean_by_fresnel();
        let [of_along, of_grazing] = surface.dielectric_reflectance;
        (self.dielectric_reflectance[0][lane], self.dielectric_reflectance[1][lane]) = (of_along, of_grazing);
        self.mean_transmittance[lane] = 1.0 - (of_along * along + of_grazing * grazing);
        self.alphas[0][lane] = alpha(surface.roughness);
        self.base_albedos[lane] = Some(surface.albedo);
        set_color(&mut self.sheen_color, lane, Rgb::BLACK);
        if let Some((sheen, albedo)) = surface.sheen {
            self.sheen |= bit;
            set_color(&mut self.sheen_color, lane, sheen.color);
            self.sheen_power[lane] = sheen.power();
            self.sheen_albedos[lane] = Some(albedo);
        }
        // The clearcoat of another lane may be computed for this one too.
        (self.clearcoat[lane], self.alphas[1][lane]) = (0.0, 1.0);
        if let Some(Clearcoat { strength, roughness, albedo }) = surface.clearcoat {
            self.coated |= bit;
            self.smooth |= if Ggx::from_roughness(roughness).is_none() { bit } else { 0 };
            self.clearcoat[lane] = strength;
            self.alphas[1][lane] = alpha(roughness);
            self.coat_albedos[lane] = Some(albedo);
        }
    }
}

/// Eight surfaces from the side of their viewers.
pub(crate) struct LayeredLanes<L: LaneSet> {
    lanes: L,
    diffuse: u8,
    with_sheen: u8,
    coated: u8,
    smooth: u8,
    wo: Vector3<L::D>,
    albedo: Vector3<L::D>,
    f0: Vector3<L::D>,
    f90: Vector3<L::D>,
    dielectric_reflectance: [L::D; 2],
    base: Facets<L>,
    base_albedos: [Option<LayerAlbedo>; LANES],
    /// Transmittance of the dielectric layer towards `wo`, divided by its mean.
    base_passes: L::D,
    sheen_color: Vector3<L::D>,
    sheen_power: L::D,
    sheen_albedos: [Option<SheenAlbedo>; LANES],
    /// Transmittance of the sheen towards `wo`.
    sheen_passes: L::D,
    clearcoat: L::D,
    coat: Facets<L>,
    coat_albedos: [Option<LayerAlbedo>; LANES],
    /// Transmittance of the clearcoat towards `wo`.
    coat_passes: L::D,
    /// Sampling probabilities of clearcoat and microfacets, and of directions by the cosine.
    probabilities: [L::D; 3],
    /// Bounds of the numbers that choose clearcoat, sheen and microfacets. A larger one chooses the diffuse lobe.
    bounds: [L::D; 3],
}

/// Microfacets of a layer, and S(wo) of [`Ggx`].
#[derive(Clone, Copy)]
struct Facets<L: LaneSet> {
    ggx: IsotropicGgx<L::D>,
    stretched: L::D,
}

impl<L: LaneSet> Facets<L> {
    #[inline(always)]
    fn new(lanes: L, alpha: &LaneArray, wo: Vector3<L::D>) -> Self {
        let ggx = IsotropicGgx { alpha: lanes.load_f64(alpha) };
        Self { ggx, stretched: ggx.stretched_length(wo) }
    }
}

impl<L: LaneSet> LayeredLanes<L> {
    /// Surfaces that are seen from directions above them.
    #[inline(always)]
    pub(crate) fn new(lanes: L, block: &LayeredBlock, wo: Vector3<L::D>) -> Self {
        let (zero, one) = (lanes.splat_f64(0.0), lanes.splat_f64(1.0));
        let strongest = |color: Vector3<L::D>| color.x.max(color.y).max(color.z);
        let albedo = lanes.load_coordinates(&block.albedo);
        let (f0, f90) = (lanes.load_coordinates(&block.f0), lanes.load_coordinates(&block.f90));
        let [of_along, of_grazing] = &block.dielectric_reflectance;
        let dielectric_reflectance = [lanes.load_f64(of_along), lanes.load_f64(of_grazing)];
        let sheen_color = lanes.load_coordinates(&block.sheen_color);
        let clearcoat = lanes.load_f64(&block.clearcoat);

        // Find the transmittance of each layer.
        let [along, grazing] = directional_by_fresnel_lanes(lanes, &block.base_albedos, wo.z);
        let through = one - (dielectric_reflectance[0] * along + dielectric_reflectance[1] * grazing);
        let (mut coat_passes, mut sheen_albedo) = (one, zero);
        if block.coated != 0 {
            coat_passes = one - clearcoat * directional_lanes(lanes, &block.coat_albedos, wo.z);
        }
        if block.sheen != 0 {
            sheen_albedo = sheen_albedo_lanes(lanes, &block.sheen_albedos, strongest(sheen_color), wo.z);
        }
        let sheen_passes = one - sheen_albedo;

        // Find the probability of each lobe, and the numbers that choose it.
        let below = coat_passes * sheen_passes;
        let of_coat = one - coat_passes;
        let of_sheen = coat_passes * sheen_albedo;
        let of_facets = below * strongest(f0 * along + f90 * grazing);
        let of_diffuse = below * through * strongest(albedo);
        let sum = of_coat + of_sheen + of_facets + of_diffuse;
        let sum = Real::select(sum.gt(zero), sum, one);
        let (of_coat, of_sheen, of_facets, of_diffuse) =
            (of_coat / sum, of_sheen / sum, of_facets / sum, of_diffuse / sum);
        let (to_sheen, to_facets) = (of_coat + of_sheen, of_coat + of_sheen + of_facets);
        // Where no lobe follows, rounding may make the sum of the probabilities less than 1.
        let infinity = lanes.splat_f64(f64::INFINITY);
        let has_diffuse = of_diffuse.gt(zero);
        let has_facets = has_diffuse | of_facets.gt(zero);
        let has_sheen = has_facets | of_sheen.gt(zero);
        let bounds = [
            Real::select(has_sheen, of_coat, infinity),
            Real::select(has_facets, to_sheen, infinity),
            Real::select(has_diffuse, to_facets, infinity),
        ];
        Self {
            lanes,
            diffuse: block.diffuse,
            with_sheen: block.sheen,
            coated: block.coated,
            smooth: block.smooth,
            wo,
            albedo,
            f0,
            f90,
            dielectric_reflectance,
            base: Facets::new(lanes, &block.alphas[0], wo),
            base_albedos: block.base_albedos,
            base_passes: through / lanes.load_f64(&block.mean_transmittance),
            sheen_color,
            sheen_power: lanes.load_f64(&block.sheen_power),
            sheen_albedos: block.sheen_albedos,
            sheen_passes,
            clearcoat,
            coat: Facets::new(lanes, &block.alphas[1], wo),
            coat_albedos: block.coat_albedos,
            coat_passes,
            probabilities: [of_coat, of_facets, of_sheen + of_diffuse],
            bounds,
        }
    }

    /// Value without the cosine, and density, for directions above the surface. Delta lobes are left out.
    #[inline(never)]
    pub(crate) fn eval_with_pdf(&self, wi: &Vector3<L::D>) -> (Vector3<L::D>, L::D) {
        self.lanes.vectorize(
            #[inline(always)]
            || self.value_with_pdf(*wi),
        )
    }

    #[inline(always)]
    fn value_with_pdf(&self, wi: Vector3<L::D>) -> (Vector3<L::D>, L::D) {
        let &Self { lanes, wo, .. } = self;
        let (zero, one) = (lanes.splat_f64(0.0), lanes.splat_f64(1.0));
        let m = normalize_or_up(wo + wi);
        let cos = wo.dot(m);
        let mut transmittance = one;
        if self.coated != 0 {
            let passes = one - self.clearcoat * directional_lanes(lanes, &self.coat_albedos, wi.z);
            transmittance = self.coat_passes * passes;
        }
        let mut below = transmittance;
        if self.with_sheen != 0 {
            let color = self.sheen_color.x.max(self.sheen_color.y).max(self.sheen_color.z);
            let passes = one - sheen_albedo_lanes(lanes, &self.sheen_albedos, color, wi.z);
            below = transmittance * self.sheen_passes.min(passes);
        }

        // Add the microfacets and the diffuse lobe.
        let (facets, pdf_of_facets) = self.base.ggx.reflection_with_pdf((wo, self.base.stretched), wi, m);
        let w = schlick_weight(cos);
        let mut value = (self.f0 * (one - w) + self.f90 * w) * (below * facets);
        if self.diffuse != 0 {
            let [along, grazing] = directional_by_fresnel_lanes(lanes, &self.base_albedos, wi.z);
            let [of_along, of_grazing] = self.dielectric_reflectance;
            let passes = one - (of_along * along + of_grazing * grazing);
            value = self.albedo * (below * (self.base_passes * passes) * FRAC_1_PI) + value;
        }
        let [of_coat, of_facets, by_cosine] = self.probabilities;
        let mut pdf = of_facets * pdf_of_facets + by_cosine * (wi.z * FRAC_1_PI);

        // Add sheen and a rough clearcoat.
        if self.with_sheen != 0 {
            value = value + self.sheen_color * (white_sheen(self.sheen_power, [wo.z, wi.z], m.z) * transmittance);
        }
        if self.coated & !self.smooth != 0 {
            let (facets, pdf_of_facets) = self.coat.ggx.reflection_with_pdf((wo, self.coat.stretched), wi, m);
            let is_smooth = lanes.mask_f64(self.smooth);
            let coat = Real::select(is_smooth, zero, self.clearcoat * dielectric_fresnel(cos) * facets);
            value = value + Vector3::new(coat, coat, coat);
            pdf = pdf + Real::select(is_smooth, zero, of_coat * pdf_of_facets);
        }
        (value, pdf)
    }

    /// Samples directions, some of which are below the surface, by numbers for the choice of a lobe and for the direction.
    #[inline(never)]
    pub(crate) fn sample(&self, u_lobe: &L::D, u: &[L::D; 2]) -> LaneSample<L> {
        let &Self { lanes, wo, .. } = self;
        lanes.vectorize(
            #[inline(always)]
            || {
                let [coat, sheen, facets] = self.bounds;
                let is_coat = u_lobe.lt(coat);
                let is_cosine = !is_coat & (u_lobe.lt(sheen) | !u_lobe.lt(facets));
                let is_delta = is_coat & lanes.mask_f64(self.smooth);
                let mut wi = wo;
                if !is_cosine.all() {
                    let alpha = Real::select(is_coat, self.coat.ggx.alpha, self.base.ggx.alpha);
                    let m = IsotropicGgx { alpha }.sample(wo, *u);
                    let m = Vector3::select(is_delta, lanes.splat_point(DVec3::Z), m);
                    wi = reflect_lanes(-wo, m);
                }
                if is_cosine.any() {
                    wi = Vector3::select(is_cosine, cosine_hemisphere_lanes(*u), wi);
                }
                let (value, mut pdf) = self.eval_with_pdf(&wi);
                let mut weight = value * (wi.z / pdf);
                if is_delta.any() {
                    pdf = Real::select(is_delta, self.probabilities[0], pdf);
                    let coat = self.clearcoat * dielectric_fresnel(wo.z) / self.probabilities[0];
                    weight = Vector3::select(is_delta, Vector3::new(coat, coat, coat), weight);
                }
                LaneSample {
                    wi,
                    weight,
                    pdf,
                    valid: ALL_LANES,
                    diffuse: lanes.bits_f64(is_cosine),
                    delta: lanes.bits_f64(is_delta),
                }
            },
        )
    }
}
