//! Dielectric interface with dispersion.

use super::{BsdfSample, Dielectric};
use rt_math::{DVec3, Rgb};

/// Interface of glass with an index of refraction per channel, as in KHR_materials_dispersion.
///
/// Each channel is a [`Dielectric`]; a sample follows one of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DispersiveDielectric {
    /// Index of refraction below the surface divided by that above, per channel.
    pub iors: [f64; 3],
    /// Roughness in \[0, 1\].
    pub roughness: f64,
    /// Factor of transmitted light.
    pub transmittance: Rgb,
}

impl DispersiveDielectric {
    /// True if all channels have the same index.
    pub(super) fn is_plain(&self) -> bool {
        self.iors[0] == self.iors[1] && self.iors[1] == self.iors[2]
    }

    fn channel(&self, index: usize) -> Dielectric {
        Dielectric { transmittance: self.transmittance, ..Dielectric::clear(self.iors[index], self.roughness) }
    }

    /// True if all lobes are delta distributions.
    pub fn is_smooth(&self) -> bool {
        (0..3).all(|index| self.channel(index).is_smooth())
    }

    /// Implements [`super::Bsdf::eval`].
    pub fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        if self.is_plain() {
            return self.channel(0).eval(wo, wi);
        }
        let [r, g, b] = [0, 1, 2].map(|index| self.channel(index).eval(wo, wi));
        Rgb::new(r.r, g.g, b.b)
    }

    /// Implements [`super::Bsdf::pdf`].
    pub fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        if self.is_plain() {
            return self.channel(0).pdf(wo, wi);
        }
        (0..3).map(|index| self.channel(index).pdf(wo, wi)).sum::<f64>() / 3.0
    }

    /// Implements [`super::Bsdf::sample`].
    pub fn sample(&self, wo: DVec3, u: [f64; 3]) -> Option<BsdfSample> {
        if self.is_plain() {
            return self.channel(0).sample(wo, u);
        }
        // The conversion truncates.
        let index = ((3.0 * u[0]) as usize).min(2);
        let within = [(3.0 * u[0] - index as f64).clamp(0.0, 1.0), u[1], u[2]];
        let sample = self.channel(index).sample(wo, within)?;
        if !sample.is_delta {
            return BsdfSample { value: self.eval(wo, sample.wi), pdf: self.pdf(wo, sample.wi), ..sample }.if_finite();
        }
        // Channels are refracted to different directions, so that the sample carries one of them.
        let value = Rgb::from(core::array::from_fn(|k| {
            if k == index { [sample.value.r, sample.value.g, sample.value.b][k] } else { 0.0 }
        }));
        BsdfSample { value, pdf: sample.pdf / 3.0, ..sample }.if_finite()
    }
}
