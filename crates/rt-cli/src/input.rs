//! Loading of scenes, models and environment images.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use rt_image::ImageFormat;
use rt_math::Rgb;
use rt_scene_io::{
    Background, InMemoryFile, InputHashes, LoadErrorKind, LoadOptions, MemoryBudget, Scene, SceneNode, Warning, load,
    read_environment,
};

use crate::args::{AdaptiveChoice, BackgroundChoice, ImageArgs, InputArgs};
use crate::console::Console;
use crate::error::{CliError, usage};
use crate::identity::hash_bytes;
use crate::stdin::{self, is_dash};

/// Maximum number of warnings that are printed.
const MAX_PRINTED: usize = 20;

/// Loaded scene.
#[derive(Debug)]
pub(crate) struct Input {
    pub(crate) scene: Scene,
    /// Image of `--env`.
    pub(crate) environment: Option<Background>,
    pub(crate) files: Vec<PathBuf>,
    pub(crate) options: LoadOptions,
}

/// Loads a scene and prints the warnings. `image` overrides settings on which the defaults of the loader depend.
pub(crate) fn read(args: &InputArgs, image: Option<&ImageArgs>, console: Console) -> Result<Input, CliError> {
    let mut options = load_options(args)?;
    if let Some(image) = image {
        options.size = image.size;
        options.integrator = image.integrator;
        options.spp = image.spp;
        options.overrides_adaptive = image.adaptive == Some(AdaptiveChoice::Off) || image.min_spp.is_some();
        options.has_environment = image.env.is_some();
        options.input_hashes = InputHashes::new(hash_bytes);
        if let Some(BackgroundChoice::Color(color)) = image.background {
            options.background = Some(color);
        }
    }
    refuse_results(&args.scene)?;
    let mut scene = load(&args.scene, &options)?;
    warn(&scene.warnings, console);
    let mut files = options.referenced.paths();
    let notes = unused_options(args, &options, &files, &scene);
    scene.notes.extend(notes);
    if args.piped.is_none() {
        files.push(args.scene.clone());
    }
    let env = image.and_then(|image| image.env.as_deref());
    let environment = env.map(|file| environment(file, &options)).transpose()?;
    files.extend(env.map(Path::to_owned));
    Ok(Input { scene, environment, files, options })
}

/// Refuses shards and images in place of a scene.
fn refuse_results(file: &Path) -> Result<(), CliError> {
    let is_shard = file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("part"));
    let message = match ImageFormat::from_path(file) {
        _ if is_shard => "is a shard of an image; combine the shards by `merge`",
        Ok(_) => "is an image; use `develop` or `compare`",
        Err(_) => return Ok(()),
    };
    Err(LoadErrorKind::Syntax(message.to_owned()).at(file, "").into())
}

/// Notes about options that do not apply to the scene, which refers to `files`.
fn unused_options(args: &InputArgs, options: &LoadOptions, files: &[PathBuf], loaded: &Scene) -> Vec<String> {
    let scene = args.scene.display();
    let has_extension = |file: &Path, known: [&str; 2]| {
        file.extension().is_some_and(|extension| known.iter().any(|known| extension.eq_ignore_ascii_case(known)))
    };
    let is_gltf = |file: &PathBuf| has_extension(file, ["gltf", "glb"]);
    let is_still = options.animation_end.seconds().is_none();
    let mut notes = Vec::new();
    if is_still && args.at_time.is_some() {
        notes.push(format!("the time of --at-time or --frames has no effect: nothing in {scene} is animated."));
    } else if is_still && args.timing.fps.total_cmp(&LoadOptions::DEFAULT_FPS).is_ne() {
        notes.push("--fps has no effect: no animation is shown; --frames and --at-time choose a time.".to_owned());
    }
    // A shutter that closes at once chooses a pose.
    if is_still && args.timing.shutter.is_some_and(|[opens, closes]| opens < closes) && !has_motion(loaded) {
        notes.push(format!("--shutter has no effect: nothing in {scene} moves while it is open."));
    }
    if args.variant.is_some() && !files.iter().chain([&args.scene]).any(is_gltf) {
        notes.push(format!("--variant has no effect: {scene} has no glTF model."));
    }
    if args.ground && has_extension(&args.scene, ["ron", "json"]) {
        notes.push("--ground has no effect on scene files.".to_owned());
    }
    notes
}

/// True if an object or a camera moves while the shutter is open.
fn has_motion(scene: &Scene) -> bool {
    let mut nodes: Vec<&SceneNode> =
        scene.nodes.iter().chain(scene.groups.iter().flat_map(|group| &group.nodes)).collect();
    while let Some(node) = nodes.pop() {
        if node.moves_to.is_some() {
            return true;
        }
        nodes.extend(&node.children);
    }
    scene.cameras.iter().any(|camera| camera.settings.moves_to.is_some())
}

fn environment(file: &Path, options: &LoadOptions) -> Result<Background, CliError> {
    if is_dash(file) && options.in_memory.is_some() {
        return usage("standard input cannot be both the scene and --env; name a file for one");
    }
    let piped = if is_dash(file) { Some(stdin::content(options.max_file_bytes, None)?) } else { None };
    let in_memory = piped.map(|bytes| InMemoryFile { path: file.to_owned(), bytes });
    let light = read_environment(file, Rgb::WHITE, 0.0, &LoadOptions { in_memory, ..options.clone() });
    Ok(Background::Environment(Arc::new(light.map_err(|reason| reason.at(file, ""))?)))
}

impl InputArgs {
    /// Reads a scene from standard input, and names it by its format.
    pub(crate) fn take_stdin(&mut self) -> Result<(), CliError> {
        if is_dash(&self.scene) {
            let file = stdin::scene(self.input_format.as_deref(), self.max_file_size, self.memory.limit())?;
            self.scene.clone_from(&file.path);
            self.piped = Some(file);
            return Ok(());
        }
        match &self.input_format {
            Some(_) => usage("--input-format requires standard input (-) as the scene"),
            None => Ok(()),
        }
    }
}

pub(crate) fn warn(warnings: &[Warning], console: Console) {
    for warning in warnings.iter().take(MAX_PRINTED) {
        console.warn(warning);
    }
    if warnings.len() > MAX_PRINTED {
        console.warn(format_args!("{} more are not shown", warnings.len() - MAX_PRINTED));
    }
}

pub(crate) fn load_options(args: &InputArgs) -> Result<LoadOptions, CliError> {
    match &args.asset_root {
        Some(root) if !root.is_dir() => {
            usage(format!("--asset-root {} is not a directory; choose another one", root.display()))
        }
        root => Ok(LoadOptions {
            root: root.clone(),
            ground: args.ground,
            studio_lights: args.lights,
            at_time: args.at_time,
            frame_time: Some(1.0 / args.timing.fps),
            shutter: args.timing.shutter,
            animation: args.animation.clone(),
            variant: args.variant.clone(),
            max_file_bytes: args.max_file_size,
            in_memory: args.piped.clone(),
            memory: args.memory.limit().map_or_else(MemoryBudget::default, MemoryBudget::of),
            ..LoadOptions::default()
        }),
    }
}

/// Prints defaults that the loader chose.
pub(crate) fn print_notes(scene: &Scene, console: Console) -> Result<(), CliError> {
    scene.notes.iter().try_for_each(|note| console.note(note))
}

pub(crate) fn refuse_warnings(file: &Path, warnings: &[Warning]) -> Result<(), CliError> {
    match warnings.len() {
        0 => Ok(()),
        count => Err(CliError::Warnings { file: file.to_owned(), count }),
    }
}
