//! Camera and image.
//!
//! The format's cameras look along +z with +y up and +x to the right; here they look along −z. The difference is a mirror, and the
//! world is mirrored with it: so turns right stay right, and text can be read.

use rt_camera::{CameraSettings, FovAxis, Projection};
use rt_math::{DMat3, DVec3, Transform};

use super::parameters::{Parameters, unknown};
use crate::NamedCamera;
use crate::error::LineError;
use crate::text;

#[derive(Clone, Copy, Debug)]
pub(super) struct PbrtCamera {
    camera_from_world: Transform,
    lens: CameraModel,
}

#[derive(Clone, Copy, Debug)]
enum CameraModel {
    /// Degrees along the shorter side of the image.
    Perspective(f64),
    Orthographic,
}

impl PbrtCamera {
    /// Reads a `Camera` of this kind; `None` for one that only other programs have.
    pub(super) fn read(
        kind: &str,
        parameters: &Parameters,
        camera_from_world: Transform,
    ) -> Result<Option<Self>, LineError> {
        let lens = match kind {
            "perspective" => {
                let degrees = parameters.float("fov", 90.0)?;
                if !(degrees > 0.0 && degrees < 180.0) {
                    let rule = "degrees: the field of view must lie between 0 and 180";
                    return Err(LineError::new(parameters.line, degrees, rule));
                }
                CameraModel::Perspective(degrees)
            }
            "orthographic" => CameraModel::Orthographic,
            "realistic" | "spherical" => return Ok(None),
            other => {
                let known = ["perspective", "orthographic", "realistic", "spherical"];
                return Err(unknown("camera", other, parameters.line, known));
            }
        };
        Ok(Some(Self { camera_from_world, lens }))
    }

    /// Map from the world of the file to that of the scene: mirrored, unless the file's camera is a mirror itself.
    pub(super) fn ours_from_world(view: Option<&Self>) -> Transform {
        if view.is_some_and(|view| view.camera_from_world.flips_handedness()) { Transform::IDENTITY } else { mirror() }
    }

    /// The camera of an image of this size in pixels.
    pub(super) fn camera(&self, [width, height]: [u32; 2]) -> NamedCamera {
        let (width, height) = (f64::from(width), f64::from(height));
        let projection = match self.lens {
            CameraModel::Perspective(degrees) => {
                let axis = if width < height { FovAxis::Horizontal } else { FovAxis::Vertical };
                Projection::Perspective { fov: degrees.to_radians(), axis }
            }
            // The shorter side shows what lies between −1 and 1.
            CameraModel::Orthographic => Projection::Orthographic { height: 2.0 * (height / width).max(1.0) },
        };
        let world_from_camera = self.camera_from_world.inverse().compose(&mirror());
        let ours = Self::ours_from_world(Some(self)).compose(&world_from_camera);
        NamedCamera { name: "camera".to_owned(), settings: CameraSettings::new(ours, projection), medium: None }
    }
}

/// z to −z.
fn mirror() -> Transform {
    let turned = Transform::from_linear(DMat3::from_diagonal(DVec3::new(1.0, 1.0, -1.0)), DVec3::ZERO);
    turned.unwrap_or(Transform::IDENTITY)
}

/// Matrix of `LookAt`.
pub(super) fn look_at(line: usize, [ex, ey, ez, tx, ty, tz, ux, uy, uz]: [f64; 9]) -> Result<Transform, LineError> {
    let (eye, target, up) = (DVec3::new(ex, ey, ez), DVec3::new(tx, ty, tz), DVec3::new(ux, uy, uz));
    // Ours looks along −z with +x to the right in a right-handed world: a half turn around y gives the axes of the file.
    let turn = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, -1.0));
    let placed = Transform::look_at(eye, target, up)
        .and_then(|ours| Ok(ours.compose(&Transform::from_linear(turn, DVec3::ZERO)?)));
    placed.map(|world_from_camera| world_from_camera.inverse()).map_err(|_| {
        let rule = "has no direction: eye and target must differ, and `up` must not be 0 or along the view";
        LineError::new(line, format_args!("the view from {eye} to {target} with {up} up"), rule)
    })
}

/// Reads the size of the image from a `Film`.
pub(super) fn film(parameters: &Parameters) -> Result<[u32; 2], LineError> {
    let (width, height) = (parameters.float("xresolution", 1280.0)?, parameters.float("yresolution", 720.0)?);
    text::resolution(parameters.line, width, height)
}
