//! Values as users write them. Each parser refuses with the rule that was broken.

use std::path::Path;
use std::time::Duration;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use rt_camera::FilmSettings;
use rt_image::{Development, Encoding, ImageFormat, ToneCurve, metrics::Flip};
use rt_math::{DVec3, Rgb};
use rt_render::{Crop, Quality, Share, SimdLevel};

use super::{Aov, AovArg, BackgroundChoice, Every};

/// The tone curves.
pub(crate) const TONE_CURVES: [ToneCurve; 3] = [ToneCurve::Clamp, ToneCurve::Reinhard, ToneCurve::Aces];

/// The name that users type.
pub(crate) const fn tone_name(tone: ToneCurve) -> &'static str {
    match tone {
        ToneCurve::Clamp => "clamp",
        ToneCurve::Reinhard => "reinhard",
        ToneCurve::Aces => "aces",
    }
}

/// The tone curve of this name.
pub(crate) fn tone_of_name(name: &str) -> Option<ToneCurve> {
    TONE_CURVES.into_iter().find(|&tone| tone_name(tone) == name)
}

/// A choice among values that have names.
pub(super) fn choice<T: Copy + Send + Sync + 'static, const N: usize>(
    all: [T; N],
    name: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(all.map(name))
        .try_map(move |typed| all.into_iter().find(|&value| name(value) == typed).ok_or("no such choice"))
}

/// Instructions that this processor has.
pub(super) fn simd() -> impl TypedValueParser<Value = SimdLevel> {
    let names = PossibleValuesParser::new(SimdLevel::ALL.iter().map(|level| level.name()));
    names.try_map(|typed| {
        let known = SimdLevel::ALL.iter().find(|level| level.name() == typed);
        known.copied().filter(|level| level.is_available()).ok_or("this processor does not have it")
    })
}

/// How much time the builder of the wide tree may take.
pub(super) fn quality() -> impl TypedValueParser<Value = Quality> {
    let names = PossibleValuesParser::new(Quality::ALL.iter().map(|quality| quality.name()));
    names.try_map(|typed| Quality::ALL.iter().copied().find(|quality| quality.name() == typed).ok_or("no such quality"))
}

/// True to dither.
pub(super) fn dither() -> impl TypedValueParser<Value = bool> {
    PossibleValuesParser::new([PossibleValue::new("on"), PossibleValue::new("none").alias("off")])
        .map(|typed| typed == "on")
}

/// The format of a picture, by the ending of its name.
pub(super) fn image_format() -> impl TypedValueParser<Value = ImageFormat> {
    let names = ImageFormat::ALL.into_iter().map(|format| {
        let [usual, others @ ..] = format.extensions() else { return PossibleValue::new("") };
        PossibleValue::new(*usual).aliases(others.iter().copied())
    });
    PossibleValuesParser::new(names)
        .try_map(|typed| ImageFormat::from_path(Path::new(&format!("a.{typed}"))).map_err(|error| error.to_string()))
}

/// `WxH`.
pub(super) fn size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    let [width, height] = sides.ok_or("write width and height in pixels as 640x480")?;
    FilmSettings { width, height, ..FilmSettings::default() }.validate().map_err(|error| error.to_string())?;
    Ok([width, height])
}

/// `X,Y,Z`.
pub(super) fn point(text: &str) -> Result<DVec3, String> {
    finite_numbers(text).map(DVec3::from_array).ok_or_else(|| "write three finite numbers as 1,-2,0.5".to_owned())
}

/// `X,Y,W,H`.
pub(super) fn crop(text: &str) -> Result<Crop, String> {
    let [x, y, width, height] = numbers(text).ok_or("write left, top, width and height in pixels as 100,50,320,200")?;
    if width == 0 || height == 0 {
        return Err("width and height must be at least 1".to_owned());
    }
    Ok(Crop { x, y, width, height })
}

/// Degrees, in (0, 180).
pub(super) fn field_of_view(text: &str) -> Result<f64, String> {
    let degrees = text.parse().ok().filter(|&degrees: &f64| degrees > 0.0 && degrees < 180.0);
    degrees.ok_or_else(|| "it must lie between 0 and 180 degrees".to_owned())
}

/// Stops.
pub(super) fn exposure(text: &str) -> Result<f64, String> {
    let exposure = number(text)?;
    check(&Development { exposure, ..Development::default() }).map(|()| exposure)
}

/// The exponent of a power law.
pub(super) fn gamma(text: &str) -> Result<f64, String> {
    let gamma = number(text)?;
    check(&Development { encoding: Encoding::Power(gamma), ..Development::default() }).map(|()| gamma)
}

/// Any finite number.
pub(super) fn finite(text: &str) -> Result<f64, String> {
    number(text).ok().filter(|value| value.is_finite()).ok_or_else(|| "write a finite number".to_owned())
}

/// A finite number above zero.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    finite(text).ok().filter(|&value| value > 0.0).ok_or_else(|| "write a number above 0".to_owned())
}

/// A time above zero with its unit.
pub(super) fn time(text: &str) -> Result<Duration, String> {
    let time = humantime::parse_duration(text).ok().filter(|time| !time.is_zero());
    time.ok_or_else(|| "write a time above 0 with its unit, as 500ms, 10s, 1.5min or 2h".to_owned())
}

/// A time with its unit, or "never".
pub(super) fn every(text: &str) -> Result<Every, String> {
    if text == "never" { Ok(Every::Never) } else { time(text).map(Every::Time).map_err(|error| error + ", or never") }
}

