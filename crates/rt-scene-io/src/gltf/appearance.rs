//! Materials and textures of a document, made when first used.

use std::collections::HashMap;

use gltf::{
    Document, Material,
    material::AlphaMode,
    texture::{Info, MagFilter, WrappingMode},
};
use rt_math::{Rgb, transcendental::pow};
use rt_shading::{Bitmap, Material as Named, Texture, TextureId, Wrap};

use super::{
    buffers::{Buffers, fetch},
    material::{Surface, Tint},
    primitive::UvSource,
};
use crate::{LoadError, LoadOptions, MaterialId, Model, Reason, Warning, decode_texture};

/// Most memory that all textures of a model may take.
const MAX_TEXTURE_BYTES: u64 = 1 << 32;

/// A material as primitives need it.
#[derive(Clone, Copy, Debug)]
pub(super) struct UsedMaterial {
    pub(super) id: MaterialId,
    /// Where its textures are read.
    pub(super) uv_source: Option<UvSource>,
}

pub(super) struct Appearance<'a> {
    document: &'a Document,
    buffers: &'a Buffers<'a>,
    options: &'a LoadOptions,
    materials: HashMap<Option<usize>, UsedMaterial>,
    /// By image and sampler; `None` for images that are not there.
    textures: HashMap<(usize, Option<usize>), Option<TextureId>>,
    texture_bytes: u64,
}

impl<'a> Appearance<'a> {
    pub(super) fn new(document: &'a Document, buffers: &'a Buffers<'a>, options: &'a LoadOptions) -> Self {
        let (materials, textures) = (HashMap::new(), HashMap::new());
        Self { document, buffers, options, materials, textures, texture_bytes: 0 }
    }

    pub(super) fn material(&mut self, material: &Material<'_>, model: &mut Model) -> Result<UsedMaterial, LoadError> {
        if let Some(&known) = self.materials.get(&material.index()) {
            return Ok(known);
        }
        let surface = self.surface(material, model)?;
        let name = material.name().unwrap_or(if material.index().is_some() { "unnamed" } else { "default" });
        let id = MaterialId(model.materials.len() as u32);
        model.materials.push(Named { name: name.to_owned(), phong: surface.phong() });
        let base = material
            .pbr_specular_glossiness()
            .map_or_else(|| material.pbr_metallic_roughness().base_color_texture(), |model| model.diffuse_texture());
        let (base, emission) = (base.map(|t| UvSource::of(&t)), material.emissive_texture().map(|t| UvSource::of(&t)));
        if base.is_some() && emission.is_some() && base != emission && surface.emission.texture.is_some() {
            warn(material, "the emissive texture is read where the base colour is, not at its own coordinates", model);
        }
        let used = UsedMaterial { id, uv_source: base.or(emission) };
        self.materials.insert(material.index(), used);
        Ok(used)
    }

    fn surface(&mut self, material: &Material<'_>, model: &mut Model) -> Result<Surface, LoadError> {
        let pbr = material.pbr_metallic_roughness();
        let emissive = rgb(material.emissive_factor()) * f64::from(material.emissive_strength().unwrap_or(1.0));
        let mut surface = Surface {
            base: self.tint(pbr.base_color_texture(), opaque(pbr.base_color_factor()), model)?,
            emission: self.tint(material.emissive_texture(), emissive, model)?,
            metallic: f64::from(pbr.metallic_factor()),
            roughness: f64::from(pbr.roughness_factor()),
            ior: material.ior().map(f64::from).filter(|ior| *ior > 0.0).unwrap_or(1.5),
            specular: specular_tint(material),
            transmission: material.transmission().map_or(0.0, |t| f64::from(t.transmission_factor())),
            unlit: material.unlit(),
        };
        if surface.unlit {
            return Ok(surface);
        }
        if let Some(bitmap) = self.mean_of(pbr.metallic_roughness_texture(), model)? {
            // The channels hold numbers, not colours: the decoding of sRGB is undone.
            surface.roughness *= encoded(bitmap.g);
            surface.metallic *= encoded(bitmap.b);
            warn(material, "metalness and roughness are the same everywhere: the mean of their texture", model);
        }
        if let Some(other) = material.pbr_specular_glossiness() {
            let diffuse = self.tint(other.diffuse_texture(), opaque(other.diffuse_factor()), model)?;
            let mean = self.mean_of(other.specular_glossiness_texture(), model)?;
            let specular = rgb(other.specular_factor()) * mean.unwrap_or(Rgb::WHITE);
            surface = surface.with_specular_glossiness(diffuse, specular, f64::from(other.glossiness_factor()));
        }
        for (what, present) in [
            ("the normal texture is not followed", material.normal_texture().is_some()),
            ("the occlusion texture is not followed", material.occlusion_texture().is_some()),
            ("the alpha channel is not followed: it is drawn opaque", material.alpha_mode() != AlphaMode::Opaque),
        ] {
            if present {
                warn(material, what, model);
            }
        }
        Ok(surface)
    }

    fn tint(&mut self, info: Option<Info<'_>>, colour: Rgb, model: &mut Model) -> Result<Tint, LoadError> {
        let texture = match info {
            Some(info) if !colour.is_black() => self.texture(&info, model)?,
            _ => None,
        };
        Ok(Tint { texture, colour })
    }

