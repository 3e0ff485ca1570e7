//! JSON to a document with valid references.
//!
//! The `gltf` crate indexes unchecked in some places and panics. Here the JSON is checked first. Findings of the crate's own
//! validation become errors with place and value.

use std::path::Path;

use gltf::{
    Document,
    json::{Root, validation::Error, validation::Validate},
};
use serde_json::Value;

use super::attribute_rules;
use crate::diagnostics::Diagnostics;
use crate::error::ErrorAt;
use crate::parser_message::plain;
use crate::sanitize::shortened;
use crate::{LoadError, LoadErrorKind, Location, Warning, limits};

const SUPPORTED: [&str; 19] = [
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_texture_transform",
];

/// The JSON part of a file.
#[derive(Debug)]
pub(super) struct ParsedDocument {
    pub(super) document: Document,
    /// The list of animations, unchecked: it matters only to those who play one.
    pub(super) animations: Value,
}

/// Reads and checks the JSON part of a file.
pub(super) fn parse(json: &[u8], path: &Path, warnings: &mut Vec<Warning>) -> Result<ParsedDocument, LoadError> {
    let mut value: Value = serde_json::from_slice(json).map_err(|error| syntax(&error, path))?;
    normalize_integers(&mut value);
    add_lists_of_nodes(&mut value);
    check_version(&value).at(path, "asset.version")?;
    check_extensions(&value, path, warnings)?;
    check_primitives(&value, path, warnings)?;
    check_depth(&value, path)?;
    let animations = value.as_object_mut().and_then(|root| root.remove("animations")).unwrap_or_default();
    let root = read_root(&value).map_err(|error| {
        // Only a parse of the text of the file reports the line, but it may fail earlier, at whole numbers with a point.
        Root::from_slice(json)
            .err()
            .filter(|located| message(located) == message(&error))
            .map_or_else(|| LoadErrorKind::Syntax(message(&error)).at(path, ""), |located| syntax(&located, path))
    })?;
    check_references(&root, &value, path)?;
    refuse(attribute_rules::check(&root, warnings), path)?;
    Ok(ParsedDocument { document: Document::from_json_without_validation(root), animations })
}

/// The types of the crate from a checked value, by way of its text. To read the value directly, code for all types would be compiled
/// here once more.
fn read_root(value: &Value) -> Result<Root, serde_json::Error> {
    Root::from_slice(&serde_json::to_vec(value)?)
}

fn syntax(error: &serde_json::Error, path: &Path) -> LoadError {
    LoadErrorKind::Syntax(message(error)).at(path, Location::Position(error.line(), error.column()))
}

/// Message without a line.
fn message(error: &serde_json::Error) -> String {
    let message = error.to_string();
    plain(message.rfind(" at line ").map_or(message.as_str(), |end| &message[..end]))
}

/// Writes whole numbers as integers: JSON treats `1.0` and `1` alike, but the types of the `gltf` crate do not. The JSON parser
/// bounds the depth of values.
fn normalize_integers(value: &mut Value) {
    match value {
        Value::Array(list) => list.iter_mut().for_each(normalize_integers),
        Value::Object(map) => map.values_mut().for_each(normalize_integers),
        Value::Number(number) => {
            // Beyond this, a number with a fraction no longer has one.
            const MAX_EXACT_INTEGER: f64 = 9_007_199_254_740_992.0;
            let whole =
                number.as_f64().filter(|x| number.is_f64() && x.trunc() == *x && (0.0..=MAX_EXACT_INTEGER).contains(x));
            if let Some(whole) = whole {
                *number = (whole as u64).into();
            }
        }
        Value::Null | Value::Bool(_) | Value::String(_) => {}
    }
}

/// Adds an empty list of nodes to scenes without nodes: optional in the format, required by the crate.
fn add_lists_of_nodes(value: &mut Value) {
    let scenes = value.get_mut("scenes").and_then(Value::as_array_mut).into_iter().flatten();
    for scene in scenes.filter_map(Value::as_object_mut) {
        scene.entry("nodes").or_insert_with(|| Value::Array(Vec::new()));
    }
}

