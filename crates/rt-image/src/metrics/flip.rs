//! ꟻLIP: the difference that a viewer sees when alternating between two images.
//!
//! ```text
//!      light ──> opponent colours ──> blurred as the eye blurs them ──> Lab, HyAB distance ──> ΔE c
//!        └─────> luminance ──> edges and points ──────────────────────────────────────────────> ΔE f
//!      ΔE = ΔE c ^ (1 − ΔE f)                                                        0 ≤ ΔE ≤ 1
//! ```

mod colour;
mod exposures;
mod kernels;

use rt_math::transcendental::pow;

use self::{colour::ColourSpace, kernels::Kernels};
use super::{
    ErrorMap, ImagePair,
    plane::{Plane, Tile},
};
use crate::{Development, Image, ToneCurve};

pub use exposures::ExposureRange;

/// The metric ꟻLIP (Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild 2020), for a viewer who sees a
/// given number of pixels per degree.
///
/// It is symmetric, 0 for equal images, and 1 for green against blue, the largest distance of colours.
#[derive(Clone, Debug)]
pub struct Flip {
    colours: ColourSpace,
    kernels: Kernels,
}

/// Error of [`Flip::new`]: a resolution for which the metric cannot be computed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum FlipError {
    /// The number of pixels per degree (the value) is not usable.
    #[error("the resolution is {0} pixels per degree; it must lie between 1 and 1000")]
    PixelsPerDegree(f64),
}

impl Flip {
    /// Pixels per degree of visual angle 0.7 m in front of a screen of 3840 pixels on 0.7 m, as the paper proposes:
    /// `0.7 · 3840 / 0.7 · π / 180`.
    pub const PIXELS_PER_DEGREE: f64 = 3840.0 * core::f64::consts::PI / 180.0;

    /// The metric for a number of pixels per degree.
    ///
    /// # Errors
    /// [`FlipError`] if the number is NaN, below 1 or above 1000.
    pub fn new(pixels_per_degree: f64) -> Result<Self, FlipError> {
        if !(1.0..=1000.0).contains(&pixels_per_degree) {
            return Err(FlipError::PixelsPerDegree(pixels_per_degree));
        }
        Ok(Self { colours: ColourSpace::new(), kernels: Kernels::new(pixels_per_degree) })
    }

    /// The difference in each pixel, between 0 and 1, of what a display shows: [`Development::light`]. Whatever the encoding,
    /// a display undoes it; so do bytes that were read from a file.
    pub fn ldr(&self, pair: &ImagePair<'_>, development: &Development) -> ErrorMap {
        let mut values = vec![0.0; pair.test().pixels().len()];
        self.max_with(pair, development, &mut values);
        ErrorMap::new(pair, values)
    }

    /// HDR-ꟻLIP (Andersson, Nilsson, Shirley and Akenine-Möller 2021). Each pixel has the maximum difference over all
    /// exposures of the images displayed with the curve [`ToneCurve::Aces`].
    pub fn hdr(&self, pair: &ImagePair<'_>, exposures: &ExposureRange) -> ErrorMap {
        let mut values = vec![0.0; pair.test().pixels().len()];
        for exposure in exposures.exposures() {
            self.max_with(
                pair,
                &Development { exposure, tone: ToneCurve::Aces, ..Development::default() },
                &mut values,
            );
        }
        ErrorMap::new(pair, values)
    }

    /// Replaces each value by the maximum of it and the difference of its pixel.
    fn max_with(&self, pair: &ImagePair<'_>, development: &Development, values: &mut [f32]) {
        // Larger margins are only worth their work around larger tiles.
        let side = self.kernels.radius().saturating_mul(4).max(128);
        for tile in Tile::cut(0..pair.width(), 0..pair.height(), side) {
            let differences = self.differences(pair, development, &tile);
            for (y, row) in tile.y.clone().zip(differences.chunks_exact(tile.x.len())) {
                let start = y as usize * pair.width() as usize + tile.x.start as usize;
                for (value, &difference) in values[start..].iter_mut().zip(row) {
                    *value = value.max(difference as f32);
                }
            }
        }
    }

