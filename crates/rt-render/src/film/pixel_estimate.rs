//! Mean of a pixel over its passes, and its standard error.
//!
//! ```text
//!      m = Σ Kₚ mₚ / N                      mₚ: mean of the Kₚ samples of pass p, N = Σ Kₚ
//!      V = (E² Vₑ + L² Vₗ) / N²             squared standard error of m
//!
//!      Vₗ = Σ (mₚ − mₗ)² / ((n − 1) n)      of the last L = n K samples: n ≥ 2 passes of the same size K
//!      Vₑ                                   of the E samples before them, found in the same way
//!      L² Vₗ = K² ((mₗ − mₑ)² − Vₑ)         if there is one pass of the last size, and K ≤ E
//! ```
//!
//! Each of these estimates is unbiased, however the variance of a pass falls with its samples. Only equal passes are compared
//! with each other, or a pass with all before it, whose variance is known. A sum of Kₚ (mₚ − m)² over passes of any size would assume that
//! the variance is σ² / Kₚ. That holds for random samples only; for Sobol' points it overestimates the error up to several times.

use rt_math::Rgb;
use serde::{Deserialize, Serialize};

use crate::{ContentError, content_checks::check_number};

/// Pixel accumulator over passes. The updates of means are numerically stable (West 1979).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct PixelEstimate {
    mean: Rgb,
    coverage: f64,
    samples: u32,
    passes: u32,
    /// The last passes that have the same size.
    last: EqualPasses,
    /// E² Vₑ.
    earlier: Rgb,
    /// 1 over the degrees of freedom of Vₑ; 0 if it is unknown.
    earlier_spread: f64,
}

/// Passes of one size.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct EqualPasses {
    mean: Rgb,
    /// Σ K (mₚ − mₗ)².
    scatter: Rgb,
    /// Samples of each pass.
    spp: u32,
    passes: u32,
}

impl EqualPasses {
    #[inline]
    fn add(&mut self, mean: Rgb) {
        self.passes = self.passes.saturating_add(1);
        if self.passes == 1 {
            self.mean = mean;
            return;
        }
        let weight = f64::from(self.spp);
        let share = weight / self.samples();
        let old_delta = mean - self.mean;
        self.mean += old_delta * share;
        self.scatter += old_delta * (mean - self.mean) * weight;
    }

    fn samples(&self) -> f64 {
        f64::from(self.spp) * f64::from(self.passes)
    }

    /// Degrees of freedom of the scatter.
    fn freedom(&self) -> f64 {
        f64::from(self.passes) - 1.0
    }
}

impl PixelEstimate {
    /// Adds a pass by its mean and its number of samples.
    #[inline]
    pub(crate) fn add(&mut self, mean: Rgb, coverage: f64, samples: u32) {
        if samples != self.last.spp {
            (self.earlier, self.earlier_spread) = self.error().unwrap_or_default();
            self.last = EqualPasses { spp: samples, ..EqualPasses::default() };
        }
        self.last.add(mean);
        // Counts saturate at 2³² − 1. Beyond it, the weights of passes are approximate.
        self.samples = self.samples.saturating_add(samples);
        self.passes = self.passes.saturating_add(1);
        if self.passes == 1 {
            (self.mean, self.coverage) = (mean, coverage);
            return;
        }
        let share = f64::from(samples) / f64::from(self.samples);
        self.mean += (mean - self.mean) * share;
        self.coverage += (coverage - self.coverage) * share;
    }

