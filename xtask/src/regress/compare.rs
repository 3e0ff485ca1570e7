//! Difference of two images.

use image::{Rgba, RgbaImage};

/// The difference between two images of one size.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Difference {
    /// Pixels with a channel that differs by more than the tolerance.
    pub outliers: u64,
    /// All pixels.
    pub pixels: u64,
    /// The pixel that differs most, the first in reading order; `None` if the images are equal.
    pub worst: Option<WorstPixel>,
    /// Root of the mean squared difference over all pixels and channels, of 1.
    pub rmse: f64,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct WorstPixel {
    pub x: u32,
    pub y: u32,
    /// Maximum difference of a channel, of 255.
    pub difference: u8,
    pub expected: [u8; 4],
    pub actual: [u8; 4],
}

/// Images that cannot be compared pixel by pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected {}×{} pixels, got {}×{}", expected.0, expected.1, actual.0, actual.1)]
pub(crate) struct SizesDiffer {
    pub expected: (u32, u32),
    pub actual: (u32, u32),
}

impl Difference {
    /// Compares all channels, alpha included. A pixel is an outlier if a channel differs by more than `tolerance`.
    pub(crate) fn of(expected: &RgbaImage, actual: &RgbaImage, tolerance: u8) -> Result<Self, SizesDiffer> {
        if expected.dimensions() != actual.dimensions() {
            return Err(SizesDiffer { expected: expected.dimensions(), actual: actual.dimensions() });
        }
        let mut difference = Self { outliers: 0, pixels: 0, worst: None, rmse: 0.0 };
        let mut squares = 0_u64;
        for ((x, y, expected), actual) in expected.enumerate_pixels().zip(actual.pixels()) {
            let of_pixel = max_difference(expected, actual);
            difference.pixels += 1;
            difference.outliers += u64::from(of_pixel > tolerance);
            squares += squared(expected, actual);
            if of_pixel > difference.worst.as_ref().map_or(0, |worst| worst.difference) {
                difference.worst =
                    Some(WorstPixel { x, y, difference: of_pixel, expected: expected.0, actual: actual.0 });
            }
        }
        difference.rmse = (squares as f64 / (4 * difference.pixels.max(1)) as f64).sqrt() / 255.0;
        Ok(difference)
    }

    pub(crate) fn outlier_share(&self) -> f64 {
        self.outliers as f64 / self.pixels.max(1) as f64
    }
}

/// Maximum difference of a channel.
pub(crate) fn max_difference(a: &Rgba<u8>, b: &Rgba<u8>) -> u8 {
    let differences = a.0.iter().zip(b.0).map(|(&a, b)| a.abs_diff(b));
    differences.max().unwrap_or(0)
}

fn squared(a: &Rgba<u8>, b: &Rgba<u8>) -> u64 {
    a.0.iter().zip(b.0).map(|(&a, b)| u64::from(a.abs_diff(b)).pow(2)).sum()
}

impl std::fmt::Display for Difference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Some(worst) = &self.worst else { return write!(f, "equal") };
        let WorstPixel { x, y, difference, expected, actual } = worst;
        write!(
            f,
            "{} of {} pixels off; worst by {difference} at ({x}, {y}): expected {expected:?}, got {actual:?}; RMSE {:.3}/255",
            self.outliers,
            self.pixels,
            self.rmse * 255.0
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(width: u32, height: u32) -> RgbaImage {
        RgbaImage::from_pixel(width, height, Rgba([100, 100, 100, 255]))
    }

    #[test]
    fn equal_images_have_no_worst_pixel() {
        let difference = Difference::of(&grey(4, 3), &grey(4, 3), 0).unwrap();
        assert_eq!(difference, Difference { outliers: 0, pixels: 12, worst: None, rmse: 0.0 });
    }

    #[test]
    fn a_changed_pixel_is_caught_with_its_place() {
        let mut actual = grey(4, 3);
        actual.put_pixel(2, 1, Rgba([100, 97, 100, 255]));
        actual.put_pixel(3, 2, Rgba([101, 100, 100, 255]));
        let difference = Difference::of(&grey(4, 3), &actual, 0).unwrap();
        assert_eq!(difference.outliers, 2);
        let worst =
            WorstPixel { x: 2, y: 1, difference: 3, expected: [100, 100, 100, 255], actual: [100, 97, 100, 255] };
        assert_eq!(difference.worst, Some(worst));
        assert!((difference.rmse * 255.0 - (10.0 / 48.0_f64).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn channels_beyond_the_tolerance_are_outliers_and_alpha_counts() {
        let mut actual = grey(2, 2);
        actual.put_pixel(0, 0, Rgba([98, 102, 100, 255]));
        actual.put_pixel(1, 1, Rgba([100, 100, 100, 252]));
        let outliers = |tolerance| Difference::of(&grey(2, 2), &actual, tolerance).unwrap().outliers;
        assert_eq!([0, 1, 2, 3].map(outliers), [2, 2, 1, 0]);
    }

    #[test]
    fn images_of_different_size_are_not_compared() {
        let error = Difference::of(&grey(4, 3), &grey(3, 4), 255).unwrap_err();
        assert_eq!(error.to_string(), "expected 4×3 pixels, got 3×4");
    }
}
