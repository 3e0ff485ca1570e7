//! The materials of an OBJ file: libraries are read at once, materials and their textures when first used.

use std::{
    collections::HashMap,
    path::{Path, PathBuf},
    sync::Arc,
};

use rt_shading::{Material, Phong, Texture, TextureId, Wrap};

use super::{
    lines,
    map::Map,
    material::{Maps, phong, physical},
    mtl, warning,
};
use crate::{
    LoadError, LoadOptions, MaterialId, Model, Place, Reason, Warning,
    files::{read_file, read_texture, resolve_path},
};

/// Parameters of physical materials, and maps, that have no effect here: sheen, coat, brushed metal, relief.
const UNUSED: [&str; 13] =
    ["Ps", "Pc", "Pcr", "aniso", "anisor", "map_Pr", "map_Pm", "map_Ps", "map_Pc", "norm", "disp", "decal", "refl"];

pub(super) struct Library<'a> {
    options: &'a LoadOptions,
    /// The OBJ file, for messages.
    path: &'a Path,
    /// By name: the material, and the file that it comes from. Of materials of the same name the first counts.
    known: HashMap<String, (tobj::Material, PathBuf)>,
    /// Whether names that are not known have been explained already by a missing library.
    incomplete: bool,
    /// By name, and whether the colours of vertices tint it.
    used: HashMap<(Option<String>, bool), MaterialId>,
    /// By file, and whether it ends at its edge.
    textures: HashMap<(PathBuf, bool), TextureId>,
}

/// The colours of vertices, times a texture if there is one.
fn tinted(texture: Option<TextureId>, model: &mut Model) -> TextureId {
    let below = texture.and_then(|id| model.textures.get(id.0 as usize)).map(|texture| Arc::new(texture.clone()));
    model.textures.push(Texture::VertexColor(below));
    TextureId(model.textures.len() as u32 - 1)
}

impl<'a> Library<'a> {
    /// Reads the libraries that `mtllib` statements name. One that is not there is a warning.
    pub(super) fn open(
        statements: &[(usize, String)],
        path: &'a Path,
        options: &'a LoadOptions,
        model: &mut Model,
    ) -> Result<Self, LoadError> {
        let (known, textures) = (HashMap::new(), HashMap::new());
        let mut library = Self { options, path, known, incomplete: false, used: HashMap::new(), textures };
        for (line, names) in statements {
            library.open_all(names, *line, model)?;
        }
        Ok(library)
    }

    /// A statement names one file, whose name may contain spaces, or several files.
    fn open_all(&mut self, names: &str, line: usize, model: &mut Model) -> Result<(), LoadError> {
        let resolve = |name: &str| match resolve_path(name, self.path, self.options) {
            Err(Reason::MissingReference { .. }) => Ok(None),
            found => found.map(Some).map_err(|reason| reason.at(self.path, Place::Line(line))),
        };
        let mut files = Vec::new();
        let mut missing = Vec::new();
        match resolve(names)? {
            Some(file) => files.push(file),
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
            let message = format!("the material library `{name}` is not there; its materials become plain grey");
            model.warnings.push(warning(self.path, line, message));
        }
        Ok(())
    }