fn check_version(value: &Value) -> Result<(), LoadErrorKind> {
    let asset = value.get("asset");
    let field = |name: &str| asset.and_then(|asset| asset.get(name)).and_then(Value::as_str);
    let Some(version) = field("version") else {
        // In glTF 1.0 the version was optional, and lists were maps.
        if value.get("meshes").is_some_and(Value::is_object) {
            return Err(LoadErrorKind::Unsupported("glTF version 1.0".to_owned()));
        }
        let problem = match asset.and_then(|asset| asset.get("version")) {
            Some(_) => "must be a string: \"2.0\"",
            None => "is missing; it must be \"2.0\"",
        };
        return Err(LoadErrorKind::Syntax(problem.to_owned()));
    };
    let min_version = field("minVersion").unwrap_or("2.0");
    match version.split_once('.') {
        Some(("2", _)) if min_version == "2.0" => Ok(()),
        Some(("2", _)) => Err(LoadErrorKind::Unsupported(format!("glTF of at least version {min_version}"))),
        Some(("1", _)) => Err(LoadErrorKind::Unsupported(format!("glTF version {version} (1.x)"))),
        _ => Err(LoadErrorKind::Unsupported(format!("glTF version {version}"))),
    }
}

/// Unknown required extensions are refused, unknown optional ones are warned about.
fn check_extensions(value: &Value, path: &Path, warnings: &mut Vec<Warning>) -> Result<(), LoadError> {
    let names = |key: &str| list(value, key).iter().filter_map(Value::as_str).collect::<Vec<_>>();
    let unknown = |name: &&str| !SUPPORTED.contains(name);
    let required = names("extensionsRequired");
    let problems = required.iter().copied().filter(unknown).map(|name| {
        let kind = LoadErrorKind::Unsupported(format!("the required extension {name}"));
        ("extensionsRequired".to_owned(), kind)
    });
    refuse(problems.collect(), path)?;
    for name in names("extensionsUsed").into_iter().filter(unknown) {
        let message = format!("the optional extension {name} is not supported");
        warnings.push(Warning { place: "extensionsUsed".to_owned(), message });
    }
    Ok(())
}

/// Checks the position accessors of primitives, which the validation of the `gltf` crate assumes. Warns of unknown morphed
/// attributes.
fn check_primitives(value: &Value, path: &Path, warnings: &mut Vec<Warning>) -> Result<(), LoadError> {
    let accessors = list(value, "accessors");
    let mut problems = Vec::new();
    for (m, mesh) in list(value, "meshes").iter().enumerate() {
        for (p, primitive) in list(mesh, "primitives").iter().enumerate() {
            let place = format!("meshes[{m}].primitives[{p}]");
            let targets = list(primitive, "targets").iter().filter_map(Value::as_object);
            let unknown = |name: &&String| !["POSITION", "NORMAL", "TANGENT"].contains(&name.as_str());
            if let Some(name) = targets.flat_map(|target| target.keys()).find(unknown) {
                let message = format!("morph targets of {name} are not supported");
                warnings.push(Warning { place: place.clone(), message });
            }
            let Some(position) = primitive.get("attributes").and_then(|all| all.get("POSITION")) else { continue };
            let accessor = position.as_u64().and_then(|i| accessors.get(usize::try_from(i).ok()?));
            if accessor.is_none() {
                let reason = LoadErrorKind::invalid(
                    position,
                    format!("is not the index of an accessor; there are {}", accessors.len()),
                );
                problems.push((format!("{place}.attributes.POSITION"), reason));
            }
        }
    }
    refuse(problems, path)
}

/// Refuses a tree that is too deep, before memory is allocated for its nodes. Cycles have no root and are refused later.
fn check_depth(value: &Value, path: &Path) -> Result<(), LoadError> {
    let nodes = list(value, "nodes");
    let children = |node: usize| {
        let indices = list(&nodes[node], "children").iter().filter_map(Value::as_u64);
        indices.filter_map(|child| usize::try_from(child).ok().filter(|&child| child < nodes.len()))
    };
    let mut is_child = vec![false; nodes.len()];
    let mut stack = Vec::new();
    for node in 0..nodes.len() {
        children(node).for_each(|child| is_child[child] = true);
    }
    stack.extend((0..nodes.len()).filter(|&node| !is_child[node]).map(|root| (root, 1)));
    while let Some((node, depth)) = stack.pop() {
        let checked = LoadErrorKind::check_limit("the depth of the tree", depth, limits::NODE_DEPTH);
        checked.at(path, format!("nodes[{node}]"))?;
        // A node that several others claim is refused later; here it is visited once.
        stack.extend(
            children(node).filter(|&child| core::mem::take(&mut is_child[child])).map(|child| (child, depth + 1)),
        );
    }
    Ok(())
}

