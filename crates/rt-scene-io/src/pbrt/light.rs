//! Delta lights and infinite lights. Their units are radiance and radiant intensity; colour 1 is white.
//!
//! `power` (lm) and `illuminance` (lx) scale a light so that its colour 1 emits or receives as much:
//!
//! | light | factor |
//! |---|---|
//! | point | power / 4π |
//! | spot | power / 2π((1 − cos inner) + (cos inner − cos outer)/3) |
//! | distant | illuminance |
//! | infinite | illuminance / π |
//!
//! The edge of a spot is a squared ramp over the cosine, whose mean is 1/3. That of pbrt-v4 has the mean 1/2.

use std::f64::consts::{FRAC_1_PI, TAU};

use rt_math::transcendental::cos;
use rt_math::{DVec3, Rgb, Transform};
use rt_shading::{DeltaLight, DeltaLightKind, Falloff, LightUnits};

use super::FileScope;
use super::parameters::{Parameters, unknown};
use super::spectrum::light_colour;
use crate::error::{ErrorInLine, LineError};
use crate::{LoadErrorKind, read_texture, resolve_path};

#[derive(Debug)]
pub(super) enum PbrtLight {
    Light(DeltaLight),
    /// Uniform radiance from all directions.
    Sky(Rgb),
    /// A light that only other programs have.
    Unsupported,
}

/// Known kinds of lights.
const KINDS: [&str; 6] = ["point", "distant", "spot", "infinite", "goniometric", "projection"];

/// Reads a light in the space of `place`; returns warnings about approximations.
pub(super) fn read(
    kind: &str,
    parameters: &Parameters,
    place: &Transform,
    files: FileScope<'_>,
) -> Result<(PbrtLight, Vec<String>), LineError> {
    let name = match kind {
        "point" | "spot" => "I",
        "distant" | "infinite" => "L",
        "goniometric" | "projection" => return Ok((PbrtLight::Unsupported, Vec::new())),
        other => return Err(unknown("light", other, parameters.line, KINDS)),
    };
    let given = light_colour(parameters, name)?;
    let (colour, warning) = given.unwrap_or((Rgb::WHITE, None));
    let mut warnings = Vec::from_iter(warning);
    let intensity = colour * parameters.not_negative("scale", 1.0)?;
    let position = place.point(parameters.point("from", DVec3::ZERO)?);
    let source = match kind {
        "point" => {
            let falloff = Falloff::InverseSquare;
            let factor = level(parameters, "power", 1.0 / (2.0 * TAU))?;
            delta_light(parameters, DeltaLightKind::Point { position, falloff, shadow_near: 0.0 }, intensity * factor)
        }
        "distant" => {
            let kind = DeltaLightKind::Directional { direction: aim(parameters, place)? };
            delta_light(parameters, kind, intensity * level(parameters, "illuminance", 1.0)?)
        }
        "spot" => {
            let kind = spot(parameters, position, aim(parameters, place)?, &mut warnings)?;
            let spread = match kind {
                DeltaLightKind::Spot { cos_inner, cos_outer, .. } => {
                    TAU * (1.0 - cos_inner + (cos_inner - cos_outer) / 3.0)
                }
                _ => 2.0 * TAU,
            };
            delta_light(parameters, kind, intensity * level(parameters, "power", 1.0 / spread)?)
        }
        _ => {
            let Some(file) = parameters.word("filename", "string")? else {
                return Ok((PbrtLight::Sky(intensity * level(parameters, "illuminance", FRAC_1_PI)?), warnings));
            };
            let mean = mean_of_map(file, files).in_line(parameters.line)?;
            warnings.push(format!(
                "the image \"{file}\" all around became its mean, {mean:?}: octahedral maps are not shown"
            ));
            PbrtLight::Sky(mean * parameters.not_negative("scale", 1.0)?)
        }
    };
    Ok((source, warnings))
}

fn delta_light(parameters: &Parameters, kind: DeltaLightKind, intensity: Rgb) -> PbrtLight {
    let name = format!("line {}", parameters.line);
    PbrtLight::Light(DeltaLight { name, kind, intensity, units: LightUnits::Physical, casts_shadows: true })
}

/// Factor for a light whose whole `power` or `illuminance` is given; 1 where it is not, or not positive.
fn level(parameters: &Parameters, name: &str, per_unit: f64) -> Result<f64, LineError> {
    let given = parameters.float(name, 0.0)?;
    Ok(if given > 0.0 { given * per_unit } else { 1.0 })
}

/// Direction of emission.
fn aim(parameters: &Parameters, place: &Transform) -> Result<DVec3, LineError> {
    let (from, to) = (parameters.point("from", DVec3::ZERO)?, parameters.point("to", DVec3::Z)?);
    place.vector(to - from).try_normalize().ok_or_else(|| {
        LineError::new(
            parameters.line,
            format_args!("the direction from {from} to {to}"),
            "has length 0: move one of them",
        )
    })
}

/// Cone of a spot light, with the squared ramp of [`DeltaLightKind::Spot`] at its edge.
///
/// pbrt-v4 takes the cosine of the inner angle. One below 0 therefore counts without its sign.
fn spot(
    parameters: &Parameters,
    position: DVec3,
    direction: DVec3,
    warnings: &mut Vec<String>,
) -> Result<DeltaLightKind, LineError> {
    let width = parameters.float("coneangle", 30.0)?;
    let start = width - parameters.float("conedeltaangle", 5.0)?;
    if !(start <= width && 0.0 < width) {
        let rule = "must be angles with inner <= outer, and outer above 0";
        return Err(LineError::new(parameters.line, format_args!("a cone from {start} to {width} degrees"), rule));
    }
    let outer = width.min(90.0);
    if width > outer {
        warnings.push(format!("a spot of {width} degrees from its axis is not supported: {outer} is used"));
    }
    // Beyond the cone, pbrt-v4 would be dark within it.
    let inner = if start < -width { 0.0 } else { start.abs().min(outer) };
    if start < 0.0 {
        warnings.push(format!("the falloff of a spot begins {start} degrees from its axis: {inner} is used"));
    }
    let cos_outer = cos(outer.to_radians()).clamp(0.0, 1.0_f64.next_down());
    let cos_inner = cos(inner.to_radians()).max(cos_outer.next_up());
    Ok(DeltaLightKind::Spot { position, direction, cos_inner, cos_outer, falloff: Falloff::InverseSquare })
}

/// The mean radiance of a map of equal areas.
fn mean_of_map(file: &str, files: FileScope<'_>) -> Result<Rgb, LoadErrorKind> {
    let path = resolve_path(file, files.root_file, files.options)?;
    let bitmap = read_texture(&path, files.options).map_err(|reason| LoadErrorKind::bad_reference(file, reason))?;
    if bitmap.width != bitmap.height {
        let rule = format!("has {}x{} pixels: maps all around must be square", bitmap.width, bitmap.height);
        return Err(LoadErrorKind::bad_reference(file, rule));
    }
    let sum = bitmap.pixels.iter().fold(Rgb::BLACK, |sum, pixel| sum + Rgb::from(pixel.map(f64::from)));
    Ok((sum / bitmap.pixels.len() as f64).map(|c| c.max(0.0)))
}
