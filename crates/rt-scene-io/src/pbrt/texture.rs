//! Textures: colours by name, most of which are a constant or an image.

use std::collections::{BTreeMap, HashMap};
use std::path::PathBuf;
use std::sync::Arc;

use rt_math::Rgb;
use rt_shading::{Bitmap, Coefficient, Texture, TextureId, UvMap, Wrap};

use super::Files;
use super::material::unknown;
use super::parameters::Parameters;
use super::spectrum::colour;
use crate::flaw::Flaw;
use crate::{Reason, read_texture, resolve_path};

/// Kinds of textures that only other programs have.
const UNSUPPORTED: [&str; 7] = ["bilerp", "directionmix", "dots", "fbm", "marble", "mix", "ptex"];

/// Most memory that all images of a file may take.
const MAX_BYTES: usize = 1 << 32;

/// The textures of a file.
#[derive(Debug, Default)]
pub(super) struct Textures {
    pub(super) list: Vec<Texture>,
    /// In the order of their names, for messages.
    named: BTreeMap<String, Coefficient>,
    images: HashMap<PathBuf, Arc<Bitmap>>,
    bytes: usize,
}

impl Textures {
    /// Adds the texture `name`; what is lost of it comes back.
    pub(super) fn define(
        &mut self,
        name: String,
        class: &str,
        parameters: &Parameters,
        files: Files<'_>,
    ) -> Result<Vec<String>, Flaw> {
        let mut losses = Vec::new();
        let made = match class {
            "constant" => self.coefficient(parameters, "value", Rgb::WHITE, &mut losses)?,
            "scale" => {
                let below = self.coefficient(parameters, "tex", Rgb::WHITE, &mut losses)?;
                let factor = self.coefficient(parameters, "scale", Rgb::WHITE, &mut losses)?;
                match (below, factor) {
                    (below, Coefficient::Constant(rgb)) => times(below, rgb),
                    (Coefficient::Constant(rgb), textured) => times(textured, rgb),
                    (below, _) => {
                        losses.push("one image times another is not shown: the first stays".to_owned());
                        below
                    }
                }
            }
            "checkerboard" => self.checkerboard(parameters, &mut losses)?,
            "imagemap" => self.image(parameters, files, &mut losses)?,
            other if UNSUPPORTED.contains(&other) => {
                losses.push(format!("the texture \"{other}\" is not supported: grey is in its place"));
                Coefficient::Constant(Rgb::gray(0.5))
            }
            other => {
                let known = ["constant", "scale", "checkerboard", "imagemap"].into_iter().chain(UNSUPPORTED);
                return Err(unknown("texture", other, parameters.line, known));
            }
        };
        // Later definitions of a name hold for what comes after them.
        self.named.insert(name, made);
        Ok(losses)
    }

    /// A parameter that is a colour, a number or a texture.
    pub(super) fn coefficient(
        &self,
        parameters: &Parameters,
        name: &str,
        default: Rgb,
        losses: &mut Vec<String>,
    ) -> Result<Coefficient, Flaw> {
        match parameters.get(name) {
            Some(parameter) if parameter.kind == "texture" => {
                let texture = parameters.word(name, "texture")?.unwrap_or_default();
                self.named
                    .get(texture)
                    .copied()
                    .ok_or_else(|| unknown("texture", texture, parameter.line, self.named.keys().map(String::as_str)))
            }
            _ => {
                let Some((rgb, loss)) = colour(parameters, name)? else { return Ok(Coefficient::Constant(default)) };
                losses.extend(loss);
                Ok(Coefficient::Constant(rgb))
            }
        }
    }

    /// A parameter that is a number here, whatever the file has.
    pub(super) fn number(
        &self,
        parameters: &Parameters,
        name: &str,
        default: f64,
        losses: &mut Vec<String>,
    ) -> Result<f64, Flaw> {
        match self.coefficient(parameters, name, Rgb::gray(default), losses)? {
            Coefficient::Constant(rgb) => Ok(rgb.g),
            Coefficient::Textured(..) => {
                losses.push(format!("the texture of \"{name}\" is not followed: it is {default} everywhere"));
                Ok(default)
            }
        }
    }