fn list<'a>(value: &'a Value, key: &str) -> &'a [Value] {
    value.get(key).and_then(Value::as_array).map_or(&[], Vec::as_slice)
}

/// Runs the validation of the `gltf` crate.
fn check_references(root: &Root, value: &Value, path: &Path) -> Result<(), LoadError> {
    let mut problems = Vec::new();
    root.validate(root, gltf::json::Path::new, &mut |place, error| {
        let place = written_place(&place().to_string());
        if is_harmless(&place, error) {
            return;
        }
        let found = lookup(value, &place).map(Value::to_string);
        let reason = match (error, found) {
            (Error::IndexOutOfBounds, Some(found)) => {
                LoadErrorKind::invalid(found, "is out of range: there is no object of this index")
            }
            (Error::Missing, _) => LoadErrorKind::Syntax("is missing".to_owned()),
            (_, Some(found)) => LoadErrorKind::invalid(shortened(&found), "is not valid"),
            (_, None) => LoadErrorKind::Syntax("is not valid".to_owned()),
        };
        problems.push((place, reason));
    });
    refuse(problems, path)
}

/// True for findings without effect: bounds and unknown attributes are not used, accessors without a view hold zeros, and
/// extensions are checked elsewhere.
fn is_harmless(place: &str, error: Error) -> bool {
    place.starts_with("extensionsRequired")
        || place.ends_with(".min")
        || place.ends_with(".max")
        || place.ends_with("[\"<invalid semantic name>\"]")
        || (error == Error::Missing && place.starts_with("accessors[") && place.ends_with("].bufferView"))
}

/// A path of the `gltf` crate with the names of extensions as in files: `KHR_lights_punctual` for `khrLightsPunctual`.
fn written_place(place: &str) -> String {
    let written = |step: &str| {
        let named = |name: &&&str| name.replace('_', "").eq_ignore_ascii_case(step);
        SUPPORTED.iter().find(named).map_or_else(|| step.to_owned(), |name| (*name).to_owned())
    };
    place.split('.').map(written).collect::<Vec<_>>().join(".")
}

/// The value at a path such as `meshes[0].primitives[1].attributes["POSITION"]`.
fn lookup<'a>(value: &'a Value, place: &str) -> Option<&'a Value> {
    let steps = place.split(['.', '[', ']']).map(|step| step.trim_matches('"')).filter(|step| !step.is_empty());
    steps.into_iter().try_fold(value, |value, step| match value {
        Value::Array(list) => list.get(step.parse::<usize>().ok()?),
        _ => value.get(step),
    })
}

