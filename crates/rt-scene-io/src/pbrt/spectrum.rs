//! Spectra as linear sRGB.
//!
//! ```text
//! rgb        as it is
//! blackbody  Planck's law ── colour matching functions ──> XYZ ──> sRGB, of luminance 1
//! spectrum   the name of a metal; pairs of wavelength and value become their mean, and of lights a colour of luminance 1
//! ```
//!
//! Colour matching functions: Wyman, Sloan and Shirley, "Simple Analytic Approximations to the CIE XYZ Color Matching
//! Functions", JCGT 2(2), 2013, with several lobes.

use rt_math::Rgb;
use rt_math::transcendental::exp;
use rt_shading::bsdf::ComplexIor;

use super::parameters::{Parameter, Parameters, Values};
use crate::error::LineError;

/// Warning about an approximated spectrum.
pub(super) type Approximation = Option<String>;

/// The colour of a parameter, none of whose numbers may be negative.
pub(super) fn colour(parameters: &Parameters, name: &str) -> Result<Option<(Rgb, Approximation)>, LineError> {
    parameters.get(name).map(of).transpose()
}

/// Version of [`colour`] for lights: pairs of wavelength and value become a colour of luminance 1.
///
/// Only the shape of such a spectrum counts, as in pbrt-v4, where the photometric value of a light is divided out.
pub(super) fn light_colour(parameters: &Parameters, name: &str) -> Result<Option<(Rgb, Approximation)>, LineError> {
    let Some(parameter) = parameters.get(name) else { return Ok(None) };
    match (parameter.kind, &parameter.values) {
        ("spectrum", Values::Numbers(numbers)) => emitted(parameter, numbers).map(Some),
        _ => of(parameter).map(Some),
    }
}

/// The colour of light with a spectrum of pairs of wavelength and value.
fn emitted(parameter: &Parameter, numbers: &[f64]) -> Result<(Rgb, Approximation), LineError> {
    check_pairs(parameter, numbers)?;
    let (points, _) = numbers.as_chunks::<2>();
    let mut neighbours = points.iter().zip(points.iter().skip(1));
    if let Some(([before, _], [after, _])) = neighbours.find(|([before, _], [after, _])| before >= after) {
        return Err(parameter.error(format_args!("{after} nm after {before} nm"), "must be a longer wavelength"));
    }
    let xyz = xyz_of(1, |nm| interpolate(points, nm));
    if xyz[1] <= 0.0 {
        return Ok((
            Rgb::BLACK,
            Some(format!("the spectrum \"{}\" has no visible light: it is black", parameter.name)),
        ));
    }
    let rgb = rgb_of(xyz);
    let warning = format!("the spectrum \"{}\" has a colour outside of sRGB: it is clipped", parameter.name);
    let is_clipped = rgb.to_array().iter().any(|c| *c < 0.0);
    Ok((of_luminance_one(rgb), is_clipped.then_some(warning)))
}

/// Value at a wavelength of a spectrum that is linear between its points, and constant beyond them.
fn interpolate(points: &[[f64; 2]], nm: f64) -> f64 {
    let (before, after) = points.split_at(points.partition_point(|[at, _]| *at <= nm));
    match (before.last(), after.first()) {
        (Some(&[x0, y0]), Some(&[x1, y1])) => y0 + (y1 - y0) * ((nm - x0) / (x1 - x0)),
        (Some(&[_, value]), None) | (None, Some(&[_, value])) => value,
        (None, None) => 0.0,
    }
}

/// Refuses a spectrum without pairs, or with negative values.
fn check_pairs(parameter: &Parameter, numbers: &[f64]) -> Result<(), LineError> {
    if numbers.is_empty() || numbers.iter().skip(1).step_by(2).any(|value| *value < 0.0) {
        return Err(parameter.error(format_args!("{numbers:?}"), "must be pairs of wavelength and value from 0 up"));
    }
    Ok(())
}

fn of(parameter: &Parameter) -> Result<(Rgb, Approximation), LineError> {
    match (parameter.kind, &parameter.values) {
        ("rgb", Values::Numbers(numbers)) => match numbers[..] {
            [r, g, b] if r >= 0.0 && g >= 0.0 && b >= 0.0 => Ok((Rgb::new(r, g, b), None)),
            _ => Err(parameter.error(format_args!("{numbers:?}"), "must be three numbers of at least 0")),
        },
        ("float", Values::Numbers(numbers)) => match numbers[..] {
            [gray] if gray >= 0.0 => Ok((Rgb::gray(gray), None)),
            _ => Err(parameter.error(format_args!("{numbers:?}"), "must be one number from 0 up")),
        },
        ("blackbody", Values::Numbers(numbers)) => match numbers[..] {
            [kelvin] if (500.0..=1e6).contains(&kelvin) => Ok((blackbody(kelvin), None)),
            _ => Err(parameter.error(format_args!("{numbers:?}"), "must be one temperature from 500 to 1e6 kelvin")),
        },
        ("spectrum", Values::Numbers(numbers)) => {
            check_pairs(parameter, numbers)?;
            let values = || numbers.iter().skip(1).step_by(2);
            let mean = values().sum::<f64>() / values().count() as f64;
            let warning = format!("the spectrum \"{}\" became its mean, {mean}", parameter.name);
            Ok((Rgb::gray(mean), values().any(|value| *value != mean).then_some(warning)))
        }
        ("spectrum", Values::Words(words)) => match words.first().map(String::as_str) {
            Some("stdillum-D65") => Ok((Rgb::WHITE, None)),
            Some(name) => {
                Ok((Rgb::WHITE, Some(format!("the spectrum \"{name}\" is not known: white is in its place"))))
            }
            None => Err(parameter.error("an empty value", "must be the name of a spectrum")),
        },
        (kind, _) => Err(parameter.error(kind, "has the wrong type: give rgb")),
    }
}

