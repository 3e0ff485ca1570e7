//! Lights and background.

use std::sync::Arc;

use rt_math::{DVec3, Rgb, transcendental::cos};
use rt_shading::{Background, DeltaLight, DeltaLightKind};

use super::texture::Textures;
use super::value::{colour, coordinate, direction, not_negative, vector};
use crate::diagnostics::Diagnostics;
use crate::format;
use crate::{LoadErrorKind, read_environment};

/// Widest cone of a spot light: half a sphere.
const MAX_CONE_DEGREES: f64 = 90.0;

/// The delta lights, and the sum of the ambient lights.
pub(super) fn lights(report: &mut Diagnostics, lights: &[format::Light]) -> (Vec<DeltaLight>, Rgb) {
    let mut placed = Vec::new();
    let mut ambient = Rgb::BLACK;
    for (i, light) in lights.iter().enumerate() {
        let path = format!("lights[{i}]");
        if let format::Light::Ambient(color) = light {
            ambient += report.check(&path, colour(color)).unwrap_or_default();
        } else {
            placed.extend(single(report, &path, light));
        }
    }
    (placed, ambient)
}

fn single(report: &mut Diagnostics, path: &str, light: &format::Light) -> Option<DeltaLight> {
    let (name, intensity, units, casts_shadows) = match light {
        format::Light::Point { name, intensity, units, casts_shadows, .. }
        | format::Light::Directional { name, intensity, units, casts_shadows, .. }
        | format::Light::Spot { name, intensity, units, casts_shadows, .. } => {
            (name, intensity, *units, *casts_shadows)
        }
        _ => return None,
    };
    let intensity = report.check(format_args!("{path}.intensity"), colour(intensity));
    let kind = match light {
        format::Light::Point { position, falloff, shadow_near, .. } => {
            let shadow_near = report.check(format_args!("{path}.shadow_near"), not_negative(*shadow_near));
            let position = report.check(format_args!("{path}.position"), vector(*position))?;
            DeltaLightKind::Point { position, falloff: (*falloff).into(), shadow_near: shadow_near? }
        }
        format::Light::Directional { direction: travel, .. } => {
            DeltaLightKind::Directional { direction: aim(report, path, *travel)? }
        }
        format::Light::Spot { position, direction: axis, inner, outer, falloff, .. } => {
            let cone = report.check(format_args!("{path}.outer"), cone(*inner, *outer));
            let position = report.check(format_args!("{path}.position"), vector(*position));
            let direction = aim(report, path, *axis)?;
            let (cos_inner, cos_outer) = cone?;
            DeltaLightKind::Spot { position: position?, direction, cos_inner, cos_outer, falloff: (*falloff).into() }
        }
        _ => return None,
    };
    Some(DeltaLight { name: name.clone(), kind, intensity: intensity?, units: units.into(), casts_shadows })
}

fn aim(report: &mut Diagnostics, path: &str, value: [f64; 3]) -> Option<DVec3> {
    report.check(format_args!("{path}.direction"), direction(value))
}

/// Cosines of the two angles of a cone. Where both are the same the edge is as sharp as can be.
fn cone(inner: f64, outer: f64) -> Result<(f64, f64), LoadErrorKind> {
    if 0.0 <= inner && inner <= outer && 0.0 < outer && outer <= MAX_CONE_DEGREES {
        let cos_outer = cos(outer.to_radians()).min(1.0_f64.next_down());
        return Ok((cos(inner.to_radians()).max(cos_outer.next_up()), cos_outer));
    }
    Err(LoadErrorKind::invalid(
        format_args!("inner {inner} and outer {outer}"),
        "must be angles with 0 <= inner <= outer <= 90, and outer above 0",
    ))
}

/// The background; black if none is given.
pub(super) fn background(
    report: &mut Diagnostics,
    background: Option<&format::Background>,
    textures: &mut Textures<'_>,
) -> Background {
    if let Some(format::Background::Image { file, scale, rotate }) = background {
        let light = colour(scale).and_then(|scale| {
            let light =
                read_environment(&textures.path(file)?, scale, coordinate(*rotate)?.to_radians(), textures.options);
            light.map_err(|reason| LoadErrorKind::bad_reference(file, reason))
        });
        let black = Background::Constant(Rgb::BLACK);
        return report.check("background", light).map_or(black, |light| Background::Environment(Arc::new(light)));
    }
    let mut at = |place: &str, value| report.check(place, colour(value)).unwrap_or_default();
    match background {
        None | Some(format::Background::Image { .. }) => Background::Constant(Rgb::BLACK),
        Some(format::Background::Constant(value)) => Background::Constant(at("background", value)),
        Some(format::Background::Gradient { bottom, top }) => {
            Background::Gradient { bottom: at("background.bottom", bottom), top: at("background.top", top) }
        }
    }
}