    fn read(&mut self, file: &Path, model: &mut Model) -> Result<(), LoadError> {
        let bytes = match read_file(file) {
            Err(Reason::Empty) => Vec::new(),
            bytes => bytes.map_err(|reason| reason.at(file, ""))?,
        };
        let (materials, complaints) = mtl::parse(&lines::decode(&bytes).0);
        for (line, message) in complaints {
            model.warnings.push(warning(file, line, format!("{message}; the statement is left out")));
        }
        for material in materials {
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
                let mut maps = Maps {
                    diffuse: self.texture(mtl.diffuse_texture.as_deref(), &mtl, &file, model)?,
                    specular: self.texture(mtl.specular_texture.as_deref(), &mtl, &file, model)?,
                    emission: self.texture(mtl.unknown_param.get("map_Ke").map(String::as_str), &mtl, &file, model)?,
                };
                if has_colours {
                    maps.diffuse = Some(tinted(maps.diffuse, model));
                }
                Self::warn_about_unused(&mtl, &file, model);
                Material { physical: physical(&mtl, maps), ..Material::new(mtl.name.clone(), phong(&mtl, maps)) }
            }
            None => {
                if let (Some(name), false) = (&name, self.incomplete) {
                    model.warnings.push(self.unknown(name));
                }
                let mtl = tobj::Material::default();
                let maps = Maps { diffuse: has_colours.then(|| tinted(None, model)), ..Maps::default() };
                let phong = if has_colours { phong(&mtl, maps) } else { Phong::default() };
                Material::new(name.clone().unwrap_or_else(|| "default".to_owned()), phong)
            }
        };
        let id = MaterialId(model.materials.len() as u32);
        model.materials.push(material);
        self.used.insert((name, has_colours), id);
        Ok(id)
    }

    fn unknown(&self, name: &str) -> Warning {
        let mut known: Vec<&str> = self.known.keys().map(String::as_str).collect();
        known.sort_unstable();
        known.truncate(24);
        let known =
            if known.is_empty() { "there are none".to_owned() } else { format!("known are {}", known.join(", ")) };
        let message = format!("the material `{name}` is in no library ({known}); it becomes plain grey");
        Warning { place: self.path.display().to_string(), message }
    }

    /// The texture of a statement. An image that is not there is a warning; a damaged one is an error.
    fn texture(
        &mut self,
        statement: Option<&str>,
        mtl: &tobj::Material,
        file: &Path,
        model: &mut Model,
    ) -> Result<Option<TextureId>, LoadError> {
        let Some(map) = statement.and_then(Map::parse) else { return Ok(None) };
        let place = format!("material `{}`", mtl.name);
        let mut warn = |message| {
            let place = format!("{}: {place}", file.display());
            model.warnings.push(Warning { place, message });
        };
        for option in &map.ignored {
            warn(format!("the texture option `{option}` of `{}` is not followed", map.file));
        }
        let image = match resolve_path(&map.file, file, self.options) {
            Ok(image) => image,
            Err(Reason::MissingReference { .. }) => {
                warn(format!("the image `{}` is not there; the plain colour is used", map.file));
                return Ok(None);
            }
            Err(reason) => return Err(reason.at(file, place)),
        };
        let id = self.image((image, map.clamp), model)?;
        if map.has_own_coordinates() {
            let Some(texture) = model.textures.get(id.0 as usize).cloned().map(Arc::new) else { return Ok(None) };
            model.textures.push(Texture::Mapped { texture, map: map.coordinates() });
            return Ok(Some(TextureId(model.textures.len() as u32 - 1)));
        }
        Ok(Some(id))
    }

    /// The texture of an image file, which is read once.
    fn image(&mut self, key: (PathBuf, bool), model: &mut Model) -> Result<TextureId, LoadError> {
        if let Some(&id) = self.textures.get(&key) {
            return Ok(id);
        }
        let bitmap = read_texture(&key.0).map_err(|reason| reason.at(&key.0, ""))?;
        let id = TextureId(model.textures.len() as u32);
        let wrap = [if key.1 { Wrap::Clamp } else { Wrap::Repeat }; 2];
        model.textures.push(Texture::Image { bitmap: Arc::new(bitmap), wrap, smooth: true });
        self.textures.insert(key, id);
        Ok(id)
    }

    /// Warns of what the material says and no surface here can show.
    fn warn_about_unused(mtl: &tobj::Material, file: &Path, model: &mut Model) {
        let maps = [
            ("map_d", mtl.dissolve_texture.is_some()),
            ("map_Ns", mtl.shininess_texture.is_some()),
            ("map_Bump", mtl.normal_texture.is_some()),
        ];
        let unknown = UNUSED.map(|keyword| (keyword, mtl.unknown_param.get(keyword).is_some_and(|text| text != "0")));
        for (keyword, _) in maps.into_iter().chain(unknown).filter(|(_, present)| *present) {
            let place = format!("{}: material `{}`", file.display(), mtl.name);
            model.warnings.push(Warning { place, message: format!("`{keyword}` is not followed") });
        }
    }
}
