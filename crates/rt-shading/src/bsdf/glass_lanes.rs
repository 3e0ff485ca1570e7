//! Interfaces of dielectrics in lanes.

use super::{
    Ggx, LaneSample,
    ggx::{IsotropicGgx, MIN_LANE_ROUGHNESS},
};
use crate::{
    lane_set::{LaneSet, set_color},
    lanes::{ALL_LANES, LANES, LaneArray},
    optics,
    wavefront::{IOR_RANGE, is_in_range},
};
use rt_math::{DVec3, Mask, Real, Rgb, Vector3};

/// Least difference of the index of a rough interface from 1. Below it, the sum of two directions that gives the normal of a facet
/// multiplies their rounding errors in `f32`.
const MIN_IOR_DIFFERENCE: f64 = 0.1;

/// Surface of a solid dielectric, smooth or rough, that reflects without colour.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GlassSurface {
    transmittance: Rgb,
    /// Microfacets, unless it is smooth.
    facets: Option<Ggx>,
}

impl GlassSurface {
    /// The surface, if it can be shaded in lanes in air, with this index of refraction behind it.
    pub(crate) fn new(transmittance: Rgb, roughness: f64, ior: f64) -> Option<Self> {
        let facets = Ggx::from_roughness(roughness);
        let is_rough_enough = roughness >= MIN_LANE_ROUGHNESS && (ior - 1.0).abs() >= MIN_IOR_DIFFERENCE;
        let fits_lanes = IOR_RANGE.contains(&ior) && ior != 1.0 && is_in_range(transmittance);
        (fits_lanes && (facets.is_none() || is_rough_enough)).then_some(Self { transmittance, facets })
    }

    pub(crate) const fn is_smooth(&self) -> bool {
        self.facets.is_none()
    }
}

/// Parameters of eight [`GlassSurface`]s.
#[derive(Clone, Debug, Default)]
pub(crate) struct GlassBlock {
    /// Lanes of glass.
    pub(crate) all: u8,
    /// Those of rough glass.
    pub(crate) rough: u8,
    /// α of [`Ggx`]; 1 if smooth.
    alpha: LaneArray,
    /// Indices of refraction behind the surface, divided by those in front of it, as seen by the viewer.
    eta: LaneArray,
    transmittance: [LaneArray; 3],
}

impl GlassBlock {
    pub(crate) const fn clear(&mut self) {
        (self.all, self.rough) = (0, 0);
    }

    /// Sets the surface of one lane, once.
    pub(crate) fn set(&mut self, lane: usize, surface: &GlassSurface) {
        let &GlassSurface { transmittance, facets } = surface;
        self.all |= 1 << lane;
        self.rough |= u8::from(facets.is_some()) << lane;
        self.alpha[lane % LANES] = facets.map_or(1.0, |facets| facets.alpha());
        set_color(&mut self.transmittance, lane, transmittance);
    }

    /// Sets the relative index of refraction of one lane.
    pub(crate) const fn set_eta(&mut self, lane: usize, eta: f64) {
        self.eta[lane % LANES] = eta;
    }
}

/// Eight interfaces from the side of their viewers.
pub(crate) struct GlassLanes<L: LaneSet> {
    lanes: L,
    eta: L::D,
    transmittance: Vector3<L::D>,
    facets: IsotropicGgx<L::D>,
    wo: Vector3<L::D>,
    /// S(wo) of [`Ggx`].
    stretched: L::D,
}

/// Directions sampled from these interfaces.
pub(crate) struct GlassSample<L: LaneSet> {
    /// Not valid on total internal reflection of a transmitted sample.
    pub(crate) sample: LaneSample<L>,
    /// Lanes of transmission, where the square of `eta` scales radiance.
    pub(crate) transmitted: u8,
    pub(crate) eta: L::D,
}

impl<L: LaneSet> GlassLanes<L> {
    /// Interfaces that are seen from directions above them.
    #[inline(always)]
    pub(crate) fn new(lanes: L, block: &GlassBlock, wo: Vector3<L::D>) -> Self {
        let (eta, transmittance) = (lanes.load_f64(&block.eta), lanes.load_coordinates(&block.transmittance));
        let facets = IsotropicGgx { alpha: lanes.load_f64(&block.alpha) };
        Self { lanes, eta, transmittance, facets, wo, stretched: facets.stretched_length(wo) }
    }

    /// Reflectances of facets at cosines to the viewer, and probabilities with which they reflect samples.
    #[inline(always)]
    fn fresnel(&self, cos: L::D) -> (L::D, L::D) {
        let (zero, one) = (self.lanes.splat_f64(0.0), self.lanes.splat_f64(1.0));
        let reflected = Real::select(self.eta.eq(one), zero, optics::fresnel(cos, self.eta.recip()));
        let Vector3 { x, y, z } = self.transmittance;
        let sum = reflected + (one - reflected) * x.max(y).max(z);
        (reflected, Real::select(sum.gt(zero), reflected / sum, reflected))
    }

