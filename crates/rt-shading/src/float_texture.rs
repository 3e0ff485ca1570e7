//! Numbers that may vary over a surface.

use crate::{Texture, TextureId};
use rt_geometry::SurfaceInteraction;

/// Channel of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Channel {
    /// Red.
    Red,
    /// Green.
    Green,
    /// Blue.
    Blue,
    /// Alpha.
    Alpha,
}

/// A parameter of a material, constant or textured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FloatTexture {
    /// Constant number.
    Constant(f64),
    /// A channel of a texture, multiplied by a factor.
    Textured {
        /// The texture.
        texture: TextureId,
        /// Its channel.
        channel: Channel,
        /// Factor of the channel.
        factor: f64,
        /// Approximate mean over the texture, times the factor. It replaces the texture where a model has a constant.
        mean: f64,
    },
}

impl FloatTexture {
    /// A channel of a texture of `textures`, multiplied by a factor. Computes the mean.
    pub fn textured(textures: &[Texture], texture: TextureId, channel: Channel, factor: f64) -> Self {
        let bitmap = textures.get(texture.0 as usize).and_then(Texture::bitmap);
        let mean = bitmap.map_or(1.0, |bitmap| match channel {
            Channel::Red => bitmap.approximate_mean().r,
            Channel::Green => bitmap.approximate_mean().g,
            Channel::Blue => bitmap.approximate_mean().b,
            Channel::Alpha => bitmap.approximate_mean_alpha(),
        });
        Self::Textured { texture, channel, factor, mean: factor * mean }
    }

    /// True if it is zero everywhere.
    pub fn is_zero(&self) -> bool {
        matches!(self, Self::Constant(factor) | Self::Textured { factor, .. } if *factor == 0.0)
    }

    /// Constant value, or the approximate mean over the texture.
    pub const fn mean(&self) -> f64 {
        match self {
            Self::Constant(value) | Self::Textured { mean: value, .. } => *value,
        }
    }

    /// Texture, if there is one.
    pub const fn texture_mut(&mut self) -> Option<&mut TextureId> {
        match self {
            Self::Constant(_) => None,
            Self::Textured { texture, .. } => Some(texture),
        }
    }

    /// Value at a point of the surface. A texture that is not in the list is 0.
    #[inline]
    pub fn at(&self, textures: &[Texture], surface: &SurfaceInteraction) -> f64 {
        let (TextureId(id), channel, factor) = match *self {
            Self::Constant(value) => return value,
            Self::Textured { texture, channel, factor, .. } => (texture, channel, factor),
        };
        let Some(texture) = textures.get(id as usize) else { return 0.0 };
        let point = surface.into();
        factor
            * match channel {
                Channel::Red => texture.at(&point).r,
                Channel::Green => texture.at(&point).g,
                Channel::Blue => texture.at(&point).b,
                Channel::Alpha => texture.alpha_at(&point),
            }
    }
}
