//! Materials, textures, lights and background of a scene.

use crate::{DeltaLight, Material, Texture, light::EnvironmentLight};
use rt_math::{DVec3, Rgb};
use std::sync::Arc;

/// Radiance of rays that hit nothing.
#[derive(Clone, Debug, PartialEq)]
pub enum Background {
    /// Constant radiance.
    Constant(Rgb),
    /// Linear in the y component of the unit direction.
    Gradient {
        /// Radiance straight down.
        bottom: Rgb,
        /// Radiance straight up.
        top: Rgb,
    },
    /// Image in all directions, which is a light as well.
    Environment(Arc<EnvironmentLight>),
}

impl Background {
    /// True if its radiance is zero everywhere.
    pub fn is_black(&self) -> bool {
        match self {
            Self::Constant(rgb) => rgb.is_black(),
            Self::Gradient { bottom, top } => bottom.is_black() && top.is_black(),
            Self::Environment(light) => light.power(1.0).is_black(),
        }
    }

    /// Radiance against `direction` (any non-zero length, world space).
    pub fn radiance(&self, direction: DVec3) -> Rgb {
        match self {
            Self::Constant(rgb) => *rgb,
            Self::Environment(light) => light.le(direction),
            Self::Gradient { bottom, top } => bottom.lerp(*top, 0.5 + 0.5 * direction.y / direction.length()),
        }
    }
}

/// Materials, textures, lights and background, referred to by index.
#[derive(Clone, Debug, PartialEq)]
pub struct Appearance {
    /// Materials; objects hold indices into this list.
    pub materials: Vec<Material>,
    /// Textures; [`TextureId`](crate::TextureId) is an index into this list.
    pub textures: Vec<Texture>,
    /// Delta lights. Area lights come from emissive materials, the environment light from the background.
    pub lights: Vec<DeltaLight>,
    /// Light from everywhere, scaled by the ambient coefficient of materials.
    pub ambient: Rgb,
    /// Radiance of rays that hit nothing.
    pub background: Background,
}

impl Default for Appearance {
    /// No materials and lights, and a black background.
    fn default() -> Self {
        Self {
            materials: Vec::new(),
            textures: Vec::new(),
            lights: Vec::new(),
            ambient: Rgb::BLACK,
            background: Background::Constant(Rgb::BLACK),
        }
    }
}
