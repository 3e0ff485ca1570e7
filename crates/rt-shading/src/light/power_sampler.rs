//! Light sampler by power.

use super::piecewise_constant::{accumulate, find, probability};
use rt_math::Rgb;

/// Sampled light, with its probability.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampledLight {
    /// Index in the list of lights.
    pub index: u32,
    /// Probability of the light, greater than 0.
    pub probability: f64,
}

/// Sampling in proportion to power, independent of the receiver (pbrt: `PowerLightSampler`).
#[derive(Clone, Debug, PartialEq)]
pub struct PowerLightSampler {
    sums: Vec<f64>,
}

impl PowerLightSampler {
    /// Sampler by the luminance of these powers. Lights without power are never sampled.
    pub fn new(powers: impl IntoIterator<Item = Rgb>) -> Self {
        let mut sums: Vec<f64> = powers.into_iter().map(|power| power.luminance().clamp(0.0, f64::MAX)).collect();
        // The sum of the largest powers would overflow.
        let max_power = sums.iter().fold(0.0f64, |a, &b| a.max(b));
        sums.iter_mut().for_each(|power| *power /= max_power);
        accumulate(&mut sums);
        Self { sums }
    }

    /// Samples a light by `u` in `[0, 1)`. `None` if no light has power.
    pub fn sample(&self, u: f64) -> Option<SampledLight> {
        let (index, _) = find(&self.sums, u)?;
        Some(SampledLight { index: u32::try_from(index).ok()?, probability: probability(&self.sums, index) })
    }

    /// Probability of a light; 0 for an index out of range.
    pub fn pmf(&self, index: u32) -> f64 {
        probability(&self.sums, index as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lights_are_chosen_in_proportion_to_power() {
        let choice = PowerLightSampler::new([0.0, 1.0, 3.0, 0.0, 4.0].map(Rgb::gray));
        for (u, index, probability) in
            [(0.0, 1, 0.125), (0.125, 2, 0.375), (0.49, 2, 0.375), (0.5, 4, 0.5), (1.0, 4, 0.5)]
        {
            assert_eq!(choice.sample(u), Some(SampledLight { index, probability }), "{u}");
            assert_eq!(choice.pmf(index), probability);
        }
        assert_eq!([0, 3, 5].map(|index| choice.pmf(index)), [0.0; 3]);
        let sum: f64 = (0..5).map(|index| choice.pmf(index)).sum();
        assert_eq!(sum, 1.0);
    }

    #[test]
    fn powers_of_any_size_are_chosen_among() {
        for powers in [[1e-30, 1e30], [1e300, 1e308], [f64::MAX, f64::MAX], [f64::INFINITY, 1.0], [1e-300, 1e-300]] {
            let choice = PowerLightSampler::new(powers.map(Rgb::gray));
            let chosen = choice.sample(0.999).expect("a light");
            assert!(chosen.probability > 0.0 && chosen.probability <= 1.0, "{powers:?}: {chosen:?}");
        }
        assert_eq!(PowerLightSampler::new([Rgb::BLACK]).sample(0.5), None);
        assert_eq!(PowerLightSampler::new([]).sample(0.5), None);
        assert_eq!(PowerLightSampler::new([]).pmf(0), 0.0);
    }
}
