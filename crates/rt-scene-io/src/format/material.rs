//! Materials in the file.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Coefficient, Color};

/// A surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Material {
    /// The classical surface of Phong and Whitted. Coefficients that are left out keep their defaults.
    Phong {
        /// Colour of the surface: a factor for `ambient` and `diffuse`. White by default.
        #[serde(default, skip_serializing_if = "Option::is_none", alias = "colour")]
        color: Option<Coefficient>,
        /// Share of the ambient light; `gray(0.07)` by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        ambient: Option<Coefficient>,
        /// Diffuse coefficient; `gray(0.7)` by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        diffuse: Option<Coefficient>,
        /// Strength of the highlight; none by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        specular: Option<Coefficient>,
        /// Exponent of the highlight, from 0 to 10⁷; 32 by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        exponent: Option<f64>,
        /// Shape of the highlight.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        highlight: Option<Highlight>,
        /// Light of its own; none by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        emission: Option<Coefficient>,
        /// Share of mirrored light; none by default, all of it with `fresnel`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        mirror: Option<Coefficient>,
        /// Share of light that passes through the surface, refracted; none by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        transmission: Option<Coefficient>,
        /// Index of refraction of the inside, where that of air is 1; 1.5 by default. Used with `transmission`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        ior: Option<f64>,
        /// Share the light between `mirror` and `transmission` by Fresnel's equations; by default both are constant, as in
        /// Whitted's model.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        fresnel: Option<bool>,
        /// Absorption inside per unit of way: light falls by exp(−absorption · length). None by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        absorption: Option<Color>,
        /// Where transparent bodies overlap, the one of the greatest number is there, among equals the one that light
        /// entered last; 0 by default. Bodies that touch, such as a glass and the water in it, must overlap. Used with
        /// `transmission`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        priority: Option<i32>,
    },
}

/// Shape of the highlight.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Highlight {
    /// About the mirrored direction (Phong 1975; the default).
    Phong,
    /// About the half vector (Blinn 1977).
    Blinn,
}
