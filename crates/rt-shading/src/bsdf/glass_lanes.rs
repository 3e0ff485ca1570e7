//! Smooth interfaces of dielectrics in lanes.

use super::LaneSample;
use crate::{
    lane_set::LaneSet,
    lanes::{ALL_LANES, LANES, LaneArray, set_color},
    optics,
};
use rt_math::{DVec3, Real, Rgb, Vector3};

/// Parameters of eight smooth [`Dielectric`](super::Dielectric)s that reflect without colour.
#[derive(Clone, Debug, Default)]
pub(crate) struct GlassBlock {
    /// Lanes of glass.
    pub(crate) all: u8,
    /// Indices of refraction behind the surface, divided by those in front of it, as seen by the viewer.
    eta: LaneArray,
    transmittance: [LaneArray; 3],
}

impl GlassBlock {
    pub(crate) const fn clear(&mut self) {
        self.all = 0;
    }

    /// Sets the factor of transmitted light of one lane, once.
    pub(crate) fn set(&mut self, lane: usize, transmittance: Rgb) {
        self.all |= 1 << lane;
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
    wo: Vector3<L::D>,
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
        Self { lanes, eta, transmittance, wo }
    }

    /// Reflects or transmits, by a number for the choice.
    #[inline(always)]
    pub(crate) fn sample(&self, u: L::D) -> GlassSample<L> {
        let &Self { lanes, eta, transmittance, wo } = self;
        let (zero, one) = (lanes.splat_f64(0.0), lanes.splat_f64(1.0));
        let (is_null, inverse) = (eta.eq(one), eta.recip());
        let reflected = Real::select(is_null, zero, optics::fresnel(wo.z, inverse));
        let most = transmittance.x.max(transmittance.y).max(transmittance.z);
        let (passed, sum) = (one - reflected, reflected + (one - reflected) * most);
        let chance = Real::select(sum.gt(zero), reflected / sum, reflected);
        let is_transmitted = !u.lt(chance);
        let mirrored = Vector3::new(-wo.x, -wo.y, wo.z);
        let sin = (wo.x * wo.x + wo.y * wo.y).sqrt();
        let (bent, is_possible) = optics::refract_lanes(-wo, lanes.splat_point(DVec3::Z), inverse, sin);
        let bent = Vector3::select(is_null, -wo, bent);
        let of_reflection = reflected / chance;
        let of_transmission = transmittance * (passed / (eta * eta * (one - chance)));
        let mirrored_weight = Vector3::new(of_reflection, of_reflection, of_reflection);
        let sample = LaneSample {
            wi: Vector3::select(is_transmitted, bent, mirrored),
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
