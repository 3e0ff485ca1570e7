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

    /// Implements [`super::Bsdf::eval_with_pdf`].
    pub fn eval_with_pdf(&self, wo: DVec3, wi: DVec3) -> (Rgb, f64) {
        if self.is_plain() {
            return self.channel(0).eval_with_pdf(wo, wi);
        }
        let [r, g, b] = [0, 1, 2].map(|index| self.channel(index).eval_with_pdf(wo, wi));
        (Rgb::new(r.0.r, g.0.g, b.0.b), (r.1 + g.1 + b.1) / 3.0)
    }

    /// Implements [`super::Bsdf::sample_along`]. Rough glass follows all channels with equal probability, so that its density does
    /// not depend on the path.
    pub fn sample(&self, wo: DVec3, u: [f64; 3], throughput: Rgb) -> Option<BsdfSample> {
        if self.is_plain() {
            return self.channel(0).sample(wo, u);
        }
        let (index, probability, within) = choose(if self.is_smooth() { throughput } else { Rgb::WHITE }, u[0]);
        let sample = self.channel(index).sample(wo, [within, u[1], u[2]])?;
        if !sample.is_delta {
            let (value, pdf) = self.eval_with_pdf(wo, sample.wi);
            return BsdfSample { value, pdf, ..sample }.if_finite();
        }
        // Channels are refracted to different directions, so that the sample carries one of them.
        let value = Rgb::from(core::array::from_fn(|k| {
            if k == index { [sample.value.r, sample.value.g, sample.value.b][k] } else { 0.0 }
        }));
        BsdfSample { value, pdf: sample.pdf * probability, ..sample }.if_finite()
    }
}

/// A channel in proportion to `throughput`, its probability, and a number in \[0, 1\] that is left of `u`.
fn choose(throughput: Rgb, u: f64) -> (usize, f64, f64) {
    let weights = throughput.to_array().map(|weight| weight.max(0.0));
    let sum: f64 = weights.iter().sum();
    let mut probabilities = [1.0 / 3.0; 3];
    if sum > 0.0 && sum.is_finite() {
        probabilities = weights.map(|weight| weight / sum);
    }
    let mut before = 0.0;
    let mut chosen = (0, 0.0, 0.0);
    for (index, probability) in probabilities.into_iter().enumerate() {
        // The last possible channel has what rounding leaves.
        if probability > 0.0 && (chosen.1 == 0.0 || u >= before) {
            chosen = (index, probability, ((u - before) / probability).clamp(0.0, 1.0));
        }
        before += probability;
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Paths chose a channel anew at each interface. Most of them then carried another one, and were black.
    #[test]
    fn a_path_of_one_channel_follows_it() {
        let glass = DispersiveDielectric { iors: [1.49, 1.5, 1.52], roughness: 0.0, transmittance: Rgb::WHITE };
        let wo = DVec3::new(0.6, 0.0, 0.8);
        let steps = 999;
        for throughput in [Rgb::WHITE, Rgb::new(1.0, 0.0, 0.0), Rgb::new(0.0, 0.0, 2.0), Rgb::new(0.5, 2.0, 0.25)] {
            let mut sum = Rgb::BLACK;
            for step in 0..steps {
                let u = (f64::from(step) + 0.5) / f64::from(steps);
                let sample = glass.sample(wo, [u, 0.5, 0.5], throughput).expect("passes");
                let weight = sample.weight() * throughput;
                assert!(!weight.is_black(), "{throughput:?} {u}");
                // Light that is refracted is compressed by η², and all of it passes.
                sum += weight * (sample.eta * sample.eta) / f64::from(steps);
            }
            let off = (sum - throughput).map(f64::abs).max_component();
            assert!(off < 0.01 * throughput.max_component(), "{throughput:?}: {sum:?}");
        }
    }

    #[test]
    fn any_number_chooses_a_possible_channel() {
        for (throughput, possible) in [
            (Rgb::new(0.0, 1.0, 0.0), vec![1]),
            (Rgb::new(1.0, 0.0, 3.0), vec![0, 2]),
            (Rgb::BLACK, vec![0, 1, 2]),
            (Rgb::new(f64::INFINITY, 1.0, 1.0), vec![0, 1, 2]),
            (Rgb::new(f64::NAN, 1.0, 1.0), vec![1, 2]),
        ] {
            let chosen: Vec<usize> = [0.0, 0.4, 0.5, 1.0].map(|u| choose(throughput, u).0).into();
            assert!(chosen.iter().all(|index| possible.contains(index)), "{throughput:?}: {chosen:?}");
            assert!(
                possible.iter().all(|index| (0..=100).any(|u| choose(throughput, f64::from(u) / 100.0).0 == *index))
            );
        }
    }
}
