//! Surface properties.

use crate::TextureId;
use rt_math::Rgb;

/// A coefficient that may vary over the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coefficient {
    /// The same everywhere.
    Constant(Rgb),
    /// A texture, multiplied by a colour.
    Textured(TextureId, Rgb),
}

impl Coefficient {
    /// Zero everywhere: what it scales is left out.
    pub const ZERO: Self = Self::Constant(Rgb::BLACK);

    /// True if it is zero everywhere.
    pub fn is_zero(&self) -> bool {
        matches!(self, Self::Constant(rgb) | Self::Textured(_, rgb) if rgb.is_black())
    }
}

/// The shape of the highlight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Highlight {
    /// cosⁿ of the angle between the light and the mirrored view (Phong 1975).
    Phong,
    /// cosⁿ of the angle between the normal and the half vector (Blinn 1977).
    Blinn,
}

/// Light through the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transmission {
    /// How much of the refracted light passes.
    pub coefficient: Coefficient,
    /// Index of refraction of the inside relative to the outside, positive.
    pub ior: f64,
    /// Whether Fresnel's equations share the light between `mirror` and this coefficient. Otherwise both are constant
    /// and totally reflected light is dropped, as in Whitted's model.
    pub fresnel: bool,
    /// Absorption per world unit of way through the inside (Beer's law): light falls by exp(−absorption · length).
    pub absorption: Rgb,
}

/// The classical surface of Phong and Whitted.
///
/// Under `whitted`, radiance = emission + ambient · ambient light + Σ lights (diffuse · cos θ + specular · highlight)
/// · intensity + mirror · reflected + transmission · refracted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phong {
    /// Share of the ambient light.
    pub ambient: Coefficient,
    /// Diffuse coefficient.
    pub diffuse: Coefficient,
    /// Strength of the highlight.
    pub specular: Coefficient,
    /// Exponent of the highlight, at least 0.
    pub exponent: f64,
    /// Shape of the highlight.
    pub highlight: Highlight,
    /// Light of its own.
    pub emission: Coefficient,
    /// Share of mirrored light.
    pub mirror: Coefficient,
    /// Light through the surface, if any.
    pub transmission: Option<Transmission>,
}

impl Default for Phong {
    /// A grey diffuse surface with a little ambient light.
    fn default() -> Self {
        Self {
            ambient: Coefficient::Constant(Rgb::gray(0.07)),
            diffuse: Coefficient::Constant(Rgb::gray(0.7)),
            specular: Coefficient::ZERO,
            exponent: 32.0,
            highlight: Highlight::Phong,
            emission: Coefficient::ZERO,
            mirror: Coefficient::ZERO,
            transmission: None,
        }
    }
}

/// A named surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// For messages and `explain`.
    pub name: String,
    /// The surface.
    pub phong: Phong,
}
