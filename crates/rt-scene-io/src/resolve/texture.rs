//! Textures, each decoded once.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rt_math::Rgb;
use rt_shading::{ColorTexture, Texture, TextureId};

use super::value::{colour, positive};
use crate::format;
use crate::{LoadErrorKind, LoadOptions, read_texture, resolve_path};

/// Textures of a scene, and the loader of image files.
pub(super) struct Textures<'a> {
    source: &'a Path,
    pub(super) options: &'a LoadOptions,
    pub(super) list: Vec<Texture>,
    images: HashMap<(PathBuf, format::Wrap, bool), TextureId>,
}

impl<'a> Textures<'a> {
    pub(super) fn new(source: &'a Path, options: &'a LoadOptions) -> Self {
        Self { source, options, list: Vec::new(), images: HashMap::new() }
    }

    /// A coefficient of the file, with its texture added to the list.
    pub(super) fn coefficient(&mut self, value: &format::ColorTexture) -> Result<ColorTexture, LoadErrorKind> {
        use format::{Color, ColorTexture as Given};
        match value {
            Given::Gray(value) => colour(&Color::Gray(*value)).map(ColorTexture::Constant),
            Given::Rgb(r, g, b) => colour(&Color::Rgb(*r, *g, *b)).map(ColorTexture::Constant),
            Given::Hex(digits) => colour(&Color::Hex(digits.clone())).map(ColorTexture::Constant),
            Given::Checker { even, odd, size } => {
                let checker = Texture::Checker { even: colour(even)?, odd: colour(odd)?, size: positive(*size)? };
                Ok(ColorTexture::Textured(self.add(checker), Rgb::WHITE))
            }
            Given::Image { file, wrap, smooth, scale } => {
                let scale = colour(scale)?;
                Ok(ColorTexture::Textured(self.image(file, *wrap, *smooth)?, scale))
            }
        }
    }

    /// Path of a file that the scene refers to.
    pub(super) fn path(&self, reference: &str) -> Result<PathBuf, LoadErrorKind> {
        resolve_path(reference, self.source, self.options)
    }

    fn image(&mut self, reference: &str, wrap: format::Wrap, smooth: bool) -> Result<TextureId, LoadErrorKind> {
        let path = resolve_path(reference, self.source, self.options)?;
        let key = (path, wrap, smooth);
        if let Some(&id) = self.images.get(&key) {
            return Ok(id);
        }
        let bitmap = read_texture(&key.0, self.options);
        let bitmap = bitmap.map_err(|reason| LoadErrorKind::bad_reference(reference, reason))?;
        let id = self.add(Texture::Image { bitmap: Arc::new(bitmap), wrap: [wrap.into(); 2], smooth });
        self.images.insert(key, id);
        Ok(id)
    }

    fn add(&mut self, texture: Texture) -> TextureId {
        let id = TextureId(self.list.len() as u32);
        self.list.push(texture);
        id
    }
}
