//! The images of material libraries: each is decoded once for each meaning of its pixels.

use std::{
    collections::HashMap,
    path::{Path, PathBuf},
    sync::Arc,
};

use rt_shading::{Bitmap, Channel, Texture, TextureId, Wrap};

use super::{map::Map, relief};
use crate::{
    LoadError, LoadOptions, Model, Reason, Warning,
    files::{is_absolute, read_texture_as, resolve_path},
    limits,
    texture::Pixels,
};

/// What the pixels of an image say.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Meaning {
    /// Colours.
    Colours,
    /// Numbers, such as how rough the surface is.
    Numbers,
    /// How much of the surface is there: alpha if the image has it, else its red part, unless the file says.
    Cover(Option<Channel>),
    /// Normals along the tangents, or heights if all of its pixels are grey.
    Relief,
}

pub(super) struct Textures<'a> {
    options: &'a LoadOptions,
    /// By file, whether it ends at its edge, and what it says.
    known: HashMap<(PathBuf, bool, Meaning), TextureId>,
    bytes: u64,
}

impl<'a> Textures<'a> {
    pub(super) fn new(options: &'a LoadOptions) -> Self {
        Self { options, known: HashMap::new(), bytes: 0 }
    }

    /// The texture of a map in the library `file`. An image that is not there is a warning; a damaged one is an error.
    pub(super) fn texture(
        &mut self,
        map: &Map,
        meaning: Meaning,
        file: &Path,
        material: &str,
        model: &mut Model,
    ) -> Result<Option<TextureId>, LoadError> {
        let place = format!("material `{material}`");
        let mut warn = |message| {
            let place = format!("{}: {place}", file.display());
            model.warnings.push(Warning { place, message });
        };
        for option in &map.ignored {
            warn(format!("the texture option `{option}` of `{}` is not followed", map.file));
        }
        let instead = match meaning {
            Meaning::Colours => "the plain colour is used",
            Meaning::Numbers => "the plain number is used",
            Meaning::Cover(_) => "the surface is whole",
            Meaning::Relief => "the surface is smooth",
        };
        // It was there on the machine of whoever made the model.
        if is_absolute(&map.file) {
            warn(format!("the image `{}` is not looked for, as its path is absolute; {instead}", map.file));
            return Ok(None);
        }
        let image = match resolve_path(&map.file, file, self.options) {
            Ok(image) => image,
            Err(Reason::MissingReference { .. }) => {
                warn(format!("the image `{}` is not there; {instead}", map.file));
                return Ok(None);
            }
            Err(reason) => return Err(reason.at(file, place)),
        };
        let id = self.image(image, map.clamp, meaning, model)?;
        if map.has_own_coordinates() {
            let Some(texture) = model.textures.get(id.0 as usize).cloned().map(Arc::new) else { return Ok(None) };
            return Ok(Some(push(Texture::Mapped { texture, map: map.coordinates() }, model)));
        }
        Ok(Some(id))
    }

    fn image(
        &mut self,
        file: PathBuf,
        clamp: bool,
        meaning: Meaning,
        model: &mut Model,
    ) -> Result<TextureId, LoadError> {
        let key = (file, clamp, meaning);
        if let Some(&known) = self.known.get(&key) {
            return Ok(known);
        }
        let file = &key.0;
        let bitmap = self.decoded(file, clamp, meaning).map_err(|reason| reason.at(file, ""))?;
        self.bytes += bitmap.memory() as u64;
        if self.bytes > limits::MODEL_TEXTURE_BYTES {
            let (value, limit) = (self.bytes, limits::MODEL_TEXTURE_BYTES);
            return Err(Reason::TooLarge { what: "the memory of all textures in bytes", value, limit }.at(file, ""));
        }
        let wrap = [if clamp { Wrap::Clamp } else { Wrap::Repeat }; 2];
        let id = push(Texture::Image { bitmap: Arc::new(bitmap), wrap, smooth: true }, model);
        self.known.insert(key, id);
        Ok(id)
    }

    fn decoded(&self, file: &Path, clamp: bool, meaning: Meaning) -> Result<Bitmap, Reason> {
        let pixels = if meaning == Meaning::Colours { Pixels::Colours } else { Pixels::Numbers };
        let mut bitmap = read_texture_as(file, pixels, self.options)?;
        match meaning {
            Meaning::Colours | Meaning::Numbers => {}
            Meaning::Cover(channel) => {
                let more = format_args!("the texture {}", file.display());
                self.options.memory.keep(more, (bitmap.pixels.len() * size_of::<f32>()) as u64)?;
                cover(&mut bitmap, channel);
            }
            Meaning::Relief if relief::is_height(&bitmap) => relief::normals_from_heights(&mut bitmap, clamp),
            Meaning::Relief => {}
        }
        Ok(bitmap)
    }
}

/// Adds a texture to those of the model.
pub(super) fn push(texture: Texture, model: &mut Model) -> TextureId {
    model.textures.push(texture);
    TextureId(model.textures.len() as u32 - 1)
}

/// Makes alpha of what the pixels say about how much of the surface is there.
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
    fn what_covers_is_alpha_or_the_channel_that_is_asked_for() {
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
