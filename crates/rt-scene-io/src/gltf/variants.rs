//! Materials that depend on a choice (KHR_materials_variants).

use gltf::{Document, Material, Primitive};
use serde::Deserialize;

use crate::parser_message::plain;
use crate::{LoadError, LoadErrorKind};
use std::path::Path;

pub(super) const NAME: &str = "KHR_materials_variants";

/// The object of the extension at the root.
#[derive(Deserialize)]
struct Variants {
    variants: Vec<Variant>,
}

#[derive(Deserialize)]
struct Variant {
    name: String,
}

/// The object of the extension at a primitive.
#[derive(Deserialize)]
struct Mappings {
    mappings: Vec<Mapping>,
}

#[derive(Deserialize)]
struct Mapping {
    material: usize,
    variants: Vec<usize>,
}

/// The index of the variant of this name.
pub(super) fn find(name: &str, document: &Document, path: &Path) -> Result<usize, LoadError> {
    let place = format!("extensions.{NAME}");
    let variants = match document.extension_value(NAME).map(Variants::deserialize) {
        Some(Ok(list)) => list.variants,
        Some(Err(error)) => return Err(LoadErrorKind::Syntax(plain(&error.to_string())).at(path, place)),
        None => Vec::new(),
    };
    variants.iter().position(|variant| variant.name == name).ok_or_else(|| {
        let known = variants.into_iter().map(|variant| variant.name).collect();
        LoadErrorKind::unknown("variant", name, known).at(path, place)
    })
}

/// The material of a primitive in a variant; its own where the variant has none.
pub(super) fn material<'a>(
    primitive: &Primitive<'a>,
    variant: Option<usize>,
    document: &'a Document,
    path: &Path,
    place: &str,
) -> Result<Material<'a>, LoadError> {
    let (Some(variant), Some(object)) = (variant, primitive.extension_value(NAME)) else {
        return Ok(primitive.material());
    };
    let fail = |reason: LoadErrorKind| reason.at(path, format!("{place}.extensions.{NAME}"));
    let Mappings { mappings } =
        Mappings::deserialize(object).map_err(|error| fail(LoadErrorKind::Syntax(plain(&error.to_string()))))?;
    let Some(mapping) = mappings.iter().find(|mapping| mapping.variants.contains(&variant)) else {
        return Ok(primitive.material());
    };
    let count = document.materials().len();
    let rule = || format!("is not the index of a material; there are {count}");
    document.materials().nth(mapping.material).ok_or_else(|| fail(LoadErrorKind::invalid(mapping.material, rule())))
}
