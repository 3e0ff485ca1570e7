//! One error for each pixel.

use super::ImagePair;

/// An error for each pixel, row by row from the top; NaN where there is none.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorMap {
    width: u32,
    height: u32,
    values: Vec<f32>,
}

impl ErrorMap {
    /// A map of the size of the pair.
    pub(super) fn new(pair: &ImagePair<'_>, values: Vec<f32>) -> Self {
        Self { width: pair.width(), height: pair.height(), values }
    }

    /// Width in pixels.
    pub const fn width(&self) -> u32 {
        self.width
    }

    /// Height in pixels.
    pub const fn height(&self) -> u32 {
        self.height
    }

    /// The errors, row by row from the top.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// The error of the pixel in column `x` and row `y`; `None` outside the image, and where there is none.
    pub fn value(&self, x: u32, y: u32) -> Option<f32> {
        let inside = x < self.width && y < self.height;
        let index = y as usize * self.width as usize + x as usize;
        inside.then(|| self.values[index]).filter(|value| !value.is_nan())
    }

    /// The mean of all errors; NaN if there are none.
    pub fn mean(&self) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0);
        for &value in self.values.iter().filter(|value| !value.is_nan()) {
            sum += f64::from(value);
            count += 1.0;
        }
        sum / count
    }

    /// The magnitude that a part `fraction` of all errors does not exceed: the greatest one for 1, 0 without errors.
    pub fn magnitude_quantile(&self, fraction: f64) -> f64 {
        let mut magnitudes: Vec<_> = self.values.iter().filter(|v| !v.is_nan()).map(|v| v.abs()).collect();
        // The conversion saturates, and takes NaN to 0.
        let rank = (fraction * magnitudes.len() as f64).ceil() as usize;
        let index = rank.clamp(1, magnitudes.len().max(1)) - 1;
        if magnitudes.is_empty() {
            return 0.0;
        }
        f64::from(*magnitudes.select_nth_unstable_by(index, f32::total_cmp).1)
    }
}

/// Test minus reference, in units of radiance, of the channel of each pixel that differs most. Unlike in a mean over
/// the channels, a red error and a green one do not cancel. NaN where a pixel is not finite in one of the images.
pub fn signed_error(pair: &ImagePair<'_>) -> ErrorMap {
    let greater = |a: f64, b: f64| if b.abs() > a.abs() { b } else { a };
    let errors =
        pair.pixels().map(|pixel| pixel.map_or(f64::NAN, |pixel| pixel.error().into_iter().fold(0.0, greater)));
    ErrorMap::new(pair, errors.map(|error| error as f32).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_images::{film, film_of};

    #[test]
    fn the_channel_that_differs_most_gives_its_sign() {
        let test = film(3, 1, &[[1.0, -0.5, 0.0], [0.25, -2.0, 1.0], [f32::INFINITY, 0.0, 0.0]]);
        let reference = film(3, 1, &[[0.0; 3]; 3]);
        let map = signed_error(&ImagePair::new(&test, &reference).expect("alike"));
        assert_eq!(
            [map.value(0, 0), map.value(1, 0), map.value(2, 0), map.value(0, 1)],
            [Some(1.0), Some(-2.0), None, None]
        );
        assert_eq!(map.mean(), -0.5);
        assert_eq!(map.magnitude_quantile(1.0), 2.0);
    }

    #[test]
    fn quantiles_are_those_of_the_sorted_magnitudes() {
        let test = film_of(100, 10, |x, y| [if (x + y) % 2 == 0 { 1.0 } else { -1.0 } * (100 * y + x + 1) as f32; 3]);
        let reference = film_of(100, 10, |_, _| [0.0; 3]);
        let map = signed_error(&ImagePair::new(&test, &reference).expect("alike"));
        for (fraction, magnitude) in
            [(1.0, 1000.0), (0.999, 999.0), (0.5, 500.0), (0.0, 1.0), (f64::NAN, 1.0), (7.0, 1000.0)]
        {
            assert_eq!(map.magnitude_quantile(fraction), magnitude, "{fraction}");
        }
    }
}
