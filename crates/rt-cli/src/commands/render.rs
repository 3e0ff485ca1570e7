//! `render`: an image of a scene, or a shard of it.

mod frames;

use std::path::{Path, PathBuf};
use std::time::Instant;

use rt_image::ImageFormat;
use rt_render::ShardSpec;
use rt_scene_io::LoadErrorKind;

use crate::aov_file::AovFile;
use crate::args::{CheckpointArgs, FrameChoice, RenderArgs};
use crate::checkpointer::{self, CheckpointOptions};
use crate::console::{Console, reserve_stdout};
use crate::error::{CliError, usage};
use crate::identity::Identity;
use crate::image_file;
use crate::input::{self, Input};
use crate::job::{Job, JobOutput};
use crate::output_error::OutputError;
use crate::output_file::{OutputFile, is_null_device, refuse_terminal};
use crate::settings;
use crate::signals::SignalGuard;
use crate::stdin::is_dash;

pub(super) fn run(args: &RenderArgs) -> Result<(), CliError> {
    if args.output.iter().chain(&args.run.stats).any(|path| is_dash(path)) {
        // Before anything is printed.
        reserve_stdout();
    }
    match args.frames.frames {
        Some(FrameChoice::Some(frames)) => frames::each(args, frames, image),
        Some(FrameChoice::All) => frames::each(args, frames::all(args)?, image),
        None => image(args).map(drop),
    }
}

/// Renders an image or a shard. The guard keeps signals from ending the program before the frame log is written.
fn image(args: &RenderArgs) -> Result<SignalGuard, CliError> {
    refuse_for_shards(args)?;
    let console = Console { quiet: args.run.quiet };
    let scene_file = args.input.scene.as_path();
    let shard = args.checkpoint.shard;
    let path = match &args.output {
        Some(path) => path.clone(),
        None if scene_file.file_name().is_none() => return Err(not_a_file(scene_file)),
        None => default_output(scene_file, shard, args.output_format),
    };
    let kind = OutputKind::of(&path, shard, args)?;
    if path.to_string_lossy().contains("####") {
        // With --frames, the number stands in its place.
        console.note("#### is replaced by the number of the frame only with --frames.")?;
    }
    if (is_dash(&path) || is_null_device(&path)) && args.checkpoint.resume && args.checkpoint.checkpoint.is_none() {
        return usage("--resume requires --checkpoint FILE for an image on standard output or the null device");
    }

    if args.checkpoint.checkpoint.as_deref().is_some_and(is_dash) {
        return usage("--checkpoint requires the name of a file: it cannot be read back from standard output");
    }

    let started = Instant::now();
    let Input { scene, environment, files, options: loaded } = input::read(&args.input, Some(&args.image), console)?;
    let load_seconds = started.elapsed().as_secs_f64();
    if args.run.strict {
        input::refuse_warnings(scene_file, &scene.warnings)?;
    }
    let rule = args.stop.rule(args.image.spp);
    let (development, memory) = (Some(&args.development), loaded.memory.limit());
    let (scene, mut options) = settings::resolve(scene, &args.image, development, environment.as_ref(), memory)?;
    options.progressive = rule.is_some() || args.aov.iter().any(|aov| aov.content.needs_maps());
    options.maps = shard.is_some();

    let file = match kind {
        OutputKind::Image(format) => {
            OutputFile::prepare(&path, &files)?.with_extension(image_file::extension_of(format))
        }
        OutputKind::Shard => OutputFile::prepare_over_link(&path, &files)?.with_extension(PART),
    };
    let stats = args.run.stats.as_deref().map(|path| OutputFile::prepare(path, &files)).transpose()?;
    let stats = stats.map(|stats| stats.for_text().with_extension("json"));
    if stats.as_ref().is_some_and(|stats| stats.is_same_file(&file)) {
        return usage("--output and --stats have the same file; choose another name for one");
    }
    let mut checkpoint_path = checkpointer::default_path(&args.checkpoint, &file);
    let checkpoint = match &checkpoint_path {
        Some(path) => prepare_checkpoint(path, &args.checkpoint, stats.iter().chain([&file]), &files),
        None => Ok(None),
    };
    let checkpoint = match checkpoint {
        Err(CliError::Output(error @ OutputError::BadName { .. })) if args.checkpoint.checkpoint.is_none() => {
            console.warn(format_args!("the render has no checkpoints: {error}"));
            checkpoint_path = None;
            None
        }
        checkpoint => checkpoint?,
    };
    let others: Vec<_> = stats.iter().chain([&file]).chain(&checkpoint).collect();
    let aovs = AovFile::prepare_all(&args.aov, &files, &others)?;
    let identity = Identity::new(&args.input, &args.image, &files, &loaded.input_hashes)?;
    let job = Job {
        scene_file,
        scene: &scene,
        load_seconds,
        options,
        checkpoint: Some(CheckpointOptions::new(&args.checkpoint, checkpoint_path, identity)),
        fallback_dir: args.checkpoint.fallback.dir.as_deref(),
        output: match kind {
            OutputKind::Image(format) => JobOutput::Image { format, file, aovs },
            OutputKind::Shard => JobOutput::Shard(file),
        },
        stats,
        rule,
        threads: args.run.threads.unwrap_or(0).into(),
        strict: args.run.strict,
        verbose: args.run.verbose,
        display_server: args.run.display_server(),
        console,
    };
    job.run()
}

