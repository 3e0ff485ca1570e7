//! Colours that may vary over a surface.

use crate::{Texture, TextureId};
use rt_geometry::SurfaceInteraction;
use rt_math::Rgb;

/// A coefficient of a material, constant or textured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ColorTexture {
    /// Constant colour.
    Constant(Rgb),
    /// A texture, multiplied by a colour.
    Textured(TextureId, Rgb),
}

impl ColorTexture {
    /// Zero everywhere: the lobe that it scales is left out.
    pub const ZERO: Self = Self::Constant(Rgb::BLACK);

    /// True if it is zero everywhere.
    pub fn is_zero(&self) -> bool {
        self.factor().is_black()
    }

    /// Constant colour, or the factor of the texture.
    pub const fn factor(&self) -> Rgb {
        match self {
            Self::Constant(rgb) | Self::Textured(_, rgb) => *rgb,
        }
    }

    /// Product with a number.
    #[must_use]
    pub fn scaled(&self, by: f64) -> Self {
        match *self {
            Self::Constant(rgb) => Self::Constant(rgb * by),
            Self::Textured(id, rgb) => Self::Textured(id, rgb * by),
        }
    }

    /// Value at a point of the surface. A texture that is not in the list is black.
    #[inline]
    pub fn at(&self, textures: &[Texture], surface: &SurfaceInteraction) -> Rgb {
        match self {
            Self::Constant(rgb) => *rgb,
            Self::Textured(TextureId(id), rgb) => {
                textures.get(*id as usize).map_or(Rgb::BLACK, |texture| texture.at(&surface.into())) * *rgb
            }
        }
    }
}
