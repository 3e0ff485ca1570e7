//! Materials in the file.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Coefficient, Color};

/// A surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[allow(clippy::large_enum_variant, reason = "a file has few materials")]
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
        /// Which sides shine, if it has `emission`; both by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        shines: Option<Sides>,
    },
    /// A diffuse surface.
    Diffuse {
        /// Part of the light that is reflected; `gray(0.5)` by default.
        #[serde(default = "half", alias = "color", alias = "colour")]
        albedo: Coefficient,
        /// 0 for paper, 1 for dust (Oren, Nayar 1994).
        #[serde(default, skip_serializing_if = "is_zero")]
        roughness: f64,
        /// Radiance of its own; none by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        emission: Option<Coefficient>,
    },
    /// A diffuse surface under a highlight of Phong's shape, energy-normalised.
    Glossy {
        /// Part of the light that is reflected diffusely; none by default.
        #[serde(default = "black")]
        diffuse: Coefficient,
        /// Part of the light along the normal that the highlight reflects.
        #[serde(default = "half")]
        specular: Coefficient,
        /// Exponent of the highlight, from 0 to 10⁷.
        #[serde(default = "exponent")]
        exponent: f64,
    },
    /// A perfect mirror.
    Mirror {
        /// Part of the light that is reflected; all of it by default.
        #[serde(default = "white", alias = "color", alias = "colour")]
        reflectance: Coefficient,
    },
    /// A body of glass, water or anything clear.
    Glass {
        /// Index of refraction of the inside, where that of air is 1.
        #[serde(default = "crown_glass")]
        ior: f64,
        /// Roughness of the surface, from 0 to 1.
        #[serde(default, skip_serializing_if = "is_zero")]
        roughness: f64,
        /// What is left of light that passes through the surface; all of it by default.
        #[serde(default = "white")]
        transmittance: Coefficient,
        /// Absorption inside per unit of way: light falls by exp(−absorption · length).
        #[serde(default, skip_serializing_if = "Option::is_none")]
        absorption: Option<Color>,
        /// As for `phong`.
        #[serde(default)]
        priority: i32,
    },
    /// Metal.
    Metal {
        /// A metal with measured constants.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        metal: Option<Metal>,
        /// Real part of the index of refraction, instead of `metal`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        n: Option<Color>,
        /// Imaginary part of the index of refraction.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        k: Option<Color>,
        /// Roughness of the surface, from 0 to 1.
        #[serde(default, skip_serializing_if = "is_zero")]
        roughness: f64,
    },
    /// The material of glTF.
    MetallicRoughness {
        /// Colour of the diffuse part, or of the metal; white by default.
        #[serde(default = "white", alias = "color", alias = "colour")]
        base_color: Coefficient,
        /// 0 for plastic, 1 for metal.
        #[serde(default = "one")]
        metallic: f64,
        /// Roughness of the surface, from 0 to 1.
        #[serde(default = "one")]
        roughness: f64,
        /// Radiance of its own; none by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        emission: Option<Coefficient>,
    },
    /// A pane of glass without thickness.
    ThinGlass {
        /// Index of refraction.
        #[serde(default = "crown_glass")]
        ior: f64,
        /// What is left of light that crosses it once along the normal; all of it by default.
        #[serde(default = "white")]
        transmittance: Coefficient,
    },
    /// A lamp: it shines and reflects nothing.
    Light {
        /// Radiance.
        #[serde(default = "white", alias = "color", alias = "colour", alias = "emission")]
        radiance: Coefficient,
        /// Which sides shine.
        #[serde(default)]
        shines: Sides,
    },
    /// Several materials at once, each with its weight. Weights of sum 1 blend them; weights of 1 lay them over each other. Glass
    /// cannot be part of it.
    Mix(Vec<(f64, Self)>),
}

impl Material {
    /// The coefficients that are given, other than those of the parts of a mix.
    pub(crate) fn coefficients_mut(&mut self) -> Vec<&mut Coefficient> {
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

/// Which sides of a surface shine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Sides {
    /// The outside; of flat shapes, the side that they face.
    #[default]
    Front,
    /// Both.
    Both,
}

/// A metal whose index of refraction was measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
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

fn half() -> Coefficient {
    Coefficient::Gray(0.5)
}

fn black() -> Coefficient {
    Coefficient::Gray(0.0)
}

fn white() -> Coefficient {
    Coefficient::Gray(1.0)
}

fn exponent() -> f64 {
    32.0
}

fn crown_glass() -> f64 {
    1.5
}

fn one() -> f64 {
    1.0
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "the signature is serde's")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
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
