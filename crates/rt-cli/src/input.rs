//! Scenes and models as they are read, and what the loader has to say about them.

use std::path::{Path, PathBuf};

use rt_scene_io::{LoadOptions, Scene, load};

use crate::args::InputArgs;
use crate::console::Console;
use crate::error::Failure;

/// Warnings that are printed one by one; the rest is counted.
const MAX_PRINTED: usize = 20;

/// A scene, and the files that it was made of.
#[derive(Debug)]
pub(crate) struct Input {
    pub(crate) scene: Scene,
    pub(crate) files: Vec<PathBuf>,
}

/// Reads a scene for an image of the given size, by default its own, and passes on what the loader warns of.
pub(crate) fn read(args: &InputArgs, size: Option<[u32; 2]>, console: Console) -> Result<Input, Failure> {
    let options = LoadOptions { size, ..load_options(args)? };
    let scene = load(&args.scene, &options)?;
    for warning in scene.warnings.iter().take(MAX_PRINTED) {
        console.warn(format_args!("{}: {}", warning.place, warning.message));
    }
    if scene.warnings.len() > MAX_PRINTED {
        console.warn(format_args!("{} more are not shown", scene.warnings.len() - MAX_PRINTED));
    }
    let mut files = options.referenced.paths();
    files.push(args.scene.clone());
    Ok(Input { scene, files })
}

/// Options of the loader.
pub(crate) fn load_options(args: &InputArgs) -> Result<LoadOptions, Failure> {
    match &args.root {
        Some(root) if !root.is_dir() => Err(Failure::Usage(format!("--root {} is not a folder", root.display()))),
        root => Ok(LoadOptions {
            root: root.clone(),
            ground: args.ground,
            at_time: args.at_time,
            animation: args.animation.clone(),
            variant: args.variant.clone(),
            ..LoadOptions::default()
        }),
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