    /// Checks that all numbers are finite and the counts within limits. `index` identifies the pixel in errors.
    pub(crate) fn validate(&self, index: usize, max_passes: u32, max_samples: u32) -> Result<(), ContentError> {
        let Self { mean, coverage, samples, passes, last, earlier, earlier_spread } = *self;
        let has_wrong_counts = passes > max_passes || samples > max_samples || passes > samples;
        let has_wrong_last = last.passes > passes || last.samples() > f64::from(samples);
        let has_wrong_spread = !(0.0..=1.0).contains(&earlier_spread);
        if has_wrong_counts || has_wrong_last || has_wrong_spread || (passes == 0) != (samples == 0) {
            return Err(ContentError::Pixel(index));
        }
        let colors = [mean, last.mean, last.scatter, earlier];
        for value in [coverage].into_iter().chain(colors.into_iter().flat_map(Rgb::to_array)) {
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

    pub(crate) const fn samples(&self) -> u32 {
        self.samples
    }

    pub(crate) const fn passes(&self) -> u32 {
        self.passes
    }

    /// Squared standard error of the mean, by channel; `None` for fewer than two passes.
    pub(crate) fn variance(&self) -> Option<Rgb> {
        let samples = f64::from(self.samples);
        if self.last.passes == self.passes {
            return (self.passes > 1).then(|| self.last.scatter / (self.last.freedom() * samples));
        }
        self.error().map(|(error, _)| error / (samples * samples))
    }

    /// Degrees of freedom of the [`variance`](Self::variance) for random samples, at least 1 (Satterthwaite 1946). Those of better patterns
    /// are similar.
    pub(crate) fn freedom(&self) -> f64 {
        self.error().map_or(1.0, |(_, spread)| 1.0 / spread)
    }

    fn knows_earlier(&self) -> bool {
        self.earlier_spread > 0.0
    }

    /// N² V by channel, and 1 over its degrees of freedom; `None` for fewer than two passes.
    fn error(&self) -> Option<(Rgb, f64)> {
        if self.passes < 2 {
            return None;
        }
        let (all, last) = (f64::from(self.samples), self.last.samples());
        let earlier = all - last;
        if self.last.passes > 1 {
            let of_last = self.last.scatter * (last / self.last.freedom());
            let (share, earlier_share) = (last / all, earlier / all);
            let spread = share * share / self.last.freedom();
            return Some(if self.knows_earlier() || earlier == 0.0 {
                (self.earlier + of_last, spread + earlier_share * earlier_share * self.earlier_spread)
            } else {
                // A single pass of another size says nothing about its own variance.
                (of_last * (all / last), 1.0 / self.last.freedom())
            });
        }
        // m − mₗ is E / N of mₑ − mₗ.
        let difference = (self.last.mean - self.mean) * (all / earlier);
        let square = difference * difference;
        let ratio = last / earlier;
        Some(if ratio <= 1.0 && self.knows_earlier() {
            let spread = ratio * ratio + (1.0 - ratio) * (1.0 - ratio) * self.earlier_spread;
            (self.earlier * (1.0 - ratio * ratio) + square * (last * last), spread)
        } else {
            // As for random samples. Two passes of the same size need no assumption, and stop rules make no larger ones.
            (square * (last * earlier), 1.0)
        })
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
        // m = (2·1 + 2·4 + 4·6) / 8 = 34/8. V of the first four samples is (4 − 1)² / 4, and that of all (6 − 5/2)² / 4.
        assert_eq!(of(&[(1.0, 2), (4.0, 2)]).variance().map(|variance| variance.r), Some(9.0 / 4.0));
        let estimate = of(&[(1.0, 2), (4.0, 2), (6.0, 4)]);
        let variance = 12.25 / 4.0;
        assert!((estimate.mean().r - 34.0 / 8.0).abs() < 1e-15);
        let Some(Rgb { r, g, b }) = estimate.variance() else { panic!("three passes") };
        assert!((r - variance).abs() < 1e-14 && (g - 4.0 * variance).abs() < 1e-14);
        // A billion added to every pass leaves seven digits of their differences.
        assert!((b - variance).abs() < 1e-6, "{b} is not {variance}");
    }

    /// Regression: the error of samples whose variance falls faster than that of random ones was overestimated, 2.5 times for Sobol'
    /// points on a smooth image. Passes of unequal size were compared with each other.
    #[test]
    fn the_expected_error_is_right_however_fast_the_variance_falls() {
        let schedules = [
            &[1, 1][..],
            &[1, 1, 2],
            &[1, 1, 2, 4, 8, 16],
            &[1, 1, 2, 4, 8, 16, 16, 16],
            &[4, 4, 4, 4, 8],
            &[4, 4, 4, 4, 8, 8],
            &[4, 4, 4, 4, 8, 8, 16],
            &[4, 4, 4, 4, 8, 8, 16, 16],
            &[8, 8, 8, 8, 16, 16, 16, 16],
        ];
        let mut number = (0u64..).map(|index| unit(hash(&[3, index])));
        for exponent in [1, 2, 3] {
            for schedule in schedules {
                let deviation = |samples: u32| (0..exponent).map(|_| 1.0 / f64::from(samples)).product::<f64>().sqrt();
                let weighted = |&samples: &u32| f64::from(samples) * deviation(samples);
                let squares = schedule.iter().map(|samples| weighted(samples) * weighted(samples));
                let total: u32 = schedule.iter().sum();
                let expected = squares.sum::<f64>() / f64::from(total * total);
                let (mut sum, mut spread, repeats) = (0.0, 0.0, 4000);
                for _ in 0..repeats {
                    // Uniform numbers of variance 1 around 0.
                    let mut unit = || 12f64.sqrt() * (number.next().expect("endless") - 0.5);
                    let mut pass = |samples: u32| (deviation(samples) * unit(), samples);
                    let passes: Vec<_> = schedule.iter().map(|&samples| pass(samples)).collect();
                    let variance = of(&passes).variance().expect("several passes").r;
                    sum += variance;
                    spread += variance * variance;
                }
                let mean = sum / f64::from(repeats);
                let error = ((spread / f64::from(repeats) - mean * mean) / f64::from(repeats)).sqrt();
                assert!(
                    (mean - expected).abs() < 4.5 * error,
                    "{schedule:?}, {exponent}: {mean} ± {error}, not {expected}"
                );
            }
        }
    }

    #[test]
    fn degrees_of_freedom_are_those_of_random_samples() {
        let freedom =
            |schedule: &[u32]| of(&schedule.iter().map(|&samples| (0.0, samples)).collect::<Vec<_>>()).freedom();
        assert_eq!([&[3; 2][..], &[3; 5], &[1, 1, 2], &[1, 1, 2, 4]].map(freedom), [1.0, 4.0, 1.0, 1.0]);
        // Half of the error comes from four passes, and half from two.
        assert!((freedom(&[4, 4, 4, 4, 8, 8]) - 1.0 / (0.25 / 3.0 + 0.25)).abs() < 1e-14);
        // The last pass has half of the error of 24 samples.
        assert!((freedom(&[4, 4, 4, 4, 8]) - 1.0 / (0.25 / 3.0 + 0.25)).abs() < 1e-14);
    }
}
