//! Lights and background in the file.

use serde::{Deserialize, Serialize};

use super::color::white;
use super::default_values::{is_yes, is_zero, yes};
use super::{Color, EmissionSides};

/// A light. Without `falloff: inverse_square` its strength is the same at any distance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Light {
    /// Emits from a point in all directions.
    Point {
        /// Name for messages.
        ///
        /// Example: `name: "lantern"`.
        #[serde(default, skip_serializing_if = "String::is_empty")]
        name: String,
        /// Position of the light.
        ///
        /// Unit: units of the scene. Example: `position: (-3, 5, 4)`.
        position: [f64; 3],
        /// Strength; with inverse-square falloff, at distance 1.
        ///
        /// Unit: radiance of a white diffuse surface that faces the light; with `units: physical`, W/sr or cd. Example: `intensity: (30, 28, 25)`.
        #[serde(default = "white", alias = "color", alias = "colour")]
        intensity: Color,
        /// Meaning of `intensity`.
        ///
        /// Default: `classical`. Example: `units: physical`.
        #[serde(default, skip_serializing_if = "is_classical")]
        units: LightUnits,
        /// Falloff with the distance.
        #[serde(default)]
        falloff: Falloff,
        /// Distance from the light up to which surfaces cast no shadow, such as the bulb around it.
        ///
        /// Unit: units of the scene. Default: `0`. Example: `shadow_near: 0.1`.
        #[serde(default, skip_serializing_if = "is_zero", alias = "lamp_radius")]
        shadow_near: f64,
        /// True if objects cast shadows in its light.
        ///
        /// Default: `true`. Example: `casts_shadows: false`.
        #[serde(default = "yes", skip_serializing_if = "is_yes")]
        casts_shadows: bool,
    },
    /// Emits in one direction from infinitely far away, like the sun.
    Directional {
        /// Name for messages.
        ///
        /// Example: `name: "sun"`.
        #[serde(default, skip_serializing_if = "String::is_empty")]
        name: String,
        /// The direction in which the light travels; any length but 0.
        ///
        /// Unit: none. Example: `direction: (-1, -2, -1)`.
        direction: [f64; 3],
        /// Strength.
        ///
        /// Unit: radiance of a white diffuse surface that faces the light; with `units: physical`, W/m² or lx. Example: `intensity: (3, 2.8, 2.5)`.
        #[serde(default = "white", alias = "color", alias = "colour")]
        intensity: Color,
        /// Meaning of `intensity`.
        ///
        /// Default: `classical`. Example: `units: physical`.
        #[serde(default, skip_serializing_if = "is_classical")]
        units: LightUnits,
        /// True if objects cast shadows in its light.
        ///
        /// Default: `true`. Example: `casts_shadows: false`.
        #[serde(default = "yes", skip_serializing_if = "is_yes")]
        casts_shadows: bool,
    },
    /// Emits from a point into a cone.
    Spot {
        /// Name for messages.
        ///
        /// Example: `name: "spotlight"`.
        #[serde(default, skip_serializing_if = "String::is_empty")]
        name: String,
        /// Position of the light.
        ///
        /// Unit: units of the scene. Example: `position: (0, 4, 0)`.
        position: [f64; 3],
        /// Axis of the cone; any length but 0.
        ///
        /// Unit: none. Example: `direction: (0, -1, 0)`.
        direction: [f64; 3],
        /// Angle in degrees from the axis up to which it has full strength.
        ///
        /// Unit: degrees.
        #[serde(default = "inner")]
        inner: f64,
        /// Angle from the axis beyond which there is no light; at least `inner`, at most 90.
        ///
        /// Unit: degrees.
        #[serde(default = "outer")]
        outer: f64,
        /// Strength; with inverse-square falloff, at distance 1.
        ///
        /// Unit: radiance of a white diffuse surface that faces the light; with `units: physical`, W/sr or cd. Example: `intensity: (30, 28, 25)`.
        #[serde(default = "white", alias = "color", alias = "colour")]
        intensity: Color,
        /// Meaning of `intensity`.
        ///
        /// Default: `classical`. Example: `units: physical`.
        #[serde(default, skip_serializing_if = "is_classical")]
        units: LightUnits,
        /// Falloff with the distance.
        #[serde(default)]
        falloff: Falloff,
        /// True if objects cast shadows in its light.
        ///
        /// Default: `true`. Example: `casts_shadows: false`.
        #[serde(default = "yes", skip_serializing_if = "is_yes")]
        casts_shadows: bool,
    },
    /// An area light: a rectangle or parallelogram.
    Quad {
        /// Name for messages.
        ///
        /// Example: `name: "ceiling"`.
        #[serde(default, skip_serializing_if = "String::is_empty")]
        name: String,
        /// A corner.
        ///
        /// Unit: units of the scene. Example: `corner: (-1, 3, -1)`.
        corner: [f64; 3],
        /// The two edges from there. The front is the side from which the second edge follows the first counter-clockwise.
        ///
        /// Unit: units of the scene. Example: `edges: ((2, 0, 0), (0, 0, 2))`.
        edges: ([f64; 3], [f64; 3]),
        /// Radiance.
        ///
        /// Unit: radiance.
        #[serde(default = "white", alias = "color", alias = "colour")]
        radiance: Color,
        /// Sides that emit.
        #[serde(default, alias = "shines")]
        emission_sides: EmissionSides,
    },
    /// An area light: a disk.
    Disk {
        /// Name for messages.
        ///
        /// Example: `name: "disk light"`.
        #[serde(default, skip_serializing_if = "String::is_empty")]
        name: String,
        /// Its centre.
        ///
        /// Unit: units of the scene. Example: `center: (0, 3, 0)`.
        #[serde(alias = "centre")]
        center: [f64; 3],
        /// The direction that it faces; any length but 0.
        ///
        /// Unit: none. Example: `normal: (0, -1, 0)`.
        normal: [f64; 3],
        /// Its radius.
        ///
        /// Unit: units of the scene.
        radius: f64,
        /// Radiance.
        ///
        /// Unit: radiance.
        #[serde(default = "white", alias = "color", alias = "colour")]
        radiance: Color,
        /// Sides that emit.
        #[serde(default, alias = "shines")]
        emission_sides: EmissionSides,
    },
    /// An area light: a sphere.
    Sphere {
        /// Name for messages.
        ///
        /// Example: `name: "bulb"`.
        #[serde(default, skip_serializing_if = "String::is_empty")]
        name: String,
        /// Its centre.
        ///
        /// Unit: units of the scene.
        #[serde(alias = "centre")]
        center: [f64; 3],
        /// Its radius.
        ///
        /// Unit: units of the scene.
        radius: f64,
        /// Radiance.
        ///
        /// Unit: radiance.
        #[serde(default = "white", alias = "color", alias = "colour")]
        radiance: Color,
    },
    /// An area light: a cylinder.
    Cylinder {
        /// Name for messages.
        ///
        /// Example: `name: "neon tube"`.
        #[serde(default, skip_serializing_if = "String::is_empty")]
        name: String,
        /// The middle of one end.
        ///
        /// Unit: units of the scene. Example: `base: (-1, 3, 0)`.
        base: [f64; 3],
        /// The middle of the other end.
        ///
        /// Unit: units of the scene.
        top: [f64; 3],
        /// Its radius.
        ///
        /// Unit: units of the scene.
        radius: f64,
        /// Radiance.
        ///
        /// Unit: radiance.
        #[serde(default = "white", alias = "color", alias = "colour")]
        radiance: Color,
        /// True if its ends are closed, and emit too.
        ///
        /// Default: `true`. Example: `caps: false`.
        #[serde(default = "yes", skip_serializing_if = "is_yes")]
        caps: bool,
    },
    /// Constant light for the `ambient` coefficient of materials, under `whitted` and `distributed`. `distributed` ignores it if
    /// there is an environment image. Other integrators use the background instead. Several add up.
    Ambient(Color),
}

