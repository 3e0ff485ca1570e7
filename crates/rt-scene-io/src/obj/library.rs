//! The materials of an OBJ file: libraries are read at once, materials and their textures when first used.

use std::{
    collections::{BTreeMap, HashMap, HashSet},
    path::{Path, PathBuf},
    sync::Arc,
};

use rt_shading::{Channel, Material, NormalMap, Phong, Texture, TextureId};

use super::{
    material::{MaterialMaps, is_glass, material, needs_tangents},
    mtl::{self, UNUSED},
    texture_map::TextureMap,
    textures::{ObjTextures, PixelMeaning},
};
use crate::error::{ErrorAt, times};
use crate::text::lines::decode;
use crate::{
    LoadError, LoadErrorKind, LoadOptions, Location, MaterialId, Model, Warning,
    files::{is_absolute, read_referenced, refuse_utf16, resolve_path},
};

/// Maps without effect on glass, which is uniform.
const UNUSED_BY_GLASS: [&str; 7] = ["map_Pr", "map_Pm", "map_Ps", "map_Pc", "Pc", "Ps", "aniso"];

pub(super) struct MaterialLibrary<'a> {
    options: &'a LoadOptions,
    /// The OBJ file, for messages.
    path: &'a Path,
    /// Material and its file, by name. The first of several materials of a name counts.
    known: BTreeMap<String, (tobj::Material, PathBuf)>,
    /// True if a missing library explains unknown names.
    incomplete: bool,
    /// By name, and whether vertex colours multiply it.
    used: HashMap<(Option<String>, bool), MaterialId>,
    textures: ObjTextures<'a>,
}

/// The colours of vertices, times a texture if there is one.
fn tinted(texture: Option<TextureId>, model: &mut Model) -> TextureId {
    let below = texture.and_then(|id| model.textures.get(id.0 as usize)).map(|texture| Arc::new(texture.clone()));
    model.add_texture(Texture::VertexColor(below))
}

impl<'a> MaterialLibrary<'a> {
    /// Reads the libraries that `mtllib` statements name. A missing one is a warning.
    pub(super) fn open(
        statements: &[(usize, String)],
        path: &'a Path,
        options: &'a LoadOptions,
        model: &mut Model,
    ) -> Result<Self, LoadError> {
        let (known, textures) = (BTreeMap::new(), ObjTextures::new(options));
        let mut library = Self { options, path, known, incomplete: false, used: HashMap::new(), textures };
        for (line, names) in statements {
            if names.is_empty() {
                library.incomplete = true;
                let message = "`mtllib` names no material library; plain grey is used for its materials";
                model.warn(format_args!("{}:{line}", path.display()), message);
                continue;
            }
            library.open_all(names, *line, model)?;
        }
        Ok(library)
    }

    /// A statement names one file, whose name may contain spaces, or several files.
    fn open_all(&mut self, names: &str, line: usize, model: &mut Model) -> Result<(), LoadError> {
        let resolve = |name: &str| {
            // Absolute paths are those of another machine.
            if is_absolute(name) {
                return Ok(None);
            }
            match resolve_path(name, self.path, self.options) {
                Err(LoadErrorKind::MissingReference { .. }) => Ok(None),
                Ok(found) if found.is_dir() => {
                    let refused = LoadErrorKind::bad_reference(name, LoadErrorKind::Directory);
                    Err(refused.at(self.path, Location::Line(line)))
                }
                found => found.map(Some).at(self.path, Location::Line(line)),
            }
        };
        let mut files = Vec::new();
        let mut missing = Vec::new();
        match resolve(names)? {
            Some(file) => files.push(file),
            // Spaces of an absolute path do not separate files.
            None if is_absolute(names) => missing.push(names),
            None => {
                for name in names.split_whitespace() {
                    match resolve(name)? {
                        Some(file) => files.push(file),
                        None => missing.push(name),
                    }
                }
            }
        }
        for file in files {
            self.read(&file, model)?;
        }
        for name in missing {
            self.incomplete = true;
            let problem = if is_absolute(name) {
                format!("the path of the material library `{name}` is absolute")
            } else {
                format!("the material library `{name}` does not exist")
            };
            let message = format!("{problem}; plain grey is used for its materials");
            model.warn(format_args!("{}:{}", self.path.display(), line), message);
        }
        Ok(())
    }

    fn read(&mut self, file: &Path, model: &mut Model) -> Result<(), LoadError> {
        let bytes = match read_referenced(file, self.options) {
            Err(LoadErrorKind::Empty) => Vec::new(),
            bytes => bytes.at(file, "")?,
        };
        refuse_utf16(&bytes).at(file, "")?;
        let mtl::MtlFile { materials, warnings, unknown } = mtl::parse(&decode(&bytes).0);
        for mtl::UnknownStatement { line, keyword, count } in unknown {
            let message = format!("unsupported statement `{keyword}`: left out{}", times(count));
            model.warn(format_args!("{}:{}", file.display(), line), message);
        }
        for (line, message) in warnings {
            model.warn(format_args!("{}:{}", file.display(), line), format!("{message}; the statement is left out"));
        }
        let mut here = HashSet::new();
        for material in materials {
            if !here.insert(material.name.clone()) {
                let message =
                    format!("the material `{}` is defined twice: the first definition is used", material.name);
                model.warn(file.display(), message);
            }
            self.known.entry(material.name.clone()).or_insert_with(|| (material, file.to_owned()));
        }
        Ok(())
    }

