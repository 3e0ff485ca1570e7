//! Material of glTF with its extensions.

use crate::{
    ColorTexture, FloatTexture, MaterialEvalContext, NormalMap, TextureId,
    bsdf::{DispersiveDielectric, Ggx, Layered, Sheen},
};
use rt_geometry::SurfaceInteraction;
use rt_math::{DVec3, Frame, Rgb, Vec3, transcendental};

/// Base layer.
#[derive(Clone, Debug, PartialEq)]
pub enum LayeredBase {
    /// A dielectric mixed with metal.
    MetallicRoughness {
        /// Albedo of the diffuse lobe, or reflectance of the metal.
        base_color: ColorTexture,
        /// 0 for a dielectric, 1 for metal.
        metallic: FloatTexture,
        /// Roughness of the microfacets, 0 to 1.
        roughness: FloatTexture,
    },
    /// Separate diffuse and specular colours (KHR_materials_pbrSpecularGlossiness).
    SpecularGlossiness {
        /// Albedo of the diffuse lobe.
        diffuse: ColorTexture,
        /// Reflectance of the microfacets at normal incidence.
        specular: ColorTexture,
        /// 1 minus the roughness.
        glossiness: FloatTexture,
        /// Base colour of the nearest metallic-roughness material, for the conversion to Phong.
        base_color: ColorTexture,
        /// Approximate mean of `specular` over the surface, for the conversion to Phong.
        mean_specular: Rgb,
    },
}

/// A base under microfacets, sheen and clearcoat. Layers with a factor of zero are left out.
#[derive(Clone, Debug, PartialEq)]
pub struct LayeredSurface {
    /// Base layer.
    pub base: LayeredBase,
    /// Index of refraction, which gives the reflectance of dielectric microfacets; 0 means total reflection.
    pub ior: f64,
    /// Strength of that reflection (KHR_materials_specular).
    pub specular: FloatTexture,
    /// Its colour at normal incidence.
    pub specular_color: ColorTexture,
    /// Transmitted part of the light that a diffuse base would scatter (KHR_materials_transmission).
    pub transmission: FloatTexture,
    /// True for a pane without thickness, false for the surface of a solid (KHR_materials_volume).
    pub is_thin: bool,
    /// 20 divided by the Abbe number, 0 for none (KHR_materials_dispersion).
    pub dispersion: f64,
    /// Strength of the clearcoat, 0 to 1 (KHR_materials_clearcoat).
    pub clearcoat: FloatTexture,
    /// Roughness of the clearcoat.
    pub clearcoat_roughness: FloatTexture,
    /// Normal map of the clearcoat. Without one it has the smooth normal, whatever the normal map of the base.
    pub clearcoat_normal_map: Option<NormalMap>,
    /// Colour of the sheen (KHR_materials_sheen).
    pub sheen_color: ColorTexture,
    /// Roughness of the sheen.
    pub sheen_roughness: FloatTexture,
    /// Strength of the anisotropy, 0 to 1 (KHR_materials_anisotropy).
    pub anisotropy: FloatTexture,
    /// Angle from the tangent to the direction of the anisotropy, in radians, counter-clockwise.
    pub anisotropy_rotation: f64,
    /// Texture with the direction of the anisotropy in red and green.
    pub anisotropy_direction: Option<TextureId>,
}

impl LayeredSurface {
    /// A base without extensions.
    pub const fn new(base: LayeredBase) -> Self {
        Self {
            base,
            ior: 1.5,
            specular: FloatTexture::Constant(1.0),
            specular_color: ColorTexture::Constant(Rgb::WHITE),
            transmission: FloatTexture::Constant(0.0),
            is_thin: true,
            dispersion: 0.0,
            clearcoat: FloatTexture::Constant(0.0),
            clearcoat_roughness: FloatTexture::Constant(0.0),
            clearcoat_normal_map: None,
            sheen_color: ColorTexture::ZERO,
            sheen_roughness: FloatTexture::Constant(0.0),
            anisotropy: FloatTexture::Constant(0.0),
            anisotropy_rotation: 0.0,
            anisotropy_direction: None,
        }
    }

    /// Version of [`MaterialModel::shows_layers`](crate::MaterialModel) for this surface.
    pub(crate) fn shows_layers(&self) -> bool {
        let is_smooth = match &self.base {
            LayeredBase::MetallicRoughness { roughness, .. } => roughness.is_zero(),
            LayeredBase::SpecularGlossiness { .. } => false,
        };
        !self.clearcoat.is_zero() || !self.sheen_color.is_zero() || (self.is_thin && !is_smooth)
    }

