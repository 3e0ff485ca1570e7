//! Accumulator of the samples of a pixel.

use rt_math::Rgb;
use rt_shading::RadianceSample;

/// Accumulator of the samples of a pixel.
#[derive(Clone, Copy)]
pub(crate) struct PixelAccumulator {
    sums: [SignedSum; 2],
    transparent: bool,
    bad_samples: u64,
}

impl PixelAccumulator {
    /// A pixel without samples; `transparent` leaves the background out and records coverage.
    pub(crate) fn new(transparent: bool) -> Self {
        Self { sums: [SignedSum::default(); 2], transparent, bad_samples: 0 }
    }

    /// A pixel of the same kind without samples.
    pub(crate) fn cleared(&self) -> Self {
        Self::new(self.transparent)
    }

    /// Adds a sample. One that is not a radiance is counted, and black.
    ///
    /// Positions are drawn in proportion to the magnitude of the filter, so that `weight` is ±∫|f| / ∫f (see [`rt_camera::Filter`]).
    /// Its sign chooses the sum.
    #[inline]
    pub(crate) fn add(&mut self, sample: &RadianceSample, weight: f64) {
        let is_bad = !is_radiance(sample.radiance);
        self.bad_samples += u64::from(is_bad);
        let radiance = if is_bad { Rgb::BLACK } else { sample.radiance };
        let shows = sample.hit || !self.transparent;
        self.sums[usize::from(weight < 0.0)].add(shows.then_some(radiance), weight.abs());
    }

    /// The filtered radiance and coverage. Negative lobes can take coverage out of [0, 1].
    pub(crate) fn mean(&self) -> (Rgb, f64) {
        SignedSum::difference(&self.sums)
    }

    /// Number of samples that were not a radiance.
    pub(crate) const fn bad_samples(&self) -> u64 {
        self.bad_samples
    }
}

/// True for radiance that a film can record: not NaN, not negative, and within the range of `f32`.
fn is_radiance(rgb: Rgb) -> bool {
    rgb.to_array().iter().all(|c| (0.0..=f64::from(f32::MAX)).contains(c))
}

/// Samples that fell into the positive or into the negative part of a filter. All samples of filters without negative lobes have weight 1
/// and lie in the first.
///
/// ```text
///   L₊ + M n₋/n (L₊ − L₋)        M = (∫ positive part + ∫ negative part) / ∫ filter
/// ```
///
/// L₊ and L₋ are the means of the parts, and n₋ of n samples are in the negative one. A flat area stays flat, however many samples fall into
/// each. On average n₋/n is the negative share of the filter. So the mean is that of the filter, unless all samples are
/// in the negative part: with four, these are few pixels.
#[derive(Clone, Copy, Default)]
struct SignedSum {
    radiance: Rgb,
    coverage: f64,
    count: f64,
    /// Magnitude of the weights, the same for all: (∫ positive part + ∫ negative part) / ∫ filter.
    magnitude: f64,
}

impl SignedSum {
    /// Adds a sample; `None` for one without coverage.
    #[inline]
    fn add(&mut self, radiance: Option<Rgb>, magnitude: f64) {
        self.count += 1.0;
        self.magnitude = magnitude;
        if let Some(radiance) = radiance {
            self.radiance += radiance;
            self.coverage += 1.0;
        }
    }

    fn mean(&self) -> (Rgb, f64) {
        let scale = 1.0 / self.count;
        (self.radiance * scale, self.coverage * scale)
    }

    /// The filtered radiance and coverage of a pixel; the mean of the negative part if all samples are in it.
    fn difference([positive, negative]: &[Self; 2]) -> (Rgb, f64) {
        if negative.count == 0.0 {
            return positive.mean();
        }
        if positive.count == 0.0 {
            return negative.mean();
        }
        let share = negative.magnitude * negative.count / (positive.count + negative.count);
        let ((plus, plus_coverage), (minus, minus_coverage)) = (positive.mean(), negative.mean());
        (plus + (plus - minus) * share, plus_coverage + (plus_coverage - minus_coverage) * share)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rt_math::random::{hash, unit};

    const MAGNITUDE: f64 = 1.25;

    /// Mean over pixels of this many samples, a tenth of which are in the negative part.
    fn mean_of(n: u64, radiance: [f64; 2]) -> f64 {
        let negative_share = 0.5 * (MAGNITUDE - 1.0) / MAGNITUDE;
        let pixel = |at: u64| {
            let mut pixel = PixelAccumulator::new(false);
            for sample in 0..n {
                let is_negative = unit(hash(&[at, sample])) < negative_share;
                let radiance = Rgb::gray(radiance[usize::from(is_negative)]);
                let weight = if is_negative { -MAGNITUDE } else { MAGNITUDE };
                pixel.add(&RadianceSample { radiance, hit: true }, weight);
            }
            pixel.mean().0.g
        };
        let n_pixels = 40_000;
        (0..n_pixels).map(pixel).sum::<f64>() / n_pixels as f64
    }

    /// Regression: a pixel without samples in the negative part had the mean of the positive one, which no number of passes mended.
    #[test]
    fn a_filter_with_negative_lobes_has_its_mean_with_any_number_of_samples() {
        for n in [4, 8, 16, 64] {
            assert!((mean_of(n, [1.0, 1.0]) - 1.0).abs() < 1e-12, "{n} samples on a flat area");
            // 1.125 · 1 − 0.125 · 0, with a standard error of less than a thousandth.
            let at_edge = mean_of(n, [1.0, 0.0]);
            assert!((at_edge - 1.125).abs() < 0.004, "{n} samples: {at_edge}");
        }
    }
}
