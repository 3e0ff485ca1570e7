//! `render`: a picture of a scene, or a part of it.

mod frames;

use std::path::{Path, PathBuf};
use std::time::Instant;

use rt_image::ImageFormat;
use rt_render::Share;

use crate::aov_file::AovFile;
use crate::args::{FrameChoice, KeepArgs, RenderArgs};
use crate::console::{Console, reserve_stdout};
use crate::error::Failure;
use crate::identity::Identity;
use crate::input::Input;
use crate::job::{Job, JobResult, Keep};
use crate::output::{OutputError, OutputFile, refuse_terminal};
use crate::stdin::is_dash;
use crate::{checkpoints, input, overrides, picture_file};

pub(super) fn run(args: &RenderArgs) -> Result<(), Failure> {
    if args.output.iter().chain(&args.run.stats).any(|path| is_dash(path)) {
        // Before anything is said.
        reserve_stdout();
    }
    match args.frames.frames {
        Some(FrameChoice::Some(frames)) => frames::each(args, frames, picture),
        Some(FrameChoice::All) => frames::each(args, frames::all(args)?, picture),
        None => picture(args),
    }
}

/// Renders a single picture.
fn picture(args: &RenderArgs) -> Result<(), Failure> {
    refuse_what_parts_cannot(args)?;
    let console = Console { quiet: args.run.quiet };
    let scene_file = args.input.scene.as_path();
    let picture = args.output.clone().unwrap_or_else(|| default_output(scene_file, args.keep.shard));
    let ending = Ending::of(&picture, args.keep.shard, args.output_format)?;
    if is_dash(&picture) && args.keep.resume && args.keep.checkpoint.is_none() {
        let message = "--resume needs --checkpoint FILE where the picture goes to standard output";
        return Err(Failure::Usage(message.to_owned()));
    }

    let started = Instant::now();
    let Input { mut scene, mut files, options: loaded } = input::read(&args.input, Some(&args.picture), console)?;
    let load_seconds = started.elapsed().as_secs_f64();
    if args.run.strict {
        input::refuse_warnings(scene_file, &scene.warnings)?;
    }
    let mut options = overrides::apply(&args.picture, &loaded, &mut scene)?;
    options.progressive = args.stop.rule(args.picture.spp).is_some() || !args.aov.is_empty();
    overrides::apply_development(&args.development, &mut scene.film.development);
    if let (Some(dither), Some(crop)) = (&mut scene.film.development.dither, options.crop) {
        dither.origin = [crop.x, crop.y];
    }
    files.extend(args.picture.env.clone());

    let output = match ending {
        Ending::Picture(_) => OutputFile::prepare(&picture, &files)?,
        Ending::Part => OutputFile::prepare_over_link(&picture, &files)?,
    };
    let stats = args.run.stats.as_deref().map(|path| OutputFile::prepare(path, &files)).transpose()?;
    if stats.as_ref().is_some_and(|stats| stats.is_same_file(&output)) {
        return Err(Failure::Usage("the picture and the statistics cannot go to the same file".to_owned()));
    }
    let checkpoint = prepare_checkpoint(&args.keep, &output, stats.as_ref(), &files)?;
    let others: Vec<_> = stats.iter().chain([&output]).chain(&checkpoint).collect();
    let aovs = AovFile::prepare_all(&args.aov, &files, &others)?;
    let identity = Identity::new(&args.input, &args.picture, &files, &loaded.input_hashes)?;
    let job = Job {
        scene_file,
        scene: &scene,
        load_seconds,
        options,
        result: match ending {
            Ending::Picture(format) => JobResult::Picture { format, output, aovs },
            Ending::Part => JobResult::Part(output),
        },
        stats,
        rule: args.stop.rule(args.picture.spp),
        keep: Some(Keep { args: &args.keep, identity }),
        threads: args.run.threads.unwrap_or(0).into(),
        strict: args.run.strict,
        verbose: args.run.verbose,
        display_server: args.run.display_server(),
        console,
    };
    job.run()
}

/// Refuses a checkpoint that would go to the file of something else, which would be removed with it. Where none can be written at
/// all, the render does without.
fn prepare_checkpoint(
    args: &KeepArgs,
    output: &OutputFile,
    stats: Option<&OutputFile>,
    inputs: &[PathBuf],
) -> Result<Option<OutputFile>, Failure> {
    if output.is_stdout() && args.checkpoint.is_none() {
        return Ok(None);
    }
    match OutputFile::prepare_over_link(&checkpoints::place(args, output), inputs) {
        Ok(checkpoint) if stats.into_iter().chain([output]).any(|other| other.is_same_file(&checkpoint)) => Err(
            Failure::Usage(format!("the checkpoint and something else would go to {}", checkpoint.path().display())),
        ),
        Ok(checkpoint) => Ok(Some(checkpoint)),
        Err(error @ OutputError::IsInput(_)) => Err(error.into()),
        Err(_) => Ok(None),
    }
}

/// Refuses options that need all of a picture, where a part of it is rendered.
fn refuse_what_parts_cannot(args: &RenderArgs) -> Result<(), Failure> {
    let whole = [
        ("--time", args.stop.time.is_some()),
        ("--target-error", args.stop.target_error.is_some()),
        ("--aov", !args.aov.is_empty()),
    ];
    match whole.into_iter().find(|(_, is_given)| *is_given && args.keep.shard.is_some()) {
        None => Ok(()),
        Some(("--aov", _)) => Err(Failure::Usage("--aov is for all of a picture: give it to `merge`".to_owned())),
        Some((option, _)) => Err(Failure::Usage(format!(
            "{option} cannot be used with --shard, unless that shares out frames (--frames)"
        ))),
    }
}

/// What the name of a result says of it.
enum Ending {
    Picture(ImageFormat),
    Part,
}

impl Ending {
    fn of(path: &Path, shard: Option<Share>, format: Option<ImageFormat>) -> Result<Self, Failure> {
        let is_part = path.extension().is_some_and(|extension| extension == PART) || (shard.is_some() && is_dash(path));
        match (shard, is_part) {
            (Some(_), true) => refuse_terminal(path).map(|()| Self::Part),
            (None, false) => Ok(Self::Picture(picture_file::chosen_format(path, format)?)),
            (Some(_), false) => Err(Failure::Usage(format!(
                "{} is no .part file, which --shard writes; `merge` makes the picture of all parts",
                path.display()
            ))),
            (None, true) => Err(Failure::Usage(format!(
                "{} would be a part of a picture: say which with --shard I/N",
                path.display()
            ))),
        }
    }
}

/// Ending of the names of parts.
const PART: &str = "part";

/// The scene's name with `.png`, or with the number of the part, in the current folder.
fn default_output(scene: &Path, shard: Option<Share>) -> PathBuf {
    let mut name = scene.file_stem().unwrap_or_default().to_owned();
    match shard {
        None => name.push(".png"),
        Some(share) => name.push(format!(".{}-of-{}.{PART}", share.index() + 1, share.count())),
    }
    PathBuf::from(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_go_to_the_current_folder_by_default() {
        for (scene, picture) in
            [("a/b.ron", "b.png"), ("/x/c.tar.gltf", "c.tar.png"), ("d", "d.png"), ("e.png.ron", "e.png.png")]
        {
            assert_eq!(default_output(Path::new(scene), None), Path::new(picture));
        }
        assert_eq!(default_output(Path::new("a/b.ron"), Share::new(2, 8)), Path::new("b.3-of-8.part"));
    }
}