    pub(crate) fn bsdf(&self, at: &MaterialEvalContext<'_>) -> Layered {
        let mut layers = match &self.base {
            LayeredBase::MetallicRoughness { base_color, metallic, roughness } => self.metallic_roughness(
                at,
                at.reflectance(base_color),
                at.unit_value(metallic),
                at.unit_value(roughness),
            ),
            LayeredBase::SpecularGlossiness { diffuse, specular, glossiness, .. } => {
                let f0 = at.reflectance(specular);
                let strongest = f0.max_component();
                let diffuse = at.reflectance(diffuse) * (1.0 - strongest);
                Layered {
                    diffuse,
                    f0,
                    dielectric_reflectance: [strongest, 1.0],
                    roughness: 1.0 - at.unit_value(glossiness),
                    ..Layered::PLASTIC
                }
            }
        };
        if !self.clearcoat.is_zero() {
            layers.clearcoat = at.unit_value(&self.clearcoat);
            layers.clearcoat_roughness = at.unit_value(&self.clearcoat_roughness);
            layers.clearcoat_normal = self.clearcoat_normal(at);
        }
        if !self.sheen_color.is_zero() {
            let (color, roughness) = (at.reflectance(&self.sheen_color), at.unit_value(&self.sheen_roughness));
            layers.sheen = (!color.is_black()).then_some(Sheen { color, roughness });
        }
        if !self.anisotropy.is_zero() {
            (layers.anisotropy, layers.axis) = self.anisotropy(at);
        }
        layers
    }

    fn metallic_roughness(&self, at: &MaterialEvalContext<'_>, color: Rgb, metallic: f64, roughness: f64) -> Layered {
        let fresnel = if self.ior == 0.0 { 1.0 } else { (self.ior - 1.0) / (self.ior + 1.0) };
        let strength = at.unit_value(&self.specular);
        let tint = self.specular_color.at(at.textures, at.surface);
        let f0 = (tint * (fresnel * fresnel)).map(|f| f.min(1.0)) * strength;
        let transmitted = if self.transmission.is_zero() { 0.0 } else { at.unit_value(&self.transmission) };
        // The glass of a solid takes its share from the dielectric. The rest has more metal.
        let weight = if self.is_thin { 0.0 } else { transmitted * (1.0 - metallic) };
        let metallic = if weight < 1.0 { metallic / (1.0 - weight) } else { 0.0 };
        let below = color * (1.0 - metallic);
        let layers = Layered {
            f0: f0.lerp(color, metallic),
            f90: Rgb::gray(strength).lerp(Rgb::WHITE, metallic),
            dielectric_reflectance: [f0.max_component(), strength],
            roughness,
            ..Layered::PLASTIC
        };
        if self.is_thin {
            return Layered { diffuse: below * (1.0 - transmitted), transmittance: below * transmitted, ..layers };
        }
        let glass = DispersiveDielectric { iors: self.iors(at.ior), roughness, transmittance: color };
        Layered { diffuse: below, glass: (weight > 0.0).then_some((weight, glass)), ..layers }
    }

    /// Indices of refraction of red, green and blue, where that of green is `ior`. The glTF index 0, which stands for an infinite one, has no
    /// dispersion.
    fn iors(&self, ior: f64) -> [f64; 3] {
        let spread = if self.ior == 0.0 { 0.0 } else { (self.ior - 1.0) * 0.025 * self.dispersion / self.ior };
        [1.0 - spread, 1.0, 1.0 + spread].map(|part| ior * part)
    }

    /// Share of the emission that passes the clearcoat towards `wo`, a unit vector in world space (KHR_materials_clearcoat, "Emission").
    pub(crate) fn clearcoat_transmittance(&self, at: &MaterialEvalContext<'_>, wo: DVec3) -> f64 {
        let (clearcoat, clearcoat_roughness) =
            (at.unit_value(&self.clearcoat), at.unit_value(&self.clearcoat_roughness));
        let cos = Frame::from_z(at.surface.shading_normal).to_local(wo).dot(self.clearcoat_normal(at)).abs();
        Layered { clearcoat, clearcoat_roughness, ..Layered::PLASTIC }.clearcoat_transmittance(cos.min(1.0))
    }

