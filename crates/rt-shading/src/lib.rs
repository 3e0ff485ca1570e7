//! # rt-shading: chapter 4, light and material

#![forbid(unsafe_code)]

mod appearance;
mod light;
mod material;
mod texture;

pub use appearance::{Appearance, Background};
pub use light::{Falloff, Light, LightKind};
pub use material::{Coefficient, Highlight, Material, Phong, Transmission};
pub use texture::{Bitmap, Texture, TextureId, Wrap};
