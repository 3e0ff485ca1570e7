//! Peak signal-to-noise ratio.

use core::f64::consts::LN_10;

use rt_math::transcendental::log;

use super::ImagePair;
use crate::Development;

/// Peak signal-to-noise ratio in decibels: −10 log₁₀ of the mean squared difference of the display signals, which range
/// from 0 to 1. Greater is better; infinite if the signals are equal.
pub fn psnr(pair: &ImagePair<'_>, development: &Development) -> f64 {
    let components = |film: &crate::Image| film.pixels().as_flattened().len();
    let signals = pair.test().pixels().as_flattened().iter().zip(pair.reference().pixels().as_flattened());
    let squares = signals.map(|(&test, &reference)| {
        let difference = development.signal(test) - development.signal(reference);
        difference * difference
    });
    -10.0 * log(squares.sum::<f64>() / components(pair.test()) as f64) / LN_10
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ToneCurve;
    use crate::test_images::{film, film_of, linear};

    #[test]
    fn a_tenth_of_the_signal_is_twenty_decibels() {
        let test = film_of(5, 4, |x, _| [0.5 + if x % 2 == 0 { 0.125 } else { -0.125 }; 3]);
        let reference = film_of(5, 4, |_, _| [0.5; 3]);
        let pair = ImagePair::new(&test, &reference).expect("alike");
        assert!((psnr(&pair, &linear()) - 20.0 * 8f64.log10()).abs() < 1e-12);
        // A byte of 255 and one of 0.
        let (white, black) = (film(1, 1, &[[1.0; 3]]), film(1, 1, &[[0.0; 3]]));
        assert!(psnr(&ImagePair::new(&white, &black).expect("alike"), &Development::default()).abs() < 1e-12);
    }

    #[test]
    fn what_is_not_shown_does_not_count() {
        let test = film(3, 1, &[[7.0, -1.0, f32::NAN], [f32::INFINITY, 0.0, 0.5], [9.0, 0.0, -2.0]]);
        let reference = film(3, 1, &[[1.0, 0.0, 0.0], [1.0, 0.0, 0.5], [1.0, 0.0, 0.0]]);
        let pair = ImagePair::new(&test, &reference).expect("the last pixel is finite");
        assert_eq!(psnr(&pair, &linear()), f64::INFINITY);
        let reinhard = Development { tone: ToneCurve::Reinhard, ..linear() };
        assert!(psnr(&pair, &reinhard) < 100.0);
    }

    #[test]
    fn the_signal_is_encoded() {
        // sRGB: 0.5 is 0.7353569830524495.
        let (test, reference) = (film(1, 1, &[[0.5; 3]]), film(1, 1, &[[1.0; 3]]));
        let pair = ImagePair::new(&test, &reference).expect("alike");
        let expected = -20.0 * (1.0 - 0.735_356_983_052_449_5f64).log10();
        assert!((psnr(&pair, &Development::default()) - expected).abs() < 1e-12);
    }
}
