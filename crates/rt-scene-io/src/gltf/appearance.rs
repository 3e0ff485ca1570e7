//! Materials and textures of a document, made when first used.

use std::collections::HashMap;

use gltf::{
    Document, Material,
    material::{AlphaMode, PbrSpecularGlossiness},
    texture::{Info, MagFilter, Sampler, WrappingMode},
};
use rt_camera::Encoding;
use rt_math::Rgb;
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
        model
            .materials
            .push(Named { physical: Some(surface.physical()), ..Named::new(name.to_owned(), surface.phong()) });
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
        if let Some(bitmap) = self.untracked(pbr.metallic_roughness_texture(), model)? {
            // The channels hold numbers, not colours: the decoding of sRGB is undone.
            let mean = mean(&bitmap);
            surface.roughness *= Encoding::Srgb.encode(mean.g);
            surface.metallic *= Encoding::Srgb.encode(mean.b);
            warn(material, "metalness and roughness are the same everywhere: the mean of their texture", model);
        }
        if let Some(other) = material.pbr_specular_glossiness() {
            surface = self.specular_glossiness(surface, &other, model)?;
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

    /// KHR_materials_pbrSpecularGlossiness: metals have their colour in the specular texture and a black diffuse one, so
    /// the sum of both is the base colour.
    fn specular_glossiness(
        &mut self,
        surface: Surface,
        other: &PbrSpecularGlossiness<'_>,
        model: &mut Model,
    ) -> Result<Surface, LoadError> {
        let (diffuse, specular) = (opaque(other.diffuse_factor()), rgb(other.specular_factor()));
        let glossiness = f64::from(other.glossiness_factor());
        let Some(shine) = self.untracked(other.specular_glossiness_texture(), model)? else {
            let base = self.tint(other.diffuse_texture(), diffuse, model)?;
            return Ok(surface.with_specular_glossiness(base, specular, glossiness));
        };
        let matt = self.untracked(other.diffuse_texture(), model)?;
        let matt = matt.unwrap_or_else(|| Bitmap { width: 1, height: 1, pixels: vec![[1.0; 3]] });
        let specular_mean = specular * mean(&shine);
        let bitmap = sum_of(&matt, diffuse, &shine, specular);
        self.count(&bitmap)?;
        let sampler = other.diffuse_texture().or(other.specular_glossiness_texture()).map(|t| t.texture().sampler());
        let id = push_image(bitmap, sampler.as_ref(), model);
        let base = Tint { texture: Some(id), colour: Rgb::WHITE };
        Ok(surface.with_specular_glossiness(base, specular_mean, glossiness))
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
        let bitmap = self.bitmap(image, model)?;
        bitmap.iter().try_for_each(|bitmap| self.count(bitmap))?;
        let id = bitmap.map(|bitmap| push_image(bitmap, Some(&sampler), model));
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
        decoded.map(Some).map_err(|error| Reason::from(error).at(path, place))
    }

    /// Adds a bitmap that is kept to the memory of all textures.
    fn count(&mut self, bitmap: &Bitmap) -> Result<(), LoadError> {
        self.texture_bytes += size_of_val(bitmap.pixels.as_slice()) as u64;
        if self.texture_bytes > MAX_TEXTURE_BYTES {
            let (value, limit) = (self.texture_bytes, MAX_TEXTURE_BYTES);
            let reason = Reason::TooLarge { what: "the memory of all textures in bytes", value, limit };
            return Err(reason.at(self.buffers.path(), ""));
        }
        Ok(())
    }

    /// The pixels of a texture that is looked at, but not kept; `None` without a texture.
    fn untracked(&mut self, info: Option<Info<'_>>, model: &mut Model) -> Result<Option<Bitmap>, LoadError> {
        match info.and_then(|info| self.image_of(&info)) {
            Some(image) => self.bitmap(image, model),
            None => Ok(None),
        }
    }
}

fn push_image(bitmap: Bitmap, sampler: Option<&Sampler<'_>>, model: &mut Model) -> TextureId {
    let wrap = sampler.map_or([WrappingMode::Repeat; 2], |s| [s.wrap_s(), s.wrap_t()]).map(|mode| match mode {
        WrappingMode::Repeat => Wrap::Repeat,
        WrappingMode::MirroredRepeat => Wrap::Mirror,
        WrappingMode::ClampToEdge => Wrap::Clamp,
    });
    let smooth = sampler.and_then(Sampler::mag_filter) != Some(MagFilter::Nearest);
    model.textures.push(Texture::Image { bitmap, wrap, smooth });
    TextureId(model.textures.len() as u32 - 1)
}

/// The mean colour, from at most some 8000 pixels.
fn mean(bitmap: &Bitmap) -> Rgb {
    let step = (bitmap.pixels.len() / 4096).max(1);
    let (mut sum, mut count) = (Rgb::BLACK, 0.0);
    for pixel in bitmap.pixels.iter().step_by(step) {
        sum += rgb(*pixel);
        count += 1.0;
    }
    sum / count
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
    Bitmap { width, height, pixels: pixels.collect() }
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
    fn the_colour_of_metals_is_added_to_the_diffuse_colour() {
        let matt = Bitmap { width: 2, height: 1, pixels: vec![[0.5; 3], [0.0; 3]] };
        let shine = Bitmap { width: 1, height: 2, pixels: vec![[0.04, 0.54, 1.0], [0.0; 3]] };
        let sum = sum_of(&matt, Rgb::WHITE, &shine, Rgb::WHITE);
        assert_eq!((sum.width, sum.height), (2, 1));
        assert_eq!(sum.pixels, [[0.5, 1.0, 1.0], [0.0, 0.5, 0.96]]);
    }
}
