//! Materials of a document, made when first used.

use std::{collections::HashMap, sync::Arc};

use gltf::{Document, Material};
use rt_math::{Rgb, transcendental};
use rt_shading::{
    Alpha, AlphaMode, Bitmap, Channel, ColorTexture, FloatTexture, InteriorMedium, LayeredBase, LayeredSurface,
    Material as NamedMaterial, MaterialModel, NormalMap, Texture, TextureId, light::EmissionSides,
};

use super::{
    buffers::Buffers,
    material_json::{self, MaterialJson, SpecularGlossiness, TextureInfo, Volume},
    primitive::RequiredAttributes,
    textures::{GltfTextures, PixelEncoding, UvSets},
};
use crate::parser_message::plain;
use crate::{LoadError, LoadErrorKind, LoadOptions, MaterialId, Model};

/// A material as primitives need it.
#[derive(Clone, Copy, Debug)]
pub(super) struct UsedMaterial {
    pub(super) id: MaterialId,
    /// Attributes that its meshes must have.
    pub(super) required_attributes: RequiredAttributes,
}

/// The materials and textures of a document.
pub(super) struct MaterialReader<'a> {
    textures: GltfTextures<'a>,
    /// By index, and whether meshes have vertex colours.
    materials: HashMap<(Option<usize>, bool), UsedMaterial>,
}

impl<'a> MaterialReader<'a> {
    pub(super) fn new(document: &'a Document, buffers: &'a Buffers<'a>, options: &'a LoadOptions) -> Self {
        Self { textures: GltfTextures::new(document, buffers, options), materials: HashMap::new() }
    }

    /// The material of a primitive, which has colours at its vertices or not.
    pub(super) fn material(
        &mut self,
        material: &Material<'_>,
        has_colors: bool,
        model: &mut Model,
    ) -> Result<UsedMaterial, LoadError> {
        let key = (material.index(), has_colors);
        if let Some(&known) = self.materials.get(&key) {
            return Ok(known);
        }
        let description = self.description(material)?;
        let required_attributes = required_attributes(&description, has_colors);
        let place = match (material.name(), material.index()) {
            (Some(name), _) => format!("material `{name}`"),
            (None, index) => format!("materials[{}]", index.unwrap_or(0)),
        };
        let uses_other_sets =
            description.textures().any(|texture| !required_attributes.uv_sets.contains(&Some(texture.uv_set())));
        let mut reader = MaterialBuilder {
            textures: &mut self.textures,
            sets: required_attributes.uv_sets,
            has_colors,
            place: &place,
            model,
        };
        if uses_other_sets {
            reader.warn("its textures use more than two sets of texture coordinates; the first is used for the others");
        }
        let name = material.name().unwrap_or(if material.index().is_some() { "unnamed" } else { "default" });
        let named = reader.material(name, &description)?;
        let id = model.add_material(named);
        let used = UsedMaterial { id, required_attributes };
        self.materials.insert(key, used);
        Ok(used)
    }

    fn description(&self, material: &Material<'_>) -> Result<MaterialJson, LoadError> {
        let Some(index) = material.index() else { return Ok(MaterialJson::default()) };
        let json = &self.textures.document.as_json().materials[index];
        let refuse = |error: serde_json::Error| {
            LoadErrorKind::Syntax(plain(&error.to_string())).at(self.textures.path(), format!("materials[{index}]"))
        };
        MaterialJson::of(json).map_err(refuse)
    }
}

/// Attributes that a material requires: up to two sets of texture coordinates, in the order of its textures.
fn required_attributes(description: &MaterialJson, has_colors: bool) -> RequiredAttributes {
    let mut uv_sets: UvSets = [None; 2];
    for set in description.textures().map(|texture| Some(texture.uv_set())) {
        if !uv_sets.contains(&set)
            && let Some(free) = uv_sets.iter_mut().find(|slot| slot.is_none())
        {
            *free = set;
        }
    }
    let of_anisotropy = description.extensions.anisotropy.as_ref().map(|_| 0);
    let tangents = description.normals().map(TextureInfo::uv_set).or(of_anisotropy);
    RequiredAttributes { uv_sets, colors: has_colors, tangents }
}

struct MaterialBuilder<'r, 'a> {
    textures: &'r mut GltfTextures<'a>,
    sets: UvSets,
    has_colors: bool,
    /// For messages.
    place: &'r str,
    model: &'r mut Model,
}

impl MaterialBuilder<'_, '_> {
    fn warn(&mut self, message: &str) {
        self.model.warn(self.place, message);
    }

