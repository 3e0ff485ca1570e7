//! Lights without extent, and the sky. Their units are radiance and radiant intensity, of which the colour 1 is white.
//!
//! Our lights without extent count π times, as a classical ray tracer has no 1/π in its diffuse surfaces: a part 1/π of the
//! intensities of the file gives the same picture.

use std::f64::consts::FRAC_1_PI;

use rt_math::transcendental::cos;
use rt_math::{DVec3, Rgb, Transform};
use rt_shading::{Falloff, Light, LightKind};

use super::Files;
use super::material::unknown;
use super::parameters::Parameters;
use super::spectrum::colour;
use crate::flaw::Flaw;
use crate::{Reason, read_texture, resolve_path};

/// Something that shines on the scene.
#[derive(Debug)]
pub(super) enum Source {
    Light(Light),
    /// The same radiance from everywhere.
    Sky(Rgb),
    /// A light that only other programs have.
    Unsupported,
}

/// Known kinds of lights.
const KINDS: [&str; 6] = ["point", "distant", "spot", "infinite", "goniometric", "projection"];

/// Reads a light in the space of `place`, with what is lost of it.
pub(super) fn read(
    kind: &str,
    parameters: &Parameters,
    place: &Transform,
    files: Files<'_>,
) -> Result<(Source, Vec<String>), Flaw> {
    let name = match kind {
        "point" | "spot" => "I",
        "distant" | "infinite" => "L",
        "goniometric" | "projection" => return Ok((Source::Unsupported, Vec::new())),
        other => return Err(unknown("light", other, parameters.line, KINDS)),
    };
    let given = colour(parameters, name)?;
    let (colour, loss) = given.unwrap_or((Rgb::WHITE, None));
    let mut losses = Vec::from_iter(loss);
    let intensity = colour * parameters.not_negative("scale", 1.0)?;
    let position = place.point(parameters.point("from", DVec3::ZERO)?);
    let source = match kind {
        "point" => {
            let falloff = Falloff::InverseSquare;
            lamp(parameters, LightKind::Point { position, falloff, lamp_radius: 0.0 }, intensity)
        }
        "distant" => lamp(parameters, LightKind::Directional { direction: aim(parameters, place)? }, intensity),
        "spot" => lamp(parameters, spot(parameters, position, aim(parameters, place)?)?, intensity),
        _ => {
            let Some(file) = parameters.word("filename", "string")? else {
                return Ok((Source::Sky(intensity), losses));
            };
            let mean = mean_of_map(file, files).map_err(|reason| Flaw { line: parameters.line, reason })?;
            losses.push(format!(
                "the image \"{file}\" all around became its mean, {mean:?}: octahedral maps are not shown"
            ));
            Source::Sky(mean * parameters.not_negative("scale", 1.0)?)
        }
    };
    Ok((source, losses))
}

fn lamp(parameters: &Parameters, kind: LightKind, intensity: Rgb) -> Source {
    let (name, intensity) = (format!("line {}", parameters.line), intensity * FRAC_1_PI);
    Source::Light(Light { name, kind, intensity, casts_shadows: true })
}

/// The direction in which it shines.
fn aim(parameters: &Parameters, place: &Transform) -> Result<DVec3, Flaw> {
    let (from, to) = (parameters.point("from", DVec3::ZERO)?, parameters.point("to", DVec3::Z)?);
    place.vector(to - from).try_normalize().ok_or_else(|| {
        Flaw::new(parameters.line, format_args!("the way from {from} to {to}"), "has no direction: move one of them")
    })
}

/// A cone whose edge fades, here by the squared ramp of our spot lights.
fn spot(parameters: &Parameters, position: DVec3, direction: DVec3) -> Result<LightKind, Flaw> {
    let outer = parameters.float("coneangle", 30.0)?;
    let inner = outer - parameters.float("conedeltaangle", 5.0)?;
    if !(0.0 <= inner && inner <= outer && 0.0 < outer && outer <= 90.0) {
        let rule = "must be angles with 0 <= inner <= outer <= 90, and outer above 0";
        return Err(Flaw::new(parameters.line, format_args!("a cone from {inner} to {outer} degrees"), rule));
    }
    let cos_outer = cos(outer.to_radians()).clamp(0.0, 1.0_f64.next_down());
    let cos_inner = cos(inner.to_radians()).max(cos_outer.next_up());
    Ok(LightKind::Spot { position, direction, cos_inner, cos_outer, falloff: Falloff::InverseSquare })
}

/// The mean radiance of a map of equal areas.
fn mean_of_map(file: &str, files: Files<'_>) -> Result<Rgb, Reason> {
    let bad = |rule: String| Reason::BadReference { reference: file.to_owned(), rule };
    let path = resolve_path(file, files.root_file, files.options)?;
    let bitmap = read_texture(&path, files.options).map_err(|reason| bad(reason.to_string()))?;
    if bitmap.width != bitmap.height {
        let rule = format!("has {} x {} pixels: maps all around must be square", bitmap.width, bitmap.height);
        return Err(bad(rule));
    }
    let sum = bitmap.pixels.iter().fold(Rgb::BLACK, |sum, pixel| sum + Rgb::from(pixel.map(f64::from)));
    Ok((sum / bitmap.pixels.len() as f64).map(|c| c.max(0.0)))
}