    fn checkerboard(&mut self, parameters: &Parameters, losses: &mut Vec<String>) -> Result<Coefficient, Flaw> {
        let mut square =
            |name: &str, default: f64| match self.coefficient(parameters, name, Rgb::gray(default), losses)? {
                Coefficient::Constant(rgb) => Ok(rgb),
                Coefficient::Textured(_, rgb) => {
                    losses.push(format!("the texture of the squares \"{name}\" is not shown"));
                    Ok(rgb)
                }
            };
        let (even, odd) = (square("tex1", 1.0)?, square("tex2", 0.0)?);
        if parameters.float("dimension", 2.0)? != 2.0 {
            losses.push("the checkerboard in space became one on the surface".to_owned());
        }
        self.mapped(parameters, Texture::Checker { even, odd, size: 1.0 }, losses)
    }

    fn image(
        &mut self,
        parameters: &Parameters,
        files: Files<'_>,
        losses: &mut Vec<String>,
    ) -> Result<Coefficient, Flaw> {
        let flaw = |reason| Flaw { line: parameters.line, reason };
        let Some(file) = parameters.word("filename", "string")? else {
            return Err(Flaw::new(parameters.line, "an image", "has no \"string filename\": add it"));
        };
        let path = resolve_path(file, files.root_file, files.options).map_err(flaw)?;
        let bitmap = match self.images.get(&path) {
            Some(bitmap) => Arc::clone(bitmap),
            None => {
                let bad = |rule: String| flaw(Reason::BadReference { reference: file.to_owned(), rule });
                let bitmap = Arc::new(read_texture(&path).map_err(|reason| bad(reason.to_string()))?);
                self.bytes += bitmap.memory();
                if self.bytes > MAX_BYTES {
                    let what = "the memory of all images in bytes";
                    return Err(flaw(Reason::TooLarge { what, value: self.bytes as u64, limit: MAX_BYTES as u64 }));
                }
                self.images.insert(path, Arc::clone(&bitmap));
                bitmap
            }
        };
        let wrap = match parameters.word("wrap", "string")? {
            None | Some("repeat") => Wrap::Repeat,
            Some("clamp") => Wrap::Clamp,
            Some(other) => {
                losses.push(format!(
                    "the image does not end at its edge, as \"{other}\" would have it: the edge goes on"
                ));
                Wrap::Clamp
            }
        };
        if let Some(encoding) = parameters.word("encoding", "string")?.filter(|encoding| *encoding != "sRGB") {
            losses
                .push(format!("the encoding \"{encoding}\" is not followed: images of whole numbers are read as sRGB"));
        }
        let smooth = parameters.word("filter", "string")? != Some("point");
        let scale = parameters.not_negative("scale", 1.0)?;
        let textured = self.mapped(parameters, Texture::Image { bitmap, wrap: [wrap; 2], smooth }, losses)?;
        Ok(times(textured, Rgb::gray(scale)))
    }

    /// Adds a texture at the coordinates that its parameters lead to.
    fn mapped(
        &mut self,
        parameters: &Parameters,
        texture: Texture,
        losses: &mut Vec<String>,
    ) -> Result<Coefficient, Flaw> {
        if let Some(mapping) = parameters.word("mapping", "string")?.filter(|mapping| *mapping != "uv") {
            losses.push(format!("the mapping \"{mapping}\" is not supported: the texture lies along u and v"));
        }
        let u = [parameters.float("uscale", 1.0)?, 0.0, parameters.float("udelta", 0.0)?];
        let v = [0.0, parameters.float("vscale", 1.0)?, parameters.float("vdelta", 0.0)?];
        let map = UvMap { is_second: false, rows: [u, v] };
        let texture =
            if map == UvMap::IDENTITY { texture } else { Texture::Mapped { texture: Arc::new(texture), map } };
        self.list.push(texture);
        Ok(Coefficient::Textured(TextureId(self.list.len() as u32 - 1), Rgb::WHITE))
    }
}

fn times(coefficient: Coefficient, factor: Rgb) -> Coefficient {
    match coefficient {
        Coefficient::Constant(rgb) => Coefficient::Constant(rgb * factor),
        Coefficient::Textured(id, rgb) => Coefficient::Textured(id, rgb * factor),
    }
}