    fn material(&mut self, name: &str, description: &MaterialJson) -> Result<NamedMaterial, LoadError> {
        let pbr = &description.pbr_metallic_roughness;
        let factors: [(&str, &[f32]); 3] = [
            ("baseColorFactor", &pbr.base_color_factor),
            ("metallicFactor", &[pbr.metallic_factor]),
            ("roughnessFactor", &[pbr.roughness_factor]),
        ];
        for (name, _) in factors.iter().filter(|(_, of)| of.iter().any(|factor| !(0.0..=1.0).contains(factor))) {
            self.warn(&format!("its `{name}` is not between 0 and 1: it is clamped"));
        }
        let emission_sides = if description.double_sided { EmissionSides::Both } else { EmissionSides::Front };
        if description.extensions.unlit.is_some() {
            let emission = self.base_color(description)?;
            let alpha = self.alpha(description, false)?;
            let black = NamedMaterial::new(name.to_owned(), MaterialModel::Black);
            return Ok(NamedMaterial { emission, emission_sides, alpha, ..black });
        }
        let layered = self.layered(description)?;
        let alpha = self.alpha(description, !layered.transmission.is_zero())?;
        let emission = self.emission(description)?;
        let interior = interior(&layered, description.extensions.volume.as_ref());
        let model = MaterialModel::Layered(Box::new(layered));
        let normal_map = self.normal_map(description.normal_texture.as_ref())?;
        let mut material = NamedMaterial {
            emission,
            emission_sides,
            interior,
            alpha,
            normal_map,
            ..NamedMaterial::new(name.to_owned(), model)
        };
        if let Some(occlusion) = &description.occlusion_texture {
            material.occlusion = self.occlusion(occlusion)?;
        }
        Ok(material)
    }

    fn emission(&mut self, description: &MaterialJson) -> Result<ColorTexture, LoadError> {
        let strength = description.extensions.emissive_strength.as_ref();
        let strength = strength.map_or(1.0, |extension| extension.emissive_strength);
        let emissive = rgb(description.emissive_factor) * f64::from(strength.max(0.0));
        self.color(description.emissive_texture.as_ref(), emissive)
    }

    fn base_color(&mut self, description: &MaterialJson) -> Result<ColorTexture, LoadError> {
        let pbr = &description.pbr_metallic_roughness;
        self.tinted(pbr.base_color_texture.as_ref(), opaque(pbr.base_color_factor))
    }

    fn layered(&mut self, description: &MaterialJson) -> Result<LayeredSurface, LoadError> {
        let (pbr, all) = (&description.pbr_metallic_roughness, &description.extensions);
        if let Some(other) = &all.specular_glossiness {
            // The extension is not combined with others.
            return Ok(LayeredSurface::new(self.specular_glossiness(other)?));
        }
        let metal_rough = pbr.metallic_roughness_texture.as_ref();
        let mut layered = LayeredSurface::new(LayeredBase::MetallicRoughness {
            base_color: self.base_color(description)?,
            metallic: self.value(metal_rough, Channel::Blue, pbr.metallic_factor)?,
            roughness: self.value(metal_rough, Channel::Green, pbr.roughness_factor)?,
        });
        if let Some(ior) = all.ior.as_ref().map(|extension| f64::from(extension.ior)) {
            if ior == 0.0 || ior >= 1.0 {
                layered.ior = ior;
            } else {
                self.warn("its index of refraction is below 1; 1.5 is used");
            }
        }
        self.read_layers(description, &mut layered)?;
        self.read_transmission(description, &mut layered)?;
        Ok(layered)
    }

    /// Reads the layers over the base: specular, clearcoat, sheen, anisotropy.
    fn read_layers(&mut self, description: &MaterialJson, layered: &mut LayeredSurface) -> Result<(), LoadError> {
        let all = &description.extensions;
        if let Some(specular) = &all.specular {
            layered.specular =
                self.value(specular.specular_texture.as_ref(), Channel::Alpha, specular.specular_factor)?;
            let color = rgb(specular.specular_color_factor);
            layered.specular_color = self.color(specular.specular_color_texture.as_ref(), color)?;
        }
        if let Some(coat) = &all.clearcoat {
            layered.clearcoat = self.value(coat.clearcoat_texture.as_ref(), Channel::Red, coat.clearcoat_factor)?;
            let roughness = coat.clearcoat_roughness_texture.as_ref();
            layered.clearcoat_roughness = self.value(roughness, Channel::Green, coat.clearcoat_roughness_factor)?;
            layered.clearcoat_normal_map = self.normal_map(coat.clearcoat_normal_texture.as_ref())?;
        }
        if let Some(sheen) = &all.sheen {
            layered.sheen_color = self.color(sheen.sheen_color_texture.as_ref(), rgb(sheen.sheen_color_factor))?;
            let roughness = sheen.sheen_roughness_texture.as_ref();
            layered.sheen_roughness = self.value(roughness, Channel::Alpha, sheen.sheen_roughness_factor)?;
        }
        if let Some(anisotropy) = &all.anisotropy {
            let texture = anisotropy.anisotropy_texture.as_ref();
            layered.anisotropy = self.value(texture, Channel::Blue, anisotropy.anisotropy_strength)?;
            layered.anisotropy_rotation = f64::from(anisotropy.anisotropy_rotation);
            layered.anisotropy_direction = self.texture(texture, PixelEncoding::Numbers)?;
        }
        Ok(())
    }

