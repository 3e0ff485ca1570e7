//! A perfect mirror.

use super::{
    BsdfSample, Scattering,
    side::{Side, reflect_dir},
};
use rt_math::{DVec3, Rgb};

/// Sends light on in the mirrored direction, and nowhere else.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mirror {
    /// Part of the light that is reflected, per channel in \[0, 1\], the same at any angle.
    pub reflectance: Rgb,
}

impl Mirror {
    /// As [`super::Bsdf::eval`]: black.
    pub fn eval(&self, _: DVec3, _: DVec3) -> Rgb {
        Rgb::BLACK
    }

    /// As [`super::Bsdf::pdf`]: 0.
    pub fn pdf(&self, _: DVec3, _: DVec3) -> f64 {
        0.0
    }

    /// As [`super::Bsdf::sample`]: the mirrored direction, of weight `reflectance`.
    pub fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        let (wo, side) = Side::of(wo, u)?;
        reflection(wo, side, self.reflectance, 1.0)
    }
}

/// The mirrored direction of `wo`, which is above the surface: chosen with probability `chance`, it carries `share` of the
/// light.
pub(super) fn reflection(wo: DVec3, side: Side, share: Rgb, chance: f64) -> Option<BsdfSample> {
    BsdfSample {
        wi: side.restore(reflect_dir(wo)),
        value: share / wo.z,
        pdf: chance,
        kind: Scattering::Reflection,
        is_delta: true,
        is_diffuse: false,
        eta: 1.0,
    }
    .if_finite()
}
