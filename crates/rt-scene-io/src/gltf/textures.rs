//! Textures of a document, made when first used. Images are decoded once for each meaning of their pixels.

use std::{collections::HashMap, sync::Arc};

use gltf::{
    Document,
    texture::{MagFilter, Sampler, WrappingMode},
};
use rt_math::transcendental::sincos;
use rt_shading::{Bitmap, Texture, TextureId, UvMap, Wrap};

use super::{
    buffers::{Buffers, fetch},
    material_json::{TextureInfo, TextureTransform},
};
use crate::error::ErrorAt;
pub(super) use crate::texture::PixelEncoding;
use crate::{LoadError, LoadErrorKind, LoadOptions, Model, Warning, limits, texture::decode_within};

/// The slots of texture coordinates that meshes of a material have: which of the document's sets each holds.
pub(super) type UvSets = [Option<u32>; 2];

/// Two references with the same key are one texture.
type TextureKey = (usize, Option<usize>, PixelEncoding, bool, [u64; 6]);

pub(super) struct GltfTextures<'a> {
    pub(super) document: &'a Document,
    buffers: &'a Buffers<'a>,
    options: &'a LoadOptions,
    /// By index of the image; `None` for missing ones.
    images: HashMap<(usize, PixelEncoding), Option<Arc<Bitmap>>>,
    known: HashMap<TextureKey, TextureId>,
    bytes: u64,
}

impl<'a> GltfTextures<'a> {
    pub(super) fn new(document: &'a Document, buffers: &'a Buffers<'a>, options: &'a LoadOptions) -> Self {
        Self { document, buffers, options, images: HashMap::new(), known: HashMap::new(), bytes: 0 }
    }

    /// Texture of a reference at `place`; `None`, with a warning, without a readable image.
    pub(super) fn texture(
        &mut self,
        info: &TextureInfo,
        pixels: PixelEncoding,
        sets: UvSets,
        place: &str,
        model: &mut Model,
    ) -> Result<Option<TextureId>, LoadError> {
        let Some(bitmap) = self.bitmap(info, pixels, place, model)? else { return Ok(None) };
        let Some(texture) = self.document.textures().nth(info.index) else { return Ok(None) };
        let sampler = texture.sampler();
        let map = uv_map(info, sets);
        let image = texture_source(self.document, info.index).unwrap_or_default();
        let [a, b] = map.rows.map(|row| row.map(f64::to_bits));
        let key = (image, sampler.index(), pixels, map.is_second, [a[0], a[1], a[2], b[0], b[1], b[2]]);
        if let Some(&known) = self.known.get(&key) {
            return Ok(Some(known));
        }
        let id = model.add_texture(mapped(image_texture(bitmap, Some(&sampler)), map));
        self.known.insert(key, id);
        Ok(Some(id))
    }

    /// Texture of an image that replaces the one of a reference, with its sampler and map.
    pub(super) fn replaced(&self, info: &TextureInfo, bitmap: Arc<Bitmap>, sets: UvSets) -> Texture {
        let sampler = self.document.textures().nth(info.index).map(|texture| texture.sampler());
        mapped(image_texture(bitmap, sampler.as_ref()), uv_map(info, sets))
    }

    /// The image of a reference; `None`, with a warning, if it cannot be read.
    pub(super) fn bitmap(
        &mut self,
        info: &TextureInfo,
        pixels: PixelEncoding,
        place: &str,
        model: &mut Model,
    ) -> Result<Option<Arc<Bitmap>>, LoadError> {
        let count = self.document.as_json().textures.len();
        if info.index >= count {
            let reason =
                LoadErrorKind::invalid(info.index, format!("is not the index of a texture; there are {count}"));
            return Err(reason.at(self.buffers.path(), place));
        }
        let Some(image) = texture_source(self.document, info.index) else {
            let message = "has no image that can be read; the plain colour is used".to_owned();
            model.warnings.push(Warning { place: format!("textures[{}]", info.index), message });
            return Ok(None);
        };
        if let Some(known) = self.images.get(&(image, pixels)) {
            return Ok(known.clone());
        }
        let bitmap = self.decoded(image, pixels, model)?.map(Arc::new);
        if let Some(bitmap) = &bitmap {
            self.count(bitmap)?;
        }
        self.images.insert((image, pixels), bitmap.clone());
        Ok(bitmap)
    }

