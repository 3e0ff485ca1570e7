//! A perfect mirror.

use super::{
    BsdfSample,
    side::{Side, reflect_dir},
};
use rt_math::{DVec3, Rgb};

/// Perfect specular reflection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mirror {
    /// Reflectance at all angles, per channel in \[0, 1\].
    pub reflectance: Rgb,
}

impl Mirror {
    /// Implements [`super::Bsdf::eval_with_pdf`]: black and 0.
    pub fn eval_with_pdf(&self, _: DVec3, _: DVec3) -> (Rgb, f64) {
        (Rgb::BLACK, 0.0)
    }

    /// Implements [`super::Bsdf::sample`]: the mirrored direction, of weight `reflectance`.
    pub fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        let (wo, side) = Side::of(wo, u)?;
        reflection(wo, side, self.reflectance, 1.0)
    }
}

/// Sample of the mirrored direction of `wo`, which is above the surface, chosen with probability `chance`.
pub(super) fn reflection(wo: DVec3, side: Side, reflectance: Rgb, chance: f64) -> Option<BsdfSample> {
    BsdfSample { is_delta: true, ..BsdfSample::new(side.restore(reflect_dir(wo)), reflectance / wo.z, chance) }
        .if_finite()
}