    /// Reads transmission, volume and dispersion.
    fn read_transmission(&mut self, description: &MaterialJson, layered: &mut LayeredSurface) -> Result<(), LoadError> {
        let all = &description.extensions;
        if let Some(transmission) = &all.transmission {
            let texture = transmission.transmission_texture.as_ref();
            layered.transmission = self.value(texture, Channel::Red, transmission.transmission_factor)?;
        }
        layered.is_thin = all.volume.as_ref().is_none_or(|volume| !has_thickness(volume));
        layered.dispersion = all.dispersion.as_ref().map_or(0.0, |d| f64::from(d.dispersion.max(0.0)));
        let has_layers =
            all.clearcoat.is_some() || all.sheen.is_some() || all.specular.is_some() || all.anisotropy.is_some();
        if !layered.is_thin && !layered.transmission.is_zero() && has_layers {
            self.warn(
                "the transmissive part of a solid (KHR_materials_volume) is plain glass: clearcoat, sheen, specular and anisotropy \
                 apply to the rest",
            );
        }
        Ok(())
    }

    /// Reads KHR_materials_pbrSpecularGlossiness.
    ///
    /// The base colour is the sum of both colours: metals have a black diffuse colour.
    fn specular_glossiness(&mut self, other: &SpecularGlossiness) -> Result<LayeredBase, LoadError> {
        let (diffuse_factor, specular_factor) = (opaque(other.diffuse_factor), rgb(other.specular_factor));
        let shine = other.specular_glossiness_texture.as_ref();
        let diffuse = self.tinted(other.diffuse_texture.as_ref(), diffuse_factor)?;
        let mut base = LayeredBase::SpecularGlossiness {
            diffuse,
            specular: self.color(shine, specular_factor)?,
            glossiness: self.glossiness(shine, other.glossiness_factor)?,
            base_color: diffuse,
            mean_specular: specular_factor,
        };
        let Some(info) = shine else { return Ok(base) };
        let Some(shine) = self.textures.bitmap(info, PixelEncoding::Colors, self.place, self.model)? else {
            return Ok(base);
        };
        let matt = match &other.diffuse_texture {
            Some(info) => self.textures.bitmap(info, PixelEncoding::Colors, self.place, self.model)?,
            None => None,
        };
        let matt = matt.unwrap_or_else(|| Arc::new(Bitmap::opaque(1, 1, vec![[1.0; 3]])));
        let bitmap = sum_of(&matt, diffuse_factor, &shine, specular_factor);
        self.textures.count(&bitmap)?;
        // The sum has the pixels of the diffuse image if there are several, and is read at its coordinates.
        let info = other.diffuse_texture.as_ref().filter(|_| matt.pixels.len() > 1).unwrap_or(info);
        let sum = self.textures.replaced(info, Arc::new(bitmap), self.sets);
        let id = self.model.add_texture(sum);
        let sum = self.times_vertex_colors(ColorTexture::Textured(id, Rgb::WHITE));
        if let LayeredBase::SpecularGlossiness { base_color, mean_specular, .. } = &mut base {
            *base_color = sum;
            *mean_specular = specular_factor * shine.approximate_mean();
        }
        Ok(base)
    }

    /// Reads glossiness, which is the alpha of an image of colours.
    fn glossiness(&mut self, info: Option<&TextureInfo>, factor: f32) -> Result<FloatTexture, LoadError> {
        let factor = f64::from(factor).clamp(0.0, 1.0);
        let Some(texture) = self.texture(info, PixelEncoding::Colors)? else {
            return Ok(FloatTexture::Constant(factor));
        };
        Ok(FloatTexture::textured(&self.model.textures, texture, Channel::Alpha, factor))
    }

