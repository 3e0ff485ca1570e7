//! From linear radiance to bytes.

use core::ops::RangeInclusive;

use rt_math::transcendental::exp2;

use crate::tone_curve::{Encoding, ToneCurve};
use crate::{Dither, Image};

/// Exposure, tone curve, encoding and dithering.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Development {
    /// Exposure in stops: radiance is multiplied by 2^exposure.
    pub exposure: f64,
    /// Tone curve.
    pub tone: ToneCurve,
    /// Encoding.
    pub encoding: Encoding,
    /// Thresholds that colours are rounded to bytes by; without them, to the nearest. Coverage is always rounded to the
    /// nearest.
    pub dither: Option<Dither>,
}

impl Default for Development {
    /// Linear light in [0, 1] to sRGB, rounded to the nearest byte.
    fn default() -> Self {
        Self { exposure: 0.0, tone: ToneCurve::Clamp, encoding: Encoding::Srgb, dither: None }
    }
}

/// Error of [`Development::validate`]: settings with which no image can be developed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum DevelopmentError {
    /// The exposure (the value, in stops) is not usable.
    #[error("the exposure is {0:?} stops; it must lie between -1000 and 1000")]
    Exposure(f64),
    /// The exponent of a power-law encoding (the value) is not usable.
    #[error("gamma is {0:?}; it must lie between 0.01 and 100")]
    Gamma(f64),
}

/// An image of 8 bits a channel, row by row from the top, channels interleaved.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Bitmap8 {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// 3: red, green, blue. 4: and coverage, with which the colours are **not** multiplied (as in PNG).
    pub channels: u8,
    /// `width · height · channels` bytes.
    pub bytes: Vec<u8>,
}

impl Bitmap8 {
    /// Linear light of the bytes, multiplied by coverage: the film that [`read_image`](crate::read_image) makes of
    /// them if the encoding is sRGB. Pixels that `bytes` is too short for are black.
    pub fn decode(&self, encoding: Encoding) -> Image {
        let light: [f32; 256] = core::array::from_fn(|byte| encoding.decode(byte as u8));
        let with_alpha = self.channels == 4;
        let mut film = Image::new(self.width, self.height, with_alpha);
        let samples = || self.bytes.chunks_exact(if with_alpha { 4 } else { 3 });
        for (pixel, bytes) in film.pixels_mut().iter_mut().zip(samples()) {
            let coverage = bytes.get(3).map_or(1.0, |&byte| f32::from(byte) / 255.0);
            *pixel = core::array::from_fn(|channel| light[usize::from(bytes[channel])] * coverage);
        }
        for (alpha, bytes) in film.alpha_mut().into_iter().flatten().zip(samples()) {
            *alpha = f32::from(bytes[3]) / 255.0;
        }
        film
    }
}

impl Development {
    /// Valid exposures in stops.
    pub const EXPOSURES: RangeInclusive<f64> = -1000.0..=1000.0;
    /// Valid exponents of [`Encoding::Power`].
    pub const GAMMAS: RangeInclusive<f64> = 0.01..=100.0;

    /// Checks exposure and gamma.
    ///
    /// # Errors
    /// [`DevelopmentError`] with the first value that is NaN or out of range.
    pub fn validate(&self) -> Result<(), DevelopmentError> {
        if !Self::EXPOSURES.contains(&self.exposure) {
            return Err(DevelopmentError::Exposure(self.exposure));
        }
        match self.encoding {
            Encoding::Power(gamma) if !Self::GAMMAS.contains(&gamma) => Err(DevelopmentError::Gamma(gamma)),
            _ => Ok(()),
        }
    }

    /// The displayable light in [0, 1] of one component, `tone(2^exposure · radiance)`. Negative radiance and NaN give 0,
    /// infinity the same as the maximum radiance.
    pub fn light(&self, radiance: f32) -> f64 {
        // An infinite radiance times an underflowing exposure would be NaN.
        let radiance = f64::from(radiance.clamp(f32::MIN, f32::MAX));
        self.tone.apply(radiance * exp2(self.exposure))
    }