    /// Value of rough interfaces without the cosine, and density, for directions on the side of a mask. `m` is the upward normal of the
    /// facets that scatter to them.
    #[inline(always)]
    fn value_with_pdf(
        &self,
        wi: Vector3<L::D>,
        m: Vector3<L::D>,
        is_below: <L::D as Real>::Mask,
    ) -> (Vector3<L::D>, L::D) {
        let &Self { lanes, eta, facets, wo, stretched, .. } = self;
        let (zero, one) = (lanes.splat_f64(0.0), lanes.splat_f64(1.0));
        let (cos_o, cos_i) = (wo.dot(m), wi.dot(m));
        let (reflected, chance) = self.fresnel(cos_o);
        let (reflection, of_reflection) = facets.reflection_with_pdf((wo, stretched), wi, m);
        let reflection = reflected * reflection;
        let (mut value, mut pdf) = (Vector3::new(reflection, reflection, reflection), chance * of_reflection);
        if is_below.any() {
            let (d, stretch) = (facets.d(m), cos_o + eta * cos_i);
            let across = cos_i.abs() / (stretch * stretch);
            // G₁ / cos stays finite where both are 0.
            let seen = one.splat(4.0) / ((wo.z + stretched) * (facets.stretched_length(wi) - wi.z));
            let transmission = self.transmittance * ((one - reflected) * (cos_o * across * d * seen));
            let of_normal = cos_o.max(zero) * d * 2.0 / (wo.z + stretched);
            let of_transmission = (one - chance) * of_normal * (eta * eta * across);
            value = Vector3::select(is_below, transmission, value);
            pdf = Real::select(is_below, of_transmission, pdf);
        }
        (value, pdf)
    }

    /// Value of rough interfaces without the cosine, and density, for directions on either side.
    #[inline(never)]
    pub(crate) fn eval_with_pdf(&self, wi: &Vector3<L::D>) -> (Vector3<L::D>, L::D) {
        let &Self { lanes, eta, wo, .. } = self;
        lanes.vectorize(
            #[inline(always)]
            || {
                let (wi, zero) = (*wi, lanes.splat_f64(0.0));
                let is_below = wi.z.lt(zero);
                let (m, is_known) = Vector3::select(is_below, wo + wi * eta, wo + wi).try_normalize();
                let m = Vector3::select(m.z.lt(zero), -m, m);
                let is_between = wo.dot(m).gt(zero) & wi.dot(m).lt(zero);
                let is_seen = is_known & (!is_below | is_between);
                let (value, pdf) = self.value_with_pdf(wi, m, is_below);
                let none = Vector3::new(zero, zero, zero);
                (Vector3::select(is_seen, value, none), Real::select(is_seen, pdf, zero))
            },
        )
    }

    /// Version of [`sample`](Self::sample) for rough interfaces, by numbers for the choice and for the facet.
    #[inline(never)]
    pub(crate) fn sample_rough(&self, u_lobe: &L::D, u: &[L::D; 2]) -> GlassSample<L> {
        let &Self { lanes, eta, wo, .. } = self;
        lanes.vectorize(
            #[inline(always)]
            || {
                let (zero, one) = (lanes.splat_f64(0.0), lanes.splat_f64(1.0));
                let m = self.facets.sample(wo, *u);
                let is_transmitted = !u_lobe.lt(self.fresnel(wo.dot(m)).1);
                let sin = wo.cross(m).length();
                let (refracted, is_possible) = optics::refract_lanes(-wo, m, eta.recip(), sin);
                let wi = Vector3::select(is_transmitted, refracted, optics::reflect_lanes(-wo, m));
                let (value, pdf) = self.value_with_pdf(wi, m, is_transmitted);
                let sample = LaneSample {
                    wi,
                    weight: value * (wi.z.abs() / pdf),
                    pdf,
                    valid: lanes.bits_f64(!is_transmitted | (is_possible & wi.z.lt(zero))),
                    diffuse: 0,
                    delta: 0,
                };
                let transmitted = lanes.bits_f64(is_transmitted);
                GlassSample { sample, transmitted, eta: Real::select(is_transmitted, eta, one) }
            },
        )
    }

    /// Reflects or transmits at smooth interfaces, by a number for the choice.
    #[inline(always)]
    pub(crate) fn sample(&self, u: L::D) -> GlassSample<L> {
        let &Self { lanes, eta, transmittance, wo, .. } = self;
        let one = lanes.splat_f64(1.0);
        let (is_null, inverse) = (eta.eq(one), eta.recip());
        let (reflected, chance) = self.fresnel(wo.z);
        let transmitted_part = one - reflected;
        let is_transmitted = !u.lt(chance);
        let mirrored = Vector3::new(-wo.x, -wo.y, wo.z);
        let sin = (wo.x * wo.x + wo.y * wo.y).sqrt();
        let (refracted, is_possible) = optics::refract_lanes(-wo, lanes.splat_point(DVec3::Z), inverse, sin);
        let refracted = Vector3::select(is_null, -wo, refracted);
        let of_reflection = reflected / chance;
        let of_transmission = transmittance * (transmitted_part / (eta * eta * (one - chance)));
        let mirrored_weight = Vector3::new(of_reflection, of_reflection, of_reflection);
        let sample = LaneSample {
            wi: Vector3::select(is_transmitted, refracted, mirrored),
            weight: Vector3::select(is_transmitted, of_transmission, mirrored_weight),
            pdf: one,
            valid: lanes.bits_f64(!is_transmitted | is_possible | is_null),
            diffuse: 0,
            delta: ALL_LANES,
        };
        let transmitted = lanes.bits_f64(is_transmitted);
        GlassSample { sample, transmitted, eta: Real::select(is_transmitted, eta, one) }
    }
}
