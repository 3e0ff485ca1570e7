//! Features of shading that a scene uses.

use crate::{Appearance, Material, Phong};
use rt_geometry::InteractionFlags;
use rt_math::Rgb;

/// Parts of shading that a scene uses. Parts that are `false` are not computed; the image is bit-identical.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShadingFeatures {
    /// A light casts shadows.
    pub shadows: bool,
    /// A material reflects ambient light.
    pub ambient: bool,
    /// A material is emissive.
    pub emission: bool,
    /// A material has a highlight.
    pub highlights: bool,
    /// A material mirrors.
    pub reflection: bool,
    /// A material transmits light.
    pub refraction: bool,
    /// A material splits light by Fresnel's equations.
    pub fresnel: bool,
    /// A medium absorbs.
    pub absorption: bool,
    /// A material is textured, so that texture coordinates are needed.
    pub textures: bool,
    /// A surface has interpolated normals.
    pub shading_normals: bool,
    /// A material reads vertex attributes: second texture coordinates, colours, tangents.
    pub detail: bool,
}

impl ShadingFeatures {
    /// All features, needed or not.
    pub const ALL: Self = Self {
        shadows: true,
        ambient: true,
        emission: true,
        highlights: true,
        reflection: true,
        refraction: true,
        fresnel: true,
        absorption: true,
        textures: true,
        shading_normals: true,
        detail: true,
    };

    /// Needs of an appearance, of materials with a `used` index. Interpolated normals are assumed to be needed.
    pub fn of(appearance: &Appearance, used: impl Fn(usize) -> bool) -> Self {
        let materials = || appearance.materials.iter().enumerate().filter(|(index, _)| used(*index));
        let any = |test: &dyn Fn(&Material) -> bool| materials().any(|(_, material)| test(material));
        let any_phong = |test: &dyn Fn(&Phong) -> bool| any(&|material| test(&material.to_phong()));
        let lit = !appearance.lights.is_empty();
        Self {
            shadows: appearance.lights.iter().any(|light| light.casts_shadows),
            ambient: !appearance.ambient.is_black() && any_phong(&|phong| !phong.ambient.is_zero()),
            emission: any(&|material| !material.emission.is_zero()),
            highlights: lit && any_phong(&|phong| !phong.specular.is_zero()),
            reflection: any_phong(&|phong| !phong.mirror.is_zero()),
            refraction: any_phong(&|phong| phong.transmission.is_some()),
            fresnel: any_phong(&|phong| phong.transmission.is_some_and(|transmission| transmission.fresnel)),
            absorption: any(&|material| material.interior.is_some_and(|interior| interior.absorption != Rgb::BLACK)),
            textures: any(&Material::is_textured),
            shading_normals: true,
            detail: any(&Material::needs_detail),
        }
    }

    /// Required attributes of a surface.
    pub const fn surface(&self) -> InteractionFlags {
        InteractionFlags { uv: self.textures, shading_normal: self.shading_normals, detail: self.detail }
    }
}
