//! Cameras in the file.

use serde::{Deserialize, Serialize};

use super::default_values::is_zero;
use super::{CameraAnimation, Step};

/// A camera. `look_from` or `transform` places it; without both it shows the whole scene. Then `fov`, `lens_shift` and
/// `orthographic` are kept: a note says if the height of `orthographic` is too small for the scene. With a `fov` close to 180,
/// the scene is small in the image.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Camera {
    /// Name to choose it by.
    ///
    /// Default: none. Example: `name: "side"`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Position of the camera.
    ///
    /// Unit: units of the scene. Default: a position that shows the whole scene. Example: `look_from: (0, 1, 5)`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub look_from: Option<[f64; 3]>,
    /// Target point of the view. Needs `look_from`.
    ///
    /// Unit: units of the scene. Default: `(0, 0, 0)`. Example: `look_at: (0, 0.5, 0)`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub look_at: Option<[f64; 3]>,
    /// The direction that is up in the image. Needs `look_from`.
    ///
    /// Unit: none. Default: `(0, 1, 0)`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub up: Option<[f64; 3]>,
    /// Instead of `look_from`: transform of a camera at the origin that looks along −z, as steps. An empty list is as none.
    ///
    /// Example: `transform: [translate(0, 1, 5)]`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub transform: Vec<Step>,
    /// Transform of the camera at time 1, as steps like those of `transform`. `look_from` or `transform` applies at
    /// time 0.
    ///
    /// Example: `motion: [translate(0.5, 1, 5)]`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub motion: Vec<Step>,
    /// Instead of `motion`: transforms of the camera at times of an animation.
    ///
    /// Default: at rest. Example: `animation: (keys: [(time: 0), (time: 4, transform: [rotate_y(90)])])`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub animation: Option<CameraAnimation>,
    /// Times at which the shutter opens and closes, from 0 to 1. Objects that move between them are blurred. For animations, 0
    /// is the time of the frame and 1 that of the next frame. `(0, 0.5)` blurs half of the way between two frames. Without
    /// `shutter`, motions are blurred over all of their time, and animations are sharp.
    ///
    /// Unit: fractions of a frame. Default: `(0, 1)` for motions, `(0, 0)` for animations. Example: `shutter: (0, 0.5)`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shutter: Option<(f64, f64)>,
    /// Full opening angle, above 0 and below 180.
    ///
    /// Unit: degrees. Default: `40`. Example: `fov: 35`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fov: Option<f64>,
    /// The side of the image that `fov` spans.
    ///
    /// Default: `vertical`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fov_axis: Option<FovAxis>,
    /// Instead of `fov`: parallel projection that shows this height of the world.
    ///
    /// Unit: units of the scene. Default: perspective. Example: `orthographic: 4`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub orthographic: Option<f64>,
    /// Shift of the image as a part of its width and height: (0.5, 0) moves the view by half an image to the right.
    ///
    /// Unit: width and height of the image. Default: `(0, 0)`. Example: `lens_shift: (0.5, 0)`.
    #[serde(skip_serializing_if = "is_centred")]
    pub lens_shift: [f64; 2],
    /// Lens for depth of field. Without it the camera is a pinhole.
    ///
    /// Default: a pinhole. Example: `lens: (radius: 0.05)`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lens: Option<Lens>,
    /// Name of the transparent material around the camera. Without it, the material is found from the closed surfaces around
    /// the camera.
    ///
    /// Default: found from the surfaces around the camera. Example: `medium: "water"`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub medium: Option<String>,
}

impl Camera {
    /// True if the camera has a position: its own, or that of an animation.
    pub fn is_placed(&self) -> bool {
        !self.is_unplaced() || self.animation.as_ref().is_some_and(CameraAnimation::places)
    }

    /// True if no field places the camera itself.
    pub(crate) fn is_unplaced(&self) -> bool {
        let Self { look_from, look_at, up, transform, .. } = self;
        look_from.is_none() && look_at.is_none() && up.is_none() && transform.is_empty()
    }
}

/// A thin lens. Lengths are in units of the camera's space, which are those of the scene unless its transform scales.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Lens {
    /// Radius of the aperture, or of the circle around its corners. 0 is a pinhole.
    ///
    /// Unit: units of the scene. Default: `0`. Example: `radius: 0.05`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius: Option<f64>,
    /// Instead of `radius`: the f-number, `focal_length / (2·radius)`.
    ///
    /// Unit: none. Default: given by `radius`. Example: `f_stop: 2.8`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub f_stop: Option<f64>,
    /// Focal length, for `f_stop`: 0.05 for 50 mm in a scene in metres. It does not change the field of view, which is `fov`.
    ///
    /// Unit: units of the scene. Default: none; needed by `f_stop`. Example: `focal_length: 0.05`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub focal_length: Option<f64>,
    /// Focus distance along the view axis. Without it and `focus_at`, the target of the view is in focus.
    ///
    /// Unit: units of the scene. Default: distance of `look_at`. Example: `focus: 4.5`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub focus: Option<f64>,
    /// Instead of `focus`: a point in the plane of focus.
    ///
    /// Unit: units of the scene. Default: `look_at`. Example: `focus_at: (0, 1, 0)`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub focus_at: Option<[f64; 3]>,
    /// Number of corners of the aperture, at least 3. Omit it for a round aperture.
    ///
    /// Unit: corners. Default: round. Example: `blades: 6`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub blades: Option<u32>,
    /// Rotation of the aperture, counter-clockwise seen from behind the camera. At 0 its first corner points up.
    ///
    /// Unit: degrees. Default: `0`. Example: `rotate: 15`.
    #[serde(skip_serializing_if = "is_zero")]
    pub rotate: f64,
}

/// A side of the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum FovAxis {
    /// The height of the image (the default).
    Vertical,
    /// The width of the image.
    Horizontal,
}

fn is_centred(shift: &[f64; 2]) -> bool {
    *shift == [0.0; 2]
}
