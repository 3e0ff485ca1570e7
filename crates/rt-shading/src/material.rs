//! Materials: a reflection model, and the parts that all models share.

use crate::{
    Alpha, ColorTexture, FloatTexture, InteriorMedium, LayeredSurface, MaterialEvalContext, MaterialModel, NormalMap,
    Phong, Texture, TextureId, bsdf::Bsdf, light::EmissionSides,
};
use rt_geometry::SurfaceInteraction;
use rt_math::{DVec3, Rgb};

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

    /// [Emitted radiance](Self::emitted_radiance) towards `wo`, a unit vector in world space: less what a clearcoat reflects.
    pub fn emitted_radiance_towards(
        &self,
        wo: DVec3,
        textures: &[Texture],
        surface: &SurfaceInteraction,
        is_inside: bool,
    ) -> Rgb {
        let emitted = self.emitted_radiance(textures, surface, is_inside);
        match self.coated_emission() {
            Some(layered) if !emitted.is_black() => {
                emitted * layered.clearcoat_transmittance(&MaterialEvalContext { textures, surface, ior: 1.0 }, wo)
            }
            _ => emitted,
        }
    }

    /// True if it emits through a clearcoat: less at grazing angles.
    pub fn has_coated_emission(&self) -> bool {
        self.coated_emission().is_some()
    }

    fn coated_emission(&self) -> Option<&LayeredSurface> {
        match &self.model {
            MaterialModel::Layered(layered) if !layered.clearcoat.is_zero() && !self.emission.is_zero() => {
                Some(layered)
            }
            _ => None,
        }
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
    use crate::LayeredBase;
    use rt_math::transcendental::{cos, sin};

    /// `coated_emission = emission * (1 - clearcoat * clearcoat_fresnel)` (KHR_materials_clearcoat).
    #[test]
    fn a_clearcoat_darkens_emission() {
        let constant = FloatTexture::Constant;
        let base_color = ColorTexture::Constant(Rgb::BLACK);
        let base = LayeredBase::MetallicRoughness { base_color, metallic: constant(0.0), roughness: constant(1.0) };
        let surface = SurfaceInteraction::flat(DVec3::ZERO, DVec3::ZERO, DVec3::Z, [0.0; 2]);
        for (strength, is_inside) in [(1.0, false), (0.5, false), (0.5, true), (0.0, false)] {
            let layered = LayeredSurface { clearcoat: constant(strength), ..LayeredSurface::new(base.clone()) };
            let emission = ColorTexture::Constant(Rgb::new(1.0, 0.5, 0.0));
            let material =
                Material { emission, ..Material::new("coated".into(), MaterialModel::Layered(Box::new(layered))) };
            assert_eq!(material.has_coated_emission(), strength > 0.0);
            for degrees in [0.0f64, 60.0, 80.0] {
                let angle = degrees.to_radians();
                let side = if is_inside { -1.0 } else { 1.0 };
                let wo = DVec3::new(sin(angle), 0.0, cos(angle) * side);
                let weight = 1.0 - cos(angle);
                let expected = 1.0 - strength * (0.04 + 0.96 * weight * weight * weight * weight * weight);
                let emitted = material.emitted_radiance_towards(wo, &[], &surface, is_inside);
                let error = emitted.r - expected;
                assert!(error.abs() < 0.01 && emitted.b == 0.0, "{strength}, {degrees}°: {emitted:?}, not {expected}");
                assert!((emitted.g - 0.5 * emitted.r).abs() < 1e-15);
            }
        }
    }

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
