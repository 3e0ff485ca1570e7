//! Phong models of uniform materials, in the form that lanes read.

use crate::{Appearance, ColorTexture, FloatTexture, Highlight, Material, Needs};
use rt_math::Rgb;

/// Greatest exponent of a highlight in lanes; all are integers.
const MAX_EXPONENT: f64 = 1024.0;

/// Phong model of a material without textures and emission.
#[derive(Clone, Debug)]
pub(super) struct UniformPhong {
    /// Reflected ambient light.
    pub(super) radiance: Rgb,
    pub(super) diffuse: Rgb,
    pub(super) specular: Rgb,
    pub(super) exponent: f64,
    pub(super) highlight: Highlight,
    pub(super) mirror: Rgb,
    /// Coefficient of transmitted light, and true if Fresnel's equations apply.
    pub(super) transmission: Option<(Rgb, bool)>,
}

impl UniformPhong {
    /// A surface that scatters no light.
    pub(super) const BLACK: Self = Self {
        radiance: Rgb::BLACK,
        diffuse: Rgb::BLACK,
        specular: Rgb::BLACK,
        exponent: 0.0,
        highlight: Highlight::Phong,
        mirror: Rgb::BLACK,
        transmission: None,
    };

    /// Models of all materials; `None` for those that are shaded one by one.
    pub(super) fn of_all(appearance: &Appearance, needs: &Needs) -> Vec<Option<Self>> {
        appearance.materials.iter().map(|material| Self::of(material, appearance, needs)).collect()
    }

    fn of(material: &Material, appearance: &Appearance, needs: &Needs) -> Option<Self> {
        let phong = material.to_phong();
        let constant = |texture: ColorTexture| match texture {
            ColorTexture::Constant(rgb) => Some(rgb),
            ColorTexture::Textured(..) => None,
        };
        let FloatTexture::Constant(occlusion) = material.occlusion else { return None };
        let ambient = constant(phong.ambient)?;
        let ambient = if occlusion == 1.0 { ambient } else { ambient * occlusion };
        let transmission = match phong.transmission {
            Some(transmission) => Some((constant(transmission.coefficient)?, transmission.fresnel)),
            None => None,
        };
        let has_plain_highlight = phong.specular.is_zero()
            || (phong.exponent.fract() == 0.0 && (0.0..=MAX_EXPONENT).contains(&phong.exponent));
        let model = Self {
            radiance: if needs.ambient { Rgb::BLACK + ambient * appearance.ambient } else { Rgb::BLACK },
            diffuse: constant(phong.diffuse)?,
            specular: if needs.highlights { constant(phong.specular)? } else { Rgb::BLACK },
            exponent: phong.exponent,
            highlight: phong.highlight,
            mirror: constant(phong.mirror)?,
            transmission,
        };
        (has_plain_highlight && material.emission.is_zero()).then_some(model)
    }
}
