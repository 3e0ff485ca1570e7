//! Textures by type and name, normal maps, and alpha textures.

use std::collections::{BTreeMap, HashMap};
use std::path::PathBuf;
use std::sync::Arc;

use rt_math::Rgb;
use rt_shading::{Alpha, AlphaMode, Bitmap, ColorTexture, NormalMap, Texture, TextureId, UvMap, Wrap};

use super::file_scope::FileScope;
use super::parameters::{Parameters, undefined, unknown};
use super::spectrum::colour;
use crate::error::{ErrorInLine, LineError};
use crate::files::read_texture_as;
use crate::texture::PixelEncoding;
use crate::{LoadErrorKind, limits, resolve_path};

/// Kinds of textures that only other programs have.
const UNSUPPORTED: [&str; 7] = ["bilerp", "directionmix", "dots", "fbm", "marble", "mix", "ptex"];

/// Type of a texture. Textures of different types may have the same name.
#[derive(Clone, Copy, Debug)]
pub(super) enum TextureType {
    Float,
    Spectrum,
}

impl TextureType {
    /// Reads the second word of a `Texture`.
    pub(super) fn read(word: &str, line: usize) -> Result<Self, LineError> {
        match word {
            "float" => Ok(Self::Float),
            "spectrum" => Ok(Self::Spectrum),
            other => Err(unknown("type of a texture", other, line, ["float", "spectrum"])),
        }
    }

    /// Kind of name, for messages.
    const fn kind(self) -> &'static str {
        match self {
            Self::Float => "float texture",
            Self::Spectrum => "spectrum texture",
        }
    }
}

#[derive(Debug, Default)]
pub(super) struct PbrtTextures {
    pub(super) list: Vec<Texture>,
    /// Float textures, then spectrum textures, in the order of their names, for messages.
    named: [BTreeMap<String, ColorTexture>; 2],
    images: HashMap<(PathBuf, PixelEncoding), Arc<Bitmap>>,
    /// Alpha textures made from the colours of other textures.
    alphas: HashMap<TextureId, TextureId>,
    bytes: u64,
}

impl PbrtTextures {
    /// True if there is a texture of this [kind](TextureType::kind) and name.
    pub(super) fn is_defined(&self, kind: &str, name: &str) -> bool {
        self.of_kind(kind).any(|named| named.contains_key(name))
    }

    /// Names of the textures of a kind.
    pub(super) fn names(&self, kind: &str) -> impl Iterator<Item = &String> {
        self.of_kind(kind).flat_map(BTreeMap::keys)
    }

    fn of_kind(&self, kind: &str) -> impl Iterator<Item = &BTreeMap<String, ColorTexture>> {
        let types = [TextureType::Float, TextureType::Spectrum];
        types.into_iter().filter(move |of| of.kind() == kind).map(|of| &self.named[of as usize])
    }

    /// Adds the texture `name`; returns warnings about unsupported parts.
    pub(super) fn define(
        &mut self,
        name: String,
        kind: TextureType,
        class: &str,
        parameters: &Parameters,
        files: FileScope<'_>,
    ) -> Result<Vec<String>, LineError> {
        let mut warnings = Vec::new();
        let made = match class {
            "constant" => self.coefficient(parameters, "value", kind, Rgb::WHITE, &mut warnings)?,
            "scale" => {
                let below = self.coefficient(parameters, "tex", kind, Rgb::WHITE, &mut warnings)?;
                let factor = self.coefficient(parameters, "scale", TextureType::Float, Rgb::WHITE, &mut warnings)?;
                match (below, factor) {
                    (below, ColorTexture::Constant(rgb)) => times(below, rgb),
                    (ColorTexture::Constant(rgb), textured) => times(textured, rgb),
                    (below, _) => {
                        warnings.push("the product of two images is not supported: the first image is used".to_owned());
                        below
                    }
                }
            }
            "checkerboard" => self.checkerboard(parameters, kind, &mut warnings)?,
            "imagemap" => self.image(parameters, files, &mut warnings)?,
            other if UNSUPPORTED.contains(&other) => {
                warnings.push(format!("the texture \"{other}\" is not supported: grey is used"));
                ColorTexture::Constant(Rgb::gray(0.5))
            }
            other => {
                let known = ["constant", "scale", "checkerboard", "imagemap"].into_iter().chain(UNSUPPORTED);
                return Err(unknown("texture", other, parameters.line, known));
            }
        };
        // Later definitions of a name hold for what comes after them.
        self.named[kind as usize].insert(name, made);
        Ok(warnings)
    }