/// Unit of the intensity of a point, directional or spot light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum LightUnits {
    /// Intensity 1 at perpendicular incidence gives a diffuse surface of albedo 1 the radiance 1.
    #[default]
    Classical,
    /// Radiant or luminous intensity; irradiance or illuminance of directional lights. Intensity 1 at perpendicular incidence gives
    /// a diffuse surface of albedo 1 the radiance 1/π.
    /// Area lights, emissive materials and environment images are in the same units.
    Physical,
}

/// Falloff of light with the distance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Falloff {
    /// None, as in classical ray tracing.
    #[default]
    None,
    /// With the square of the distance, as real light does.
    InverseSquare,
}

/// Radiance of rays that leave the scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Background {
    /// Constant radiance in all directions.
    Constant(Color),
    /// From one colour straight down to another straight up.
    Gradient {
        /// Straight down.
        ///
        /// Unit: radiance.
        bottom: Color,
        /// Straight up.
        ///
        /// Unit: radiance.
        top: Color,
    },
    /// An equirectangular image all around, which lights the scene. Its middle is seen along −z, its upper edge is straight up.
    Image {
        /// Path of a PNG, JPEG, HDR or EXR file, relative to the directory of the scene file.
        ///
        /// Example: `file: "sky.hdr"`.
        file: String,
        /// Factor for its radiance.
        ///
        /// Unit: factor. Example: `scale: 0.5`.
        #[serde(default = "white")]
        scale: Color,
        /// Rotates it around the y axis, to the left as seen from inside.
        ///
        /// Unit: degrees. Default: `0`. Example: `rotate: 90`.
        #[serde(default, skip_serializing_if = "is_zero")]
        rotate: f64,
    },
}

fn inner() -> f64 {
    20.0
}

fn outer() -> f64 {
    30.0
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "the signature is serde's")]
fn is_classical(units: &LightUnits) -> bool {
    *units == LightUnits::Classical
}
