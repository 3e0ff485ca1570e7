//! Values of options and their parsers. Each error states the expected form.

use std::fmt::Display;
#[cfg(feature = "view")]
use std::net::IpAddr;
use std::ops::RangeInclusive;
use std::path::Path;
use std::str::FromStr;
use std::time::Duration;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use rt_camera::FilmSettings;
use rt_image::{Development, Encoding, ImageFormat, ToneCurve, metrics::Flip};
use rt_math::{DVec3, Rgb};
use rt_render::{Crop, ShardSpec, SimdLevel};
use rt_scene_io::{LoadErrorKind, limits};

use crate::image_file::is_developed;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum BackgroundChoice {
    /// Constant radiance.
    Color(Rgb),
    /// No background: the image has an alpha channel.
    Transparent,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CheckpointInterval {
    Time(Duration),
    Never,
}

pub(crate) const TONE_CURVES: [ToneCurve; 3] = [ToneCurve::Clamp, ToneCurve::Reinhard, ToneCurve::Aces];

pub(crate) const fn tone_name(tone: ToneCurve) -> &'static str {
    match tone {
        ToneCurve::Clamp => "clamp",
        ToneCurve::Reinhard => "reinhard",
        ToneCurve::Aces => "aces",
    }
}

pub(crate) fn tone_of_name(name: &str) -> Option<ToneCurve> {
    TONE_CURVES.into_iter().find(|&tone| tone_name(tone) == name)
}

/// Names and their older spellings.
const RENAMED: [(&str, &str); 4] =
    [("bvh8", "wide"), ("sphere-tree", "spheres"), ("cylinder-tree", "cylinders"), ("path-caustics", "caustics")];

/// Parser for an enum of another crate.
pub(super) fn named<T: Copy + Send + Sync + 'static>(
    all: &'static [T],
    name: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T> {
    let names = all.iter().map(move |&value| {
        let name = name(value);
        PossibleValue::new(name).aliases(RENAMED.iter().filter(|(new, _)| *new == name).map(|(_, old)| *old))
    });
    PossibleValuesParser::new(names).try_map(move |typed| {
        all.iter().copied().find(|&value| name(value) == current_name(&typed)).ok_or("unknown name")
    })
}

fn current_name(name: &str) -> &str {
    RENAMED.iter().find(|(_, old)| *old == name).map_or(name, |(new, _)| new)
}

/// SIMD instructions of this processor.
pub(super) fn simd() -> impl TypedValueParser<Value = SimdLevel> {
    named(SimdLevel::ALL, SimdLevel::name).try_map(|level| match level {
        level if level.is_available() => Ok(level),
        _ => Err("this processor does not support it; remove --simd to use the best available"),
    })
}

pub(super) fn dither() -> impl TypedValueParser<Value = bool> {
    PossibleValuesParser::new([PossibleValue::new("on"), PossibleValue::new("off").alias("none")])
        .map(|typed| typed == "on")
}

/// Image format by file extension.
pub(super) fn image_format() -> impl TypedValueParser<Value = ImageFormat> {
    format_among(|_| true)
}

/// Format of images for display.
pub(super) fn display_format() -> impl TypedValueParser<Value = ImageFormat> {
    format_among(is_developed)
}

fn format_among(accepts: fn(ImageFormat) -> bool) -> impl TypedValueParser<Value = ImageFormat> {
    let names = ImageFormat::ALL.into_iter().filter(|&format| accepts(format)).map(|format| {
        let [usual, others @ ..] = format.extensions() else { return PossibleValue::new("") };
        PossibleValue::new(*usual).aliases(others.iter().copied())
    });
    PossibleValuesParser::new(names)
        .try_map(|typed| ImageFormat::from_path(Path::new(&format!("a.{typed}"))).map_err(|error| error.to_string()))
}

/// `WxH`.
pub(super) fn size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    let [width, height] = sides.ok_or("expected width and height in pixels, such as 640x480")?;
    FilmSettings { width, height, ..FilmSettings::default() }.validate().map_err(|error| error.to_string())?;
    Ok([width, height])
}

