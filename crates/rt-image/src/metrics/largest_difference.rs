//! The component that differs most.

use super::ImagePair;

/// The component that differs most, the first in reading order among equals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LargestDifference {
    /// Column and row of the pixel, from the upper left corner.
    pub pixel: [u32; 2],
    /// 0 for red, 1 for green, 2 for blue.
    pub channel: usize,
    /// Radiance of the pixel in the image under test.
    pub test: [f64; 3],
    /// Radiance of the pixel in the reference.
    pub reference: [f64; 3],
}

impl LargestDifference {
    /// Test minus reference in the channel, in units of radiance.
    pub fn difference(&self) -> f64 {
        self.test[self.channel] - self.reference[self.channel]
    }
}

/// The component that differs most; that of the first finite pixel if the images are equal.
pub fn largest_difference(pair: &ImagePair<'_>) -> LargestDifference {
    let mut largest = LargestDifference { pixel: [0; 2], channel: 0, test: [0.0; 3], reference: [0.0; 3] };
    let mut magnitude = f64::NEG_INFINITY;
    let places = (0..pair.height()).flat_map(|y| (0..pair.width()).map(move |x| [x, y]));
    for (place, pixel) in places.zip(pair.pixels()) {
        let Some(pixel) = pixel else { continue };
        for (channel, error) in pixel.error().into_iter().enumerate() {
            if error.abs() > magnitude {
                magnitude = error.abs();
                largest = LargestDifference { pixel: place, channel, test: pixel.test, reference: pixel.reference };
            }
        }
    }
    largest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_images::film;

    #[test]
    fn the_first_of_equals_is_found_with_its_sign() {
        let test = film(2, 2, &[[f32::NAN, 9.0, 9.0], [0.0, 0.5, 0.0], [0.0; 3], [0.0, 0.0, 2.0]]);
        let reference = film(2, 2, &[[0.0; 3], [0.0; 3], [0.0, 2.0, 0.0], [0.0; 3]]);
        let found = largest_difference(&ImagePair::new(&test, &reference).expect("alike"));
        assert_eq!((found.pixel, found.channel, found.difference()), ([0, 1], 1, -2.0));
        assert_eq!((found.test, found.reference), ([0.0; 3], [0.0, 2.0, 0.0]));
    }

    #[test]
    fn equal_images_differ_nowhere() {
        let test = film(2, 1, &[[f32::NAN; 3], [3.0; 3]]);
        let found = largest_difference(&ImagePair::new(&test, &test).expect("alike"));
        assert_eq!((found.pixel, found.difference(), found.test), ([1, 0], 0.0, [3.0; 3]));
    }
}
