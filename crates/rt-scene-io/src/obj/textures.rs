//! The images of material libraries: each is decoded once for each meaning of its pixels.

use std::{
    collections::HashMap,
    path::{Path, PathBuf},
    sync::Arc,
};

use rt_shading::{Bitmap, Channel, Texture, TextureId, Wrap};

use super::{bump_to_normal, texture_map::TextureMap};
use crate::error::ErrorAt;
use crate::{
    LoadError, LoadErrorKind, LoadOptions, Model,
    files::{is_absolute, read_texture_as, resolve_path},
    limits,
    texture::PixelEncoding,
};

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum PixelMeaning {
    Colors,
    /// Numbers, such as how rough the surface is.
    Numbers,
    /// Alpha: that of the image, or else its red channel, unless specified.
    Alpha(Option<Channel>),
    /// Normals along the tangents, or heights if all of its pixels are grey.
    NormalMap,
}

pub(super) struct ObjTextures<'a> {
    options: &'a LoadOptions,
    /// By file, clamping, reversed axes of normals, and meaning.
    known: HashMap<(PathBuf, bool, [bool; 2], PixelMeaning), TextureId>,
    bytes: u64,
}

impl<'a> ObjTextures<'a> {
    pub(super) fn new(options: &'a LoadOptions) -> Self {
        Self { options, known: HashMap::new(), bytes: 0 }
    }

    /// The texture of a map in the library `file`. A missing image is a warning; a damaged one is an error.
    pub(super) fn texture(
        &mut self,
        map: &TextureMap,
        meaning: PixelMeaning,
        file: &Path,
        material: &str,
        model: &mut Model,
    ) -> Result<Option<TextureId>, LoadError> {
        let place = format!("material `{material}`");
        let mut warn = |message| {
            let place = format!("{}: {place}", file.display());
            model.warn(place, message);
        };
        for option in &map.ignored {
            warn(format!("the texture option `{option}` of `{}` is not supported", map.file));
        }
        let instead = match meaning {
            PixelMeaning::Colors => "the plain colour is used",
            PixelMeaning::Numbers => "the plain number is used",
            PixelMeaning::Alpha(_) => "the surface is opaque",
            PixelMeaning::NormalMap => "the surface is smooth",
        };
        // Absolute paths are those of another machine.
        if is_absolute(&map.file) {
            warn(format!("the path of the image `{}` is absolute; {instead}", map.file));
            return Ok(None);
        }
        let image = match resolve_path(&map.file, file, self.options) {
            Ok(image) if image.is_dir() => {
                return Err(LoadErrorKind::bad_reference(&map.file, LoadErrorKind::Directory).at(file, place));
            }
            Ok(image) => image,
            Err(LoadErrorKind::MissingReference { .. }) => {
                warn(format!("the image `{}` does not exist; {instead}", map.file));
                return Ok(None);
            }
            Err(reason) => return Err(reason.at(file, place)),
        };
        // Normals are along the coordinates of the mesh, not of the map.
        let mirrored = map.scale.map(|scale| meaning == PixelMeaning::NormalMap && scale < 0.0);
        let id = self.image(image, (map.clamp, mirrored), meaning, model)?;
        if map.has_own_coordinates() {
            let Some(texture) = model.textures.get(id.0 as usize).cloned().map(Arc::new) else { return Ok(None) };
            return Ok(Some(model.add_texture(Texture::Mapped { texture, map: map.coordinates() })));
        }
        Ok(Some(id))
    }

    fn image(
        &mut self,
        file: PathBuf,
        (clamp, mirrored): (bool, [bool; 2]),
        meaning: PixelMeaning,
        model: &mut Model,
    ) -> Result<TextureId, LoadError> {
        let key = (file, clamp, mirrored, meaning);
        if let Some(&known) = self.known.get(&key) {
            return Ok(known);
        }
        let file = &key.0;
        let mut bitmap = self.decoded(file, clamp, meaning).at(file, "")?;
        for (axis, _) in mirrored.iter().enumerate().filter(|(_, mirrored)| **mirrored) {
            bitmap.pixels.iter_mut().for_each(|pixel| pixel[axis] = 1.0 - pixel[axis]);
        }
        self.bytes += bitmap.memory() as u64;
        let (what, limit) = ("the memory of all textures in bytes", limits::MODEL_TEXTURE_BYTES);
        LoadErrorKind::check_limit(what, self.bytes, limit).at(file, "")?;
        let wrap = [if clamp { Wrap::Clamp } else { Wrap::Repeat }; 2];
        let id = model.add_texture(Texture::Image { bitmap: Arc::new(bitmap), wrap, smooth: true });
        self.known.insert(key, id);
        Ok(id)
    }

    fn decoded(&self, file: &Path, clamp: bool, meaning: PixelMeaning) -> Result<Bitmap, LoadErrorKind> {
        let pixels = if meaning == PixelMeaning::Colors { PixelEncoding::Colors } else { PixelEncoding::Numbers };
        let mut bitmap = read_texture_as(file, pixels, self.options)?;
        match meaning {
            PixelMeaning::Colors | PixelMeaning::Numbers => {}
            PixelMeaning::Alpha(channel) => {
                let more = format_args!("the texture {}", file.display());
                self.options.memory.keep(more, (bitmap.pixels.len() * size_of::<f32>()) as u64)?;
                cover(&mut bitmap, channel);
            }
            PixelMeaning::NormalMap if bump_to_normal::is_height(&bitmap) => {
                bump_to_normal::normals_from_heights(&mut bitmap, clamp)
            }
            PixelMeaning::NormalMap => {}
        }
        Ok(bitmap)
    }
}

/// Computes alpha from the pixels.
fn cover(bitmap: &mut Bitmap, channel: Option<Channel>) {
    let part = match channel {
        None if bitmap.alpha.is_empty() => 0,
        None | Some(Channel::Alpha) => return,
        Some(Channel::Red) => 0,
        Some(Channel::Green) => 1,
        Some(Channel::Blue) => 2,
    };
    bitmap.alpha = bitmap.pixels.iter().map(|pixel| pixel[part].clamp(0.0, 1.0)).collect();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opacity_is_alpha_or_the_requested_channel() {
        let grey = Bitmap::opaque(2, 1, vec![[0.25, 0.5, 0.75], [2.0, 0.0, 1.0]]);
        let of = |bitmap: &Bitmap, channel| {
            let mut bitmap = bitmap.clone();
            cover(&mut bitmap, channel);
            bitmap.alpha
        };
        assert_eq!(of(&grey, None), [0.25, 1.0]);
        assert_eq!(of(&grey, Some(Channel::Blue)), [0.75, 1.0]);
        assert_eq!(of(&grey, Some(Channel::Alpha)), [0.0; 0], "there is none: the surface is whole");
        let cut = Bitmap { alpha: vec![0.0, 1.0], ..grey };
        assert_eq!(of(&cut, None), [0.0, 1.0]);
        assert_eq!(of(&cut, Some(Channel::Green)), [0.5, 0.0]);
    }
}
