//! Materials by name, added to the scene when a node first refers to them.

use std::collections::{HashMap, HashSet};

use indexmap::IndexMap;
use rt_math::Rgb;
use rt_shading::{ColorTexture, Phong, Transmission};

use super::physical::PhysicalReader;
use super::texture::Textures;
use super::value::{colour, positive, within};
use crate::diagnostics::Diagnostics;
use crate::format;
use crate::{LoadErrorKind, Material, MaterialId, limits};

/// Index of refraction of a transparent material that does not say: crown glass.
const DEFAULT_IOR: f64 = 1.5;

/// Name of the material of shapes that have none.
const DEFAULT_NAME: &str = "default";

/// A material of a node, and its path in the document.
pub(super) struct Assigned<'a> {
    pub(super) path: String,
    pub(super) material: &'a format::NodeMaterial,
}

pub(super) struct Materials<'a> {
    definitions: &'a IndexMap<String, format::Material>,
    pub(super) list: Vec<Material>,
    ids: HashMap<&'a str, MaterialId>,
    /// Those that stand at nodes, by their path in the document.
    at_nodes: HashMap<String, MaterialId>,
    default: Option<MaterialId>,
}

impl<'a> Materials<'a> {
    pub(super) fn new(definitions: &'a IndexMap<String, format::Material>) -> Self {
        Self { definitions, list: Vec::new(), ids: HashMap::new(), at_nodes: HashMap::new(), default: None }
    }

    /// The material of a node, as [`id`](Self::id) gives it. One that stands at the node is made once for all below.
    pub(super) fn of(
        &mut self,
        assigned: Option<&Assigned<'a>>,
        textures: &mut Textures<'_>,
        report: &mut Diagnostics,
    ) -> Result<MaterialId, LoadErrorKind> {
        let (path, definition) = match assigned {
            None => return Ok(self.default_id()),
            Some(Assigned { material: format::NodeMaterial::Name(name), .. }) => {
                return self.id(Some(name), textures, report);
            }
            Some(Assigned { path, material: format::NodeMaterial::Inline(definition) }) => (path, definition),
        };
        if let Some(&id) = self.at_nodes.get(path) {
            return Ok(id);
        }
        let plain = Material::new(path.clone(), Phong::default());
        let material = changed(path, definition, plain.clone(), textures, report).unwrap_or(plain);
        let id = self.add(material);
        self.at_nodes.insert(path.clone(), id);
        Ok(id)
    }

    /// The material of this name, or the default for no name. A name that is unknown is an error; a material that is
    /// wrong is reported once and replaced by the default.
    pub(super) fn id(
        &mut self,
        name: Option<&str>,
        textures: &mut Textures<'_>,
        report: &mut Diagnostics,
    ) -> Result<MaterialId, LoadErrorKind> {
        let Some(name) = name else {
            return Ok(self.default_id());
        };
        let Some((name, definition)) = self.definitions.get_key_value(name) else {
            let known = self.definitions.keys().cloned().collect();
            return Err(LoadErrorKind::UnknownWord { kind: "material", found: name.to_owned(), known });
        };
        if let Some(&id) = self.ids.get(name.as_str()) {
            return Ok(id);
        }
        let plain = Material::new(name.clone(), Phong::default());
        let material = changed(&place_of(name), definition, plain.clone(), textures, report).unwrap_or(plain);
        let id = self.add(material);
        self.ids.insert(name, id);
        Ok(id)
    }

    fn default_id(&mut self) -> MaterialId {
        match self.default {
            Some(id) => id,
            None => {
                let id = self.add(Material::new(DEFAULT_NAME.to_owned(), Phong::default()));
                *self.default.insert(id)
            }
        }
    }

    pub(super) fn add(&mut self, material: Material) -> MaterialId {
        let id = MaterialId(self.list.len() as u32);
        self.list.push(material);
        id
    }

    /// A model's material, with the changes that the scene makes to materials of its name.
    pub(super) fn add_of_model(
        &mut self,
        material: Material,
        textures: &mut Textures<'_>,
        report: &mut Diagnostics,
    ) -> MaterialId {
        let changes = self.definitions.get(&material.name);
        let place = place_of(&material.name);
        let changed = changes.and_then(|definition| changed(&place, definition, material.clone(), textures, report));
        self.add(changed.unwrap_or(material))
    }

    /// Checks the materials that nothing refers to, without keeping them.
    pub(super) fn check_unused(&self, mut scratch: Textures<'_>, report: &mut Diagnostics) {
        let used: HashSet<&str> = self.list.iter().map(|material| material.name.as_str()).collect();
        for (name, definition) in self.definitions.iter().filter(|(name, _)| !used.contains(name.as_str())) {
            let plain = Material::new(name.clone(), Phong::default());
            changed(&place_of(name), definition, plain, &mut scratch, report);
        }
    }
}