/// Error of a scene path without a file name, such as `.` and `/`.
fn not_a_file(scene: &Path) -> CliError {
    let kind = scene.metadata().map_or_else(LoadErrorKind::from, |_| LoadErrorKind::Directory);
    kind.at(scene, "").into()
}

/// Refuses a checkpoint in the place of another file, which would be removed with it, and an unwritable `--checkpoint`. Other
/// obstacles to the default are reported when the checkpoint is read or written.
fn prepare_checkpoint<'a>(
    path: &Path,
    args: &CheckpointArgs,
    mut others: impl Iterator<Item = &'a OutputFile>,
    inputs: &[PathBuf],
) -> Result<Option<OutputFile>, CliError> {
    match OutputFile::prepare_over_link(path, inputs) {
        Ok(checkpoint) if others.any(|other| other.is_same_file(&checkpoint)) => usage(format!(
            "the checkpoint and another output have the same file {}; choose another --checkpoint",
            checkpoint.path().display()
        )),
        Ok(checkpoint) => Ok(Some(checkpoint)),
        Err(error @ (OutputError::IsInput(_) | OutputError::BadName { .. })) => Err(error.into()),
        // A pipe or directory is refused when the checkpoint is read.
        Err(error) if args.checkpoint.is_some() && !matches!(error, OutputError::NotAFile(_)) => Err(error.into()),
        Err(_) => Ok(None),
    }
}

/// Refuses options that need the whole image for a shard.
fn refuse_for_shards(args: &RenderArgs) -> Result<(), CliError> {
    let whole = [
        ("--time", args.stop.time.is_some()),
        ("--target-error", args.stop.target_error.is_some()),
        ("--aov", !args.aov.is_empty()),
        ("--output-format", args.output_format.is_some()),
    ];
    match whole.into_iter().find(|(_, is_given)| *is_given && args.checkpoint.shard.is_some()) {
        None => Ok(()),
        Some(("--aov", _)) => {
            usage("--aov cannot be used with --shard, except with --frames; `merge` writes stderr and samples")
        }
        Some((option, _)) => usage(format!("{option} cannot be used with --shard, except with --frames")),
    }
}

enum OutputKind {
    Image(ImageFormat),
    Shard,
}

impl OutputKind {
    fn of(path: &Path, shard: Option<ShardSpec>, args: &RenderArgs) -> Result<Self, CliError> {
        let is_part = path.extension().is_some_and(|extension| extension == PART) || (shard.is_some() && is_dash(path));
        match (shard, is_part) {
            (Some(_), true) => refuse_terminal(path).map(|()| Self::Shard),
            (None, false) => Ok(Self::Image(image_file::chosen_format(path, args.output_format)?)),
            (Some(_), false) => {
                usage(format!("--shard writes .part files, not {}; `merge` combines them to an image", path.display()))
            }
            (None, true) if args.frames.frames.is_some() => usage(format!(
                "{} is a .part file: with --frames, images are written, also by each shard; name an image, such as out-####.png",
                path.display()
            )),
            (None, true) => usage(format!("{} is a .part file, which needs --shard I/N", path.display())),
        }
    }
}

const PART: &str = "part";

/// Name of the scene with the extension of the format or the index of the shard, in the current directory.
fn default_output(scene: &Path, shard: Option<ShardSpec>, format: Option<ImageFormat>) -> PathBuf {
    let mut name = scene.file_stem().unwrap_or_default().to_owned();
    match shard {
        None => name.push(format!(".{}", image_file::extension_of(format.unwrap_or(ImageFormat::Png)))),
        Some(spec) => name.push(format!(".{}-of-{}.{PART}", spec.index() + 1, spec.count())),
    }
    PathBuf::from(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_go_to_the_current_directory_by_default() {
        for (scene, image) in
            [("a/b.ron", "b.png"), ("/x/c.tar.gltf", "c.tar.png"), ("d", "d.png"), ("e.png.ron", "e.png.png")]
        {
            assert_eq!(default_output(Path::new(scene), None, None), Path::new(image));
        }
        assert_eq!(default_output(Path::new("a/b.ron"), None, Some(ImageFormat::Exr)), Path::new("b.exr"));
        assert_eq!(default_output(Path::new("a/b.ron"), ShardSpec::new(2, 8), None), Path::new("b.3-of-8.part"));
    }
}
