//! Cameras.

use std::collections::HashSet;

use rt_camera::{Camera, CameraSettings, FilmSettings, FovAxis, Projection};
use rt_math::DVec2;

use super::animation::posed_camera;
use super::camera_pose::{DEFAULT_FOV_DEGREES, opening};
use super::lens::lens;
use super::shutter::ShutterInterval;
use super::value::{coordinate, positive};
use crate::diagnostics::Diagnostics;
use crate::format;
use crate::{LoadErrorKind, MaterialId, NamedCamera};

/// All cameras, the default one first, validated for this film. `media` are the media around them.
pub(super) fn cameras(
    report: &mut Diagnostics,
    listed: &[(String, format::Camera)],
    film: &FilmSettings,
    media: &[Option<MaterialId>],
    shutter: &ShutterInterval,
) -> Vec<NamedCamera> {
    let mut names = HashSet::new();
    let mut cameras = Vec::new();
    for (index, (path, camera)) in listed.iter().enumerate() {
        let name = camera.name.clone().unwrap_or_else(|| match cameras.len() {
            0 => "camera".to_owned(),
            before => format!("camera {}", before + 1),
        });
        if !names.insert(name.clone()) {
            let duplicate = LoadErrorKind::Duplicate { kind: "camera", name: name.clone() };
            report.check::<()>(format_args!("{path}.name"), Err(duplicate));
        }
        if let Some(settings) = settings(report, path, camera, shutter) {
            report.check(path, Camera::new(&settings, film.width, film.height));
            cameras.push(NamedCamera { name, settings, medium: media.get(index).copied().flatten() });
        }
    }
    cameras
}

fn settings(
    report: &mut Diagnostics,
    path: &str,
    camera: &format::Camera,
    shutter: &ShutterInterval,
) -> Option<CameraSettings> {
    let posed = posed_camera(report, path, camera, shutter);
    let camera = posed.as_ref().map_or(camera, |posed| &posed.camera);
    let projection = match (camera.orthographic, camera.fov) {
        (Some(_), Some(fov)) => {
            report.refuse(format_args!("{path}.fov"), fov, "conflicts with `orthographic`: remove one of them")
        }
        (Some(height), None) => report
            .check(format_args!("{path}.orthographic"), positive(height))
            .map(|height| Projection::Orthographic { height }),
        (None, fov) => {
            let fov = report.check(format_args!("{path}.fov"), opening(fov.unwrap_or(DEFAULT_FOV_DEGREES)));
            let axis = camera.fov_axis.map_or(FovAxis::Vertical, Into::into);
            fov.map(|fov| Projection::Perspective { fov, axis })
        }
    };
    let [x, y] = camera.lens_shift;
    report.check(format_args!("{path}.lens_shift"), coordinate(x).and(coordinate(y)))?;
    let (posed, projection) = (posed.as_ref()?, projection?);
    let lens = match &camera.lens {
        Some(given) => {
            // A camera that is moved on as a whole stays as far away from what it looks at.
            let place = if given.focus_at.is_some() { &posed.world_from_camera } else { &posed.rest };
            Some(lens(report, path, camera, given, place)?)
        }
        None => None,
    };
    let (opens, closes) = camera.shutter.unwrap_or((0.0, 1.0));
    if !(0.0 <= opens && opens <= closes && closes <= 1.0) {
        let rule = "must open and close between 0 and 1, and not close before it opens";
        let value = format_args!("the shutter, open from {opens} to {closes},");
        return report.refuse(format_args!("{path}.shutter"), value, rule);
    }
    Some(CameraSettings {
        moves_to: posed.moves_to,
        shutter: shutter.relative(camera.shutter),
        lens_shift: DVec2::new(x, y),
        lens,
        ..CameraSettings::new(posed.world_from_camera, projection)
    })
}