    /// Normal of the clearcoat in shading coordinates.
    fn clearcoat_normal(&self, at: &MaterialEvalContext<'_>) -> DVec3 {
        let base = at.surface.shading_normal;
        let has_normal_map = at.surface.detail.smooth_normal != Vec3::ZERO;
        let smooth = if has_normal_map { at.surface.detail.smooth_normal.as_dvec3().normalize() } else { base };
        let mapped = self.clearcoat_normal_map.and_then(|map| map.mapped(at.textures, at.surface, smooth));
        match mapped {
            None if !has_normal_map => DVec3::Z,
            mapped => Frame::from_z(base).to_local(mapped.unwrap_or(smooth)),
        }
    }

    /// Strength and direction of the anisotropy in shading coordinates.
    fn anisotropy(&self, at: &MaterialEvalContext<'_>) -> (f64, [f64; 2]) {
        let SurfaceInteraction { detail, shading_normal, .. } = at.surface;
        let texture = self.anisotropy_direction.and_then(|id| at.textures.get(id.0 as usize));
        let turned = texture.map_or([1.0, 0.0], |texture| {
            let map = texture.at(&at.surface.into());
            [2.0 * map.r - 1.0, 2.0 * map.g - 1.0]
        });
        let (sin, cos) = transcendental::sincos(self.anisotropy_rotation);
        let [along, across] = [turned[0] * cos - turned[1] * sin, turned[0] * sin + turned[1] * cos];
        if detail.tangent == Vec3::ZERO {
            return (0.0, [1.0, 0.0]);
        }
        let tangent = Frame::from_z(*shading_normal).to_local(detail.tangent.as_dvec3());
        let side = if detail.is_mirrored { -1.0 } else { 1.0 };
        let axis = DVec3::new(
            tangent.x * along - tangent.y * across * side,
            tangent.y * along + tangent.x * across * side,
            0.0,
        );
        match axis.try_normalize() {
            Some(axis) => (at.unit_value(&self.anisotropy), [axis.x, axis.y]),
            None => (0.0, [1.0, 0.0]),
        }
    }

    /// True if a lobe may be a delta distribution. Textures count as if they had smooth parts.
    pub(crate) fn may_be_delta(&self) -> bool {
        let may_be_smooth = |roughness: &FloatTexture| match roughness {
            FloatTexture::Constant(value) => Ggx::from_roughness(*value).is_none(),
            FloatTexture::Textured { .. } => true,
        };
        let facets = match &self.base {
            LayeredBase::MetallicRoughness { roughness, .. } => may_be_smooth(roughness),
            LayeredBase::SpecularGlossiness { glossiness: FloatTexture::Constant(value), .. } => {
                Ggx::from_roughness(1.0 - value).is_none()
            }
            LayeredBase::SpecularGlossiness { .. } => true,
        };
        facets || self.has_glass_interface() || (!self.clearcoat.is_zero() && may_be_smooth(&self.clearcoat_roughness))
    }

    /// True if transmitted light enters a solid.
    fn has_glass_interface(&self) -> bool {
        !self.is_thin && !self.transmission.is_zero()
    }

    /// True if it reads the tangents of meshes.
    pub fn needs_tangents(&self) -> bool {
        !self.anisotropy.is_zero() || (self.clearcoat_normal_map.is_some() && !self.clearcoat.is_zero())
    }

    /// Base colour, metalness and roughness of a surface without textured numbers and without extensions.
    ///
    /// Such a surface is evaluated as the metallic-roughness BSDF, which has fewer lobes.
    pub fn as_metallic_roughness(&self) -> Option<(&ColorTexture, f64, f64)> {
        let LayeredBase::MetallicRoughness {
            base_color,
            metallic: FloatTexture::Constant(metallic),
            roughness: FloatTexture::Constant(roughness),
        } = &self.base
        else {
            return None;
        };
        let Self { base: _, ior, specular, specular_color, transmission, is_thin, dispersion, .. } = self;
        let Self { clearcoat, clearcoat_roughness, clearcoat_normal_map, sheen_color, sheen_roughness, .. } = self;
        let Self { anisotropy, anisotropy_rotation, anisotropy_direction, .. } = self;
        let (zero, one) = (FloatTexture::Constant(0.0), FloatTexture::Constant(1.0));
        let has_zeros = [transmission, clearcoat, clearcoat_roughness, sheen_roughness, anisotropy]
            .into_iter()
            .all(|parameter| *parameter == zero);
        let is_plain = has_zeros
            && (*ior, *specular, *is_thin) == (1.5, one, true)
            && (*specular_color, *sheen_color) == (ColorTexture::Constant(Rgb::WHITE), ColorTexture::ZERO)
            && (*dispersion, *anisotropy_rotation) == (0.0, 0.0)
            && clearcoat_normal_map.is_none()
            && anisotropy_direction.is_none();
        is_plain.then_some((base_color, *metallic, *roughness))
    }

