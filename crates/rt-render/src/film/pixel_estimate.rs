//! Mean of a pixel over its passes, and its standard error.
//!
//! ```text
//!      m = Σ Kₚ mₚ / Σ Kₚ        s² = Σ Kₚ (mₚ − m)² / (P − 1)        standard error² = s² / Σ Kₚ
//! ```
//!
//! mₚ is the mean of the Kₚ samples of pass p. If the variance of mₚ is σ² / Kₚ, as for random samples, the expected value of
//! s² is σ². The variance of better patterns falls faster. For these, s² is an upper estimate if passes differ in size.

use rt_math::Rgb;
use serde::{Deserialize, Serialize};

use crate::{ContentError, content_checks::check_number};

/// Pixel accumulator over passes. The update of the mean is numerically stable (West 1979).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct PixelEstimate {
    mean: Rgb,
    coverage: f64,
    /// Σ Kₚ (mₚ − m)².
    scatter: Rgb,
    samples: u32,
    passes: u32,
}

impl PixelEstimate {
    /// Adds a pass by its mean and its number of samples.
    #[inline]
    pub(crate) fn add(&mut self, mean: Rgb, coverage: f64, samples: u32) {
        // Counts saturate at 2³² − 1. Beyond it, the weights of passes are approximate.
        self.samples = self.samples.saturating_add(samples);
        self.passes = self.passes.saturating_add(1);
        if self.passes == 1 {
            (self.mean, self.coverage) = (mean, coverage);
            return;
        }
        let weight = f64::from(samples);
        let share = weight / f64::from(self.samples);
        let old_delta = mean - self.mean;
        self.mean += old_delta * share;
        self.coverage += (coverage - self.coverage) * share;
        self.scatter += old_delta * (mean - self.mean) * weight;
    }

    /// Checks that all numbers are finite and the counts within limits. `index` identifies the pixel in errors.
    pub(crate) fn validate(&self, index: usize, max_passes: u32, max_samples: u32) -> Result<(), ContentError> {
        let Self { mean, coverage, scatter, samples, passes } = *self;
        if passes > max_passes || samples > max_samples || passes > samples || (passes == 0) != (samples == 0) {
            return Err(ContentError::Pixel(index));
        }
        for value in [coverage].into_iter().chain(mean.to_array()).chain(scatter.to_array()) {
            // Filters with negative lobes can make each of them negative.
            check_number("the magnitude of a pixel", value.abs())?;
        }
        Ok(())
    }

    /// Mean radiance of all samples.
    pub(crate) const fn mean(&self) -> Rgb {
        self.mean
    }

    /// Covered fraction of the pixel; valid in plans of transparent images only.
    pub(crate) const fn coverage(&self) -> f64 {
        self.coverage
    }

    /// Samples taken.
    pub(crate) const fn samples(&self) -> u32 {
        self.samples
    }

    /// Passes taken.
    pub(crate) const fn passes(&self) -> u32 {
        self.passes
    }

    /// Squared standard error of the mean, by channel; `None` for fewer than two passes.
    pub(crate) fn variance(&self) -> Option<Rgb> {
        let freedom = f64::from(self.passes) - 1.0;
        (self.passes > 1).then(|| self.scatter / (freedom * f64::from(self.samples)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rt_math::random::{hash, unit};

    fn of(passes: &[(f64, u32)]) -> PixelEstimate {
        let mut estimate = PixelEstimate::default();
        passes.iter().for_each(|&(mean, samples)| estimate.add(Rgb::new(mean, 2.0 * mean, 1e9 + mean), 0.5, samples));
        estimate
    }

    #[test]
    fn one_pass_is_bit_identical_and_has_no_error() {
        let one = of(&[(0.1 + 0.2, 7)]);
        assert_eq!((one.mean().r, one.coverage(), one.samples()), (0.1 + 0.2, 0.5, 7));
        assert_eq!((one.variance(), PixelEstimate::default().variance()), (None, None));
    }

    #[test]
    fn passes_are_weighted_by_samples() {
        // m = (1 + 2·4 + 5·6) / 8 = 39/8; s² = (1·(31/8)² + 2·(7/8)² + 5·(9/8)²) / 2.
        let estimate = of(&[(1.0, 1), (4.0, 2), (6.0, 5)]);
        let variance = (31.0 * 31.0 + 2.0 * 49.0 + 5.0 * 81.0) / 64.0 / 2.0 / 8.0;
        assert!((estimate.mean().r - 39.0 / 8.0).abs() < 1e-15);
        let Some(Rgb { r, g, b }) = estimate.variance() else { panic!("three passes") };
        assert!((r - variance).abs() < 1e-14 && (g - 4.0 * variance).abs() < 1e-14);
        // A billion added to every pass leaves seven digits of their differences.
        assert!((b - variance).abs() < 1e-6, "{b} is not {variance}");
    }

    #[test]
    fn the_expected_error_is_that_of_random_samples() {
        // Uniform numbers have the variance 1/12, and so has the mean of 1 + 2 + 4 + 8 + 16 of them 1/12 / 31.
        let (mut sum, repeats) = (0.0, 4000u64);
        let mut number = (0u64..).map(|index| unit(hash(&[3, index])));
        for _ in 0..repeats {
            let mut mean_of = |samples: u32| number.by_ref().take(samples as usize).sum::<f64>() / f64::from(samples);
            let passes = [1, 2, 4, 8, 16].map(|samples| (mean_of(samples), samples));
            sum += of(&passes).variance().expect("five passes").r;
        }
        let ratio = sum / repeats as f64 * 12.0 * 31.0;
        // A ratio of 1 with a standard error of √(2/4) / √4000, or 0.011.
        assert!((ratio - 1.0).abs() < 0.045, "{ratio}");
    }
}
