//! Scenes and models as they are read, and what the loader has to say about them.

use std::path::Path;

use rt_scene_io::{LoadOptions, Scene, load};

use crate::args::InputArgs;
use crate::console::Console;
use crate::error::Failure;

/// Warnings that are printed one by one; the rest is counted.
const MAX_PRINTED: usize = 20;

/// Reads a scene, and passes on what the loader warns of.
pub(crate) fn read_scene(args: &InputArgs, console: Console) -> Result<Scene, Failure> {
    let scene = load(&args.scene, &load_options(args)?)?;
    for warning in scene.warnings.iter().take(MAX_PRINTED) {
        console.warn(format_args!("{}: {}", warning.place, warning.message));
    }
    if scene.warnings.len() > MAX_PRINTED {
        console.warn(format_args!("{} more are not shown", scene.warnings.len() - MAX_PRINTED));
    }
    Ok(scene)
}

/// Options of the loader.
pub(crate) fn load_options(args: &InputArgs) -> Result<LoadOptions, Failure> {
    match &args.root {
        Some(root) if !root.is_dir() => Err(Failure::Usage(format!("--root {} is not a folder", root.display()))),
        root => Ok(LoadOptions { root: root.clone(), ground: args.ground, ..LoadOptions::default() }),
    }
}

/// Says what the loader chose because the file leaves it open.
pub(crate) fn say_notes(scene: &Scene, console: Console) -> Result<(), Failure> {
    scene.notes.iter().try_for_each(|note| console.say(format_args!("note: {note}")))
}

/// Refuses a scene with warnings.
pub(crate) fn refuse_warnings(file: &Path, scene: &Scene) -> Result<(), Failure> {
    match scene.warnings.len() {
        0 => Ok(()),
        count => Err(Failure::Warnings { file: file.to_owned(), count }),
    }
}