    fn alpha(&mut self, description: &MaterialJson, is_transmissive: bool) -> Result<Alpha, LoadError> {
        let is_unlit = description.extensions.unlit.is_some();
        let gloss = description.extensions.specular_glossiness.as_ref().filter(|_| !is_unlit);
        let pbr = &description.pbr_metallic_roughness;
        let (info, factor) = match gloss {
            Some(other) => (other.diffuse_texture.as_ref(), other.diffuse_factor[3]),
            None => (pbr.base_color_texture.as_ref(), pbr.base_color_factor[3]),
        };
        let mode = match description.alpha_mode {
            material_json::AlphaMode::Opaque => AlphaMode::Opaque,
            material_json::AlphaMode::Mask => AlphaMode::Mask(f64::from(description.alpha_cutoff)),
            material_json::AlphaMode::Blend => AlphaMode::Blend,
        };
        let texture = if mode == AlphaMode::Opaque { None } else { self.texture(info, PixelEncoding::Colors)? };
        let texture = texture
            .filter(|id| self.model.textures[id.0 as usize].bitmap().is_some_and(|bitmap| !bitmap.alpha.is_empty()));
        let factor = f64::from(factor).clamp(0.0, 1.0);
        // A blended surface without translucent parts is opaque, which is faster to trace.
        let is_whole = texture.is_none() && !self.has_colors && factor == 1.0;
        let mode = if is_whole && mode == AlphaMode::Blend { AlphaMode::Opaque } else { mode };
        // Light leaves a transmissive solid through the back of its surface.
        let culls_back_faces = !description.double_sided && !is_transmissive;
        Ok(Alpha { mode, factor, texture, culls_back_faces })
    }

    /// Reads occlusion, 1 + strength · (texture − 1). A strength below 1 is applied to a copy of the texture.
    fn occlusion(&mut self, info: &TextureInfo) -> Result<FloatTexture, LoadError> {
        let whole = FloatTexture::Constant(1.0);
        let Some(texture) = self.texture(Some(info), PixelEncoding::Numbers)? else { return Ok(whole) };
        let strength = info.strength.clamp(0.0, 1.0);
        if strength == 1.0 {
            return Ok(FloatTexture::textured(&self.model.textures, texture, Channel::Red, 1.0));
        }
        let faded = |bitmap: &Bitmap| {
            let pixels = bitmap.pixels.iter().map(|pixel| [1.0 + strength * (pixel[0] - 1.0); 3]).collect();
            Arc::new(Bitmap::opaque(bitmap.width, bitmap.height, pixels))
        };
        let texture = match self.model.textures[texture.0 as usize].clone() {
            Texture::Image { bitmap, wrap, smooth } => Texture::Image { bitmap: faded(&bitmap), wrap, smooth },
            Texture::Mapped { texture, map } => match &*texture {
                Texture::Image { bitmap, wrap, smooth } => {
                    let (wrap, smooth) = (*wrap, *smooth);
                    Texture::Mapped { texture: Arc::new(Texture::Image { bitmap: faded(bitmap), wrap, smooth }), map }
                }
                _ => return Ok(whole),
            },
            _ => return Ok(whole),
        };
        if let Some(bitmap) = texture.bitmap() {
            self.textures.count(bitmap)?;
        }
        let texture = self.model.add_texture(texture);
        Ok(FloatTexture::textured(&self.model.textures, texture, Channel::Red, 1.0))
    }

    fn texture(&mut self, info: Option<&TextureInfo>, pixels: PixelEncoding) -> Result<Option<TextureId>, LoadError> {
        match info {
            Some(info) => self.textures.texture(info, pixels, self.sets, self.place, self.model),
            None => Ok(None),
        }
    }

    fn normal_map(&mut self, info: Option<&TextureInfo>) -> Result<Option<NormalMap>, LoadError> {
        let scale = info.map_or(1.0, |info| f64::from(info.scale));
        Ok(self.texture(info, PixelEncoding::Numbers)?.map(|texture| NormalMap { texture, scale }))
    }

    fn color(&mut self, info: Option<&TextureInfo>, factor: Rgb) -> Result<ColorTexture, LoadError> {
        let texture = if factor.is_black() { None } else { self.texture(info, PixelEncoding::Colors)? };
        Ok(texture.map_or(ColorTexture::Constant(factor), |texture| ColorTexture::Textured(texture, factor)))
    }

    /// Reads a colour, which vertex colours multiply, if there are any.
    fn tinted(&mut self, info: Option<&TextureInfo>, factor: Rgb) -> Result<ColorTexture, LoadError> {
        let color = self.color(info, factor)?;
        Ok(self.times_vertex_colors(color))
    }

