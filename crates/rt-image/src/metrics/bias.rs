//! The mean signed error and its standard error.

use super::{ImagePair, mean_error::mean};

/// A mean and its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The mean.
    pub mean: f64,
    /// Its standard error, if the values that it is the mean of are independent. Infinite for a single value.
    pub standard_error: f64,
}

/// Mean of `x − r` over the pixels, in units of radiance: positive if the image is too bright.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bias {
    /// Red, green and blue.
    pub channels: [Estimate; 3],
    /// Bias of the mean of the three channels of each pixel. As these are rarely independent, its standard error does not
    /// follow from theirs.
    pub all: Estimate,
}

/// The bias of the image under test. Errors that are independent from pixel to pixel, as noise is, rarely move it from
/// zero by more than three standard errors.
pub fn bias(pair: &ImagePair<'_>) -> Bias {
    let mean_of = mean(pair, |pixel| pixel.error());
    // Red, green, blue, and their mean.
    let (mut squares, mut count) = ([0.0; 4], 0.0);
    for pixel in pair.finite_pixels() {
        let [r, g, b] = pixel.error();
        let deviations = [r - mean_of.red, g - mean_of.green, b - mean_of.blue, (r + g + b) / 3.0 - mean_of.mean()];
        for (square, deviation) in squares.iter_mut().zip(deviations) {
            *square += deviation * deviation;
        }
        count += 1.0;
    }
    let [red, green, blue, all] =
        squares.map(|square| if count > 1.0 { (square / (count * (count - 1.0))).sqrt() } else { f64::INFINITY });
    let estimate = |mean, standard_error| Estimate { mean, standard_error };
    Bias {
        channels: [estimate(mean_of.red, red), estimate(mean_of.green, green), estimate(mean_of.blue, blue)],
        all: estimate(mean_of.mean(), all),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_images::{film, film_of};

    #[test]
    fn of_three_pixels_by_hand() {
        let test = film(3, 1, &[[1.0, 1.0, 0.0], [2.0, 1.0, 0.0], [3.0, 1.0, 0.0]]);
        let reference = film(3, 1, &[[0.0, 0.0, 0.5]; 3]);
        let pair = ImagePair::new(&test, &reference).expect("alike");
        let Bias { channels: [red, green, blue], all } = bias(&pair);
        // 1, 2, 3: mean 2, variance 1.
        assert_eq!(red.mean, 2.0);
        assert!((red.standard_error - (1f64 / 3.0).sqrt()).abs() < 1e-15);
        assert_eq!(green, Estimate { mean: 1.0, standard_error: 0.0 });
        assert_eq!(blue, Estimate { mean: -0.5, standard_error: 0.0 });
        assert!((all.mean - 2.5 / 3.0).abs() < 1e-15);
        assert!((all.standard_error - red.standard_error / 3.0).abs() < 1e-15);
    }

    #[test]
    fn noise_that_cancels_is_no_bias() {
        let test = film_of(64, 64, |x, y| [if (x + y) % 2 == 0 { 0.5 } else { 1.5 }; 3]);
        let reference = film_of(64, 64, |_, _| [1.0; 3]);
        let found = bias(&ImagePair::new(&test, &reference).expect("alike")).all;
        assert_eq!(found.mean, 0.0);
        assert!((found.standard_error - 0.5 / 4095f64.sqrt()).abs() < 1e-15);
        let swapped = bias(&ImagePair::new(&reference, &test).expect("alike")).all;
        assert_eq!(swapped, found);
    }

    #[test]
    fn one_pixel_says_nothing_about_its_spread() {
        let (test, reference) = (film(1, 1, &[[1.0; 3]]), film(1, 1, &[[0.5; 3]]));
        let found = bias(&ImagePair::new(&test, &reference).expect("alike")).all;
        assert_eq!(found, Estimate { mean: 0.5, standard_error: f64::INFINITY });
    }
}