fn refuse(errors: Vec<(String, LoadErrorKind)>, path: &Path) -> Result<(), LoadError> {
    let mut diagnostics = Diagnostics::new(path);
    for (place, kind) in errors {
        diagnostics.check::<()>(place, Err(kind));
    }
    diagnostics.finish().map(drop)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(json: &str) -> String {
        parse(json.as_bytes(), Path::new("m.gltf"), &mut Vec::new()).expect_err("a bad document").to_string()
    }

    #[test]
    fn versions() {
        let asset = |fields: &str| refused(&format!(r#"{{"asset": {{{fields}}}}}"#));
        assert_eq!(asset(r#""version": "1.1""#), "m.gltf: asset.version: glTF version 1.1 (1.x) is not supported");
        assert_eq!(asset(r#""version": "9.0""#), "m.gltf: asset.version: glTF version 9.0 is not supported");
        let later = r#""version": "2.1", "minVersion": "2.1""#;
        assert_eq!(asset(later), "m.gltf: asset.version: glTF of at least version 2.1 is not supported");
        assert_eq!(refused("{}"), "m.gltf: asset.version: is missing; it must be \"2.0\"");
        assert_eq!(asset(r#""version": 2.0"#), "m.gltf: asset.version: must be a string: \"2.0\"");
        assert_eq!(refused(r#"{"meshes": {}}"#), "m.gltf: asset.version: glTF version 1.0 is not supported");
    }

    #[test]
    fn extensions() {
        let json = r#"{"asset": {"version": "2.0"}, "extensionsUsed": ["A", "B"], "extensionsRequired": ["B", "C"]}"#;
        let expected = "m.gltf: extensionsRequired: the required extension B is not supported\n\
                        m.gltf: extensionsRequired: the required extension C is not supported";
        assert_eq!(refused(json), expected);
        let json = r#"{"asset": {"version": "2.0"}, "extensionsUsed": ["A", "KHR_materials_ior"]}"#;
        let mut warnings = Vec::new();
        parse(json.as_bytes(), Path::new("m.gltf"), &mut warnings).expect("optional");
        assert_eq!(warnings.len(), 1);
        assert_eq!(warnings[0].message, "the optional extension A is not supported");
    }

    #[test]
    fn whole_numbers_may_be_written_with_a_point() {
        let json = r#"{"asset": {"version": "2.0"}, "nodes": [{"mesh": 0.0, "scale": [1.0, -2.0, 0.5]}],
            "accessors": [{"componentType": 5126, "count": 3e0, "type": "VEC3"}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0.0}}]}]}"#;
        let parsed = parse(json.as_bytes(), Path::new("m.gltf"), &mut Vec::new()).expect("the same as 0 and 3");
        assert_eq!(parsed.document.accessors().next().map(|accessor| accessor.count()), Some(3));
        assert!(refused(&json.replace("3e0", "3.5")).contains("found `3.5`, expected a whole number from 0 up"));
    }

    #[test]
    fn broken_text_is_located() {
        assert_eq!(refused("{\n \"asset\": }"), "m.gltf:2:11: expected value");
        let wrong = "{\"asset\": {\"version\": \"2.0\"},\n\"nodes\": 3}";
        assert!(refused(wrong).starts_with("m.gltf:2:10: found `3`, expected"), "{}", refused(wrong));
        assert!(refused(&"[".repeat(100_000)).contains("recursion limit"));
    }

    #[test]
    fn what_does_not_matter_is_let_through() {
        let json = r#"{"asset": {"version": "2.0"}, "animations": [{"channels": 3}],
            "accessors": [{"componentType": 5126, "count": 1, "type": "VEC3"}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "COLOUR": 0}, "targets": [{"TEXCOORD_0": 0}]}]}]}"#;
        let mut warnings = Vec::new();
        parse(json.as_bytes(), Path::new("m.gltf"), &mut warnings).expect("usable");
        assert_eq!(warnings[0].message, "morph targets of TEXCOORD_0 are not supported");
    }

    #[test]
    fn errors_of_extensions_have_the_names_of_the_file() {
        let lights = r#"{"asset": {"version": "2.0"}, "extensionsUsed": ["KHR_lights_punctual"],
            "extensions": {"KHR_lights_punctual": {"lights": [{"type": "lamp"}]}}}"#;
        assert_eq!(refused(lights), "m.gltf: extensions.KHR_lights_punctual.lights[0].type: \"lamp\" is not valid");
    }

    #[test]
    fn references_to_nothing_are_refused_with_their_value() {
        let with = |rest: &str| refused(&format!(r#"{{"asset": {{"version": "2.0"}}, {rest}}}"#));
        assert_eq!(
            with(r#""nodes": [{"children": [7]}]"#),
            "m.gltf: nodes[0].children[0]: 7 is out of range: there is no object of this index"
        );
        assert_eq!(
            with(r#""meshes": [{"primitives": [{"attributes": {"POSITION": 2}}]}]"#),
            "m.gltf: meshes[0].primitives[0].attributes.POSITION: 2 is not the index of an accessor; there are 0"
        );
        assert_eq!(
            with(r#""meshes": [{"primitives": [{"attributes": {}}]}]"#),
            "m.gltf: meshes[0].primitives[0].attributes[\"POSITION\"]: is missing"
        );
        assert_eq!(
            with(r#""accessors": [{"componentType": 7, "count": 1, "type": "VEC3", "bufferView": 1}]"#),
            "m.gltf: accessors[0].bufferView: 1 is out of range: there is no object of this index\n\
             m.gltf: accessors[0].componentType: 7 is not valid"
        );
    }
}
