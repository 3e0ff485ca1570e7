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

/// Samples that fell into the positive or into the negative part of a filter.
///
/// The two are averaged apart and then subtracted: a flat area stays flat, however many samples fall into each. All
/// samples of filters without negative lobes have weight 1 and lie in the first.
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

    /// The filtered radiance and coverage of a pixel; where one lobe has no sample, the mean of the other.
    fn difference([positive, negative]: &[Self; 2]) -> (Rgb, f64) {
        if negative.count == 0.0 {
            return positive.mean();
        }
        if positive.count == 0.0 {
            return negative.mean();
        }
        // The parts differ by 1 and add up to the magnitude.
        let share = 0.5 * (negative.magnitude - 1.0);
        let ((plus, plus_coverage), (minus, minus_coverage)) = (positive.mean(), negative.mean());
        (plus * (1.0 + share) - minus * share, plus_coverage * (1.0 + share) - minus_coverage * share)
    }
}
