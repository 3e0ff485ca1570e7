//! Materials in the file.

use serde::{Deserialize, Deserializer, Serialize};

use super::color::gray;
use super::default_values::{is_zero, one};
use super::spelling::{self, Spelled};
use super::{Color, ColorTexture};

/// A surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[allow(clippy::large_enum_variant, reason = "a file has few materials")]
pub enum Material {
    /// Phong's surface, with mirror and transmission as in Whitted's model. Missing coefficients keep their defaults.
    Phong {
        /// Colour of the surface: a factor for `ambient` and `diffuse`.
        ///
        /// Unit: factor. Default: `1`. Example: `color: checker(even: 1, odd: 0.2)`.
        #[serde(default, skip_serializing_if = "Option::is_none", alias = "colour")]
        color: Option<ColorTexture>,
        /// Fraction of the ambient light that is reflected.
        ///
        /// Unit: fraction of the light. Default: `0.07`. Example: `ambient: 0.1`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        ambient: Option<ColorTexture>,
        /// Diffuse coefficient.
        ///
        /// Unit: fraction of the light. Default: `0.7`. Example: `diffuse: "#c03020"`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        diffuse: Option<ColorTexture>,
        /// Strength of the highlight.
        ///
        /// Unit: fraction of the light. Default: `0`. Example: `specular: 0.5`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        specular: Option<ColorTexture>,
        /// Exponent of the highlight, from 0 to 10⁷.
        ///
        /// Unit: none. Default: `32`. Example: `exponent: 80`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        exponent: Option<f64>,
        /// Shape of the highlight.
        ///
        /// Default: `phong`. Example: `highlight: blinn`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        highlight: Option<Highlight>,
        /// Light of its own.
        ///
        /// Unit: radiance. Default: `0`. Example: `emission: (2, 1.5, 1)`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        emission: Option<ColorTexture>,
        /// Fraction of the light that is mirrored.
        ///
        /// Unit: fraction of the light. Default: `0`; `1` with `fresnel` and `transmission`. Example: `mirror: 0.6`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        mirror: Option<ColorTexture>,
        /// Fraction of the light that passes through the surface, refracted.
        ///
        /// Unit: fraction of the light. Default: `0`. Example: `transmission: 1`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        transmission: Option<ColorTexture>,
        /// Index of refraction of the inside, where that of air is 1. Used with `transmission`.
        ///
        /// Unit: none. Default: `1.5`. Example: `ior: 1.33`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        ior: Option<f64>,
        /// Share the light between `mirror` and `transmission` by Fresnel's equations; by default both are constant, as in
        /// Whitted's model. The transmitted share is then lost on total internal reflection.
        ///
        /// Default: `false`. Example: `fresnel: true`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        fresnel: Option<bool>,
        /// Absorption inside per unit of length: light falls by exp(−absorption · length).
        ///
        /// Unit: per unit of length. Default: `0`. Example: `absorption: (0.2, 0.05, 0.1)`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        absorption: Option<Color>,
        /// Rank where dielectrics overlap: the one with the greatest number counts, and among equals the one that light entered
        /// last. Touching dielectrics, such as a glass and the water in it, must overlap. Used with `transmission`.
        ///
        /// Unit: none. Default: `0`. Example: `priority: 1`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        priority: Option<i32>,
        /// Sides that emit, if it has `emission`.
        ///
        /// Default: `both`.
        #[serde(default, skip_serializing_if = "Option::is_none", alias = "shines")]
        emission_sides: Option<EmissionSides>,
    },
    /// A diffuse surface.
    Diffuse {
        /// Part of the light that is reflected.
        ///
        /// Unit: fraction of the light. Example: `albedo: (0.8, 0.1, 0.1)`.
        #[serde(default = "gray::<50>", alias = "color", alias = "colour")]
        albedo: ColorTexture,
        /// 0 for paper, 1 for dust (Oren, Nayar 1994).
        ///
        /// Unit: none. Default: `0`. Example: `roughness: 0.5`.
        #[serde(default, skip_serializing_if = "is_zero")]
        roughness: f64,
        /// Radiance of its own.
        ///
        /// Unit: radiance. Default: `0`. Example: `emission: (2, 1.5, 1)`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        emission: Option<ColorTexture>,
    },
    /// A diffuse surface under a highlight of Phong's shape, energy-normalised.
    Glossy {
        /// Part of the light that is reflected diffusely.
        ///
        /// Unit: fraction of the light.
        #[serde(default = "gray::<0>", alias = "color", alias = "colour")]
        diffuse: ColorTexture,
        /// Part of the light along the normal that the highlight reflects.
        ///
        /// Unit: fraction of the light.
        #[serde(default = "gray::<50>")]
        specular: ColorTexture,
        /// Exponent of the highlight, from 0 to 10⁷.
        ///
        /// Unit: none.
        #[serde(default = "exponent")]
        exponent: f64,
    },
    /// A perfect mirror.
    Mirror {
        /// Part of the light that is reflected.
        ///
        /// Unit: fraction of the light.
        #[serde(default = "gray::<100>", alias = "color", alias = "colour")]
        reflectance: ColorTexture,
    },
    /// A dielectric such as glass or water.
    Glass {
        /// Index of refraction of the inside, where that of air is 1.
        ///
        /// Unit: none.
        #[serde(default = "crown_glass")]
        ior: f64,
        /// Roughness of the surface, from 0 to 1.
        ///
        /// Unit: none. Default: `0`. Example: `roughness: 0.1`.
        #[serde(default, skip_serializing_if = "is_zero")]
        roughness: f64,
        /// Fraction of the light that is left after it passes through the surface.
        ///
        /// Unit: fraction of the light.
        #[serde(default = "gray::<100>", alias = "color", alias = "colour")]
        transmittance: ColorTexture,
        /// Absorption inside per unit of length: light falls by exp(−absorption · length).
        ///
        /// Unit: per unit of length. Default: `0`. Example: `absorption: (0.2, 0.05, 0.1)`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        absorption: Option<Color>,
        /// Rank where dielectrics overlap, as for `phong`.
        ///
        /// Unit: none.
        #[serde(default)]
        priority: i32,
    },
    /// Metal.
    Metal {
        /// A metal with measured constants.
        ///
        /// Default: none; needed unless `n` and `k` are given. Example: `metal: gold`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        metal: Option<Metal>,
        /// Real part of the index of refraction, instead of `metal`.
        ///
        /// Unit: none. Default: that of `metal`. Example: `n: (0.14, 0.38, 1.44)`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        n: Option<Color>,
        /// Imaginary part of the index of refraction.
        ///
        /// Unit: none. Default: that of `metal`. Example: `k: (3.98, 2.38, 1.6)`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        k: Option<Color>,
        /// Roughness of the surface, from 0 to 1.
        ///
        /// Unit: none. Default: `0`. Example: `roughness: 0.2`.
        #[serde(default, skip_serializing_if = "is_zero")]
        roughness: f64,
    },
    /// The material of glTF.
    MetallicRoughness {
        /// Colour of the diffuse part, or of the metal.
        ///
        /// Unit: fraction of the light. Example: `base_color: image(file: "wood.png")`.
        #[serde(default = "gray::<100>", alias = "color", alias = "colour")]
        base_color: ColorTexture,
        /// 0 for plastic, 1 for metal.
        ///
        /// Unit: none.
        #[serde(default = "one")]
        metallic: f64,
        /// Roughness of the surface, from 0 to 1.
        ///
        /// Unit: none.
        #[serde(default = "one")]
        roughness: f64,
        /// Radiance of its own.
        ///
        /// Unit: radiance. Default: `0`. Example: `emission: (2, 1.5, 1)`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        emission: Option<ColorTexture>,
    },
    /// A pane of glass without thickness.
    ThinGlass {
        /// Index of refraction.
        ///
        /// Unit: none.
        #[serde(default = "crown_glass")]
        ior: f64,
        /// Fraction of the light that is left after it crosses the pane once along the normal.
        ///
        /// Unit: fraction of the light.
        #[serde(default = "gray::<100>", alias = "color", alias = "colour")]
        transmittance: ColorTexture,
    },
    /// An emitter without reflection.
    Light {
        /// Radiance.
        ///
        /// Unit: radiance. Example: `radiance: (10, 8, 6)`.
        #[serde(default = "gray::<100>", alias = "color", alias = "colour", alias = "emission")]
        radiance: ColorTexture,
        /// Sides that emit.
        #[serde(default, alias = "shines")]
        emission_sides: EmissionSides,
    },
    /// Weighted sum of materials. Weights of sum 1 blend them; weights of 1 add their reflection. Glass cannot be part
    /// of it. Only one part may emit if one has a textured emission. Parts that emit must do so from the same sides.
    ///
    /// Example: `mix([(0.7, diffuse(albedo: 0.8)), (0.3, mirror())])`.
    Mix(Vec<(f64, Self)>),
}

