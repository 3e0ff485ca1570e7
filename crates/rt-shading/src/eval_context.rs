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
    /// Value of a reflectance, clamped to \[0, 1\]: more would create energy, and negative pixels of images are made by resampling.
    pub(crate) fn reflectance(&self, coefficient: &ColorTexture) -> Rgb {
        coefficient.at(self.textures, self.surface).map(|c| c.clamp(0.0, 1.0))
    }

    /// Value of a parameter, clamped to \[0, 1\].
    pub(crate) fn unit_value(&self, parameter: &FloatTexture) -> f64 {
        parameter.at(self.textures, self.surface).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rt_math::DVec3;

    /// Regression: a channel below 0 made samples negative, which count as black.
    #[test]
    fn reflectances_are_neither_negative_nor_above_one() {
        let surface = SurfaceInteraction::flat(DVec3::ZERO, DVec3::ZERO, DVec3::Z, [0.0; 2]);
        let at = MaterialEvalContext { textures: &[], surface: &surface, ior: 1.0 };
        let reflectance = at.reflectance(&ColorTexture::Constant(Rgb::new(-0.02, 0.5, 1.5)));
        assert_eq!(reflectance, Rgb::new(0.0, 0.5, 1.0));
    }
}