    /// The differences of the pixels of a tile, row by row.
    fn differences(&self, pair: &ImagePair<'_>, development: &Development, tile: &Tile) -> Vec<f64> {
        let [test, reference] = [pair.test(), pair.reference()].map(|image| self.perceived(image, development, tile));
        let colours = test.colours.iter().zip(&reference.colours);
        let features = test.features.iter().zip(&reference.features);
        let differences = colours.zip(features).map(|((&test, &reference), (&[e, p], &[f, q]))| {
            let of_colours = self.colours.difference(test, reference);
            // Equation 17 of the paper, with its exponent q_f = 1/2.
            let of_features = ((e - f).abs().max((p - q).abs()) * core::f64::consts::FRAC_1_SQRT_2).min(1.0).sqrt();
            pow(of_colours, 1.0 - of_features)
        });
        differences.collect()
    }

    /// Perceived colours of a tile.
    fn perceived(&self, image: &Image, development: &Development, tile: &Tile) -> Perceived {
        let radius = self.kernels.radius();
        let width = image.width() as usize;
        let channels: [Plane; 3] = core::array::from_fn(|channel| {
            Plane::around(tile, radius, [image.width(), image.height()], |x, y| {
                development.light(image.pixels()[y as usize * width + x as usize][channel])
            })
        });
        let opponent = self.colours.opponent(&channels);
        let [achromatic, red_green, yellow_blue] = self.kernels.blurred(&opponent);
        let blurred = achromatic.values.iter().zip(&red_green.values).zip(&yellow_blue.values);
        Perceived {
            colours: blurred.map(|((&y, &cx), &cz)| self.colours.lab([y, cx, cz])).collect(),
            features: self.kernels.features(&opponent[0].map(ColourSpace::luminance)),
        }
    }
}

impl Default for Flip {
    /// The metric for [`Flip::PIXELS_PER_DEGREE`].
    fn default() -> Self {
        Self { colours: ColourSpace::new(), kernels: Kernels::new(Self::PIXELS_PER_DEGREE) }
    }
}

/// Perceived colours of the pixels of a tile, row by row.
struct Perceived {
    /// In Lab, adjusted after Hunt.
    colours: Vec<[f64; 3]>,
    /// Strength of the edge and of the point.
    features: Vec<[f64; 2]>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_images::{brightened, disturbed_ramps, film_of, ramps};
    use proptest::prelude::*;

    fn ldr(test: &Image, reference: &Image) -> ErrorMap {
        Flip::default().ldr(&ImagePair::new(test, reference).expect("alike"), &Development::default())
    }

    fn assert_pixels(map: &ErrorMap, expected: &[([u32; 2], f32)]) {
        for &([x, y], value) in expected {
            assert!(
                (map.values()[(y * map.width() + x) as usize] - value).abs() < 2e-5,
                "{x} {y}: {:?}",
                map.value(x, y)
            );
        }
    }

    /// Results of the program published by the authors of the metric, which computes in `f32`.
    #[test]
    fn the_authors_program_agrees() {
        let (test, reference) = (disturbed_ramps(), ramps());
        let map = ldr(&test, &reference);
        assert!((map.mean() - 0.210_527_79).abs() < 5e-6, "{}", map.mean());
        assert_pixels(&map, &[([0, 0], 0.475_427), ([20, 10], 0.207_200), ([47, 31], 0.276_961), ([33, 5], 0.201_766)]);
        let pair = ImagePair::new(&test, &reference).expect("alike");
        let near = Flip::new(25.0).expect("usable").ldr(&pair, &Development::default());
        assert!((near.mean() - 0.291_888_03).abs() < 5e-6, "{}", near.mean());
    }

    /// Reference values of HDR-FLIP.
    #[test]
    fn the_authors_program_agrees_on_high_dynamic_range() {
        let (test, reference) = (brightened(&disturbed_ramps()), brightened(&ramps()));
        let exposures = ExposureRange::fitting(&reference);
        // It has a factor of 0.6 in the curve.
        let offset = rt_math::transcendental::log2(0.6);
        assert!((exposures.start - offset + 1.756_390_5).abs() < 1e-3, "{exposures:?}");
        assert!((exposures.stop - offset - 1.860_724_4).abs() < 1e-3, "{exposures:?}");
        assert_eq!(exposures.count, 4);
        let map = Flip::default().hdr(&ImagePair::new(&test, &reference).expect("alike"), &exposures);
        assert!((map.mean() - 0.255_377_86).abs() < 2e-5, "{}", map.mean());
        assert_pixels(&map, &[([0, 0], 0.466_936), ([20, 10], 0.347_245), ([47, 31], 0.383_058), ([33, 5], 0.165_724)]);
    }

