//! Materials by name, added to the scene when a node first refers to them.

use std::collections::{HashMap, HashSet};

use indexmap::IndexMap;
use rt_math::Rgb;
use rt_shading::{ColorTexture, InteriorMedium, MaterialModel, Phong, Transmission};

use super::material_model::ModelReader;
use super::texture::Textures;
use super::value::{colour, positive, within};
use crate::diagnostics::Diagnostics;
use crate::format;
use crate::{LoadErrorKind, Material, MaterialId, limits};

/// Default index of refraction: crown glass.
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
    /// Inline materials of nodes, by their path in the document.
    at_nodes: HashMap<String, MaterialId>,
    default: Option<MaterialId>,
}

impl<'a> Materials<'a> {
    pub(super) fn new(definitions: &'a IndexMap<String, format::Material>) -> Self {
        Self { definitions, list: Vec::new(), ids: HashMap::new(), at_nodes: HashMap::new(), default: None }
    }

    /// The material of a node, as from [`id`](Self::id). An inline material is resolved once for all nodes below.
    pub(super) fn of(
        &mut self,
        assigned: Option<&Assigned<'a>>,
        textures: &mut Textures<'_>,
        report: &mut Diagnostics,
    ) -> Result<MaterialId, LoadErrorKind> {
        let (path, definition) = match assigned {
            None => return Ok(self.default_id()),
            Some(Assigned { material: format::NodeMaterial::Name(name), .. }) => {
                return self.id(name, textures, report);
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

    /// The material of this name. A name that is unknown is an error; a material that is wrong is reported once and
    /// replaced by the default.
    pub(super) fn id(
        &mut self,
        name: &str,
        textures: &mut Textures<'_>,
        report: &mut Diagnostics,
    ) -> Result<MaterialId, LoadErrorKind> {
        let Some((name, definition)) = self.definitions.get_key_value(name) else {
            return Err(LoadErrorKind::unknown("material", name, report.names(self.definitions.keys())));
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

    /// Checks unused materials, without keeping them.
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

/// Applies a definition to `base`: `phong` replaces the fields that it names, other materials replace all.
///
/// `None` if the definition has an error.
fn changed(
    path: &str,
    definition: &format::Material,
    base: Material,
    textures: &mut Textures<'_>,
    report: &mut Diagnostics,
) -> Option<Material> {
    let format::Material::Phong { emission_sides, .. } = definition else {
        let read = ModelReader { textures, report }.material(path, &base.name, definition)?;
        let is_same = is_same_model(&read.model, &base.model)
            && (read.emission_sides == base.emission_sides || base.emission.is_zero())
            && read.emission == base.emission
            && read.interior == base.interior;
        // A definition without changes keeps the Phong override of the model. Normal map, occlusion and alpha are always kept.
        return Some(if is_same {
            base
        } else {
            let Material { model, emission, emission_sides, interior, .. } = read;
            Material { model, phong_override: None, emission, emission_sides, interior, ..base }
        });
    };
    let emission_sides = emission_sides.map_or(base.emission_sides, Into::into);
    let before = PhongMaterial { phong: *base.to_phong(), emission: base.emission, interior: base.phong_interior() };
    let after = changed_phong(path, definition, before, textures, report)?;
    if after == before {
        return Some(Material { emission_sides, ..base });
    }
    // A changed Phong material applies to all integrators.
    let PhongMaterial { phong, emission, interior } = after;
    Some(Material { model: phong.into(), phong_override: None, emission, emission_sides, interior, ..base })
}

/// True if two models are equal. Scene files describe a layered model without layers as `metallic_roughness`.
fn is_same_model(read: &MaterialModel, base: &MaterialModel) -> bool {
    match (read, base) {
        (MaterialModel::MetallicRoughness { base_color, metallic, roughness }, MaterialModel::Layered(layered)) => {
            layered.as_metallic_roughness() == Some((base_color, *metallic, *roughness))
        }
        _ => read == base,
    }
}

/// The parts of a material that a `phong` definition describes.
#[derive(Clone, Copy, PartialEq)]
struct PhongMaterial {
    phong: Phong,
    emission: ColorTexture,
    interior: Option<InteriorMedium>,
}

/// `before` with the fields replaced that the definition gives.
fn changed_phong(
    path: &str,
    definition: &format::Material,
    before: PhongMaterial,
    textures: &mut Textures<'_>,
    report: &mut Diagnostics,
) -> Option<PhongMaterial> {
    let PhongMaterial { phong: base, interior: inside, .. } = before;
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
        emission_sides: _,
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
    let emission = read("emission", emission, before.emission);
    let fresnel = fresnel.unwrap_or(base.transmission.is_some_and(|t| t.fresnel));
    // Light that Fresnel's equations reflect is mirrored unless the file says otherwise.
    let passes = transmission.is_some() || base.transmission.is_some();
    let default_mirror =
        if fresnel && passes && base.mirror.is_zero() { ColorTexture::Constant(Rgb::WHITE) } else { base.mirror };
    let mirror = read("mirror", mirror, default_mirror);
    let transmitted = base.transmission.map_or(ColorTexture::ZERO, |t| t.coefficient);
    let coefficient = read("transmission", transmission, transmitted);
    let exponent =
        report.check(at("exponent"), within(exponent.unwrap_or(base.exponent), 0.0, limits::HIGHLIGHT_EXPONENT));
    let ior = ior.unwrap_or(inside.map_or(DEFAULT_IOR, |inside| inside.ior));
    let ior = report.check(at("ior"), positive(ior));
    let absorption = match absorption {
        Some(value) => report.check(at("absorption"), colour(value)),
        None => Some(inside.map_or(Rgb::BLACK, |inside| inside.absorption)),
    };
    let ambient = report.check(at("ambient"), product(color?, ambient?));
    let diffuse = report.check(at("diffuse"), product(color?, diffuse?));
    let priority = priority.unwrap_or(inside.map_or(0, |inside| inside.priority));
    let transmission = Transmission { coefficient: coefficient?, fresnel };
    let interior = InteriorMedium { ior: ior?, absorption: absorption?, priority };
    let phong = Phong {
        ambient: ambient?,
        diffuse: diffuse?,
        specular: specular?,
        exponent: exponent?,
        highlight: highlight.map_or(base.highlight, Into::into),
        mirror: mirror?,
        transmission: passes.then_some(transmission),
    };
    Some(PhongMaterial { phong, emission: emission?, interior: passes.then_some(interior) })
}

/// Product of a colour and a coefficient, of which at most one is textured.
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

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::LoadOptions;

    /// Each error copied all names, although few errors are listed.
    #[test]
    fn errors_that_are_not_listed_copied_all_names() {
        let mirror = serde_json::from_str(r#"{"mirror": {}}"#).expect("a material");
        let definitions = IndexMap::from([("red".to_owned(), mirror)]);
        let (options, path) = (LoadOptions::default(), Path::new("a.ron"));
        let (mut materials, mut textures) = (Materials::new(&definitions), Textures::new(path, &options));
        let mut report = Diagnostics::new(path);
        for index in 0..=limits::PROBLEMS {
            let unknown = materials.id("rde", &mut textures, &mut report).expect_err("unknown");
            let LoadErrorKind::UnknownWord { known, .. } = &unknown else { panic!("{unknown}") };
            let is_listed = index < limits::PROBLEMS;
            assert_eq!(known.len(), usize::from(is_listed), "{index}");
            report.check::<()>("nodes", Err(unknown));
        }
    }
}
