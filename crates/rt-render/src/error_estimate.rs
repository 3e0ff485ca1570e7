//! Error of an image, estimated from the differences between its passes.
//!
//! ```text
//!      vᵢ: squared standard error of pixel i, mean of channels               MSE ≈ V = mean of vᵢ
//!      V F₀.₀₂₅(m, n) ≤ MSE ≤ V F₀.₉₇₅(m, n)        m = (Σ vᵢ)² / Σ vᵢ²        n = (Σ vᵢ)² / Σ vᵢ² / fᵢ
//!      fᵢ: degrees of freedom of vᵢ
//! ```
//!
//! The interval bounds the error of *this* image, as a comparison with an exact image would measure it. Two uncertainties
//! enter:
//!
//! * The estimate V has n degrees of freedom.
//! * The sum of squared pixel errors has m degrees of freedom.
//!
//! Both numbers follow Satterthwaite (1946) and are small where few pixels have most of the error. They are biased low, since
//! squares of uncertain variances are too large on average. The interval is therefore slightly too wide.
//!
//! Pixels count as independent, the channels of a pixel as one value.

use rt_math::Rgb;
use rt_math::stats::f_quantile;
use serde::{Deserialize, Serialize};

use crate::{
    ContentError,
    content_checks::{check_count, check_number},
    film::pixel_estimate::PixelEstimate,
};

/// Added to squared radiance before it divides an error, as in [`rt_image::metrics`].
const RELATIVE_EPSILON: f64 = 1e-2;

/// Passes beyond which the number of degrees of freedom no longer changes the interval.
const MAX_PASSES: f64 = 65_536.0;

/// Estimated error of an image relative to infinitely many samples. Bias of a sample pattern or integrator is not included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorEstimate {
    /// Root mean square over pixels and channels, in units of radiance.
    pub rmse: f64,
    /// Confidence interval of the root mean square error, at 95 %.
    pub interval: [f64; 2],
    /// Mean radiance over pixels and channels.
    pub mean: f64,
    /// Root mean square of the error divided by √(r² + 0.01), where r is the radiance of the pixel.
    pub relative: f64,
    /// Largest standard error of a channel of a pixel.
    pub largest: f64,
}

impl ErrorEstimate {
    /// Root mean square error over mean radiance; 0 for an image without error, and infinite for a black image with error.
    pub fn relative_rmse(&self) -> f64 {
        relative(self.rmse, self.mean)
    }

    /// Confidence interval of the relative root mean square error, at 95 %. The mean over the image counts as exact: its error
    /// is smaller by the square root of the number of pixels.
    pub fn relative_interval(&self) -> [f64; 2] {
        self.interval.map(|rmse| relative(rmse, self.mean))
    }
}

fn relative(rmse: f64, mean: f64) -> f64 {
    match rmse {
        0.0 => 0.0,
        _ if mean > 0.0 => rmse / mean,
        _ => f64::INFINITY,
    }
}

/// Sums over pixels for the error estimate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct ErrorSums {
    pixels: u64,
    /// Σ vᵢ.
    squares: f64,
    /// Σ vᵢ² / fᵢ.
    spread_of_estimate: f64,
    /// Σ vᵢ².
    spread_of_error: f64,
    relative: f64,
    largest: f64,
    /// Sum of the radiance of pixels, mean of channels.
    radiance: f64,
}

