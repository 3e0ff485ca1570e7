//! Scenes and models as they are read, and what the loader has to say about them.

use std::path::{Path, PathBuf};

use rt_scene_io::{InputHashes, LoadOptions, MemoryBudget, Scene, Warning, load};

use crate::args::{BackgroundChoice, InputArgs, PictureArgs};
use crate::console::Console;
use crate::error::Failure;
use crate::identity::hash_bytes;
use crate::memory;
use crate::stdin::{self, is_dash};

/// Warnings that are printed one by one; the rest is counted.
const MAX_PRINTED: usize = 20;

/// A scene, and the files that it was made of.
#[derive(Debug)]
pub(crate) struct Input {
    pub(crate) scene: Scene,
    pub(crate) files: Vec<PathBuf>,
    /// How they were read, and what memory that took.
    pub(crate) options: LoadOptions,
}

/// Reads a scene for a picture, by default its own, and passes on what the loader warns of.
pub(crate) fn read(args: &InputArgs, picture: Option<&PictureArgs>, console: Console) -> Result<Input, Failure> {
    let options = load_options(args)?;
    let options = picture.map_or(options.clone(), |picture| LoadOptions {
        size: picture.size,
        integrator: picture.integrator,
        background: match picture.background {
            Some(BackgroundChoice::Colour(colour)) => Some(colour),
            Some(BackgroundChoice::Transparent) | None => None,
        },
        has_environment: picture.env.is_some(),
        input_hashes: InputHashes::new(hash_bytes),
        ..options
    });
    let scene = load(&args.scene, &options)?;
    warn(&scene.warnings, console);
    let mut files = options.referenced.paths();
    if args.piped.is_none() {
        files.push(args.scene.clone());
    }
    Ok(Input { scene, files, options })
}

impl InputArgs {
    /// Reads the scene from standard input if that is asked for. It goes by a name that tells its format from then on.
    pub(crate) fn take_stdin(&mut self) -> Result<(), Failure> {
        if is_dash(&self.scene) {
            let file = stdin::scene(self.input_format.as_deref(), self.max_file_size)?;
            self.scene.clone_from(&file.path);
            self.piped = Some(file);
            return Ok(());
        }
        match &self.input_format {
            Some(_) => Err(Failure::Usage(
                "--input-format is for standard input (-): the name of a file tells its format".to_owned(),
            )),
            None => Ok(()),
        }
    }
}

/// Passes on what the loader warns of.
pub(crate) fn warn(warnings: &[Warning], console: Console) {
    for warning in warnings.iter().take(MAX_PRINTED) {
        console.warn(warning);
    }
    if warnings.len() > MAX_PRINTED {
        console.warn(format_args!("{} more are not shown", warnings.len() - MAX_PRINTED));
    }
}

/// Options of the loader.
pub(crate) fn load_options(args: &InputArgs) -> Result<LoadOptions, Failure> {
    if args.animation.is_some() && args.at_time.is_none() {
        return Err(Failure::Usage("--animation needs a moment of it: add --at-time".to_owned()));
    }
    match &args.root {
        Some(root) if !root.is_dir() => Err(Failure::Usage(format!("--root {} is not a folder", root.display()))),
        root => Ok(LoadOptions {
            root: root.clone(),
            ground: args.ground,
            studio_lights: args.lights.unwrap_or_default(),
            at_time: args.at_time,
            frame_time: Some(1.0 / args.pace.fps),
            shutter: args.pace.shutter,
            animation: args.animation.clone(),
            variant: args.variant.clone(),
            max_file_bytes: args.max_file_size,
            in_memory: args.piped.clone(),
            memory: memory_limit(args).map_or_else(MemoryBudget::default, MemoryBudget::of),
            ..LoadOptions::default()
        }),
    }
}

/// Most bytes of memory that a command may take, if there is a limit.
pub(crate) fn memory_limit(args: &InputArgs) -> Option<u64> {
    args.memory.unwrap_or_default().of(memory::available_bytes())
}

/// Says what the loader chose because the file leaves it open.
pub(crate) fn say_notes(scene: &Scene, console: Console) -> Result<(), Failure> {
    scene.notes.iter().try_for_each(|note| console.say(format_args!("note: {note}")))
}

/// Refuses a scene with warnings.
pub(crate) fn refuse_warnings(file: &Path, warnings: &[Warning]) -> Result<(), Failure> {
    match warnings.len() {
        0 => Ok(()),
        count => Err(Failure::Warnings { file: file.to_owned(), count }),
    }
}
