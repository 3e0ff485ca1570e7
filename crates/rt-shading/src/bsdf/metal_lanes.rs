//! Metals and mirrors in lanes.

use super::{
    ComplexIor, Conductor, Ggx, LaneSample, Mirror, conductor_fresnel,
    ggx::{IsotropicGgx, MIN_LANE_ROUGHNESS, normalize_or_up},
};
use crate::{
    lane_set::{LaneSet, set_color},
    lanes::{ALL_LANES, LANES, LaneArray},
    optics::reflect_lanes,
    wavefront::is_in_range,
};
use rt_math::{DVec3, Real, Vector3};

impl Conductor {
    /// True if it can be shaded in lanes: smooth, or rough enough, with an index of refraction in range.
    pub(super) fn fits_lanes(&self) -> bool {
        (self.is_smooth() || self.roughness >= MIN_LANE_ROUGHNESS) && is_in_range(self.ior.n) && is_in_range(self.ior.k)
    }
}

/// Parameters of eight metals or mirrors.
#[derive(Clone, Debug, Default)]
pub(crate) struct MetalBlock {
    /// Lanes of metals and mirrors.
    pub(crate) all: u8,
    /// Those whose lobe is a delta distribution.
    pub(crate) delta: u8,
    mirrors: u8,
    /// Complex indices of refraction, by channel.
    n: [LaneArray; 3],
    k: [LaneArray; 3],
    reflectance: [LaneArray; 3],
    /// α of [`Ggx`]; 1 for delta lobes.
    alpha: LaneArray,
}

impl MetalBlock {
    pub(crate) const fn clear(&mut self) {
        (self.all, self.delta, self.mirrors) = (0, 0, 0);
    }

    /// Sets the metal of one lane, once.
    pub(crate) fn set_conductor(&mut self, lane: usize, conductor: &Conductor) {
        let Conductor { ior: ComplexIor { n, k }, roughness } = *conductor;
        let facets = Ggx::from_roughness(roughness);
        self.all |= 1 << lane;
        self.delta |= u8::from(facets.is_none()) << lane;
        self.alpha[lane % LANES] = facets.map_or(1.0, |facets| facets.alpha());
        set_color(&mut self.n, lane, n);
        set_color(&mut self.k, lane, k);
    }

    /// Sets the mirror of one lane, once.
    pub(crate) fn set_mirror(&mut self, lane: usize, mirror: &Mirror) {
        for lanes in [&mut self.all, &mut self.delta, &mut self.mirrors] {
            *lanes |= 1 << lane;
        }
        self.alpha[lane % LANES] = 1.0;
        set_color(&mut self.reflectance, lane, mirror.reflectance);
    }
}

/// Eight metals or mirrors from the side of their viewers.
pub(crate) struct MetalLanes<L: LaneSet> {
    lanes: L,
    delta: u8,
    mirrors: u8,
    n: Vector3<L::D>,
    k: Vector3<L::D>,
    reflectance: Vector3<L::D>,
    facets: IsotropicGgx<L::D>,
    wo: Vector3<L::D>,
    /// S(wo) of [`Ggx`].
    stretched: L::D,
}

impl<L: LaneSet> MetalLanes<L> {
    /// Surfaces that are seen from directions above them.
    #[inline(always)]
    pub(crate) fn new(lanes: L, block: &MetalBlock, wo: Vector3<L::D>) -> Self {
        let facets = IsotropicGgx { alpha: lanes.load_f64(&block.alpha) };
        Self {
            lanes,
            delta: block.delta,
            mirrors: block.mirrors,
            n: lanes.load_coordinates(&block.n),
            k: lanes.load_coordinates(&block.k),
            reflectance: lanes.load_coordinates(&block.reflectance),
            facets,
            wo,
            stretched: facets.stretched_length(wo),
        }
    }

    /// Reflectances at cosines between the viewer and the normal of a facet.
    #[inline(always)]
    fn fresnel(&self, cos: L::D) -> Vector3<L::D> {
        let (n, k) = (self.n, self.k);
        let metal = Vector3::new(
            conductor_fresnel(cos, n.x, k.x),
            conductor_fresnel(cos, n.y, k.y),
            conductor_fresnel(cos, n.z, k.z),
        );
        Vector3::select(self.lanes.mask_f64(self.mirrors), self.reflectance, metal)
    }

    /// Value of perfectly reflecting facets, and density, for directions above the surface with the normalised half vectors `m`.
    #[inline(always)]
    fn facets_with_pdf(&self, wi: Vector3<L::D>, m: Vector3<L::D>) -> (L::D, L::D) {
        self.facets.reflection_with_pdf((self.wo, self.stretched), wi, m)
    }

    /// Value without the cosine, and density, for directions above the surface. Not valid for delta lobes.
    #[inline(always)]
    pub(crate) fn eval_with_pdf(&self, wi: Vector3<L::D>) -> (Vector3<L::D>, L::D) {
        let m = normalize_or_up(self.wo + wi);
        let (facets, pdf) = self.facets_with_pdf(wi, m);
        (self.fresnel(self.wo.dot(m)) * facets, pdf)
    }

    /// Samples directions, some of which are below the surface.
    #[inline(always)]
    pub(crate) fn sample(&self, u: [L::D; 2]) -> LaneSample<L> {
        let is_delta = self.lanes.mask_f64(self.delta);
        let up = self.lanes.splat_point(DVec3::Z);
        let m = Vector3::select(is_delta, up, self.facets.sample(self.wo, u));
        let wi = reflect_lanes(-self.wo, m);
        let (facets, pdf) = self.facets_with_pdf(wi, m);
        let one = self.lanes.splat_f64(1.0);
        let (pdf, share) = (Real::select(is_delta, one, pdf), Real::select(is_delta, one, facets * wi.z / pdf));
        let weight = self.fresnel(self.wo.dot(m)) * share;
        LaneSample { wi, weight, pdf, valid: ALL_LANES, diffuse: 0, delta: self.delta }
    }
}