    fn texture(&mut self, info: &Info<'_>, model: &mut Model) -> Result<Option<TextureId>, LoadError> {
        let sampler = info.texture().sampler();
        let Some(image) = self.image_of(info) else {
            let message = "has no image that can be read; the plain colour is used".to_owned();
            model.warnings.push(Warning { place: format!("textures[{}]", info.texture().index()), message });
            return Ok(None);
        };
        let key = (image, sampler.index());
        if let Some(&known) = self.textures.get(&key) {
            return Ok(known);
        }
        let id = self.bitmap(image, model)?.map(|bitmap| {
            let wrap = [sampler.wrap_s(), sampler.wrap_t()].map(|mode| match mode {
                WrappingMode::Repeat => Wrap::Repeat,
                WrappingMode::MirroredRepeat => Wrap::Mirror,
                WrappingMode::ClampToEdge => Wrap::Clamp,
            });
            let smooth = sampler.mag_filter() != Some(MagFilter::Nearest);
            model.textures.push(Texture::Image { bitmap, wrap, smooth });
            TextureId(model.textures.len() as u32 - 1)
        });
        self.textures.insert(key, id);
        Ok(id)
    }

    /// The image of a texture; extensions may bring formats of their own and leave it out.
    fn image_of(&self, info: &Info<'_>) -> Option<usize> {
        let json = self.document.as_json();
        let image = json.textures.get(info.texture().index())?.source.value();
        (image < json.images.len()).then_some(image)
    }

    /// Decodes an image. One that is not there is a warning; a damaged one is an error.
    fn bitmap(&mut self, index: usize, model: &mut Model) -> Result<Option<Bitmap>, LoadError> {
        let path = self.buffers.path();
        let place = format!("images[{index}]");
        let image = &self.document.as_json().images[index];
        let decoded = match (&image.uri, image.buffer_view) {
            (Some(uri), _) => match fetch(uri, path, self.options) {
                Err(missing @ Reason::MissingReference { .. }) => {
                    let message = format!("{missing}; the plain colour is used");
                    model.warnings.push(Warning { place, message });
                    return Ok(None);
                }
                bytes => decode_texture(&bytes.map_err(|reason| reason.at(path, place.clone()))?),
            },
            (None, Some(view)) => match self.document.views().nth(view.value()) {
                Some(view) => decode_texture(self.buffers.view(&view)?),
                None => return Ok(None),
            },
            (None, None) => return Err(Reason::Syntax("has neither uri nor bufferView".to_owned()).at(path, place)),
        };
        let bitmap = decoded.map_err(|error| Reason::from(error).at(path, place))?;
        self.texture_bytes += size_of_val(bitmap.pixels.as_slice()) as u64;
        if self.texture_bytes > MAX_TEXTURE_BYTES {
            let (value, limit) = (self.texture_bytes, MAX_TEXTURE_BYTES);
            return Err(Reason::TooLarge { what: "the memory of all textures in bytes", value, limit }.at(path, ""));
        }
        Ok(Some(bitmap))
    }

    /// The mean colour of a texture, from at most some 4000 pixels; `None` without a texture.
    fn mean_of(&mut self, info: Option<Info<'_>>, model: &mut Model) -> Result<Option<Rgb>, LoadError> {
        let Some(image) = info.and_then(|info| self.image_of(&info)) else { return Ok(None) };
        let Some(bitmap) = self.bitmap(image, model)? else { return Ok(None) };
        self.texture_bytes -= size_of_val(bitmap.pixels.as_slice()) as u64;
        let step = (bitmap.pixels.len() / 4096).max(1);
        let (mut sum, mut count) = (Rgb::BLACK, 0.0);
        for pixel in bitmap.pixels.iter().step_by(step) {
            sum += rgb(*pixel);
            count += 1.0;
        }
        Ok(Some(sum / count))
    }
}

/// KHR_materials_specular, without its textures.
fn specular_tint(material: &Material<'_>) -> Rgb {
    let Some(extension) = material.extension_value("KHR_materials_specular") else { return Rgb::WHITE };
    let number = |value: &serde_json::Value| value.as_f64().filter(|n| n.is_finite() && *n >= 0.0);
    let factor = extension.get("specularFactor").and_then(number).unwrap_or(1.0);
    let channel = |i: usize| extension.get("specularColorFactor").and_then(|c| number(c.get(i)?)).unwrap_or(1.0);
    Rgb::new(channel(0), channel(1), channel(2)) * factor
}

fn warn(material: &Material<'_>, message: &str, model: &mut Model) {
    let place = match (material.name(), material.index()) {
        (Some(name), _) => format!("material `{name}`"),
        (None, index) => format!("materials[{}]", index.unwrap_or(0)),
    };
    model.warnings.push(Warning { place, message: message.to_owned() });
}

/// The sRGB-encoded value of linear light in [0, 1] (IEC 61966-2-1).
fn encoded(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * pow(linear, 1.0 / 2.4) - 0.055 }
}

fn opaque([r, g, b, _]: [f32; 4]) -> Rgb {
    rgb([r, g, b])
}

/// A colour without negative or infinite components.
fn rgb(colour: [f32; 3]) -> Rgb {
    Rgb::from(colour.map(f64::from)).map(|c| if c.is_finite() { c.max(0.0) } else { 0.0 })
}