/// The index of refraction of a measured metal by the name of either of its two spectra, such as `metal-Cu-eta`.
pub(super) fn metal(name: &str) -> Option<ComplexIor> {
    let symbol = name.strip_prefix("metal-")?;
    match symbol.strip_suffix("-eta").or_else(|| symbol.strip_suffix("-k"))? {
        "Al" => Some(ComplexIor::ALUMINIUM),
        "Cu" => Some(ComplexIor::COPPER),
        "Au" => Some(ComplexIor::GOLD),
        "Ag" => Some(ComplexIor::SILVER),
        _ => None,
    }
}

/// The index of refraction of a measured glass at 587.6 nm, by the catalogues of its makers.
pub(super) fn glass(name: &str) -> Option<f64> {
    Some(match name {
        "glass-BK7" => 1.5168,
        "glass-BAF10" => 1.67003,
        "glass-FK51A" => 1.48656,
        "glass-LASF9" => 1.85025,
        "glass-F5" | "glass-SF5" => 1.6727,
        "glass-F10" | "glass-SF10" => 1.72825,
        "glass-F11" | "glass-SF11" => 1.78472,
        _ => return None,
    })
}

/// Colour of a black body, of luminance 1; colours outside of sRGB are clipped.
fn blackbody(kelvin: f64) -> Rgb {
    /// Planck's constant times the speed of light over Boltzmann's constant, in nm·K.
    const C2: f64 = 1.438_776_877e7;
    let xyz = xyz_of(5, |nm| {
        // Relative to 560 nm, lest numbers grow out of range.
        let relative = nm / 560.0;
        let fifth = relative * relative * relative * relative * relative;
        (exp(C2 / (560.0 * kelvin)) - 1.0) / (exp(C2 / (nm * kelvin)) - 1.0) / fifth
    });
    of_luminance_one(rgb_of(xyz))
}

/// Relative XYZ of a spectrum, in steps of `step` nm.
fn xyz_of(step: u32, power: impl Fn(f64) -> f64) -> [f64; 3] {
    let mut xyz = [0.0; 3];
    for nm in (360..=830).step_by(step as usize).map(f64::from) {
        let power = power(nm);
        for (sum, matching) in xyz.iter_mut().zip(matching(nm)) {
            *sum += power * matching;
        }
    }
    xyz
}

/// Linear sRGB of a colour whose Y becomes 1; components outside of sRGB are negative.
fn rgb_of(xyz: [f64; 3]) -> Rgb {
    let [x, y, z] = xyz.map(|sum| sum / xyz[1]);
    Rgb::new(
        3.240_454_2 * x - 1.537_138_5 * y - 0.498_531_4 * z,
        -0.969_266_0 * x + 1.876_010_8 * y + 0.041_556_0 * z,
        0.055_643_4 * x - 0.204_025_9 * y + 1.057_225_2 * z,
    )
}

/// Clips a colour, and scales it to luminance 1.
fn of_luminance_one(rgb: Rgb) -> Rgb {
    let clipped = rgb.map(|c| c.max(0.0));
    clipped / clipped.luminance()
}

