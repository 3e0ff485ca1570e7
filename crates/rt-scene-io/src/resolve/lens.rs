//! Lenses.

use rt_camera::Lens;
use rt_math::Transform;

use super::value::{coordinate, not_negative, positive, vector};
use crate::LoadErrorKind;
use crate::diagnostics::Diagnostics;
use crate::format;

/// Lens of a camera with this transform.
pub(super) fn lens(
    report: &mut Diagnostics,
    path: &str,
    camera: &format::Camera,
    lens: &format::Lens,
    world_from_camera: &Transform,
) -> Option<Lens> {
    let path = format!("{path}.lens");
    let radius = radius(report, &path, lens);
    let is_pinhole = lens.radius.is_none() && lens.f_stop.is_none() && lens.focal_length.is_none();
    let focus = match (lens.focus, lens.focus_at) {
        // All distances are in focus.
        (None, None) if is_pinhole => Some(1.0),
        _ => focus(report, &path, camera, lens, world_from_camera),
    };
    let blades = match lens.blades {
        Some(blades @ 0..3) => {
            let rule = "is less than 3: give at least 3 blades, or omit the field for a round aperture";
            report.refuse(format_args!("{path}.blades"), blades, rule)
        }
        blades => Some(blades),
    };
    let rotation = report.check(format_args!("{path}.rotate"), coordinate(lens.rotate));
    Some(Lens { radius: radius?, focus: focus?, blades: blades?, rotation: rotation?.to_radians() })
}

fn radius(report: &mut Diagnostics, path: &str, lens: &format::Lens) -> Option<f64> {
    let (f_stop, focal_length) = match (lens.radius, lens.f_stop, lens.focal_length) {
        (Some(radius), None, None) => return report.check(format_args!("{path}.radius"), not_negative(radius)),
        (None, Some(f_stop), Some(focal_length)) => (f_stop, focal_length),
        (None, None, None) => return Some(0.0),
        _ => {
            let rule = "either as `radius`, or as `f_stop` with `focal_length`";
            return report.refuse(path, "the aperture must be given", rule);
        }
    };
    let f_stop = report.check(format_args!("{path}.f_stop"), positive(f_stop));
    let focal_length = report.check(format_args!("{path}.focal_length"), positive(focal_length));
    report.check(path, coordinate(focal_length? / (2.0 * f_stop?)))
}

fn focus(
    report: &mut Diagnostics,
    path: &str,
    camera: &format::Camera,
    lens: &format::Lens,
    world_from_camera: &Transform,
) -> Option<f64> {
    let (at, point) = match (lens.focus, lens.focus_at) {
        (Some(depth), None) => return report.check(format_args!("{path}.focus"), positive(depth)),
        (None, Some(point)) => (format!("{path}.focus_at"), point),
        (None, None) if camera.look_from.is_some() => (format!("{path}.focus"), camera.look_at.unwrap_or_default()),
        (None, None) => return report.refuse(path, "`focus`", "is needed with `transform`, or `focus_at`"),
        (Some(_), Some(point)) => {
            let [x, y, z] = point;
            let rule = "conflicts with `focus`: remove one of them";
            return report.refuse(format_args!("{path}.focus_at"), format_args!("({x}, {y}, {z})"), rule);
        }
    };
    let depth = -world_from_camera.inverse_point(report.check(&at, vector(point))?).z;
    let [x, y, z] = point;
    let refused = || {
        LoadErrorKind::invalid(format_args!("({x}, {y}, {z})"), "is not in front of the camera: move it, or the camera")
    };
    report.check(at, positive(depth).map_err(|_| refused()))
}