/// The material of a node.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum NodeMaterial {
    /// Name of one of the scene's `materials`.
    Name(String),
    /// An inline material: `diffuse(albedo: 0.8)`.
    Inline(Box<Material>),
}

impl<'de> Deserialize<'de> for NodeMaterial {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        spelling::read(from)
    }
}

impl Spelled for NodeMaterial {
    fn choice<'de, D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        Box::deserialize(from).map(Self::Inline)
    }

    fn from_text(text: &str) -> Option<Self> {
        Some(Self::Name(text.to_owned()))
    }
}

impl From<String> for NodeMaterial {
    fn from(name: String) -> Self {
        Self::Name(name)
    }
}

impl From<Material> for NodeMaterial {
    fn from(material: Material) -> Self {
        Self::Inline(Box::new(material))
    }
}

impl Material {
    /// The coefficients that are given, other than those of the parts of a mix.
    pub(crate) fn coefficients_mut(&mut self) -> Vec<&mut ColorTexture> {
        match self {
            Self::Phong { color, ambient, diffuse, specular, emission, mirror, transmission, .. } => {
                [color, ambient, diffuse, specular, emission, mirror, transmission].into_iter().flatten().collect()
            }
            Self::Diffuse { albedo, emission, .. } => [albedo].into_iter().chain(emission).collect(),
            Self::Glossy { diffuse, specular, .. } => vec![diffuse, specular],
            Self::Mirror { reflectance } => vec![reflectance],
            Self::Glass { transmittance, .. } | Self::ThinGlass { transmittance, .. } => vec![transmittance],
            Self::MetallicRoughness { base_color, emission, .. } => [base_color].into_iter().chain(emission).collect(),
            Self::Light { radiance, .. } => vec![radiance],
            Self::Metal { .. } | Self::Mix(_) => Vec::new(),
        }
    }
}

/// Sides of a surface that emit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum EmissionSides {
    /// The outside; of flat shapes, the side that they face.
    #[default]
    Front,
    /// Both.
    Both,
}

/// A metal whose index of refraction was measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Metal {
    /// Al.
    #[serde(alias = "aluminum")]
    Aluminium,
    /// Cr.
    Chromium,
    /// Cu.
    Copper,
    /// Au.
    Gold,
    /// Fe.
    Iron,
    /// Ag.
    Silver,
    /// Ti.
    Titanium,
}

fn exponent() -> f64 {
    32.0
}

fn crown_glass() -> f64 {
    1.5
}

/// Shape of the highlight.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Highlight {
    /// About the mirrored direction (Phong 1975; the default).
    Phong,
    /// About the half vector (Blinn 1977).
    Blinn,
}
