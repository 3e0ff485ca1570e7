//! Any file to a scene, by the ending of its name.

use std::path::Path;

use crate::bare::scene_around;
use crate::format::{SceneFile, parse_json, parse_ron};
use crate::resolve::{resolve, resolve_with};
use crate::{LoadError, LoadOptions, Scene, load_model, read_text};

/// Loads a scene (`.ron`, `.json`) or a bare model (`.obj`, `.gltf`, `.glb`, `.nff`, `.pbrt`,
/// `.ply`, `.stl`).
///
/// What the file leaves open is chosen, and said in [`Scene::notes`]: a camera that sees everything, a key and a fill
/// light, an exposure that suits the lights of a model, a ground plane if `options.ground` asks for it.
///
/// # Errors
/// Everything that is wrong with the file and those that it refers to.
pub fn load(path: &Path, options: &LoadOptions) -> Result<Scene, LoadError> {
    let options = options.rooted_at(path);
    match read_scene_file(path)? {
        Some(file) => resolve(&file, path, &options),
        None => load_bare(path, &options).map(|(_, scene)| scene),
    }
}

/// A model as a scene, and the scene file that would give the same.
pub(crate) fn load_bare(path: &Path, options: &LoadOptions) -> Result<(SceneFile, Scene), LoadError> {
    let model = load_model(path, options)?;
    let reference = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let (mut file, mut notes) = scene_around(&model, &reference, options);
    let mut scene = resolve_with(&mut file, path, options, Some((reference, model)))?;
    notes.append(&mut scene.notes);
    scene.notes = notes;
    Ok((file, scene))
}

/// Parses a scene file; `None` if the name ends otherwise.
pub(crate) fn read_scene_file(path: &Path) -> Result<Option<SceneFile>, LoadError> {
    let parse = match ending(path).as_str() {
        "ron" => parse_ron,
        "json" => parse_json,
        _ => return Ok(None),
    };
    let text = read_text(path).map_err(|reason| reason.at(path, ""))?;
    parse(&text, path).map(Some)
}

/// The ending of a file's name in lower case.
pub(crate) fn ending(path: &Path) -> String {
    path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}
