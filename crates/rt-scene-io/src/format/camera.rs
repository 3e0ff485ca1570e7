//! Cameras in the file.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Step;

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
    /// Name of the transparent material that the camera stands inside of. Without it, that is seen from the closed bodies
    /// around it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub medium: Option<String>,
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
