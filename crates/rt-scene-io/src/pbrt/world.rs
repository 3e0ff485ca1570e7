//! Directives of the world: objects, materials, lights and shapes.

use rt_math::Rgb;
use rt_shading::light::EmissionSides;
use rt_shading::{Alpha, ColorTexture, Material};

use super::light::PbrtLight;
use super::parameters::{Parameters, undefined, unknown};
use super::reader::PbrtReader;
use super::shape::{DirectiveError, PbrtShape};
use super::state::Emission;
use super::texture::TextureType;
use super::view::PbrtCamera;
use super::{light, material, shape, spectrum};
use crate::build_mesh::build_mesh;
use crate::error::{ErrorInLine, LineError};
use crate::tangents;
use crate::text::tokenizer::Tokenizer;
use crate::{Content, LoadErrorKind, MaterialId, SceneNode, limits};

impl PbrtReader<'_> {
    pub(super) fn object(&mut self, word: &str, line: usize, tokens: &mut Tokenizer<'_>) -> Result<(), LineError> {
        if word == "ObjectEnd" {
            self.close_scope(line, word)?;
            if let Some((name, nodes)) = self.object.take() {
                self.objects.insert(name, nodes);
            }
            return Ok(());
        }
        let name = tokens.text("the name of an object")?;
        if self.object.is_some() {
            return Err(LineError::new(
                line,
                format_args!("`{word}`"),
                "is inside an object: objects may contain shapes only",
            ));
        }
        if word == "ObjectBegin" {
            if self.objects.contains_key(&name) {
                return Err(LineError { line, kind: LoadErrorKind::Duplicate { kind: "object", name } });
            }
            self.open_scope(line, true)?;
            self.object = Some((name, Vec::new()));
            return Ok(());
        }
        let Some(nodes) = self.objects.get(&name) else {
            return Err(undefined("object", &name, line));
        };
        let children = nodes.clone();
        self.add(SceneNode { children, ..SceneNode::empty(name, self.state.matrix) }, line)
    }

    /// Adds a node to the object that is described, or to the world.
    fn add(&mut self, node: SceneNode, line: usize) -> Result<(), LineError> {
        self.unfolded += 1 + node.children.len();
        let (what, limit) = ("the number of shapes, with expanded instances,", limits::PBRT_NODES as u64);
        LoadErrorKind::check_limit(what, self.unfolded as u64, limit).in_line(line)?;
        match &mut self.object {
            Some((_, nodes)) => nodes.push(node),
            None => self.nodes.push(node),
        }
        Ok(())
    }

    pub(super) fn appearance(&mut self, word: &str, line: usize, tokens: &mut Tokenizer<'_>) -> Result<(), LineError> {
        let name = tokens.text("a name")?;
        let mut warnings = Vec::new();
        match word {
            "NamedMaterial" => {
                let Some(surface) = self.named.get(&name) else {
                    return Err(undefined("material", &name, line));
                };
                self.state.surface = *surface;
            }
            "Texture" => {
                let texture_type = TextureType::read(&tokens.text("the type of a texture")?, line)?;
                let class = tokens.text("the class of a texture")?;
                let parameters = self.parameters(tokens, line, "texture")?;
                let warnings = self.textures.define(name, texture_type, &class, &parameters, self.files)?;
                self.warn_all(word, &parameters, warnings);
            }
            _ => {
                let parameters = self.parameters(tokens, line, "material")?;
                let kind = if word == "Material" {
                    name.clone()
                } else {
                    parameters.word("type", "string")?.unwrap_or("diffuse").to_owned()
                };
                let (named, surfaces) = (&self.named, &self.surfaces);
                let find = |part: &str| match named.get(part) {
                    Some(&index) => Ok(surfaces.get(index).cloned().flatten()),
                    None => Err(undefined("material", part, line)),
                };
                let mut surface = material::read(&kind, &parameters, &self.textures, find, &mut warnings)?;
                let normal_map = self.textures.normal_map(&parameters, self.files)?;
                if let (Some(surface), Some(_)) = (&mut surface, normal_map) {
                    surface.normal_map = normal_map;
                }
                self.surfaces.push(surface);
                let index = self.surfaces.len() - 1;
                if word == "Material" {
                    self.state.surface = index;
                } else {
                    if let Some(surface) = &mut self.surfaces[index] {
                        surface.name.clone_from(&name);
                    }
                    self.named.insert(name, index);
                }
                self.warn_all(word, &parameters, warnings);
            }
        }
        Ok(())
    }

    /// The parameters of a directive, with the attributes that hold for its kind.
    fn parameters(&self, tokens: &mut Tokenizer<'_>, line: usize, target: &str) -> Result<Parameters, LineError> {
        let own = Parameters::read(tokens, line)?;
        Ok(match self.state.attributes.get(target) {
            Some(defaults) => own.or(defaults),
            None => own,
        })
    }

    pub(super) fn light(&mut self, word: &str, line: usize, tokens: &mut Tokenizer<'_>) -> Result<(), LineError> {
        let kind = tokens.text("the kind of a light")?;
        let parameters = self.parameters(tokens, line, "light")?;
        if word == "AreaLightSource" {
            if kind != "diffuse" {
                return Err(unknown("area light", &kind, line, ["diffuse"]));
            }
            let (radiance, warning) = spectrum::light_colour(&parameters, "L")?.unwrap_or((Rgb::WHITE, None));
            let radiance = radiance * parameters.not_negative("scale", 1.0)?;
            self.state.emission = Some(Emission { radiance, both_sides: parameters.flag("twosided")? });
            self.warn_all(word, &parameters, warning.into_iter().collect());
            return Ok(());
        }
        let place = PbrtCamera::ours_from_world(self.view.as_ref()).compose(&self.state.matrix);
        let (source, warnings) = light::read(&kind, &parameters, &place, self.files)?;
        match source {
            PbrtLight::Light(light) => self.model.lights.push(light),
            PbrtLight::Sky(radiance) => self.sky = Some(self.sky.unwrap_or_default() + radiance),
            PbrtLight::Unsupported => {
                self.warn(line, format!("the light \"{kind}\" is not supported: it is left out"));
                return Ok(());
            }
        }
        self.warn_all(word, &parameters, warnings);
        Ok(())
    }

    pub(super) fn shape(&mut self, line: usize, tokens: &mut Tokenizer<'_>) -> Result<(), DirectiveError> {
        let kind = tokens.text("the kind of a shape")?;
        let parameters = self.parameters(tokens, line, "shape")?;
        let mut warnings = Vec::new();
        let name = format!("line {line}");
        let mut alpha = self.textures.alpha(&parameters, self.files, &mut warnings)?;
        let needs_uvs = alpha.texture.is_some() || self.surface().is_some_and(Material::is_textured);
        let mut solid = shape::read(&kind, &parameters, self.state.reversed, needs_uvs, self.files, &mut warnings)?;
        if matches!(solid, PbrtShape::Exact(..)) && alpha != Alpha::OPAQUE {
            warnings.push(format!("\"alpha\" is supported for meshes only: the {kind} is opaque"));
            alpha = Alpha::OPAQUE;
        }
        let is_reflected = self.state.matrix.flips_handedness();
        if self.surface().is_some_and(|surface| surface.normal_map.is_some()) && !lay_tangents(&mut solid, is_reflected)
        {
            warnings.push("its normal map needs texture coordinates: it is left out".to_owned());
        }
        let (content, place) = match solid {
            PbrtShape::Exact(shape, place) => (Content::Shape(shape), self.state.matrix.compose(&place)),
            PbrtShape::Mesh(data) => {
                let at = format!("{}:{line}", self.path.display());
                let mesh = build_mesh(data, &at, &mut self.model.warnings);
                let Some(mesh) = mesh.in_line(line)? else { return Ok(()) };
                (Content::Mesh(self.model.add_mesh(name.clone(), mesh)), self.state.matrix)
            }
            PbrtShape::Unsupported => {
                self.warn(line, format!("the shape \"{kind}\" is not supported: it is left out"));
                return Ok(());
            }
        };
        self.warn_all(&format!("the shape \"{kind}\""), &parameters, warnings);
        let emits = self.emission().is_some();
        if emits && alpha.factor == 0.0 {
            self.warn(line, "an area light of alpha 0 is not supported: it gives no light".to_owned());
        }
        let Some(material) = self.material(alpha) else {
            let of_light = if emits { ", and its area light is ignored, as in pbrt" } else { "" };
            self.warn(line, format!("a shape without material is invisible: it is left out{of_light}"));
            return Ok(());
        };
        self.add(SceneNode { content: Some(content), material, ..SceneNode::empty(name, place) }, line)?;
        Ok(())
    }

    /// The surface in force.
    fn surface(&self) -> Option<&Material> {
        self.surfaces.get(self.state.surface)?.as_ref()
    }

    /// The emission in force; `None` if it is black.
    fn emission(&self) -> Option<Emission> {
        self.state.emission.filter(|emission| !emission.radiance.is_black())
    }

    /// The current material with its emission and alpha; `None` if it is invisible.
    fn material(&mut self, alpha: Alpha) -> Option<MaterialId> {
        let emission = self.emission();
        let bits = emission.map(|light| (light.radiance.to_array().map(f64::to_bits), light.both_sides));
        let key = (self.state.surface, bits, (alpha.factor.to_bits(), alpha.texture));
        if let Some(known) = self.materials.get(&key) {
            return Some(*known);
        }
        let mut made = self.surface()?.clone();
        if let Some(Emission { radiance, both_sides }) = emission {
            self.emits = true;
            made.emission = ColorTexture::Constant(radiance);
            made.emission_sides = if both_sides { EmissionSides::Both } else { EmissionSides::Front };
        }
        made.alpha = alpha;
        let id = self.model.add_material(made);
        self.materials.insert(key, id);
        Some(id)
    }
}

/// Makes the tangents that normal maps are laid along; false if there are none.
///
/// The second axis of a map is the cross product of normal and tangent in the world, as in `NormalMap` of pbrt-v4. `v` may fall along
/// it. `is_reflected` is true for a mesh whose transform flips handedness.
fn lay_tangents(solid: &mut PbrtShape, is_reflected: bool) -> bool {
    match solid {
        PbrtShape::Mesh(data) if !data.uvs.is_empty() => {
            let uvs = data.uvs.clone();
            tangents::generate(data, &uvs);
            let side = if is_reflected { -1.0 } else { 1.0 };
            data.tangents.iter_mut().for_each(|tangent| tangent[3] = side);
            true
        }
        PbrtShape::Mesh(_) | PbrtShape::Exact(..) => false,
        PbrtShape::Unsupported => true,
    }
}