    /// The material of this name, or the default material; the colours of vertices tint it if there are any.
    pub(super) fn material(
        &mut self,
        name: Option<&str>,
        has_colours: bool,
        model: &mut Model,
    ) -> Result<MaterialId, LoadError> {
        let name = name.map(str::to_owned);
        if let Some(&id) = self.used.get(&(name.clone(), has_colours)) {
            return Ok(id);
        }
        let material = match name.as_ref().and_then(|name| self.known.get(name)).cloned() {
            Some((mtl, file)) => {
                let mut maps = self.maps(&mtl, &file, model)?;
                if has_colours {
                    maps.diffuse = Some(tinted(maps.diffuse, model));
                }
                Self::warn_about_unused(&mtl, &file, model);
                material(&mtl, maps, &model.textures)
            }
            None => {
                if let (Some(name), false) = (&name, self.incomplete) {
                    model.warnings.push(self.unknown(name));
                }
                let name = name.clone().unwrap_or_else(|| "default".to_owned());
                if has_colours {
                    let maps = MaterialMaps { diffuse: Some(tinted(None, model)), ..MaterialMaps::default() };
                    Material { name, ..material(&tobj::Material::default(), maps, &model.textures) }
                } else {
                    Material::new(name, Phong::default())
                }
            }
        };
        let id = model.add_material(material);
        self.used.insert((name, has_colours), id);
        Ok(id)
    }

    fn unknown(&self, name: &str) -> Warning {
        let known: Vec<&str> = self.known.keys().map(String::as_str).take(24).collect();
        let known =
            if known.is_empty() { "there are none".to_owned() } else { format!("known are {}", known.join(", ")) };
        let message = format!("the material `{name}` is not defined in a library ({known}); plain grey is used");
        Warning { place: self.path.display().to_string(), message }
    }

    fn maps(&mut self, mtl: &tobj::Material, file: &Path, model: &mut Model) -> Result<MaterialMaps, LoadError> {
        let other = |keyword: &str| mtl.unknown_param.get(keyword).map(String::as_str);
        let colours = PixelMeaning::Colors;
        let texture =
            |statement: Option<&str>, textures: &mut ObjTextures<'_>, meaning: PixelMeaning, model: &mut Model| {
                let Some(map) = statement.and_then(TextureMap::parse) else { return Ok(None) };
                textures.texture(&map, meaning, file, &mtl.name, model)
            };
        let number = |keyword: &str, textures: &mut ObjTextures<'_>, model: &mut Model| {
            let Some(map) = other(keyword).and_then(TextureMap::parse) else { return Ok(None) };
            let id = textures.texture(&map, PixelMeaning::Numbers, file, &mtl.name, model)?;
            Ok::<_, LoadError>(id.map(|id| (id, map.channel.unwrap_or(Channel::Red))))
        };
        let textures = &mut self.textures;
        let (metallic, roughness, clearcoat) = match is_glass(mtl) {
            true => (None, None, None),
            false => (
                number("map_Pm", textures, model)?,
                number("map_Pr", textures, model)?,
                number("map_Pc", textures, model)?,
            ),
        };
        let alpha = mtl.dissolve_texture.as_deref();
        let channel = alpha.and_then(TextureMap::parse).and_then(|map| map.channel);
        let normal_map = other("norm").or(mtl.normal_texture.as_deref());
        let scale = normal_map.and_then(TextureMap::parse).map_or(1.0, |map| map.bump);
        let normal_map = texture(normal_map, textures, PixelMeaning::NormalMap, model)?;
        Ok(MaterialMaps {
            diffuse: texture(mtl.diffuse_texture.as_deref(), textures, colours, model)?,
            specular: texture(mtl.specular_texture.as_deref(), textures, colours, model)?,
            emission: texture(other("map_Ke"), textures, colours, model)?,
            metallic,
            roughness,
            clearcoat,
            sheen: if is_glass(mtl) { None } else { texture(other("map_Ps"), textures, colours, model)? },
            alpha: texture(alpha, textures, PixelMeaning::Alpha(channel), model)?,
            normal_map: normal_map.map(|texture| NormalMap { texture, scale }),
        })
    }

    /// True if meshes of this material need tangents.
    pub(super) fn needs_tangents(&self, name: Option<&str>) -> bool {
        name.and_then(|name| self.known.get(name)).is_some_and(|(mtl, _)| needs_tangents(mtl))
    }

    /// Warns of parameters that no surface here has.
    fn warn_about_unused(mtl: &tobj::Material, file: &Path, model: &mut Model) {
        let of_glass = if is_glass(mtl) { &UNUSED_BY_GLASS[..] } else { &[] };
        let present = |keyword: &&str| mtl.unknown_param.get(*keyword).is_some_and(|text| text != "0");
        let unknown = UNUSED.iter().chain(of_glass).copied().filter(present);
        for keyword in mtl.shininess_texture.iter().map(|_| "map_Ns").chain(unknown) {
            let place = format!("{}: material `{}`", file.display(), mtl.name);
            model.warnings.push(Warning { place, message: format!("`{keyword}` is not supported") });
        }
    }
}
