//! Structural similarity.

use rt_math::transcendental::exp;

use super::{
    ImagePair,
    plane::{Plane, Tile},
};
use crate::{Development, Image};

/// Pixels of the window on each side of its middle.
const MARGIN: u32 = 5;
/// Standard deviation of the window in pixels.
const SIGMA: f64 = 1.5;
/// `(K₁ L)²` and `(K₂ L)²` for signals with the range L = 1.
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;

/// Mean structural similarity (Wang, Bovik, Sheikh and Simoncelli 2004) of the display signals, with a Gaussian window
/// of 11 by 11 pixels. Mean over red, green and blue. At most 1, for equal signals. `None` for an image that is smaller
/// than the window.
pub fn ssim(pair: &ImagePair<'_>, development: &Development) -> Option<f64> {
    let (width, height) = (pair.width(), pair.height());
    if width.min(height) <= 2 * MARGIN {
        return None;
    }
    let window = window();
    let (mut sum, mut count) = (0.0, 0.0);
    for tile in Tile::cut(MARGIN..width - MARGIN, MARGIN..height - MARGIN, 128) {
        for channel in 0..3 {
            let signals = |film: &Image| {
                Plane::around(&tile, MARGIN, [width, height], |x, y| {
                    development.signal(film.pixels()[y as usize * width as usize + x as usize][channel])
                })
            };
            for similarity in similarities(&signals(pair.test()), &signals(pair.reference()), &window) {
                sum += similarity;
                count += 1.0;
            }
        }
    }
    Some(sum / count)
}

/// Equation 13 of the paper for every place of the window.
fn similarities(a: &Plane, b: &Plane, window: &[f64]) -> impl Iterator<Item = f64> {
    let mean = |plane: &Plane| plane.filtered(window, window).values;
    let (mean_a, mean_b) = (mean(a), mean(b));
    let [aa, bb, ab] = [(a, a), (b, b), (a, b)].map(|(a, b)| mean(&a.combined(b, |a, b| a * b)));
    (0..mean_a.len()).map(move |index| {
        let (ma, mb) = (mean_a[index], mean_b[index]);
        let (variance_a, variance_b, covariance) = (aa[index] - ma * ma, bb[index] - mb * mb, ab[index] - ma * mb);
        (2.0 * ma * mb + C1) * (2.0 * covariance + C2) / ((ma * ma + mb * mb + C1) * (variance_a + variance_b + C2))
    })
}

/// One side of the window; it sums to 1.
fn window() -> Vec<f64> {
    let margin = i64::from(MARGIN);
    let weights: Vec<_> = (-margin..=margin).map(|x| exp(-(x * x) as f64 / (2.0 * SIGMA * SIGMA))).collect();
    let sum: f64 = weights.iter().sum();
    weights.into_iter().map(|weight| weight / sum).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_images::{disturbed_ramps, film_of, linear, ramps};

    fn of(test: &Image, reference: &Image) -> Option<f64> {
        ssim(&ImagePair::new(test, reference).expect("alike"), &linear())
    }

    #[test]
    fn of_flat_images_by_hand() {
        let flat = |level: f32| film_of(20, 11, |_, _| [level; 3]);
        let expected = (2.0 * 0.25 * 0.75 + C1) / (0.0625 + 0.5625 + C1);
        assert!((of(&flat(0.25), &flat(0.75)).expect("large enough") - expected).abs() < 1e-12);
    }

    #[test]
    fn of_a_dot_by_hand() {
        // One place for the window, of which the middle has the weight w².
        let dot = |level: f32| film_of(11, 11, move |x, y| if [x, y] == [5, 5] { [level; 3] } else { [0.0; 3] });
        let w = 1.0 / (-5..=5).map(|x| exp(-f64::from(x * x) / 4.5)).sum::<f64>();
        let (m, v) = (w * w, w * w - w * w * w * w);
        // Half of the dot has half of the mean and covariance, and a quarter of the variance.
        let expected = (m * m + C1) * (v + C2) / ((1.25 * m * m + C1) * (1.25 * v + C2));
        assert!((of(&dot(1.0), &dot(0.5)).expect("large enough") - expected).abs() < 1e-12);
    }

    #[test]
    fn equal_images_are_one_and_swapping_changes_nothing() {
        let (test, reference) = (disturbed_ramps(), ramps());
        assert_eq!(of(&test, &test), Some(1.0));
        assert_eq!(of(&test, &reference), of(&reference, &test));
        assert!(of(&test, &reference).expect("large enough") < 0.99);
    }

    #[test]
    fn tiles_leave_no_seam() {
        // Of a pattern that repeats every 10 pixels, any 10 by 10 places have the same mean.
        let pattern = |width| film_of(width, 20, |x, y| [(x % 10 * 3 + y % 10) as f32 / 40.0, 0.5, 0.25]);
        let other = |width| film_of(width, 20, |x, y| [(x % 10 + y % 10) as f32 / 40.0, 0.5, 0.125]);
        let (narrow, wide) = (of(&pattern(20), &other(20)), of(&pattern(310), &other(310)));
        assert!((narrow.expect("large") - wide.expect("large")).abs() < 1e-12, "{narrow:?} {wide:?}");
    }

    #[test]
    fn a_small_image_has_none() {
        let small = film_of(10, 30, |_, _| [0.5; 3]);
        assert_eq!(of(&small, &small), None);
    }
}