/// The colour matching functions of the observer of 1931 at a wavelength.
fn matching(nm: f64) -> [f64; 3] {
    let lobe = |height: f64, middle: f64, below: f64, above: f64| {
        let t = (nm - middle) * if nm < middle { below } else { above };
        height * exp(-0.5 * t * t)
    };
    [
        lobe(0.362, 442.0, 0.0624, 0.0374) + lobe(1.056, 599.8, 0.0264, 0.0323) + lobe(-0.065, 501.1, 0.0490, 0.0382),
        lobe(0.821, 568.8, 0.0213, 0.0247) + lobe(0.286, 530.9, 0.0613, 0.0322),
        lobe(1.217, 437.0, 0.0845, 0.0278) + lobe(0.681, 459.0, 0.0385, 0.0725),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text::tokenizer::Tokenizer;

    fn read(text: &str) -> Result<(Rgb, Approximation), String> {
        let parameters = Parameters::read(&mut Tokenizer::new(text), 1).expect("parameters");
        colour(&parameters, "L").map(|found| found.expect("a colour")).map_err(|error| error.kind.to_string())
    }

    #[test]
    fn colours_and_their_losses() {
        assert_eq!(read("\"rgb L\" [1 2 3]").unwrap(), (Rgb::new(1.0, 2.0, 3.0), None));
        assert_eq!(read("\"spectrum L\" [400 2 700 2]").unwrap(), (Rgb::gray(2.0), None));
        assert_eq!(read("\"spectrum L\" [400 1 700 2]").unwrap().1.unwrap(), "the spectrum \"L\" became its mean, 1.5");
        assert_eq!(
            read("\"rgb L\" [1 -2 3]").unwrap_err(),
            "\"L\": [1.0, -2.0, 3.0] must be three numbers of at least 0"
        );
        assert!(read("\"blackbody L\" [1]").is_err() && read("\"point3 L\" [1 1 1]").is_err());
        assert!(read("\"spectrum L\" \"stdillum-F11\"").unwrap().1.is_some());
    }

    fn read_light(text: &str) -> Result<(Rgb, Approximation), String> {
        let parameters = Parameters::read(&mut Tokenizer::new(text), 1).expect("parameters");
        light_colour(&parameters, "L").map(|found| found.expect("a colour")).map_err(|error| error.kind.to_string())
    }

    /// Lights had the mean of their spectrum. pbrt-v4 divides its photometric value out.
    #[test]
    fn spectra_of_lights_have_luminance_1_whatever_their_level() {
        let (constant, warning) = read_light("\"spectrum L\" [200 128 900 128]").unwrap();
        assert_eq!((constant, &warning), (read_light("\"spectrum L\" [550 1]").unwrap().0, &None));
        // CIE 15: equal energy has the chromaticity (1/3, 1/3), and these components in sRGB.
        let equal_energy = Rgb::new(1.2048, 0.9483, 0.9089);
        assert!((constant - equal_energy).map(f64::abs).max_component() < 0.01, "{constant:?}");
        for spectrum in ["[400 1e59 700 2e59]", "[360 0 500 1 830 4]", "[454 0 455 1e-9 456 0]", "[700 3 701 3]"] {
            let (rgb, _) = read_light(&format!("\"spectrum L\" {spectrum}")).unwrap();
            assert!((rgb.luminance() - 1.0).abs() < 1e-12, "{spectrum}: {rgb:?}");
        }
        let (twice, once) = ("\"spectrum L\" [400 2 700 4]", "\"spectrum L\" [400 1 700 2]");
        assert_eq!((read_light(twice), read_light(once).unwrap().1), (read_light(once), None));
        assert!(read_light("\"spectrum L\" [519 0 520 1 521 0]").unwrap().1.unwrap().contains("outside of sRGB"));
        for black in ["[400 0 700 0]", "[200 1 300 0]"] {
            let (rgb, warning) = read_light(&format!("\"spectrum L\" {black}")).unwrap();
            assert_eq!(rgb, Rgb::BLACK);
            assert_eq!(warning.unwrap(), "the spectrum \"L\" has no visible light: it is black");
        }
        let error = read_light("\"spectrum L\" [400 1 400 2]").unwrap_err();
        assert_eq!(error, "\"L\": 400 nm after 400 nm must be a longer wavelength");
        assert!(read_light("\"spectrum L\" [400 -1]").is_err());
        assert_eq!(read_light("\"rgb L\" [1 2 3]").unwrap().0, Rgb::new(1.0, 2.0, 3.0));
    }

    /// CIE 15: the chromaticity of a black body of 2856 K, illuminant A, is (0.4476, 0.4074).
    #[test]
    fn black_bodies_have_the_chromaticity_of_their_temperature() {
        let Rgb { r, g, b } = blackbody(2856.0);
        let x = 0.412_456 * r + 0.357_576 * g + 0.180_437 * b;
        let y = 0.212_673 * r + 0.715_152 * g + 0.072_175 * b;
        let z = 0.019_334 * r + 0.119_192 * g + 0.950_304 * b;
        let sum = x + y + z;
        assert!((x / sum - 0.4476).abs() < 4e-3 && (y / sum - 0.4074).abs() < 4e-3, "{} {}", x / sum, y / sum);
        assert!((y - 1.0).abs() < 1e-3, "{y}");
        for kelvin in [500.0, 6500.0, 1e6] {
            let white = blackbody(kelvin);
            assert!(white.is_finite() && (white.luminance() - 1.0).abs() < 1e-12, "{kelvin}: {white:?}");
        }
        assert!((blackbody(6600.0) - Rgb::WHITE).map(f64::abs).max_component() < 0.05, "{:?}", blackbody(6600.0));
    }

    #[test]
    fn metals_go_by_either_spectrum() {
        assert_eq!(metal("metal-Au-eta"), Some(ComplexIor::GOLD));
        assert_eq!(metal("metal-Ag-k"), Some(ComplexIor::SILVER));
        assert_eq!((metal("metal-Xx-k"), metal("glass-BK7")), (None, None));
    }
}
