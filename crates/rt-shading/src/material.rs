//! Materials: a reflection model, and the parts that all models share.

use crate::{
    Alpha, ColorTexture, FloatTexture, InteriorMedium, MaterialEvalContext, MaterialModel, NormalMap, Phong, Texture,
    TextureId, bsdf::Bsdf, light::EmissionSides,
};
use rt_geometry::SurfaceInteraction;
use rt_math::Rgb;

/// A named material.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name in messages and `explain`.
    pub name: String,
    /// Reflection model.
    pub model: MaterialModel,
    /// Phong model of a file that states both a Phong and a physically based part. It replaces the
    /// [conversion](Self::to_phong) of `model`.
    pub phong_override: Option<Phong>,
    /// Emitted radiance.
    pub emission: ColorTexture,
    /// Sides that emit.
    pub emission_sides: EmissionSides,
    /// Medium behind the surface. `None` for opaque and thin surfaces, which have the same medium on both sides.
    pub interior: Option<InteriorMedium>,
    /// Parts of the surface that rays pass.
    pub alpha: Alpha,
    /// Normal map, if any.
    pub normal_map: Option<NormalMap>,
    /// Ambient occlusion: factor of the ambient light.
    pub occlusion: FloatTexture,
}

impl Material {
    /// An opaque material that emits no light.
    pub fn new(name: String, model: impl Into<MaterialModel>) -> Self {
        Self {
            name,
            model: model.into(),
            phong_override: None,
            emission: ColorTexture::ZERO,
            emission_sides: EmissionSides::Both,
            interior: None,
            alpha: Alpha::OPAQUE,
            normal_map: None,
            occlusion: FloatTexture::Constant(1.0),
        }
    }

    /// True if the model is physically based and scatters light: `whitted` shows a conversion.
    pub const fn is_physically_based(&self) -> bool {
        !matches!(self.model, MaterialModel::Phong(_) | MaterialModel::Black)
    }

    /// Emitted radiance; black on the back of a surface that emits from its front only.
    #[inline]
    pub fn emitted_radiance(&self, textures: &[Texture], surface: &SurfaceInteraction, is_inside: bool) -> Rgb {
        let is_dark_side = is_inside && self.emission_sides == EmissionSides::Front;
        if is_dark_side { Rgb::BLACK } else { self.emission.at(textures, surface) }
    }

    /// Ambient coefficient of `phong`, the [Phong model](Self::to_phong) of this material, with occlusion.
    #[inline]
    pub fn ambient(&self, phong: &Phong, textures: &[Texture], surface: &SurfaceInteraction) -> Rgb {
        let ambient = phong.ambient.at(textures, surface);
        match self.occlusion {
            FloatTexture::Constant(1.0) => ambient,
            occlusion => ambient * occlusion.at(textures, surface),
        }
    }

    /// Evaluates textures at a point and builds the BSDF there. It takes time: the BSDFs of uniform materials are
    /// [cached](crate::BsdfCache).
    pub fn bsdf(&self, at: &MaterialEvalContext<'_>) -> Bsdf {
        self.model.bsdf(at)
    }

    /// True if it reads the [`VertexAttributes`](rt_geometry::VertexAttributes) of meshes.
    pub fn needs_detail(&self) -> bool {
        self.model.needs_tangents() || self.is_textured()
    }

    /// True if the BSDF is the same at every point: without textures, tangents, and media that depend on the ray.
    pub fn is_uniform(&self) -> bool {
        self.interior.is_none() && !self.needs_detail()
    }

    /// Adds `first` to the indices of all textures.
    pub fn offset_textures(&mut self, first: u32) {
        for color in self.color_textures_mut() {
            if let ColorTexture::Textured(id, _) = color {
                id.0 += first;
            }
        }
        for id in self.data_textures_mut() {
            id.0 += first;
        }
        self.alpha.texture.iter_mut().for_each(|id| id.0 += first);
    }

    /// True if shading reads textures.
    pub fn is_textured(&self) -> bool {
        !self.textures().is_empty()
    }

    /// Textures that shading reads, in no particular order. Those of the alpha test, which traversal reads, are left out.
    pub fn textures(&self) -> Vec<TextureId> {
        // One list of mutable references serves both this copy and `offset_textures`.
        let mut copy = self.clone();
        let of_colors = copy.color_textures_mut().into_iter().filter_map(|color| match color {
            ColorTexture::Textured(id, _) => Some(*id),
            ColorTexture::Constant(_) => None,
        });
        let mut ids: Vec<TextureId> = of_colors.collect();
        ids.extend(copy.data_textures_mut().into_iter().map(|id| *id));
        ids
    }

    fn color_textures_mut(&mut self) -> Vec<&mut ColorTexture> {
        let phong = self.phong_override.as_mut().map(Phong::color_textures_mut).unwrap_or_default();
        self.model.color_textures_mut().into_iter().chain(phong).chain([&mut self.emission]).collect()
    }

    /// Textures that are read as numbers, normals or directions.
    fn data_textures_mut(&mut self) -> Vec<&mut TextureId> {
        let normal_map = self.normal_map.as_mut().map(|map| &mut map.texture);
        self.model.data_textures_mut().into_iter().chain(self.occlusion.texture_mut()).chain(normal_map).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LayeredBase, LayeredSurface};

    #[test]
    fn a_normal_map_of_the_clearcoat_is_a_texture() {
        let map = NormalMap { texture: TextureId(3), scale: 1.0 };
        let (base_color, metallic) = (ColorTexture::Constant(Rgb::WHITE), FloatTexture::Constant(0.0));
        let base = LayeredBase::MetallicRoughness { base_color, metallic, roughness: metallic };
        let surface = LayeredSurface { clearcoat_normal_map: Some(map), ..LayeredSurface::new(base) };
        let material = Material::new("coated".into(), MaterialModel::Layered(Box::new(surface)));
        assert_eq!((material.textures(), material.is_textured()), (vec![TextureId(3)], true));
    }
}
