//! Cameras in the file.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{CameraAnimation, Step};

/// A camera. It stands where `look_from` or `transform` says; without both it is put where it sees everything.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Camera {
    /// Name to choose it by.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Where the camera stands.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub look_from: Option<[f64; 3]>,
    /// The point that it looks at; the origin by default. Needs `look_from`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub look_at: Option<[f64; 3]>,
    /// The direction that is up in the image; +y by default. Needs `look_from`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub up: Option<[f64; 3]>,
    /// Instead of `look_from`: steps that place a camera which stands at the origin and looks along −z.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub transform: Vec<Step>,
    /// Where the camera is at time 1, as steps like those of `transform`; at time 0 it is where `look_from` or `transform` says.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub motion: Vec<Step>,
    /// Instead of `motion`: where the camera is at moments of an animation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub animation: Option<CameraAnimation>,
    /// When the shutter opens and closes, from 0 to 1. What moves is blurred, unless both are the same. Motions take all of the
    /// time from 0 to 1, which is the default for them. An animation is seen at the moment of a frame, which is 0, and 1 is the
    /// moment of the next frame: `(0, 0.5)` blurs half of the way between two frames, and without `shutter` animations are
    /// sharp.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shutter: Option<(f64, f64)>,
    /// Full opening angle in degrees, above 0 and below 180; 40 by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fov: Option<f64>,
    /// The side of the image that `fov` spans.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fov_axis: Option<FovAxis>,
    /// Instead of `fov`: parallel projection that shows this height of the world.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub orthographic: Option<f64>,
    /// Shift of the image as a part of its width and height: (0.5, 0) shows what lies half an image to the right.
    #[serde(skip_serializing_if = "is_centred")]
    pub lens_shift: [f64; 2],
    /// The lens, for what is out of focus to be blurred; all is sharp without.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lens: Option<Lens>,
    /// Name of the transparent material that the camera stands inside of. Without it, that is seen from the closed bodies
    /// around it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub medium: Option<String>,
}

impl Camera {
    /// True if nothing says where the camera itself stands.
    pub(crate) fn is_unplaced(&self) -> bool {
        let Self { look_from, look_at, up, transform, .. } = self;
        look_from.is_none() && look_at.is_none() && up.is_none() && transform.is_empty()
    }
}

/// A thin lens. Lengths are in units of the camera's space, which are those of the scene unless its transform scales.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Lens {
    /// Radius of the aperture, or of the circle around its corners. 0 is a pinhole.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius: Option<f64>,
    /// Instead of `radius`: the f-number, `focal_length / (2·radius)`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub f_stop: Option<f64>,
    /// Focal length, for `f_stop`: 0.05 for 50 mm in a scene in metres. What the image shows is said by `fov`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub focal_length: Option<f64>,
    /// Depth of the plane in which all is sharp, along the view axis. Without it and `focus_at`, the plane goes through the
    /// point that the camera looks at.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub focus: Option<f64>,
    /// Instead of `focus`: a point of that plane.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub focus_at: Option<[f64; 3]>,
    /// Number of corners of the aperture, at least 3; it is round without.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub blades: Option<u32>,
    /// Degrees by which the aperture is turned counter-clockwise, seen from behind the camera. Its first corner points up
    /// otherwise.
    #[serde(skip_serializing_if = "is_zero")]
    pub rotate: f64,
}

/// A side of the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
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

#[expect(clippy::trivially_copy_pass_by_ref, reason = "the signature is serde's")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}