    /// Signal in [0, 1] of this [`light`](Self::light).
    pub fn signal(&self, radiance: f32) -> f64 {
        self.encoding.encode(self.light(radiance))
    }

    /// The byte of one component without dithering: the [`signal`](Self::signal) times 255, rounded.
    pub fn byte(&self, radiance: f32) -> u8 {
        // The conversion saturates, and takes NaN to 0.
        (255.0 * self.signal(radiance)).round() as u8
    }

    /// Develops a film to bytes, with its coverage as a fourth channel if it has one. Colours are divided by their
    /// coverage before they are developed; pixels without coverage are black.
    pub fn develop(&self, film: &Image) -> Bitmap8 {
        let Some(alpha) = film.alpha() else { return self.develop_over_black(film) };
        let curve = Curve::new(self);
        let mut bytes = Vec::with_capacity(4 * alpha.len());
        for ((pixel, radiance), &alpha) in pixels_of(film).zip(film.pixels()).zip(alpha) {
            // Filters with negative lobes overshoot. A NaN compares as not covered, and becomes the byte 0.
            let coverage = alpha.clamp(0.0, 1.0);
            let straight = radiance.map(|value| if coverage > 0.0 { value / coverage } else { 0.0 });
            bytes.extend(curve.bytes(straight, pixel));
            bytes.push((255.0 * coverage).round() as u8);
        }
        Bitmap8 { width: film.width(), height: film.height(), channels: 4, bytes }
    }

    /// Develops a film to three channels, in front of black: radiance is premultiplied, so that coverage is simply left
    /// out.
    pub fn develop_over_black(&self, film: &Image) -> Bitmap8 {
        let curve = Curve::new(self);
        let mut bytes = Vec::with_capacity(3 * film.pixels().len());
        for (pixel, &radiance) in pixels_of(film).zip(film.pixels()) {
            bytes.extend(curve.bytes(radiance, pixel));
        }
        Bitmap8 { width: film.width(), height: film.height(), channels: 3, bytes }
    }
}

/// Positions of the pixels of a film, row by row from the top.
fn pixels_of(film: &Image) -> impl Iterator<Item = [u32; 2]> {
    let (width, height) = (film.width(), film.height());
    (0..height).flat_map(move |y| (0..width).map(move |x| [x, y]))
}

/// Radiance to bytes, by tables.
enum Curve {
    Rounded(Box<ByteCurve>),
    Dithered(Box<LevelCurve>, Dither),
}

impl Curve {
    fn new(development: &Development) -> Self {
        match development.dither {
            None => Self::Rounded(Box::new(ByteCurve::new(development))),
            Some(dither) => Self::Dithered(Box::new(LevelCurve::new(development)), dither),
        }
    }

    fn bytes(&self, radiance: [f32; 3], pixel: [u32; 2]) -> [u8; 3] {
        match self {
            Self::Rounded(curve) => radiance.map(|value| curve.byte(value)),
            Self::Dithered(curve, dither) => {
                core::array::from_fn(|channel| dither.level(curve.level(radiance[channel]), pixel, channel as u32))
            }
        }
    }
}

/// [`Development::byte`] as a table: the smallest radiance of each byte from 1 to 255.
///
/// The development never decreases, so that counting the thresholds that a radiance reaches gives its byte exactly,
/// without a power per pixel.
struct ByteCurve {
    thresholds: [f32; 255],
}

impl ByteCurve {
    fn new(development: &Development) -> Self {
        Self {
            thresholds: core::array::from_fn(|index| {
                smallest_radiance(|radiance| development.byte(radiance) > index as u8)
            }),
        }
    }

    fn byte(&self, radiance: f32) -> u8 {
        // A NaN reaches no threshold, and no radiance reaches a threshold that is NaN.
        self.thresholds.partition_point(|&threshold| threshold <= radiance) as u8
    }
}

/// Parts that [`LevelCurve`] cuts a level into.
const PARTS: usize = 8;

