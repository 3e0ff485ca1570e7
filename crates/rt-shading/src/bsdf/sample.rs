//! Sampled directions.

use super::side;
use rt_math::{DVec3, Rgb};

/// Side of the surface to which light is scattered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scattering {
    /// The side of `wo`.
    Reflection,
    /// The opposite side.
    Transmission,
}

/// Direction that a BSDF sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// Sampled direction: a unit vector that leaves the surface.
    pub wi: DVec3,
    /// f(wo, wi), without the cosine, in 1/sr; of a delta lobe its reflectance divided by |cos θ(wi)|.
    pub value: Rgb,
    /// Density over solid angle, in 1/sr, as `pdf` returns it; of a delta lobe the probability of its choice.
    pub pdf: f64,
    /// Side of `wi`.
    pub kind: Scattering,
    /// True for a delta lobe, which `eval` and `pdf` leave out.
    pub is_delta: bool,
    /// True for a diffuse lobe, rather than one around a mirrored or refracted direction.
    pub is_diffuse: bool,
    /// Index of refraction on the side of `wi` divided by that on the side of `wo`: 1 but for transmission into another
    /// medium. Russian roulette must not count the factor 1/`eta`² of the radiance as a loss.
    pub eta: f64,
}

impl BsdfSample {
    /// Sample of a lobe that reflects, and is neither diffuse nor a delta distribution.
    #[inline]
    pub(super) const fn new(wi: DVec3, value: Rgb, pdf: f64) -> Self {
        Self { wi, value, pdf, kind: Scattering::Reflection, is_delta: false, is_diffuse: false, eta: 1.0 }
    }

    /// f · |cos θ| / pdf: factor of the throughput.
    pub fn weight(&self) -> Rgb {
        self.value * (self.wi.z.abs() / self.pdf)
    }

    /// The sample, or `None` if rounding made it invalid.
    pub(super) fn if_finite(self) -> Option<Self> {
        let is_sound = side::is_valid(self.wi) && self.pdf > 0.0 && self.pdf.is_finite();
        (is_sound && self.value.is_finite()).then_some(self)
    }
}