/// `X,Y,Z`, within the limit of numbers in scenes.
pub(super) fn point(text: &str) -> Result<DVec3, String> {
    numbers(text)
        .filter(|values| values.iter().all(|value: &f64| value.abs() <= limits::NUMBER))
        .map(DVec3::from_array)
        .ok_or_else(|| format!("expected three numbers of magnitude at most {:e}, such as 1,-2,0.5", limits::NUMBER))
}

/// `X,Y,W,H`.
pub(super) fn crop(text: &str) -> Result<Crop, String> {
    let [x, y, width, height] =
        numbers(text).ok_or("expected left, top, width and height in pixels, such as 100,50,320,200")?;
    if width == 0 || height == 0 {
        return Err("width and height must be at least 1".to_owned());
    }
    Ok(Crop { x, y, width, height })
}

/// Angle in degrees, in (0, 180).
pub(super) fn field_of_view(text: &str) -> Result<f64, String> {
    let degrees = text.parse().ok().filter(|&degrees: &f64| degrees > 0.0 && degrees < 180.0);
    degrees.ok_or_else(|| "expected an angle greater than 0 and less than 180 degrees".to_owned())
}

/// Exposure in stops.
pub(super) fn exposure(text: &str) -> Result<f64, String> {
    let exposure = number(text)?;
    check(&Development { exposure, ..Development::default() }).map(|()| exposure)
}

/// Exponent of a power law.
pub(super) fn gamma(text: &str) -> Result<f64, String> {
    let gamma = number(text)?;
    check(&Development { encoding: Encoding::Power(gamma), ..Development::default() }).map(|()| gamma)
}

/// IP address.
#[cfg(feature = "view")]
pub(super) fn address(text: &str) -> Result<IpAddr, String> {
    text.parse().map_err(|_| "expected an IP address, such as 127.0.0.1 or ::1".to_owned())
}

/// Parser of whole numbers in a range.
pub(super) fn whole<T>(range: RangeInclusive<T>) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync + 'static
where
    T: FromStr + PartialOrd + Display + Clone + Send + Sync + 'static,
{
    move |text| {
        let number = text.parse().ok().filter(|number| range.contains(number));
        number.ok_or_else(|| format!("expected a whole number from {} to {}", range.start(), range.end()))
    }
}

pub(super) fn finite(text: &str) -> Result<f64, String> {
    number(text).ok().filter(|value| value.is_finite()).ok_or_else(|| "expected a finite number".to_owned())
}

pub(super) fn non_negative(text: &str) -> Result<f64, String> {
    finite(text).ok().filter(|&value| value >= 0.0).ok_or_else(|| "expected a number of at least 0".to_owned())
}

pub(super) fn positive(text: &str) -> Result<f64, String> {
    finite(text).ok().filter(|&value| value > 0.0).ok_or_else(|| "expected a number greater than 0".to_owned())
}

pub(super) fn time(text: &str) -> Result<Duration, String> {
    let time = humantime::parse_duration(text).ok().filter(|time| !time.is_zero());
    time.ok_or_else(|| "expected a time greater than 0 with its unit, such as 500ms, 10s, 1.5min or 2h".to_owned())
}

/// A time with its unit, or `never`.
pub(super) fn checkpoint_interval(text: &str) -> Result<CheckpointInterval, String> {
    match text {
        "never" => Ok(CheckpointInterval::Never),
        _ => time(text).map(CheckpointInterval::Time).map_err(|error| error + ", or never"),
    }
}

/// Shard I of N; I starts at 1.
pub(super) fn shard_spec(text: &str) -> Result<ShardSpec, String> {
    let numbers =
        text.split_once('/').and_then(|(index, count)| Some((index.parse::<u32>().ok()?, count.parse().ok()?)));
    numbers
        .and_then(|(index, count)| ShardSpec::new(index.checked_sub(1)?, count))
        .ok_or_else(|| format!("expected I/N, such as 1/8 to 8/8, with at most {} shards", ShardSpec::MAX_COUNT))
}

/// Percentage greater than zero, as a fraction.
pub(super) fn percentage(text: &str) -> Result<f64, String> {
    let percent = text.strip_suffix('%').and_then(|number| positive(number.trim_end()).ok());
    percent
        .map(|percent| percent / 100.0)
        .filter(|&share| share > 0.0)
        .ok_or_else(|| "expected a percentage greater than 0 with its sign, such as 1%".to_owned())
}