    /// Coefficients, which may be textured.
    pub(crate) fn color_textures_mut(&mut self) -> Vec<&mut ColorTexture> {
        let mut list = match &mut self.base {
            LayeredBase::MetallicRoughness { base_color, .. } => vec![base_color],
            LayeredBase::SpecularGlossiness { diffuse, specular, base_color, .. } => {
                vec![diffuse, specular, base_color]
            }
        };
        list.extend([&mut self.specular_color, &mut self.sheen_color]);
        list
    }

    /// Textures that are read as numbers, normals or directions.
    pub(crate) fn data_textures_mut(&mut self) -> Vec<&mut TextureId> {
        let of_base = match &mut self.base {
            LayeredBase::MetallicRoughness { metallic, roughness, .. } => [Some(metallic), Some(roughness)],
            LayeredBase::SpecularGlossiness { glossiness, .. } => [Some(glossiness), None],
        };
        let parameters = [
            &mut self.specular,
            &mut self.transmission,
            &mut self.clearcoat,
            &mut self.clearcoat_roughness,
            &mut self.sheen_roughness,
            &mut self.anisotropy,
        ];
        let normal_map = self.clearcoat_normal_map.as_mut().map(|map| &mut map.texture);
        let parameters = of_base.into_iter().flatten().chain(parameters).filter_map(FloatTexture::texture_mut);
        parameters.chain(normal_map).chain(&mut self.anisotropy_direction).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Regression: solids of half metal and half glass reflected 20 times the diffuse light.
    #[test]
    fn an_infinite_index_of_refraction_has_no_dispersion() {
        for dispersion in [0.0, 1.0] {
            let base = LayeredBase::MetallicRoughness {
                base_color: ColorTexture::Constant(Rgb::WHITE),
                metallic: FloatTexture::Constant(0.0),
                roughness: FloatTexture::Constant(0.0),
            };
            let invisible = LayeredSurface { ior: 0.0, dispersion, ..LayeredSurface::new(base) };
            assert_eq!(invisible.iors(1.0), [1.0; 3]);
        }
    }

    #[test]
    fn the_rest_of_a_solid_is_the_metal_and_the_plastic_that_glass_leaves() {
        let constant = FloatTexture::Constant;
        let color = Rgb::new(0.8, 0.4, 0.2);
        let base_color = ColorTexture::Constant(color);
        let surface = SurfaceInteraction::flat(DVec3::ZERO, DVec3::ZERO, DVec3::Z, [0.0; 2]);
        let at = MaterialEvalContext { textures: &[], surface: &surface, ior: 1.5 };
        let of = |metallic: f64, transmission: f64| {
            let base =
                LayeredBase::MetallicRoughness { base_color, metallic: constant(metallic), roughness: constant(0.3) };
            let transmission = constant(transmission);
            LayeredSurface { transmission, is_thin: false, ..LayeredSurface::new(base) }.bsdf(&at)
        };
        for (metallic, transmission) in [(0.0, 0.5), (0.25, 1.0), (0.5, 0.5), (0.75, 0.2), (1.0, 1.0)] {
            let layered = of(metallic, transmission);
            let rest = 1.0 - layered.glass.map_or(0.0, |(weight, _)| weight);
            assert!((rest - (1.0 - transmission * (1.0 - metallic))).abs() < 1e-15);
            // m metal and (1 − m)(1 − t) plastic.
            let plastic = (1.0 - metallic) * (1.0 - transmission);
            assert!((layered.diffuse.r * rest - color.r * plastic).abs() < 1e-15, "{metallic}, {transmission}");
            let f0 = metallic * color.r + plastic * 0.04;
            assert!((layered.f0.r * rest - f0).abs() < 1e-15, "{metallic}, {transmission}");
        }
    }
}
