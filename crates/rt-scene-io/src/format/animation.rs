//! Animations in the file.

use serde::{Deserialize, Serialize};

use super::Step;

/// Interpolation between two keys. The first key holds before its time, the last key after its time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Interpolation {
    /// The earlier key holds.
    Step,
    /// Straight paths and rotations by the shortest arc, each at constant speed.
    #[default]
    Linear,
    /// Curves through the keys, without kinks, that start and end at rest.
    Smooth,
}

/// Motion of a node by keys.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct NodeAnimation {
    /// Interpolation between two keys.
    ///
    /// Default: `linear`.
    #[serde(default, skip_serializing_if = "is_linear")]
    pub interpolation: Interpolation,
    /// Keys in the order of their times: at least one.
    ///
    /// Example: `keys: [(time: 0), (time: 1, transform: [translate(0, 2, 0)])]`.
    pub keys: Vec<NodeKey>,
}

/// Transform of a node at a time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct NodeKey {
    /// Time of the key.
    ///
    /// Unit: seconds. Example: `time: 2.5`.
    pub time: f64,
    /// Steps that follow those of the node's own `transform`. From one key to the next it turns by at most half a turn.
    ///
    /// Example: `transform: [translate(0, 2, 0)]`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub transform: Vec<Step>,
}

/// Motion of a camera by keys.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct CameraAnimation {
    /// Interpolation between two keys.
    ///
    /// Default: `linear`.
    #[serde(default, skip_serializing_if = "is_linear")]
    pub interpolation: Interpolation,
    /// Keys in the order of their times: at least one. All of them place the camera by `look_from`, `look_at` and `up`, or all
    /// by `transform`.
    ///
    /// Example: `keys: [(time: 0), (time: 4, transform: [rotate_y(90)])]`.
    pub keys: Vec<CameraKey>,
}

/// Place of a camera at a time. Fields that are left out are those of the camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct CameraKey {
    /// Time of the key.
    ///
    /// Unit: seconds. Example: `time: 2.5`.
    pub time: f64,
    /// Position of the camera.
    ///
    /// Unit: units of the scene. Default: that of the camera.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub look_from: Option<[f64; 3]>,
    /// Target point of the view.
    ///
    /// Unit: units of the scene. Default: that of the camera.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub look_at: Option<[f64; 3]>,
    /// The direction that is up in the image.
    ///
    /// Unit: none. Default: that of the camera.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub up: Option<[f64; 3]>,
    /// Instead of these: steps that follow the camera's own place. `[rotate_y(90)]` takes it around the y axis by a quarter.
    /// From one key to the next it turns by at most half a turn.
    ///
    /// Example: `transform: [rotate_y(90)]`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub transform: Vec<Step>,
    /// Full opening angle, above 0 and below 180.
    ///
    /// Unit: degrees. Default: that of the camera. Example: `fov: 25`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fov: Option<f64>,
}

impl CameraAnimation {
    /// True if the keys place the camera.
    pub(crate) fn places(&self) -> bool {
        self.keys.iter().any(|key| key.looks() || !key.transform.is_empty())
    }
}

impl CameraKey {
    /// True if the key has `look_from`, `look_at` or `up`.
    pub(crate) const fn looks(&self) -> bool {
        self.look_from.is_some() || self.look_at.is_some() || self.up.is_some()
    }
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "the signature is serde's")]
fn is_linear(interpolation: &Interpolation) -> bool {
    *interpolation == Interpolation::Linear
}