    /// A colour multiplied by vertex colours, if there are any.
    fn times_vertex_colors(&mut self, color: ColorTexture) -> ColorTexture {
        if !self.has_colors || color.factor().is_black() {
            return color;
        }
        let below = match color {
            ColorTexture::Constant(_) => None,
            ColorTexture::Textured(id, _) => Some(Arc::new(self.model.textures[id.0 as usize].clone())),
        };
        ColorTexture::Textured(self.model.add_texture(Texture::VertexColor(below)), color.factor())
    }

    fn value(&mut self, info: Option<&TextureInfo>, channel: Channel, factor: f32) -> Result<FloatTexture, LoadError> {
        let factor = f64::from(factor).clamp(0.0, 1.0);
        let info = info.filter(|_| factor > 0.0);
        let Some(texture) = self.texture(info, PixelEncoding::Numbers)? else {
            return Ok(FloatTexture::Constant(factor));
        };
        Ok(FloatTexture::textured(&self.model.textures, texture, channel, factor))
    }
}

fn has_thickness(volume: &Volume) -> bool {
    volume.thickness_factor > 0.0
}

/// Medium of a solid. Metallic surfaces transmit no light, and have no medium.
fn interior(layered: &LayeredSurface, volume: Option<&Volume>) -> Option<InteriorMedium> {
    let volume = volume.filter(|volume| has_thickness(volume))?;
    let LayeredBase::MetallicRoughness { metallic, .. } = &layered.base else { return None };
    if layered.transmission.is_zero() || layered.transmission.mean() * (1.0 - metallic.mean()) <= 0.0 {
        return None;
    }
    let distance = f64::from(volume.attenuation_distance);
    let color = rgb(volume.attenuation_color).map(|c| c.min(1.0));
    Some(InteriorMedium { absorption: absorption(distance, color), ..InteriorMedium::clear(layered.ior.max(1.0)) })
}

/// Absorption per length: light falls to `color` over `distance` (KHR_materials_volume).
fn absorption(distance: f64, color: Rgb) -> Rgb {
    if distance <= 0.0 {
        return Rgb::BLACK;
    }
    // A black colour would make the absorption infinite.
    color.map(|part| (-transcendental::log(part.max(1e-6)) / distance).max(0.0))
}

/// Diffuse colour plus what the specular colour has above the 4 % of a dielectric, at the resolution of the diffuse
/// colour.
fn sum_of(matt: &Bitmap, diffuse: Rgb, shine: &Bitmap, specular: Rgb) -> Bitmap {
    let (width, height) = if matt.pixels.len() == 1 { (shine.width, shine.height) } else { (matt.width, matt.height) };
    let nearest = |bitmap: &Bitmap, x: u32, y: u32| {
        let scaled = |i: u32, to: u32, from: u32| u64::from(i) * u64::from(to) / u64::from(from);
        let (x, y) = (scaled(x, bitmap.width, width), scaled(y, bitmap.height, height));
        rgb(bitmap.pixels[(y * u64::from(bitmap.width) + x) as usize])
    };
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| {
        let metal = (nearest(shine, x, y) * specular).map(|c| (c - 0.04).max(0.0));
        (nearest(matt, x, y) * diffuse + metal).to_array().map(|c| c.min(1.0) as f32)
    });
    Bitmap::opaque(width, height, pixels.collect())
}

fn opaque([r, g, b, _]: [f32; 4]) -> Rgb {
    rgb([r, g, b])
}

/// A colour without negative or infinite components.
fn rgb(colour: [f32; 3]) -> Rgb {
    Rgb::from(colour.map(f64::from)).map(|c| if c.is_finite() { c.max(0.0) } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn media_absorb_to_the_attenuation_color() {
        let absorption = absorption(2.0, Rgb::new(1.0, 0.5, 0.0));
        let left = absorption.map(|a| transcendental::exp(-2.0 * a));
        assert!((left.r - 1.0).abs() < 1e-12 && (left.g - 0.5).abs() < 1e-12 && left.b < 1e-5, "{left:?}");
    }

    #[test]
    fn the_colour_of_metals_is_added_to_the_diffuse_colour() {
        let matt = Bitmap::opaque(2, 1, vec![[0.5; 3], [0.0; 3]]);
        let shine = Bitmap::opaque(1, 2, vec![[0.04, 0.54, 1.0], [0.0; 3]]);
        let sum = sum_of(&matt, Rgb::WHITE, &shine, Rgb::WHITE);
        assert_eq!((sum.width, sum.height), (2, 1));
        assert_eq!(sum.pixels, [[0.5, 1.0, 1.0], [0.0, 0.5, 0.96]]);
    }
}
