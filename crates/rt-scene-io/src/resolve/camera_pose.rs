//! Positions and opening angles of cameras.

use rt_math::{DVec3, Transform, TransformError};

use super::transform::transform;
use super::value::vector;
use crate::LoadErrorKind;
use crate::diagnostics::Diagnostics;
use crate::format;

/// Default field of view, in degrees.
pub(super) const DEFAULT_FOV_DEGREES: f64 = 40.0;

/// The cameras of a file with their paths in the document, the default one first.
pub(super) fn listed(file: &format::SceneFile) -> impl Iterator<Item = (String, &format::Camera)> {
    let first = file.camera.iter().map(|camera| ("camera".to_owned(), camera));
    first.chain(file.cameras.iter().enumerate().map(|(i, camera)| (format!("cameras[{i}]"), camera)))
}

/// An opening angle in radians.
pub(super) fn opening(degrees: f64) -> Result<f64, LoadErrorKind> {
    if degrees > 0.0 && degrees < 180.0 {
        Ok(degrees.to_radians())
    } else {
        Err(LoadErrorKind::invalid(degrees, "degrees: the field of view must lie between 0 and 180"))
    }
}

/// Transform of a camera without animation.
pub(super) fn place(report: &mut Diagnostics, path: &str, camera: &format::Camera) -> Option<Transform> {
    let looks = camera.look_from.is_some() || camera.look_at.is_some() || camera.up.is_some();
    if !camera.transform.is_empty() {
        if looks {
            let rule = "conflicts with `look_from`, `look_at` or `up`: remove one of them";
            return report.refuse(format_args!("{path}.transform"), "the transform", rule);
        }
        return transform(report, path, &camera.transform);
    }
    let Some(look_from) = camera.look_from else {
        let rule = "is needed with `look_at` and `up`; omit all three for a camera that shows the whole scene";
        return report.refuse(path, "`look_from`", rule);
    };
    let eye = report.check(format_args!("{path}.look_from"), vector(look_from));
    let target = report.check(format_args!("{path}.look_at"), vector(camera.look_at.unwrap_or([0.0; 3])));
    let up = report.check(format_args!("{path}.up"), vector(camera.up.unwrap_or([0.0, 1.0, 0.0])));
    report.check(path, look_at(eye?, target?, up?))
}

/// Transform of a camera at `eye` that looks at `target`.
pub(super) fn look_at(eye: DVec3, target: DVec3, up: DVec3) -> Result<Transform, LoadErrorKind> {
    Transform::look_at(eye, target, up).map_err(|error| match error {
        TransformError::DegenerateDirection if eye == target => {
            LoadErrorKind::invalid(format_args!("look_from and look_at are both {eye}:"), "move one of them")
        }
        TransformError::DegenerateDirection => {
            LoadErrorKind::invalid(format_args!("up {up}"), "is zero or parallel to the view: choose another direction")
        }
        other => other.into(),
    })
}