    #[test]
    fn of_flat_images_the_colours_alone_count() {
        let flat = |pixel: [f32; 3]| film_of(8, 8, |_, _| pixel);
        let (black, white) = (flat([0.0; 3]), flat([1.0; 3]));
        assert!((ldr(&flat([0.0, 1.0, 0.0]), &flat([0.0, 0.0, 1.0])).mean() - 1.0).abs() < 1e-6);
        // (L^0.7 / 41.27609841 − 0.4) / 0.6 · 0.05 + 0.95 for L = 100 and 76.069.
        assert!((ldr(&black, &white).mean() - 0.967_379_76).abs() < 1e-6);
        assert!((ldr(&black, &flat([0.5; 3])).mean() - 0.958_542_80).abs() < 1e-6);
        // What is brighter than white is shown white.
        assert_eq!(ldr(&flat([7.0, f32::MAX, 1.0]), &flat([1.0; 3])).mean(), 0.0);
    }

    /// With the values of the authors' program, which computes in `f32`.
    #[test]
    fn of_a_dot() {
        let black = film_of(15, 15, |_, _| [0.0; 3]);
        let dot = film_of(15, 15, |x, y| if [x, y] == [7, 7] { [1.0; 3] } else { [0.0; 3] });
        let map = ldr(&dot, &black);
        assert!((map.mean() - 0.063_596_81).abs() < 2e-5, "{}", map.mean());
        assert_pixels(&map, &[([7, 7], 0.864_906_5), ([8, 7], 0.763_490_7)]);
    }

    #[test]
    fn tiles_leave_no_seam() {
        // Far from the border, a pattern that repeats looks the same wherever the tiles end.
        let pattern =
            |shift: u32| film_of(320, 40, move |x, y| [((x + shift) % 8) as f32 / 8.0, (y % 4) as f32 / 4.0, 0.5]);
        let map = ldr(&pattern(0), &pattern(3));
        let row = &map.values()[20 * 320..21 * 320];
        assert!((10..300).all(|x| (row[x] - row[x + 8]).abs() < 1e-6 || x + 8 >= 310));
    }

    #[test]
    fn unusable_pixels_per_degree_are_refused() {
        for ppd in [0.0, -1.0, 0.99, 1001.0, f64::INFINITY] {
            assert_eq!(Flip::new(ppd).expect_err("refused"), FlipError::PixelsPerDegree(ppd));
        }
        assert!(Flip::new(f64::NAN).is_err());
    }

    #[test]
    fn exposure_and_curve_are_those_of_the_development() {
        let (test, reference) = (brightened(&disturbed_ramps()), brightened(&ramps()));
        let pair = ImagePair::new(&test, &reference).expect("alike");
        let range = ExposureRange { start: -1.0, stop: -1.0, count: 2 };
        let development = Development { exposure: -1.0, tone: ToneCurve::Aces, ..Development::default() };
        assert_eq!(Flip::default().hdr(&pair, &range), Flip::default().ldr(&pair, &development));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(16))]

        #[test]
        fn differences_are_symmetric_and_within_their_range(seed in any::<u32>(), width in 1u32..24, height in 1u32..24) {
            let noise = |salt: u32| film_of(width, height, move |x, y| {
                [0, 1, 2].map(|c: u64| {
                    let bits = rt_math::random::hash(&[u64::from(seed ^ salt), u64::from(x), u64::from(y), c]);
                    (bits >> 40) as f32 / (1u64 << 24) as f32
                })
            });
            let (a, b) = (noise(1), noise(2));
            prop_assert_eq!(ldr(&a, &b), ldr(&b, &a));
            prop_assert!(ldr(&a, &b).values().iter().all(|value| (0.0..=1.0).contains(value)));
            prop_assert!(ldr(&a, &a).values().iter().all(|&value| value == 0.0));
        }

        #[test]
        fn more_noise_is_more_difference(seed in any::<u64>()) {
            let reference = film_of(32, 32, |_, _| [0.5; 3]);
            let noisy = |amplitude: f32| film_of(32, 32, move |x, y| {
                let bits = rt_math::random::hash(&[seed, u64::from(x), u64::from(y)]);
                [0.5 + amplitude * ((bits >> 40) as f32 / (1u64 << 24) as f32 - 0.5); 3]
            });
            let differences = [0.01, 0.03, 0.1, 0.3, 1.0].map(|amplitude| ldr(&noisy(amplitude), &reference).mean());
            prop_assert!(differences.windows(2).all(|pair| pair[0] < pair[1]), "{:?}", differences);
        }
    }
}
