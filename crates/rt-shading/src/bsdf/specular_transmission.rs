//! Specular transmission with a constant transmittance.

use super::{BsdfSample, Scattering, side::Side};
use crate::optics;
use rt_math::{DVec3, Rgb};

/// Refraction by Snell's law with the same transmittance at all angles, without total internal reflection (Whitted 1980).
///
/// Radiance is not scaled by eta²: a light source is as bright inside of a dielectric as outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpecularTransmission {
    /// Index of refraction below the surface divided by that above, positive and finite; otherwise all light is absorbed.
    pub ior: f64,
    /// Transmittance, per channel in \[0, 1\].
    pub transmittance: Rgb,
}

impl SpecularTransmission {
    /// Implements [`super::Bsdf::eval_with_pdf`]: black and 0.
    pub fn eval_with_pdf(&self, _: DVec3, _: DVec3) -> (Rgb, f64) {
        (Rgb::BLACK, 0.0)
    }

    /// Implements [`super::Bsdf::sample`]: the refracted direction, of weight `transmittance`.
    pub fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        let ior = if wo.z > 0.0 { self.ior } else { 1.0 / self.ior };
        let (wo, side) = Side::of(wo, u)?;
        if !(ior > 0.0 && ior.is_finite()) {
            return None;
        }
        // Index-matched interfaces keep all bits of the direction.
        let wi = if ior == 1.0 { -wo } else { optics::refract(-wo, DVec3::Z, 1.0 / ior)? };
        BsdfSample {
            kind: Scattering::Transmission,
            is_delta: true,
            ..BsdfSample::new(side.restore(wi), self.transmittance / wi.z.abs(), 1.0)
        }
        .if_finite()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_follow_snells_law_and_weights_are_constant() {
        let surface = SpecularTransmission { ior: 1.5, transmittance: Rgb::gray(0.7) };
        let sample = surface.sample(DVec3::new(0.6, 0.0, 0.8), [0.5; 3]).expect("passes");
        assert!((sample.wi.x + 0.4).abs() < 1e-15 && sample.wi.z < 0.0);
        assert!((sample.weight().r - 0.7).abs() < 1e-15);
        assert_eq!(surface.sample(DVec3::new(0.8, 0.0, -0.6), [0.5; 3]), None, "totally reflected");
        let air = SpecularTransmission { ior: 1.0, ..surface };
        assert_eq!(air.sample(DVec3::new(0.6, 0.0, 0.8), [0.5; 3]).expect("passes").wi, DVec3::new(-0.6, 0.0, -0.8));
    }

    #[test]
    fn invalid_indices_absorb_all_light() {
        for ior in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(SpecularTransmission { ior, transmittance: Rgb::WHITE }.sample(DVec3::Z, [0.5; 3]), None);
        }
    }
}