    /// A parameter that is a colour, a number or a texture of type `kind`.
    pub(super) fn coefficient(
        &self,
        parameters: &Parameters,
        name: &str,
        kind: TextureType,
        default: Rgb,
        warnings: &mut Vec<String>,
    ) -> Result<ColorTexture, LineError> {
        match parameters.get(name) {
            Some(parameter) if parameter.kind == "texture" => {
                let texture = parameters.word(name, "texture")?.unwrap_or_default();
                let named = &self.named[kind as usize];
                named.get(texture).copied().ok_or_else(|| undefined(kind.kind(), texture, parameter.line))
            }
            _ => {
                let Some((rgb, warning)) = colour(parameters, name)? else {
                    return Ok(ColorTexture::Constant(default));
                };
                warnings.extend(warning);
                Ok(ColorTexture::Constant(rgb))
            }
        }
    }

    /// A parameter that is a number here, whatever the file has.
    pub(super) fn number(
        &self,
        parameters: &Parameters,
        name: &str,
        default: f64,
        warnings: &mut Vec<String>,
    ) -> Result<f64, LineError> {
        match self.coefficient(parameters, name, TextureType::Float, Rgb::gray(default), warnings)? {
            ColorTexture::Constant(rgb) => Ok(rgb.g),
            ColorTexture::Textured(..) => {
                warnings.push(format!("the texture of \"{name}\" is not supported: {default} is used"));
                Ok(default)
            }
        }
    }

    fn checkerboard(
        &mut self,
        parameters: &Parameters,
        kind: TextureType,
        warnings: &mut Vec<String>,
    ) -> Result<ColorTexture, LineError> {
        let mut square =
            |name: &str, default: f64| match self.coefficient(parameters, name, kind, Rgb::gray(default), warnings)? {
                ColorTexture::Constant(rgb) => Ok(rgb),
                ColorTexture::Textured(_, rgb) => {
                    warnings.push(format!("the texture of the squares \"{name}\" is not shown"));
                    Ok(rgb)
                }
            };
        let (even, odd) = (square("tex1", 1.0)?, square("tex2", 0.0)?);
        if parameters.float("dimension", 2.0)? != 2.0 {
            warnings.push("checkerboards in space are not supported: one on the surface is used".to_owned());
        }
        self.mapped(parameters, Texture::Checker { even, odd, size: 1.0 }, warnings)
    }

    fn image(
        &mut self,
        parameters: &Parameters,
        files: FileScope<'_>,
        warnings: &mut Vec<String>,
    ) -> Result<ColorTexture, LineError> {
        let Some(file) = parameters.word("filename", "string")? else {
            return Err(LineError::new(parameters.line, "an image", "has no \"string filename\": add it"));
        };
        let bitmap = self.bitmap(file, PixelEncoding::Colors, parameters.line, files)?;
        let wrap = match parameters.word("wrap", "string")? {
            None | Some("repeat") => Wrap::Repeat,
            Some("clamp") => Wrap::Clamp,
            Some(other) => {
                warnings.push(format!("the wrap mode \"{other}\" is not supported: `clamp` is used"));
                Wrap::Clamp
            }
        };
        if let Some(encoding) = parameters.word("encoding", "string")?.filter(|encoding| *encoding != "sRGB") {
            warnings
                .push(format!("the encoding \"{encoding}\" is not supported: images of 8 or 16 bits are read as sRGB"));
        }
        let smooth = parameters.word("filter", "string")? != Some("point");
        let scale = parameters.not_negative("scale", 1.0)?;
        let textured = self.mapped(parameters, Texture::Image { bitmap, wrap: [wrap; 2], smooth }, warnings)?;
        Ok(times(textured, Rgb::gray(scale)))
    }

    /// The image in a file, which is read once.
    fn bitmap(
        &mut self,
        file: &str,
        pixels: PixelEncoding,
        line: usize,
        files: FileScope<'_>,
    ) -> Result<Arc<Bitmap>, LineError> {
        let path = resolve_path(file, files.root_file, files.options).in_line(line)?;
        let key = (path, pixels);
        if let Some(bitmap) = self.images.get(&key) {
            return Ok(Arc::clone(bitmap));
        }
        let bitmap = read_texture_as(&key.0, pixels, files.options);
        let bitmap = bitmap.map_err(|reason| LoadErrorKind::bad_reference(file, reason)).in_line(line)?;
        let bitmap = Arc::new(bitmap);
        self.count(&bitmap, line)?;
        self.images.insert(key, Arc::clone(&bitmap));
        Ok(bitmap)
    }

    /// Adds a bitmap to the memory of all.
    fn count(&mut self, bitmap: &Bitmap, line: usize) -> Result<(), LineError> {
        self.bytes += bitmap.memory() as u64;
        let (what, limit) = ("the memory of all images in bytes", limits::MODEL_TEXTURE_BYTES);
        LoadErrorKind::check_limit(what, self.bytes, limit).in_line(line)
    }

