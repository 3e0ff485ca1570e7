//! Point of a surface at which a material is evaluated.

use crate::{ColorTexture, FloatTexture, Texture};
use rt_geometry::SurfaceInteraction;
use rt_math::Rgb;

/// Point of a surface at which a material is evaluated.
#[derive(Clone, Copy, Debug)]
pub struct MaterialEvalContext<'a> {
    /// Textures that coefficients refer to.
    pub textures: &'a [Texture],
    /// The surface.
    pub surface: &'a SurfaceInteraction,
    /// Index of refraction behind the surface divided by that in front of it.
    pub ior: f64,
}

impl MaterialEvalContext<'_> {
    /// Value of a reflectance, at most 1 so that no energy is created.
    pub(crate) fn reflectance(&self, coefficient: &ColorTexture) -> Rgb {
        coefficient.at(self.textures, self.surface).map(|c| c.min(1.0))
    }

    /// Value of a parameter, clamped to \[0, 1\].
    pub(crate) fn unit_value(&self, parameter: &FloatTexture) -> f64 {
        parameter.at(self.textures, self.surface).clamp(0.0, 1.0)
    }
}