/// Percentage in (0, 100], as a fraction.
pub(super) fn share_of_pixels(text: &str) -> Result<f64, String> {
    percentage(text)
        .ok()
        .filter(|share| *share <= 1.0)
        .ok_or_else(|| "expected a percentage greater than 0 and at most 100, such as 99%".to_owned())
}

/// Pixels per degree of ꟻLIP.
pub(super) fn pixels_per_degree(text: &str) -> Result<f64, String> {
    let value = number(text)?;
    Flip::new(value).map(|_| value).map_err(|error| error.to_string())
}

/// A color, as scene files write it, or its name.
pub(super) fn background(text: &str) -> Result<BackgroundChoice, String> {
    const FORMS: &str = "#RRGGBB, #RGB, or one or three linear numbers, such as 0.5 or 0.2,0.4,1";
    let color = match text {
        "transparent" => return Ok(BackgroundChoice::Transparent),
        "black" => Some(Rgb::BLACK),
        "white" => Some(Rgb::WHITE),
        _ if text.starts_with(|c: char| c.is_ascii_alphabetic()) && text.parse::<f64>().is_err() => {
            let known = ["black", "white", "transparent"].map(str::to_owned).into();
            return Err(unknown_word("colour", text, known) + "; or write " + FORMS);
        }
        _ => match text.strip_prefix('#') {
            Some(digits) => hexadecimal(digits),
            None => finite_numbers(text)
                .or_else(|| finite(text).ok().map(|grey| [grey; 3]))
                .filter(|rgb| rgb.iter().all(|&c| c >= 0.0))
                .map(Rgb::from),
        },
    };
    color
        .map(BackgroundChoice::Color)
        .ok_or_else(|| format!("expected `black`, `white`, `transparent`, {FORMS}, none negative"))
}

fn check(development: &Development) -> Result<(), String> {
    development.validate().map_err(|error| error.to_string())
}

fn number(text: &str) -> Result<f64, String> {
    text.parse().map_err(|_| "expected a number".to_owned())
}

/// Three or six hexadecimal digits in the sRGB encoding.
fn hexadecimal(digits: &str) -> Option<Rgb> {
    let digits = match digits.as_bytes() {
        [r, g, b] => vec![*r, *r, *g, *g, *b, *b],
        six => six.to_vec(),
    };
    let is_sound = digits.len() == 6 && digits.iter().all(u8::is_ascii_hexdigit);
    let value = u32::from_str_radix(std::str::from_utf8(&digits).ok().filter(|_| is_sound)?, 16).ok()?;
    let [_, r, g, b] = value.to_be_bytes().map(|byte| f64::from(Encoding::Srgb.decode(byte)));
    Some(Rgb::new(r, g, b))
}

fn finite_numbers(text: &str) -> Option<[f64; 3]> {
    numbers(text).filter(|values| values.iter().all(|value: &f64| value.is_finite()))
}

/// Exactly `N` numbers, separated by commas.
fn numbers<T: FromStr, const N: usize>(text: &str) -> Option<[T; N]> {
    let values: Option<Vec<T>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    values?.try_into().ok()
}

