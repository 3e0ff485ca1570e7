//! Exposures at which HDR-FLIP compares images of high dynamic range.

use rt_math::{Rgb, transcendental::log2};

use crate::Image;

/// Displayed light at which a pixel counts as about to be too bright.
const BRIGHT: f64 = 0.85;
/// Luminance that replaces 0 in logarithms.
const DARKEST: f64 = f32::EPSILON as f64;

/// Exposures in steps of at most two stops. The first displays the brightest pixel of the reference at 0.85, the last
/// the pixel of median luminance (Andersson et al. 2021).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExposureRange {
    /// The shortest exposure, in stops.
    pub start: f64,
    /// The longest exposure, in stops.
    pub stop: f64,
    /// Number of exposures, at least 2.
    pub count: u32,
}

impl ExposureRange {
    /// The range that fits a reference, of which only the finite pixels are looked at.
    ///
    /// The exposures are those of [`ToneCurve::Aces`](crate::ToneCurve::Aces). Programs that multiply radiance by 0.6
    /// in this curve use exposures that are higher by log₂ 1/0.6 = 0.74.
    pub fn fitting(reference: &Image) -> Self {
        // Luminance has the weights of the metric's colour space to four digits.
        let luminances = reference.pixels().iter().map(|pixel| Rgb::from(pixel.map(f64::from)).luminance());
        let mut luminances: Vec<_> = luminances.filter(|luminance| luminance.is_finite()).collect();
        let middle = luminances.len() / 2;
        let (median, max) = if luminances.is_empty() {
            (DARKEST, DARKEST)
        } else {
            let (_, &mut median, above) = luminances.select_nth_unstable_by(middle, f64::total_cmp);
            (median.max(DARKEST), above.iter().copied().fold(median, f64::max).max(DARKEST))
        };
        let bright = radiance_displayed_as(BRIGHT);
        let (start, stop) = (log2(bright / max), log2(bright / median));
        // The range of `f32` has 277 stops, and a few more to `DARKEST`.
        Self { start, stop, count: ((stop - start).ceil() as u32).max(2) }
    }

    /// The exposures in stops, from the shortest to the longest.
    pub fn exposures(&self) -> impl Iterator<Item = f64> + use<> {
        let (start, step) = (self.start, (self.stop - self.start) / f64::from(self.count.max(2) - 1));
        (0..self.count).map(move |index| start + f64::from(index) * step)
    }
}

/// The radiance that [`ToneCurve::Aces`](crate::ToneCurve::Aces) displays as the given light: the positive root of a quadratic.
fn radiance_displayed_as(light: f64) -> f64 {
    // light = (2.51 x² + 0.03 x) / (2.43 x² + 0.59 x + 0.14).
    let (a, b, c) = (2.51 - light * 2.43, 0.03 - light * 0.59, -light * 0.14);
    (-b + (b * b - 4.0 * a * c).sqrt()) / (2.0 * a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ToneCurve, test_images::film};
    use rt_math::transcendental::exp2;

    #[test]
    fn the_curve_is_inverted() {
        for light in [0.1, 0.5, BRIGHT, 0.99] {
            assert!((ToneCurve::Aces.apply(radiance_displayed_as(light)) - light).abs() < 1e-14, "{light}");
        }
    }

    #[test]
    fn the_brightest_and_the_median_pixel_become_bright() {
        let grey = |level: f32| [level; 3];
        let reference = film(5, 1, &[grey(0.25), grey(40.0), grey(0.5), grey(0.0), [f32::NAN; 3]]);
        let range = ExposureRange::fitting(&reference);
        let displayed = |radiance: f64, exposure: f64| ToneCurve::Aces.apply(radiance * exp2(exposure));
        assert!((displayed(40.0, range.start) - BRIGHT).abs() < 1e-12);
        // Of an even number of pixels, the median is the brighter one in the middle.
        assert!((displayed(0.5, range.stop) - BRIGHT).abs() < 1e-12);
        // log2(80) = 6.3 stops.
        assert_eq!(range.count, 7);
        let exposures: Vec<_> = range.exposures().collect();
        assert_eq!((exposures.len(), exposures[0]), (7, range.start));
        assert!((exposures[6] - range.stop).abs() < 1e-12);
    }

    #[test]
    fn black_and_broken_references_have_a_range() {
        for pixel in [[0.0; 3], [-1.0; 3], [f32::NAN; 3]] {
            let range = ExposureRange::fitting(&film(1, 1, &[pixel]));
            assert_eq!((range.start, range.count), (range.stop, 2), "{pixel:?}");
            assert!(range.start.is_finite());
        }
        let wide = ExposureRange::fitting(&film(3, 1, &[[0.0; 3], [0.0; 3], [f32::MAX; 3]]));
        assert_eq!(wide.count, 151);
    }
}