/// 255 times [`Development::signal`] as a table: exact at eighths of levels, linear between. The encodings bend so little
/// there that the tests find no difference above 0.005 of a level, but 0.05 below the first level.
struct LevelCurve {
    /// The smallest radiance that reaches one part, two, and so on; NaN where none does.
    thresholds: [f32; 255 * PARTS],
}

impl LevelCurve {
    fn new(development: &Development) -> Self {
        let parts = (255 * PARTS) as f64;
        let reaches = |part: usize| move |radiance| parts * development.signal(radiance) >= part as f64 - ROUNDING;
        Self { thresholds: core::array::from_fn(|index| smallest_radiance(reaches(index + 1))) }
    }

    /// The value in levels, from 0 to 255; of NaN 0.
    fn level(&self, radiance: f32) -> f64 {
        let reached = self.thresholds.partition_point(|&threshold| threshold <= radiance);
        let from = reached.checked_sub(1).map_or(0.0, |below| f64::from(self.thresholds[below]));
        let share = match self.thresholds.get(reached) {
            Some(&to) => (f64::from(radiance) - from) / (f64::from(to) - from),
            None => 0.0,
        };
        // NaN is no share: it comes of a radiance that is none, or of a next threshold that is never reached.
        let share = if share > 0.0 { share.min(1.0) } else { 0.0 };
        (reached as f64 + share) / PARTS as f64
    }
}

/// Parts of a level that the rounding of radiance to `f32` may cost.
const ROUNDING: f64 = 1e-5;

