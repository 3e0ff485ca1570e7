//! Mean errors of linear radiance: absolute, squared, and squared relative to the reference.

use super::{ImagePair, pair::PixelPair};

/// Added to the squared reference by [`relative_mean_squared_error`], so that black pixels do not dominate.
pub const RELATIVE_EPSILON: f64 = 0.01;

/// A metric for each colour channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PerChannel {
    /// Red.
    pub red: f64,
    /// Green.
    pub green: f64,
    /// Blue.
    pub blue: f64,
}

impl PerChannel {
    /// The channels in order.
    pub const fn to_array(self) -> [f64; 3] {
        [self.red, self.green, self.blue]
    }

    /// The mean of the channels: the metric over all components of all pixels.
    pub fn mean(self) -> f64 {
        (self.red + self.green + self.blue) / 3.0
    }

    /// Applies `f` to each channel.
    pub fn map(self, f: impl Fn(f64) -> f64) -> Self {
        self.to_array().map(f).into()
    }
}

impl From<[f64; 3]> for PerChannel {
    fn from([red, green, blue]: [f64; 3]) -> Self {
        Self { red, green, blue }
    }
}

/// Mean of `|x − r|`, in units of radiance.
pub fn mean_absolute_error(pair: &ImagePair<'_>) -> PerChannel {
    mean(pair, |pixel| pixel.error().map(f64::abs))
}

/// Mean of `(x − r)²`, in squared units of radiance. Its root is the RMSE.
pub fn mean_squared_error(pair: &ImagePair<'_>) -> PerChannel {
    mean(pair, |pixel| pixel.error().map(|error| error * error))
}

/// Mean of `(x − r)² / (r² + ε)` with ε = [`RELATIVE_EPSILON`] (Rousselle, Knaus and Zwicker 2011): an error of a tenth
/// counts the same in light and shade. Without unit; it is not the same when image and reference are swapped.
pub fn relative_mean_squared_error(pair: &ImagePair<'_>) -> PerChannel {
    mean(pair, |pixel| {
        let error = pixel.error();
        core::array::from_fn(|channel| {
            let reference = pixel.reference[channel];
            error[channel] * error[channel] / (reference * reference + RELATIVE_EPSILON)
        })
    })
}

/// The mean of a measure over all pixels that are finite in both images.
pub(super) fn mean(pair: &ImagePair<'_>, measure: impl Fn(&PixelPair) -> [f64; 3]) -> PerChannel {
    let (mut sum, mut count) = ([0.0; 3], 0.0);
    for pixel in pair.finite_pixels() {
        for (sum, value) in sum.iter_mut().zip(measure(&pixel)) {
            *sum += value;
        }
        count += 1.0;
    }
    sum.map(|sum| sum / count).into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_images::{disturbed_ramps, film, film_of, ramps};

    #[test]
    fn of_two_pixels_by_hand() {
        let test = film(2, 1, &[[1.0, 0.5, 3.0], [0.0, 0.5, 0.0]]);
        let reference = film(2, 1, &[[0.5, 0.5, 1.0], [0.25, 0.5, 2.0]]);
        let pair = ImagePair::new(&test, &reference).expect("alike");
        assert_eq!(mean_absolute_error(&pair).to_array(), [0.375, 0.0, 2.0]);
        assert_eq!(mean_squared_error(&pair).to_array(), [(0.25 + 0.0625) / 2.0, 0.0, 4.0]);
        let red = (0.25 / (0.25 + 0.01) + 0.0625 / (0.0625 + 0.01)) / 2.0;
        let blue = (4.0 / 1.01 + 4.0 / 4.01) / 2.0;
        let relative = relative_mean_squared_error(&pair);
        assert!((relative.red - red).abs() < 1e-15 && relative.green == 0.0 && (relative.blue - blue).abs() < 1e-15);
        assert_eq!(mean_squared_error(&pair).mean(), (0.15625 + 4.0) / 3.0);
    }

    /// The mean of k² over k = 0..n−1 is (n − 1)(2n − 1)/6, that of k is (n − 1)/2.
    #[test]
    fn of_a_ramp_in_closed_form() {
        let test = film_of(50, 20, |x, y| [(50 * y + x) as f32 / 1024.0, 0.0, 7.0]);
        let reference = film_of(50, 20, |_, _| [0.0, 0.0, 7.0]);
        let pair = ImagePair::new(&test, &reference).expect("alike");
        assert!((mean_absolute_error(&pair).red - 999.0 / 2.0 / 1024.0).abs() < 1e-13);
        assert!((mean_squared_error(&pair).red - 999.0 * 1999.0 / 6.0 / 1024.0 / 1024.0).abs() < 1e-12);
        assert!((relative_mean_squared_error(&pair).red / mean_squared_error(&pair).red - 100.0).abs() < 1e-12);
    }

    #[test]
    fn pixels_that_are_not_finite_do_not_count() {
        let test = film(3, 1, &[[2.0; 3], [f32::NAN, 0.0, 0.0], [5.0; 3]]);
        let reference = film(3, 1, &[[1.0; 3], [0.0; 3], [f32::INFINITY, 5.0, 5.0]]);
        let pair = ImagePair::new(&test, &reference).expect("one pixel is finite");
        assert_eq!(mean_squared_error(&pair).to_array(), [1.0; 3]);
        assert_eq!(mean_absolute_error(&pair).to_array(), [1.0; 3]);
    }

    #[test]
    fn huge_radiance_does_not_overflow() {
        let (test, reference) = (film(1, 1, &[[f32::MAX; 3]]), film(1, 1, &[[f32::MIN; 3]]));
        let pair = ImagePair::new(&test, &reference).expect("finite");
        let twice = 2.0 * f64::from(f32::MAX);
        assert_eq!(mean_squared_error(&pair).to_array(), [twice * twice; 3]);
        assert!((relative_mean_squared_error(&pair).red - 4.0).abs() < 1e-12);
    }

    #[test]
    fn equal_images_have_no_error_and_swapping_matters_to_the_relative_one_alone() {
        let (test, reference) = (disturbed_ramps(), ramps());
        let same = ImagePair::new(&test, &test).expect("alike");
        let pair = ImagePair::new(&test, &reference).expect("alike");
        let swapped = ImagePair::new(&reference, &test).expect("alike");
        for metric in [mean_absolute_error, mean_squared_error, relative_mean_squared_error] {
            assert_eq!(metric(&same).to_array(), [0.0; 3]);
            assert!(metric(&pair).mean() > 0.0);
        }
        assert_eq!(mean_squared_error(&pair), mean_squared_error(&swapped));
        assert_ne!(relative_mean_squared_error(&pair), relative_mean_squared_error(&swapped));
    }
}
