//! Numbers, vectors and colours of the file, checked.

use std::fmt::Display;

use rt_image::Encoding;
use rt_math::{DVec3, Rgb};

use crate::LoadErrorKind;
use crate::format::Color;
use crate::limits;

/// A coordinate or length: a number of magnitude at most 10⁶⁰.
pub(super) fn coordinate(value: f64) -> Result<f64, LoadErrorKind> {
    // A NaN fails the comparison.
    if value.abs() <= limits::NUMBER {
        Ok(value)
    } else {
        Err(LoadErrorKind::invalid(format_args!("{value:e}"), "is not a number of magnitude at most 1e60"))
    }
}

/// A point or vector.
pub(super) fn vector(value: [f64; 3]) -> Result<DVec3, LoadErrorKind> {
    for component in value {
        coordinate(component)?;
    }
    Ok(DVec3::from(value))
}

/// A direction of any length but 0, as a unit vector.
pub(super) fn direction(value: [f64; 3]) -> Result<DVec3, LoadErrorKind> {
    let [x, y, z] = value;
    vector(value)?.try_normalize().ok_or_else(|| {
        LoadErrorKind::invalid(format_args!("({x}, {y}, {z})"), "has no direction: give a vector that is not 0")
    })
}

/// A number above 0.
pub(super) fn positive(value: f64) -> Result<f64, LoadErrorKind> {
    if value > 0.0 { coordinate(value) } else { Err(LoadErrorKind::invalid(value, "must be above 0")) }
}

/// A number from 0 up.
pub(super) fn not_negative(value: f64) -> Result<f64, LoadErrorKind> {
    if value >= 0.0 { coordinate(value) } else { Err(LoadErrorKind::invalid(value, "must be at least 0")) }
}

/// A value between two limits, which both count.
pub(super) fn within<T: PartialOrd + Display>(value: T, min: T, max: T) -> Result<T, LoadErrorKind> {
    if min <= value && value <= max {
        Ok(value)
    } else {
        Err(LoadErrorKind::invalid(value, format!("must lie between {min} and {max}")))
    }
}

/// A colour whose components are finite and not negative.
pub(super) fn colour(value: &Color) -> Result<Rgb, LoadErrorKind> {
    let components = match value {
        Color::Gray(value) => [*value; 3],
        Color::Rgb(r, g, b) => [*r, *g, *b],
        Color::Hex(digits) => hex(digits)?,
    };
    for component in components {
        not_negative(component)?;
    }
    Ok(components.into())
}

/// Linear components of `#rrggbb`, or of `#rgb` for short.
fn hex(text: &str) -> Result<[f64; 3], LoadErrorKind> {
    let bad = || {
        let rule = "is not a colour: write six hexadecimal digits as in \"#ff8000\", or three as in \"#f80\"";
        LoadErrorKind::invalid(format_args!("\"{text}\""), rule)
    };
    let digits = text.strip_prefix('#').unwrap_or(text);
    if !digits.bytes().all(|digit| digit.is_ascii_hexdigit()) {
        return Err(bad());
    }
    let digits = match digits.len() {
        3 => digits.chars().flat_map(|digit| [digit; 2]).collect(),
        6 => digits.to_owned(),
        4 | 8 => {
            let rule = "has an alpha component, which colours do not support: remove it, as in \"#ff8000\"";
            return Err(LoadErrorKind::invalid(format_args!("\"{text}\""), rule));
        }
        _ => return Err(bad()),
    };
    let digits = digits.as_str();
    let [_, r, g, b] = u32::from_str_radix(digits, 16).map_err(|_| bad())?.to_be_bytes();
    Ok([r, g, b].map(|byte| Encoding::Srgb.decode_signal(f64::from(byte) / 255.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_are_no_coordinates_are_refused() {
        for bad in [f64::NAN, f64::INFINITY, -1.1e60] {
            assert!(coordinate(bad).is_err(), "{bad}");
            assert!(vector([0.0, bad, 0.0]).is_err(), "{bad}");
            assert!(colour(&Color::Gray(bad)).is_err(), "{bad}");
        }
        assert_eq!(coordinate(-1e60).unwrap(), -1e60);
        assert!(positive(0.0).is_err() && positive(f64::NAN).is_err() && not_negative(f64::NAN).is_err());
        assert!(within(f64::NAN, 0.0, 1.0).is_err());
        assert!(direction([0.0; 3]).is_err());
        assert_eq!(direction([0.0, 3.0, 0.0]).unwrap(), DVec3::Y);
    }

    #[test]
    fn hex_colours_are_display_colours() {
        assert_eq!(colour(&Color::Hex("#ff0000".to_owned())).unwrap(), Rgb::new(1.0, 0.0, 0.0));
        let middle = colour(&Color::Hex("808080".to_owned())).unwrap().g;
        assert!((middle - 0.215_860_5).abs() < 1e-7, "{middle}");
        assert_eq!(colour(&Color::Hex("#f80".to_owned())).unwrap(), colour(&Color::Hex("#ff8800".to_owned())).unwrap());
        for bad in ["", "#ffff", "#ff0000ff", "#gg0000", "#ff00000", "#+f0000", "#é000"] {
            assert!(colour(&Color::Hex(bad.to_owned())).is_err(), "{bad}");
        }
    }
}