    /// Decodes an image. A missing one is a warning; a damaged one is an error.
    fn decoded(&self, index: usize, pixels: PixelEncoding, model: &mut Model) -> Result<Option<Bitmap>, LoadError> {
        let path = self.buffers.path();
        let place = format!("images[{index}]");
        let what = format!("image {index} of {}", path.display());
        let decode = |bytes: &[u8]| decode_within(bytes, pixels, &what, &self.options.memory);
        let image = &self.document.as_json().images[index];
        let decoded = match (&image.uri, image.buffer_view) {
            (Some(uri), _) => match fetch(uri, path, self.options) {
                Err(missing @ LoadErrorKind::MissingReference { .. }) => {
                    let message = format!("{missing}; the plain colour is used");
                    model.warn(place, message);
                    return Ok(None);
                }
                bytes => decode(&bytes.at(path, place.clone())?),
            },
            (None, Some(view)) => match self.document.views().nth(view.value()) {
                Some(view) => decode(self.buffers.view(&view)?),
                None => return Ok(None),
            },
            (None, None) => {
                return Err(LoadErrorKind::Syntax("has neither uri nor bufferView".to_owned()).at(path, place));
            }
        };
        decoded.map(Some).at(path, place)
    }

    /// Adds a bitmap that is kept to the memory of all textures.
    pub(super) fn count(&mut self, bitmap: &Bitmap) -> Result<(), LoadError> {
        self.bytes += bitmap.memory() as u64;
        let (what, limit) = ("the memory of all textures in bytes", limits::MODEL_TEXTURE_BYTES);
        LoadErrorKind::check_limit(what, self.bytes, limit).at(self.buffers.path(), "")
    }

    /// The file, for messages.
    pub(super) const fn path(&self) -> &'a std::path::Path {
        self.buffers.path()
    }
}

/// The image of a texture; extensions may bring formats of their own and leave it out.
fn texture_source(document: &Document, texture: usize) -> Option<usize> {
    let json = document.as_json();
    let image = json.textures.get(texture)?.source.value();
    (image < json.images.len()).then_some(image)
}

/// Map from the texture coordinates of meshes to those of a reference.
fn uv_map(info: &TextureInfo, sets: UvSets) -> UvMap {
    UvMap { is_second: sets[1] == Some(info.uv_set()), rows: rows(info.extensions.transform.as_ref()) }
}

fn mapped(texture: Texture, map: UvMap) -> Texture {
    if map == UvMap::IDENTITY { texture } else { Texture::Mapped { texture: Arc::new(texture), map } }
}

/// Texture of an image with the modes of a sampler; it repeats without one.
fn image_texture(bitmap: Arc<Bitmap>, sampler: Option<&Sampler<'_>>) -> Texture {
    let wrap = sampler.map_or([WrappingMode::Repeat; 2], |s| [s.wrap_s(), s.wrap_t()]).map(|mode| match mode {
        WrappingMode::Repeat => Wrap::Repeat,
        WrappingMode::MirroredRepeat => Wrap::Mirror,
        WrappingMode::ClampToEdge => Wrap::Clamp,
    });
    let smooth = sampler.and_then(Sampler::mag_filter) != Some(MagFilter::Nearest);
    Texture::Image { bitmap, wrap, smooth }
}

/// KHR_texture_transform maps coordinates with v downwards: first the scale, then the rotation, counter-clockwise as seen in
/// the image, then the offset. Ours have v upwards, on both ends.
fn rows(transform: Option<&TextureTransform>) -> [[f64; 3]; 2] {
    let Some(transform) = transform else { return UvMap::IDENTITY.rows };
    let (sin, cos) = sincos(f64::from(transform.rotation));
    let [scale_u, scale_v] = transform.scale.map(f64::from);
    let [offset_u, offset_v] = transform.offset.map(f64::from);
    let ([a, b], [c, d]) = ([cos * scale_u, sin * scale_v], [-sin * scale_u, cos * scale_v]);
    [[a, -b, b + offset_u], [-c, d, 1.0 - d - offset_v]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::FRAC_PI_2;

    #[test]
    fn texture_coordinates_are_scaled_turned_moved_and_flipped() {
        let transform = TextureTransform {
            offset: [0.5, 0.25],
            rotation: FRAC_PI_2,
            scale: [2.0, 4.0],
            ..TextureTransform::default()
        };
        let [u, v] = rows(Some(&transform)).map(|[a, b, c]| a * 1.0 + b * 1.0 + c);
        // (1, 0) of the file, our (1, 1), is scaled to (2, 0); a quarter turn counter-clockwise, with v downwards, takes it to
        // (0, −2), and the offset to (0.5, −1.75): our (0.5, 2.75).
        assert!((u - 0.5).abs() < 1e-6 && (v - 2.75).abs() < 1e-6, "{u} {v}");
        assert_eq!(rows(Some(&TextureTransform::default())), UvMap::IDENTITY.rows);
        assert_eq!(rows(None), UvMap::IDENTITY.rows);
    }
}
