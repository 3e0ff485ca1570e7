//! What changes over time in the file.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Step;

/// What happens between two keys. Before the first key, that one holds, and after the last, the last.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Interpolation {
    /// The earlier key holds.
    Step,
    /// Straight ways and turns by the shortest arc, each at constant speed.
    #[default]
    Linear,
    /// Curves through the keys, without kinks, that start and end at rest.
    Smooth,
}

/// How a node moves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NodeAnimation {
    /// What happens between two keys.
    #[serde(default, skip_serializing_if = "is_linear")]
    pub interpolation: Interpolation,
    /// Where it is at some moments: at least one, the earliest first.
    pub keys: Vec<NodeKey>,
}

/// Where a node is at a moment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NodeKey {
    /// The moment in seconds.
    pub time: f64,
    /// Steps that follow those of the node's own `transform`. From one key to the next it turns by at most half a turn.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub transform: Vec<Step>,
}

/// How a camera moves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CameraAnimation {
    /// What happens between two keys.
    #[serde(default, skip_serializing_if = "is_linear")]
    pub interpolation: Interpolation,
    /// Where it is at some moments, and how much it sees: at least one, the earliest first. Keys place it by `look_from`,
    /// `look_at` and `up`, or by `transform`, but not some by these and some by that.
    pub keys: Vec<CameraKey>,
}

/// Where a camera is at a moment. What is left out of it is as the camera itself says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CameraKey {
    /// The moment in seconds.
    pub time: f64,
    /// Where the camera stands.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub look_from: Option<[f64; 3]>,
    /// The point that it looks at.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub look_at: Option<[f64; 3]>,
    /// The direction that is up in the image.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub up: Option<[f64; 3]>,
    /// Instead of these: steps that take the camera on from where it stands by itself. `[rotate_y(90)]` takes it around the y
    /// axis by a quarter. From one key to the next it turns by at most half a turn.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub transform: Vec<Step>,
    /// Full opening angle in degrees, above 0 and below 180.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fov: Option<f64>,
}

impl CameraAnimation {
    /// True if it says where the camera is.
    pub(crate) fn places(&self) -> bool {
        self.keys.iter().any(|key| key.looks() || !key.transform.is_empty())
    }
}

impl CameraKey {
    /// True if it says where the camera looks from, at, or which way is up.
    pub(crate) const fn looks(&self) -> bool {
        self.look_from.is_some() || self.look_at.is_some() || self.up.is_some()
    }
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "the signature is serde's")]
fn is_linear(interpolation: &Interpolation) -> bool {
    *interpolation == Interpolation::Linear
}
