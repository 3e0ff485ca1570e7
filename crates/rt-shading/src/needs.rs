//! Features of shading that a scene uses.

use crate::{Appearance, Phong};
use rt_geometry::InteractionFlags;
use rt_math::Rgb;

/// The parts of shading that a scene uses. What is `false` is not computed; the picture is the same to the bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Needs {
    /// Some light casts shadows.
    pub shadows: bool,
    /// There is ambient light and a surface that reflects it.
    pub ambient: bool,
    /// Some surface is emissive.
    pub emission: bool,
    /// Some surface has a highlight.
    pub highlights: bool,
    /// Some surface mirrors.
    pub reflection: bool,
    /// Some surface lets light through.
    pub refraction: bool,
    /// Some transparent surface shares its light by Fresnel's equations.
    pub fresnel: bool,
    /// Some transparent body absorbs.
    pub absorption: bool,
    /// Some coefficient is textured, so texture coordinates are needed.
    pub textures: bool,
    /// Some surface has interpolated normals.
    pub shading_normals: bool,
    /// Some surface looks at what only some meshes have: a second set of texture coordinates, colours, tangents.
    pub detail: bool,
}

impl Needs {
    /// Everything, needed or not.
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

    /// Features of an appearance whose materials are in use if `used` is true for their index. Interpolated normals are a
    /// matter of the geometry and assumed needed.
    pub fn of(appearance: &Appearance, used: impl Fn(usize) -> bool) -> Self {
        let materials = || appearance.materials.iter().enumerate().filter(|(index, _)| used(*index));
        let any = |test: &dyn Fn(&Phong) -> bool| materials().any(|(_, material)| test(&material.phong));
        let lit = !appearance.lights.is_empty();
        Self {
            shadows: appearance.lights.iter().any(|light| light.casts_shadows),
            ambient: !appearance.ambient.is_black() && any(&|p| !p.ambient.is_zero()),
            emission: any(&|p| !p.emission.is_zero()),
            highlights: lit && any(&|p| !p.specular.is_zero()),
            reflection: any(&|p| !p.mirror.is_zero()),
            refraction: any(&|p| p.transmission.is_some()),
            fresnel: any(&|p| p.transmission.is_some_and(|t| t.fresnel)),
            absorption: any(&|p| p.transmission.is_some_and(|t| t.absorption != Rgb::BLACK)),
            textures: materials().any(|(_, material)| material.is_textured()),
            shading_normals: true,
            detail: materials().any(|(_, material)| material.needs_detail()),
        }
    }

    /// Required attributes of a surface.
    pub const fn surface(&self) -> InteractionFlags {
        InteractionFlags { uv: self.textures, shading_normal: self.shading_normals, detail: self.detail }
    }
}