    /// The normal map of a material, if it has one.
    pub(super) fn normal_map(
        &mut self,
        parameters: &Parameters,
        files: FileScope<'_>,
    ) -> Result<Option<NormalMap>, LineError> {
        let Some(file) = parameters.word("normalmap", "string")? else { return Ok(None) };
        let bitmap = self.bitmap(file, PixelEncoding::Numbers, parameters.line, files)?;
        let texture = self.push(Texture::Image { bitmap, wrap: [Wrap::Repeat; 2], smooth: true });
        Ok(Some(NormalMap { texture, scale: 1.0 }))
    }

    /// Alpha of a shape: a number or a texture of numbers.
    pub(super) fn alpha(
        &mut self,
        parameters: &Parameters,
        files: FileScope<'_>,
        warnings: &mut Vec<String>,
    ) -> Result<Alpha, LineError> {
        let (texture, factor) = match self.coefficient(parameters, "alpha", TextureType::Float, Rgb::WHITE, warnings)? {
            ColorTexture::Constant(rgb) if rgb.g >= 1.0 => return Ok(Alpha::OPAQUE),
            ColorTexture::Constant(rgb) => (None, rgb.g),
            ColorTexture::Textured(id, rgb) => match self.alpha_of(id, parameters.line, files)? {
                Some(alpha) => (Some(alpha), rgb.g),
                None => {
                    warnings.push("\"alpha\" must be an image: the shape is opaque".to_owned());
                    return Ok(Alpha::OPAQUE);
                }
            },
        };
        // The product counts as 1 where it is larger: neither its factor nor its texture is clamped.
        Ok(Alpha { mode: AlphaMode::Blend, factor, texture, culls_back_faces: false })
    }

    /// The texture whose alpha is the number that a float image map gives; `None` if `id` shows no image.
    ///
    /// It is the alpha channel, or the mean of the colours of an opaque image (`MIPMap::Bilerp<Float>` of pbrt-v4).
    fn alpha_of(&mut self, id: TextureId, line: usize, files: FileScope<'_>) -> Result<Option<TextureId>, LineError> {
        if let Some(known) = self.alphas.get(&id) {
            return Ok(Some(*known));
        }
        let (image, map) = match self.list.get(id.0 as usize) {
            Some(Texture::Mapped { texture, map }) => (Texture::clone(texture), Some(*map)),
            Some(texture) => (texture.clone(), None),
            None => return Ok(None),
        };
        let Texture::Image { bitmap, wrap, smooth } = image else { return Ok(None) };
        if bitmap.alpha.iter().any(|alpha| *alpha != 1.0) {
            return Ok(Some(id));
        }
        let bytes = (bitmap.memory() + bitmap.pixels.len() * size_of::<f32>()) as u64;
        files.options.memory.keep("the alpha of a shape", bytes).in_line(line)?;
        let alpha = bitmap.pixels.iter().map(|pixel| pixel.iter().sum::<f32>() / 3.0).collect();
        let bitmap = Arc::new(Bitmap { alpha, ..Bitmap::clone(&bitmap) });
        self.count(&bitmap, line)?;
        let image = Texture::Image { bitmap, wrap, smooth };
        let alpha = self.push(match map {
            Some(map) => Texture::Mapped { texture: Arc::new(image), map },
            None => image,
        });
        self.alphas.insert(id, alpha);
        Ok(Some(alpha))
    }

    fn push(&mut self, texture: Texture) -> TextureId {
        self.list.push(texture);
        TextureId(self.list.len() as u32 - 1)
    }

    /// Adds a texture at the coordinates that its parameters lead to.
    fn mapped(
        &mut self,
        parameters: &Parameters,
        texture: Texture,
        warnings: &mut Vec<String>,
    ) -> Result<ColorTexture, LineError> {
        if let Some(mapping) = parameters.word("mapping", "string")?.filter(|mapping| *mapping != "uv") {
            warnings.push(format!("the mapping \"{mapping}\" is not supported: the texture lies along u and v"));
        }
        let u = [parameters.float("uscale", 1.0)?, 0.0, parameters.float("udelta", 0.0)?];
        let v = [0.0, parameters.float("vscale", 1.0)?, parameters.float("vdelta", 0.0)?];
        let map = UvMap { is_second: false, rows: [u, v] };
        let texture =
            if map == UvMap::IDENTITY { texture } else { Texture::Mapped { texture: Arc::new(texture), map } };
        Ok(ColorTexture::Textured(self.push(texture), Rgb::WHITE))
    }
}

fn times(coefficient: ColorTexture, factor: Rgb) -> ColorTexture {
    match coefficient {
        ColorTexture::Constant(rgb) => ColorTexture::Constant(rgb * factor),
        ColorTexture::Textured(id, rgb) => ColorTexture::Textured(id, rgb * factor),
    }
}