/// The path of a material with a name.
fn place_of(name: &str) -> String {
    format!("materials[\"{name}\"]")
}

/// The material that a definition makes of `base`: a classical one changes what it names, a physical one takes its place.
/// `None` if something in it is wrong.
fn changed(
    path: &str,
    definition: &format::Material,
    base: Material,
    textures: &mut Textures<'_>,
    report: &mut Diagnostics,
) -> Option<Material> {
    let format::Material::Phong { shines, .. } = definition else {
        let read = PhysicalReader { textures, report }.material(path, &base.name, definition)?;
        let is_same = read.physical == base.physical
            && (read.shines == base.shines || base.phong.emission.is_zero())
            && read.phong.emission == base.phong.emission
            && read.body() == base.body();
        // A definition that changes nothing keeps the classical surface of the model as well. Detail stays in any case.
        return Some(if is_same {
            base
        } else {
            Material { phong: read.phong, physical: read.physical, shines: read.shines, ..base }
        });
    };
    let shines = shines.map_or(base.shines, Into::into);
    let phong = changed_phong(path, definition, base.phong, textures, report)?;
    // A change of the classical surface is meant for all integrators.
    let physical = if phong == base.phong { base.physical } else { None };
    Some(Material { phong, physical, shines, ..base })
}

/// `base` with the fields replaced that the definition gives.
fn changed_phong(
    path: &str,
    definition: &format::Material,
    base: Phong,
    textures: &mut Textures<'_>,
    report: &mut Diagnostics,
) -> Option<Phong> {
    let format::Material::Phong {
        color,
        ambient,
        diffuse,
        specular,
        exponent,
        highlight,
        emission,
        mirror,
        transmission,
        ior,
        fresnel,
        absorption,
        priority,
        shines: _,
    } = definition
    else {
        return None;
    };
    let at = |field: &str| format!("{path}.{field}");
    let mut read = |field: &str, given: &Option<format::ColorTexture>, base: ColorTexture| {
        given.as_ref().map_or(Some(base), |value| report.check(at(field), textures.coefficient(value)))
    };
    let color = read("color", color, ColorTexture::Constant(Rgb::WHITE));
    let ambient = read("ambient", ambient, base.ambient);
    let diffuse = read("diffuse", diffuse, base.diffuse);
    let specular = read("specular", specular, base.specular);
    let emission = read("emission", emission, base.emission);
    let fresnel = fresnel.unwrap_or(base.transmission.is_some_and(|t| t.fresnel));
    // Light that Fresnel's equations don't let pass is mirrored; it is not to be lost unless the file says so.
    let passes = transmission.is_some() || base.transmission.is_some();
    let unsaid =
        if fresnel && passes && base.mirror.is_zero() { ColorTexture::Constant(Rgb::WHITE) } else { base.mirror };
    let mirror = read("mirror", mirror, unsaid);
    let before = base.transmission;
    let passing = read("transmission", transmission, before.map_or(ColorTexture::ZERO, |t| t.coefficient));
    let exponent =
        report.check(at("exponent"), within(exponent.unwrap_or(base.exponent), 0.0, limits::HIGHLIGHT_EXPONENT));
    let ior = ior.unwrap_or(before.map_or(DEFAULT_IOR, |t| t.ior));
    let ior = report.check(at("ior"), positive(ior));
    let absorption = match absorption {
        Some(value) => report.check(at("absorption"), colour(value)),
        None => Some(before.map_or(Rgb::BLACK, |t| t.absorption)),
    };
    let ambient = report.check(at("ambient"), product(color?, ambient?));
    let diffuse = report.check(at("diffuse"), product(color?, diffuse?));
    let priority = priority.unwrap_or(before.map_or(0, |t| t.priority));
    let inside = Transmission { coefficient: passing?, ior: ior?, fresnel, absorption: absorption?, priority };
    Some(Phong {
        ambient: ambient?,
        diffuse: diffuse?,
        specular: specular?,
        exponent: exponent?,
        highlight: highlight.map_or(base.highlight, Into::into),
        emission: emission?,
        mirror: mirror?,
        transmission: passes.then_some(inside),
    })
}

/// The product of a colour and a coefficient, of which one may have a texture.
fn product(color: ColorTexture, coefficient: ColorTexture) -> Result<ColorTexture, LoadErrorKind> {
    match (color, coefficient) {
        (ColorTexture::Constant(a), ColorTexture::Constant(b)) => Ok(ColorTexture::Constant(a * b)),
        (ColorTexture::Constant(a), ColorTexture::Textured(id, b))
        | (ColorTexture::Textured(id, a), ColorTexture::Constant(b)) => Ok(ColorTexture::Textured(id, a * b)),
        (ColorTexture::Textured(..), ColorTexture::Textured(..)) => Err(LoadErrorKind::invalid(
            "a texture",
            "cannot be multiplied by the texture of `color`: make one of them constant",
        )),
    }
}