impl ErrorSums {
    pub(crate) fn of<'p>(pixels: impl IntoIterator<Item = &'p PixelEstimate>) -> Self {
        let mut sums = Self::default();
        pixels.into_iter().for_each(|pixel| sums.add(pixel));
        sums
    }

    /// Adds a pixel. Pixels of fewer than two passes have no error estimate and are skipped.
    fn add(&mut self, pixel: &PixelEstimate) {
        let Some(variance) = pixel.variance() else { return };
        let mean_of_channels = |rgb: Rgb| (rgb.r + rgb.g + rgb.b) / 3.0;
        let square = mean_of_channels(variance);
        let weights = (pixel.mean() * pixel.mean()).map(|square| 1.0 / (square + RELATIVE_EPSILON));
        self.pixels += 1;
        self.squares += square;
        self.spread_of_estimate += square * square / pixel.freedom();
        self.spread_of_error += square * square;
        self.relative += mean_of_channels(variance * weights);
        self.largest = self.largest.max(variance.max_component().sqrt());
        self.radiance += mean_of_channels(pixel.mean());
    }

    /// Checks the sums over a tile of `area` pixels.
    pub(crate) fn validate(&self, area: u64) -> Result<(), ContentError> {
        let Self { pixels, squares, spread_of_estimate, spread_of_error, relative, largest, radiance } = *self;
        check_count("pixels of an error", pixels, area)?;
        [squares, spread_of_estimate, spread_of_error, relative, largest]
            .into_iter()
            .try_for_each(|sum| check_number("a sum of squared errors", sum))?;
        // Negative lobes of a filter may make pixels negative.
        check_number("the sum of the radiance", radiance.abs())
    }

    /// Sums over all shards of the image. Their last digits depend on the order of the shards.
    pub(crate) fn merged(shards: impl IntoIterator<Item = Self>) -> Self {
        shards.into_iter().fold(Self::default(), |all, shard| Self {
            pixels: all.pixels + shard.pixels,
            squares: all.squares + shard.squares,
            spread_of_estimate: all.spread_of_estimate + shard.spread_of_estimate,
            spread_of_error: all.spread_of_error + shard.spread_of_error,
            relative: all.relative + shard.relative,
            largest: all.largest.max(shard.largest),
            radiance: all.radiance + shard.radiance,
        })
    }

    /// Root mean square error over all added pixels; `None` without any.
    pub(crate) fn rmse(&self) -> Option<f64> {
        (self.pixels > 0).then(|| (self.squares / self.pixels as f64).sqrt())
    }

    /// Root mean square error over mean radiance of all added pixels; `None` without any.
    pub(crate) fn relative_rmse(&self) -> Option<f64> {
        Some(relative(self.rmse()?, self.radiance / self.pixels as f64))
    }

    /// The estimate over all added pixels; `None` without any.
    pub(crate) fn estimate(&self) -> Option<ErrorEstimate> {
        let rmse = self.rmse()?;
        let interval = if self.spread_of_estimate > 0.0 {
            // Valid sums lie far within these bounds. They bound the run time of the quantile for crafted files.
            let max = 2.0 * self.pixels as f64;
            let freedom = |spread: f64, max: f64| (self.squares * self.squares / spread).clamp(0.5, max);
            let (m, n) = (freedom(self.spread_of_error, max), freedom(self.spread_of_estimate, max * MAX_PASSES));
            if m.is_nan() || n.is_nan() {
                [0.0, f64::INFINITY]
            } else {
                [0.025, 0.975].map(|probability| rmse * f_quantile(probability, m, n).sqrt())
            }
        } else {
            [rmse; 2]
        };
        let relative = (self.relative / self.pixels as f64).sqrt();
        let mean = self.radiance / self.pixels as f64;
        Some(ErrorEstimate { rmse, interval, mean, relative, largest: self.largest })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rt_math::random::{hash, unit};

    /// Approximately normal random numbers of variance 1: the sum of twelve uniform ones (Irwin and Hall 1927).
    fn normal(words: [u64; 4]) -> f64 {
        (0..12).map(|index| unit(hash(&[words[0], words[1], words[2], words[3], index]))).sum::<f64>() - 6.0
    }

    /// Number of images whose true error lies within the interval. They have 60 pixels of unequal noise.
    fn covered(images: u64, passes: &[u32]) -> usize {
        let noise = |pixel: u64| if pixel.is_multiple_of(10) { 5.0 } else { 0.3 };
        let is_covered = |image: &u64| {
            let (mut sums, mut true_square) = (ErrorSums::default(), 0.0);
            for pixel in 0..60 {
                let mut estimate = PixelEstimate::default();
                for (pass, &samples) in passes.iter().enumerate() {
                    let deviation = noise(pixel) / f64::from(samples).sqrt();
                    let error = deviation * normal([passes.len() as u64, *image, pixel, pass as u64]);
                    estimate.add(Rgb::gray(7.0 + error), 1.0, samples);
                }
                sums.add(&estimate);
                let error = estimate.mean().r - 7.0;
                true_square += error * error / 60.0;
            }
            let [low, high] = sums.estimate().expect("several passes").interval;
            (low..=high).contains(&true_square.sqrt())
        };
        (0..images).filter(is_covered).count()
    }

    #[test]
    fn the_interval_covers_the_true_error_as_often_as_it_says() {
        for passes in [&[4; 2][..], &[4; 4], &[1; 16], &[1, 1, 2, 4, 8, 16, 16]] {
            let covered = covered(1000, passes);
            // At least 950 expected, with a standard deviation of 7: six pixels have nearly all of the error.
            assert!((930..=998).contains(&covered), "{covered} of 1000 with passes of {passes:?}");
        }
    }

    #[test]
    fn without_two_passes_there_is_no_estimate() {
        let mut sums = ErrorSums::default();
        assert_eq!(sums.estimate(), None);
        let mut pixel = PixelEstimate::default();
        pixel.add(Rgb::WHITE, 1.0, 4);
        sums.add(&pixel);
        assert_eq!(sums.estimate(), None);
    }

    #[test]
    fn equal_passes_have_no_error() {
        let mut pixel = PixelEstimate::default();
        (0..3).for_each(|_| pixel.add(Rgb::WHITE, 1.0, 4));
        let sums = ErrorSums::of(&[pixel]);
        let none = ErrorEstimate { rmse: 0.0, interval: [0.0; 2], mean: 1.0, relative: 0.0, largest: 0.0 };
        assert_eq!(sums.estimate(), Some(none));
    }

    #[test]
    fn the_relative_error_does_not_depend_on_the_unit_of_light() {
        let of = |unit: f64| {
            let mut pixel = PixelEstimate::default();
            [1.0, 2.0, 6.0].into_iter().for_each(|mean| pixel.add(Rgb::gray(mean * unit), 1.0, 4));
            let sums = ErrorSums::of(&[pixel]);
            let estimate = sums.estimate().expect("three passes");
            assert_eq!(sums.relative_rmse(), Some(estimate.relative_rmse()));
            estimate
        };
        // m = 3 and s² = (4 + 1 + 9) · 4 / 2, over 12 samples.
        assert!((of(1.0).relative_rmse() - (28.0f64 / 12.0).sqrt() / 3.0).abs() < 1e-15);
        assert_eq!(of(1.0).relative_rmse(), of(1.0 / 1024.0).relative_rmse());
        assert_eq!(of(1.0).relative_interval(), of(1.0 / 1024.0).relative_interval());
        assert_eq!((of(0.0).relative_rmse(), of(-1.0).relative_rmse()), (0.0, f64::INFINITY));
    }

    #[test]
    fn parts_join_to_the_whole() {
        let pixels: Vec<_> = (0..8u64)
            .map(|pixel| {
                let mut estimate = PixelEstimate::default();
                (0..3).for_each(|pass| estimate.add(Rgb::gray(unit(hash(&[pixel, pass]))), 1.0, 1));
                estimate
            })
            .collect();
        let merged = ErrorSums::merged([ErrorSums::of(&pixels[..3]), ErrorSums::of(&pixels[3..])]);
        let (whole, merged) = (ErrorSums::of(&pixels).estimate().expect("passes"), merged.estimate().expect("passes"));
        assert!((whole.rmse - merged.rmse).abs() < 1e-15 && whole.largest == merged.largest);
        assert!(whole.interval[0] < whole.rmse && whole.rmse < whole.interval[1]);
    }
}
