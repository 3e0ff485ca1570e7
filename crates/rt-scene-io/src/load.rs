//! Loading by file extension.

use std::path::Path;

use crate::default_scene::{needs_bounds, scene_for_model};
use crate::format::{SceneFile, parse_json, parse_ron};
use crate::load_model::KNOWN_EXTENSIONS;
use crate::memory::Reservation;
use crate::memory::reserve_scene;
use crate::resolve::{resolve, resolve_with};
use crate::{LoadError, LoadErrorKind, LoadOptions, Scene, load_model, read_text};

/// Loads a scene (`.ron`, `.json`) or a bare model (`.obj`, `.gltf`, `.glb`, `.nff`, `.pbrt`, `.ply`, `.stl`).
///
/// Missing fields are filled in and listed in [`Scene::notes`]. These are a camera that shows the whole scene, key
/// and fill light, and an exposure for the lights of a model. With `options.ground` there is a ground plane.
///
/// # Errors
/// Every error in the file and in those that it refers to.
pub fn load(path: &Path, options: &LoadOptions) -> Result<Scene, LoadError> {
    let options = options.rooted_at(path);
    match read_scene_file(path, &options)? {
        Some((file, _reservation)) => resolve_located(&file, path, &options),
        None => load_standalone_model(path, &options).map(|(_, scene)| scene),
    }
}

/// Version of [`resolve`] whose errors have lines and columns.
pub(crate) fn resolve_located(file: &SceneFile, path: &Path, options: &LoadOptions) -> Result<Scene, LoadError> {
    resolve(file, path, options).map_err(|error| match read_text(path, options) {
        Ok(text) => error.with_positions(path, &text),
        Err(_) => error,
    })
}

/// Extensions of scenes and models, for messages.
const ALL_EXTENSIONS: &str = ".ron, .json, .obj, .gltf, .glb, .nff, .pbrt, .ply, .stl";

fn is_model(path: &Path) -> bool {
    let extension = extension(path);
    KNOWN_EXTENSIONS.split(", ").any(|known| known.strip_prefix('.') == Some(&extension))
}

/// A model as a scene, and the scene file that would give the same.
pub(crate) fn load_standalone_model(path: &Path, options: &LoadOptions) -> Result<(SceneFile, Scene), LoadError> {
    if !is_model(path) {
        if path.is_dir() {
            return Err(LoadErrorKind::Directory.at(path, ""));
        }
        return Err(LoadErrorKind::UnknownFormat { known: ALL_EXTENSIONS }.at(path, ""));
    }
    let model = load_model(path, options)?;
    let reference = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    // Choices are made for the pose at rest, so that they are constant over an animation.
    let at_rest = match options.at_time {
        Some(_) if needs_bounds(&model, options) => {
            Some(load_model(path, &LoadOptions { at_time: None, ..options.clone() })?)
        }
        _ => None,
    };
    let (mut file, mut notes) = scene_for_model(&model, at_rest.as_ref().unwrap_or(&model), &reference, options);
    let (mut scene, fields) = resolve_with(&file, path, options, Some((reference, model)))?;
    fields.write_to(&mut file);
    notes.append(&mut scene.notes);
    scene.notes = notes;
    Ok((file, scene))
}

/// Parses a scene file, with a reservation for its memory; `None` for other extensions.
pub(crate) fn read_scene_file(
    path: &Path,
    options: &LoadOptions,
) -> Result<Option<(SceneFile, Reservation)>, LoadError> {
    let parse = match extension(path).as_str() {
        "ron" => parse_ron,
        "json" => parse_json,
        _ => return Ok(None),
    };
    let fail = |reason: LoadErrorKind| reason.at(path, "");
    let reservation = reserve_scene(path, options).map_err(fail)?;
    let text = read_text(path, options).map_err(fail)?;
    parse(&text, path).map(|file| Some((file, reservation)))
}

/// Lower-case extension of a file name.
pub(crate) fn extension(path: &Path) -> String {
    path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}
