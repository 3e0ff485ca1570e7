//! Ordered dithering: rounds values to levels so that their local mean is kept.
//!
//! ```text
//!   value in levels      2.25  2.25  2.25  2.25
//!   threshold            0.13  0.88  0.63  0.38      by position and channel, uniform in (0, 1)
//!   level                3     2     2     2         mean 2.25
//! ```

/// Thresholds by position and channel. Gradients keep their shape, where plain rounding shows bands.
///
/// The level of a value is `⌊value + threshold⌋`. Thresholds are uniform in (0, 1), so that the mean over positions is the
/// value, and values that are levels stay unchanged. They are the additive recurrence R2 (Roberts 2018, "The
/// Unreasonable Effectiveness of Quasirandom Sequences"): even over any small area, without a table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dither {
    /// Position of the film's upper left pixel in the full image, in pixels: a crop is dithered like that part of the
    /// full image.
    pub origin: [u32; 2],
}

/// Thresholds are odd multiples of 2⁻¹³. Values that differ from a level by rounding only never reach another one.
const LOG_THRESHOLDS: u32 = 12;

impl Dither {
    /// The threshold in (0, 1) of a channel of the pixel `[x, y]` of the film.
    pub fn threshold(self, [x, y]: [u32; 2], channel: u32) -> f64 {
        // 2³² divided by the plastic number, by its square, and by 3, so that channels do not change together.
        const STEPS: [u32; 3] = [3_242_174_889, 2_447_445_414, 1_431_655_765];
        let place = [self.origin[0].wrapping_add(x), self.origin[1].wrapping_add(y), channel];
        let sum = place.iter().zip(STEPS).fold(0u32, |sum, (&at, step)| sum.wrapping_add(at.wrapping_mul(step)));
        (f64::from(sum >> (u32::BITS - LOG_THRESHOLDS)) + 0.5) / f64::from(1u32 << LOG_THRESHOLDS)
    }

    /// The level of a value in levels; beyond 0 and 255 that of the limit, of NaN 0.
    pub fn level(self, value: f64, pixel: [u32; 2], channel: u32) -> u8 {
        // The conversion rounds down, saturates, and takes NaN to 0.
        (value + self.threshold(pixel, channel)) as u8
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Means of the levels over the squares of a side into which an area is cut.
    fn means(value: f64, side: u32, channel: u32) -> impl Iterator<Item = f64> {
        let dither = Dither::default();
        (0..8).map(move |square| {
            let corner = [square * side, 3 * square * side];
            let levels = (0..side * side).map(|index| {
                f64::from(dither.level(value, [corner[0] + index % side, corner[1] + index / side], channel))
            });
            levels.sum::<f64>() / f64::from(side * side)
        })
    }

    #[test]
    fn local_means_are_the_values() {
        for thousandths in 0..=1000 {
            let value = 100.0 + f64::from(thousandths) * 0.001;
            for mean in means(value, 16, thousandths % 3) {
                assert!((mean - value).abs() < 0.03, "{value}: {mean}");
            }
            for mean in means(value, 64, thousandths % 3) {
                assert!((mean - value).abs() < 0.002, "{value}: {mean}");
            }
        }
    }

    #[test]
    fn levels_stay_what_they_are() {
        let dither = Dither { origin: [5, 7] };
        for level in 0..=255u8 {
            for (x, channel) in (0..5000).zip((0..3).cycle()) {
                for rounding in [-1e-4, 0.0, 1e-4] {
                    assert_eq!(dither.level(f64::from(level) + rounding, [x, x / 7], channel), level);
                }
            }
        }
        assert_eq!(
            [f64::NAN, -3.0, f64::NEG_INFINITY, 300.0, f64::INFINITY].map(|value| dither.level(value, [3, 4], 1)),
            [0, 0, 0, 255, 255]
        );
    }

    #[test]
    fn thresholds_are_known_by_the_place_in_the_full_image_and_the_channel() {
        let (whole, crop) = (Dither::default(), Dither { origin: [30, 40] });
        for (x, y) in [(0, 0), (1, 5), (100, 2)] {
            assert_eq!(crop.threshold([x, y], 2), whole.threshold([30 + x, 40 + y], 2));
            assert_ne!(whole.threshold([x, y], 0), whole.threshold([x, y], 1));
        }
        let far = Dither { origin: [u32::MAX; 2] }.threshold([u32::MAX; 2], u32::MAX);
        assert!(far > 0.0 && far < 1.0);
    }
}