/// The smallest radiance for which a condition holds that never ceases to hold as radiance grows; NaN if it holds for none.
fn smallest_radiance(holds: impl Fn(f32) -> bool) -> f32 {
    // Non-negative numbers are ordered as their bits are.
    let reaches = |bits: u32| holds(f32::from_bits(bits));
    let (mut below, mut reached) = (0, f32::MAX.to_bits());
    if !reaches(reached) {
        return f32::NAN;
    }
    while reached - below > 1 {
        let middle = below + (reached - below) / 2;
        if reaches(middle) {
            reached = middle;
        } else {
            below = middle;
        }
    }
    f32::from_bits(reached)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_images::{film_by_index, film_of, linear};
    use proptest::prelude::*;

    #[test]
    fn srgb_has_its_known_values() {
        let development = Development::default();
        for (light, byte) in [(0.0, 0), (0.5, 188), (1.0, 255), (0.18, 118), (0.215_860_5, 128), (2.0, 255), (-1.0, 0)]
        {
            assert_eq!(development.byte(light), byte, "{light}");
        }
        // The two pieces meet at the published breakpoints to the digits that the standard gives.
        assert!((Encoding::Srgb.encode(0.0031308) - 0.04045).abs() < 1e-6);
        assert!((Encoding::Srgb.encode(0.0031309) - 0.04045).abs() < 2e-6);
        assert!((Encoding::Srgb.decode_signal(0.04045) - 0.0031308).abs() < 1e-7);
        assert!((Encoding::Srgb.encode(1.0) - 1.0).abs() < 1e-15);
        assert!((Encoding::Srgb.decode(128) - 0.215_860_5).abs() < 1e-7);
    }

    #[test]
    fn bytes_are_rounded_to_the_nearest() {
        let development = linear();
        assert_eq!(development.byte(0.4999 / 255.0), 0);
        assert_eq!(development.byte(0.5001 / 255.0), 1);
        assert_eq!(development.byte(254.4999 / 255.0), 254);
        assert_eq!(development.byte(254.5001 / 255.0), 255);
    }

    #[test]
    fn exposure_counts_stops() {
        let brighter = Development { exposure: 2.0, ..linear() };
        assert_eq!(brighter.byte(0.1), 102);
        let darker = Development { exposure: -1.0, ..linear() };
        assert_eq!(darker.byte(1.0), 128);
    }

    #[test]
    fn power_law_encodes_with_the_reciprocal_exponent() {
        let development = Development { encoding: Encoding::Power(2.0), ..Development::default() };
        assert_eq!(development.byte(0.25), 128);
        assert!((Encoding::Power(2.0).decode(51) - 0.04).abs() < 1e-7);
    }

    #[test]
    fn bytes_survive_decoding_and_encoding() {
        for encoding in [Encoding::Srgb, Encoding::Power(2.2), Encoding::Power(1.0)] {
            let development = Development { encoding, ..Development::default() };
            for byte in 0..=255 {
                assert_eq!(development.byte(encoding.decode(byte)), byte, "{encoding:?}");
            }
        }
    }

    #[test]
    fn unusual_radiance_develops_to_the_ends() {
        for tone in [ToneCurve::Clamp, ToneCurve::Reinhard, ToneCurve::Aces] {
            for exposure in [-1000.0, 0.0, 1000.0] {
                let development = Development { tone, exposure, ..Development::default() };
                let curve = ByteCurve::new(&development);
                for value in [f32::NAN, f32::NEG_INFINITY, -1.0, -0.0, 0.0] {
                    assert_eq!(curve.byte(value), 0, "{tone:?} {exposure} {value}");
                }
                assert_eq!(curve.byte(f32::INFINITY), if exposure < 0.0 { 0 } else { 255 }, "{tone:?} {exposure}");
            }
        }
    }

    #[test]
    fn colours_are_divided_by_their_coverage() {
        let mut film = Image::new(3, 1, true);
        film.pixels_mut().copy_from_slice(&[[0.25, 0.125, 0.0], [1.0, 1.0, 1.0], [1.0, 0.5, 0.0]]);
        film.alpha_mut().expect("asked for").copy_from_slice(&[0.5, 0.0, 1.0]);
        let developed = linear().develop(&film);
        assert_eq!((developed.width, developed.height, developed.channels), (3, 1, 4));
        assert_eq!(developed.bytes, [128, 64, 0, 128, 0, 0, 0, 0, 255, 128, 0, 255]);
        let opaque = linear().develop_over_black(&film);
        assert_eq!(opaque.bytes, [64, 32, 0, 255, 255, 255, 255, 128, 0]);
    }

    #[test]
    fn coverage_beyond_one_does_not_darken() {
        let mut film = film_by_index(1, 1, true, |_| [0.5; 3]);
        film.alpha_mut().expect("asked for")[0] = 2.0;
        assert_eq!(linear().develop(&film).bytes, [128, 128, 128, 255]);
    }

    #[test]
    fn useless_settings_are_refused() {
        let sound = Development::default();
        assert_eq!(sound.validate(), Ok(()));
        for gamma in [0.0, -2.2, f64::INFINITY] {
            let development = Development { encoding: Encoding::Power(gamma), ..sound };
            assert_eq!(development.validate(), Err(DevelopmentError::Gamma(gamma)));
        }
        let bright = Development { exposure: f64::INFINITY, ..sound };
        assert_eq!(bright.validate(), Err(DevelopmentError::Exposure(f64::INFINITY)));
        assert!(Development { exposure: f64::NAN, ..sound }.validate().is_err());
        assert!(Development { encoding: Encoding::Power(f64::NAN), ..sound }.validate().is_err());
    }

    fn dithered(development: Development, origin: [u32; 2]) -> Development {
        Development { dither: Some(Dither { origin }), ..development }
    }

    /// A film whose value depends on the column only.
    fn columns(width: u32, height: u32, value: impl Fn(u32) -> f32) -> Image {
        film_of(width, height, |x, _| [value(x); 3])
    }

    #[test]
    fn a_dithered_gradient_has_the_local_means_of_its_values() {
        // Four levels in steps of a thousandth, each 16 pixels wide.
        let step = 16;
        for development in [Development::default(), linear()] {
            let level_of = |x: u32| 60.0 + f64::from(x / step) * 0.001;
            let radiance = |x| development.encoding.decode_signal(level_of(x) / 255.0) as f32;
            let (width, height) = (4000 * step, 16);
            let bytes = dithered(development, [0; 2]).develop(&columns(width, height, radiance)).bytes;
            for block in 0..width / step {
                for channel in 0..3 {
                    let inside = (0..height).flat_map(|y| (0..step).map(move |x| (y * width + block * step + x) * 3));
                    let sum: f64 = inside.map(|index| f64::from(bytes[(index + channel) as usize])).sum();
                    let (mean, level) = (sum / f64::from(step * height), level_of(block * step));
                    assert!((mean - level).abs() < 0.03, "{level}: {mean}");
                }
            }
        }
    }

    #[test]
    fn bytes_that_are_exact_are_not_dithered() {
        for encoding in [Encoding::Srgb, Encoding::Power(2.2), Encoding::Power(1.0)] {
            let development = dithered(Development { encoding, ..Development::default() }, [3, 1]);
            let bytes = development.develop(&columns(256, 70, |x| encoding.decode(x as u8))).bytes;
            assert!(
                bytes.iter().enumerate().all(|(index, &byte)| usize::from(byte) == index / 3 % 256),
                "{encoding:?}"
            );
        }
        let dark = [0.0, -1.0, f32::NAN, f32::NEG_INFINITY].map(|radiance| (radiance, 0));
        let bright = [1.0, 7.0, f32::INFINITY].map(|radiance| (radiance, 255));
        for (radiance, level) in dark.into_iter().chain(bright) {
            let bytes = dithered(Development::default(), [0; 2]).develop(&columns(64, 64, |_| radiance)).bytes;
            assert!(bytes.iter().all(|&byte| byte == level), "{radiance}");
        }
    }

    #[test]
    fn a_dithered_crop_is_a_part_of_the_dithered_whole() {
        let radiance = |x: u32| x as f32 * 0.001;
        let whole = dithered(Development::default(), [0; 2]).develop(&columns(60, 40, radiance));
        let crop = dithered(Development::default(), [13, 9]).develop(&columns(20, 10, |x| radiance(x + 13)));
        for y in 0..10 {
            let row = &whole.bytes[((y + 9) * 60 + 13) * 3..][..60];
            assert_eq!(&crop.bytes[y * 60..][..60], row, "row {y}");
        }
    }

    #[test]
    fn coverage_is_not_dithered_and_the_colour_below_it_is() {
        let mut film = film_by_index(64, 64, true, |_| [0.1; 3]);
        film.alpha_mut().expect("asked for").fill(0.4);
        let bytes = dithered(linear(), [0; 2]).develop(&film).bytes;
        assert!(bytes.chunks_exact(4).all(|pixel| pixel[3] == 102));
        let red: Vec<u8> = bytes.chunks_exact(4).map(|pixel| pixel[0]).collect();
        assert!(red.contains(&63) && red.contains(&64), "0.25 is between two levels");
    }

    fn any_development() -> impl Strategy<Value = Development> {
        let tone = prop_oneof![Just(ToneCurve::Clamp), Just(ToneCurve::Reinhard), Just(ToneCurve::Aces)];
        let encoding = prop_oneof![Just(Encoding::Srgb), (0.5..4.0f64).prop_map(Encoding::Power)];
        (-10.0..10.0f64, tone, encoding).prop_map(|(exposure, tone, encoding)| Development {
            exposure,
            tone,
            encoding,
            dither: None,
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn the_table_equals_the_formula(development in any_development(), bits in proptest::collection::vec(any::<u32>(), 256)) {
            let curve = ByteCurve::new(&development);
            for value in bits.into_iter().map(f32::from_bits) {
                prop_assert_eq!(curve.byte(value), development.byte(value), "{}", value);
                let displayable = value.abs().fract() / 2f32.powf(development.exposure as f32);
                prop_assert_eq!(curve.byte(displayable), development.byte(displayable), "{}", displayable);
            }
        }

        #[test]
        fn the_table_of_levels_follows_the_formula(development in any_development(), values in proptest::collection::vec(0.0..1.0f32, 256)) {
            let curve = LevelCurve::new(&development);
            for value in values {
                let radiance = value / 2f32.powf(development.exposure as f32);
                let (level, exact) = (curve.level(radiance), 255.0 * development.signal(radiance));
                prop_assert!((level - exact).abs() < if exact < 1.0 { 0.05 } else { 0.005 }, "{}: {} {}", radiance, level, exact);
            }
        }
    }
}