/// Message for an unknown word, with the nearest known one.
pub(super) fn unknown_word(kind: &'static str, found: &str, known: Vec<String>) -> String {
    LoadErrorKind::UnknownWord { kind, found: found.to_owned(), known }.to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_two_sides_within_the_limits() {
        assert_eq!(size("640x480"), Ok([640, 480]));
        for bad in
            ["", "640", "640x", "x480", "0x10", "10x0", "-1x5", "640*480", "1e3x10", "99999x99999", "4294967296x1"]
        {
            assert!(size(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn whole_numbers_lie_in_their_range() {
        let threads = whole(1..=1024_u16);
        assert_eq!((threads("1"), threads("1024")), (Ok(1), Ok(1024)));
        for bad in ["", "0", "1025", "-1", "1.5", "1e3", "many", "99999999999999999999"] {
            assert_eq!(threads(bad), Err("expected a whole number from 1 to 1024".to_owned()), "{bad}");
        }
        assert_eq!(whole(0..=u64::MAX)("18446744073709551615"), Ok(u64::MAX));
    }

    #[test]
    fn points_are_three_numbers_within_the_limit_of_scenes() {
        assert_eq!(point("1,-2.5, 1e3"), Ok(DVec3::new(1.0, -2.5, 1000.0)));
        assert_eq!(point("0,0,-1e60"), Ok(DVec3::new(0.0, 0.0, -1e60)));
        for bad in
            ["", "1,2", "1,2,3,4", "1,2,nan", "1,2,inf", "1,2,1e400", "a,b,c", "1;2;3", "1e61,0,0", "0,-1.1e60,0"]
        {
            assert!(point(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn crops_are_not_empty() {
        assert_eq!(crop("1,2,3,4"), Ok(Crop { x: 1, y: 2, width: 3, height: 4 }));
        for bad in ["1,2,3", "1,2,0,4", "1,2,3,0", "-1,2,3,4", "1,2,3,4,5", "1.5,2,3,4"] {
            assert!(crop(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn backgrounds_are_decoded_from_the_display() {
        let colour = |text: &str| match background(text) {
            Ok(BackgroundChoice::Color(rgb)) => rgb,
            other => panic!("{text}: {other:?}"),
        };
        assert_eq!(background("transparent"), Ok(BackgroundChoice::Transparent));
        assert_eq!(colour("#ffffff"), Rgb::WHITE);
        let mid = colour("#bc0000");
        assert!((mid.r - 0.502_886).abs() < 1e-6 && mid.g == 0.0, "{mid:?}");
        assert_eq!(colour("0.5,1,20"), Rgb::new(0.5, 1.0, 20.0));
        assert_eq!((colour("#f00"), colour("0.5")), (colour("#ff0000"), Rgb::new(0.5, 0.5, 0.5)));
        for bad in ["", "#ff", "#ggg", "#gggggg", "#+ffff0", "#ff00000", "1,2", "-1", "-1,0,0", "nan", "inf", "nan,0,0"]
        {
            let error = background(bad).expect_err(bad);
            assert!(error.contains("#RRGGBB"), "{error}");
        }
        let error = background("whit").expect_err("no color");
        assert!(
            error.starts_with("unknown colour `whit`; did you mean `white`?") && error.contains("#RRGGBB"),
            "{error}"
        );
    }

    #[test]
    fn times_and_percentages_have_units() {
        for (text, millis) in [
            ("500ms", 500),
            ("0.5s", 500),
            ("10s", 10_000),
            ("1.5min", 90_000),
            ("10m", 600_000),
            ("0.25h", 900_000),
            ("1h 30min", 5_400_000),
        ] {
            assert_eq!(time(text), Ok(Duration::from_millis(millis)), "{text}");
        }
        for bad in ["", "0s", "10", "0", "-1s", "nans", "NaN", "infs", "1e400s", "s", "1e-12s", "1e30h", "10 s s"] {
            assert!(time(bad).is_err(), "{bad}");
        }
        assert_eq!((percentage("1%"), percentage("0.5 %")), (Ok(0.01), Ok(0.005)));
        for bad in ["", "1", "0%", "-1%", "nan%", "inf%", "%", "1%%", "0.01", "1e-400%"] {
            assert!(percentage(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn scalars_are_checked() {
        assert_eq!(field_of_view("40"), Ok(40.0));
        assert_eq!(exposure("-1.5"), Ok(-1.5));
        assert_eq!(gamma("2.2"), Ok(2.2));
        for bad in ["0", "180", "-5", "nan", "x"] {
            assert!(field_of_view(bad).is_err(), "{bad}");
        }
        for bad in ["nan", "inf", "1e9", "x"] {
            assert!(exposure(bad).is_err() && gamma(bad).is_err(), "{bad}");
        }
        assert!(gamma("0").is_err());
        assert_eq!((finite("-2"), positive("1e-9"), pixels_per_degree("67")), (Ok(-2.0), Ok(1e-9), Ok(67.0)));
        for bad in ["nan", "inf", "-inf", "x"] {
            assert!(finite(bad).is_err() && positive(bad).is_err() && pixels_per_degree(bad).is_err(), "{bad}");
        }
        assert_eq!((non_negative("0"), non_negative("-1").is_err()), (Ok(0.0), true));
        assert!(positive("0").is_err() && pixels_per_degree("0").is_err());
    }
}