/// Part I of N, from 1 on.
pub(super) fn share(text: &str) -> Result<Share, String> {
    let numbers =
        text.split_once('/').and_then(|(index, count)| Some((index.parse::<u32>().ok()?, count.parse().ok()?)));
    numbers
        .and_then(|(index, count)| Share::new(index.checked_sub(1)?, count))
        .ok_or_else(|| format!("write which part of how many, as 1/8 to 8/8; there are at most {}", Share::MOST))
}

/// A percentage above zero, as a share.
pub(super) fn percentage(text: &str) -> Result<f64, String> {
    let percent = text.strip_suffix('%').and_then(|number| positive(number.trim_end()).ok());
    percent
        .map(|percent| percent / 100.0)
        .filter(|&share| share > 0.0)
        .ok_or_else(|| "write a percentage above 0, as 1%".to_owned())
}

/// A percentage above zero and up to a hundred, as a share.
pub(super) fn share_of_pixels(text: &str) -> Result<f64, String> {
    percentage(text)
        .ok()
        .filter(|share| *share <= 1.0)
        .ok_or_else(|| "write a percentage above 0 and up to 100, as 99%".to_owned())
}

/// `NAME=FILE`.
pub(super) fn aov(text: &str) -> Result<AovArg, String> {
    let parts = text.split_once('=').filter(|(_, file)| !file.is_empty());
    let known = parts.and_then(|(name, file)| Some((Aov::ALL.into_iter().find(|aov| aov.name() == name)?, file)));
    let (aov, file) = known.ok_or_else(|| "write variance=FILE or samples=FILE".to_owned())?;
    Ok(AovArg { aov, file: file.into() })
}

/// What ꟻLIP accepts.
pub(super) fn pixels_per_degree(text: &str) -> Result<f64, String> {
    let value = number(text)?;
    Flip::new(value).map(|_| value).map_err(|error| error.to_string())
}

/// A colour, or `transparent`.
pub(super) fn background(text: &str) -> Result<BackgroundChoice, String> {
    let colour = match text {
        "transparent" => return Ok(BackgroundChoice::Transparent),
        "black" => Some(Rgb::BLACK),
        "white" => Some(Rgb::WHITE),
        _ => match text.strip_prefix('#') {
            Some(digits) => hexadecimal(digits),
            None => finite_numbers(text).filter(|rgb| rgb.iter().all(|&c| c >= 0.0)).map(Rgb::from),
        },
    };
    let rule = "write #RRGGBB, three linear numbers as 0.2,0.4,1, `black`, `white` or `transparent`";
    colour.map(BackgroundChoice::Colour).ok_or_else(|| rule.to_owned())
}

fn check(development: &Development) -> Result<(), String> {
    development.validate().map_err(|error| error.to_string())
}

fn number(text: &str) -> Result<f64, String> {
    text.parse().map_err(|_| "write a number".to_owned())
}

/// Six hexadecimal digits in the sRGB encoding.
fn hexadecimal(digits: &str) -> Option<Rgb> {
    let value = u32::from_str_radix(digits, 16).ok().filter(|_| digits.len() == 6 && !digits.starts_with('+'))?;
    let [_, r, g, b] = value.to_be_bytes().map(|byte| f64::from(Encoding::Srgb.decode(byte)));
    Some(Rgb::new(r, g, b))
}

fn finite_numbers(text: &str) -> Option<[f64; 3]> {
    numbers(text).filter(|values| values.iter().all(|value: &f64| value.is_finite()))
}

/// Exactly `N` numbers with commas between.
fn numbers<T: std::str::FromStr, const N: usize>(text: &str) -> Option<[T; N]> {
    let values: Option<Vec<T>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    values?.try_into().ok()
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
    fn points_are_three_finite_numbers() {
        assert_eq!(point("1,-2.5, 1e3"), Ok(DVec3::new(1.0, -2.5, 1000.0)));
        for bad in ["", "1,2", "1,2,3,4", "1,2,nan", "1,2,inf", "1,2,1e400", "a,b,c", "1;2;3"] {
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
            Ok(BackgroundChoice::Colour(rgb)) => rgb,
            other => panic!("{text}: {other:?}"),
        };
        assert_eq!(background("transparent"), Ok(BackgroundChoice::Transparent));
        assert_eq!(colour("#ffffff"), Rgb::WHITE);
        let mid = colour("#bc0000");
        assert!((mid.r - 0.502_886).abs() < 1e-6 && mid.g == 0.0, "{mid:?}");
        assert_eq!(colour("0.5,1,20"), Rgb::new(0.5, 1.0, 20.0));
        for bad in ["", "blue", "#fff", "#gggggg", "#+ffff0", "#ff00000", "1,2", "-1,0,0", "nan,0,0"] {
            assert!(background(bad).is_err(), "{bad}");
        }
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
    fn aovs_have_a_name_and_a_file() {
        let samples = AovArg { aov: Aov::Samples, file: "a=b.exr".into() };
        assert_eq!(aov("samples=a=b.exr"), Ok(samples));
        for bad in ["", "samples", "samples=", "depth=a.exr", "=a.exr", "variance a.exr"] {
            assert!(aov(bad).is_err(), "{bad}");
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
        assert!(positive("0").is_err() && pixels_per_degree("0").is_err());
    }
}
