//! Frames of an animation, each rendered by itself.

use std::path::{Path, PathBuf};

use rt_image::ImageFormat;
use rt_render::ShardSpec;
use rt_scene_io::InputHashes;

use crate::args::{AovArg, CheckpointArgs, Frames, InputArgs, RenderArgs, RunArgs};
use crate::console::Console;
use crate::error::{CliError, usage};
use crate::frame_log::FrameLog;
use crate::identity::Identity;
use crate::signals::SignalGuard;
use crate::{checkpointer, image_file, input, signals};

/// Renders the frames in order; stops at the first failure.
pub(super) fn each(
    args: &RenderArgs,
    frames: Frames,
    render: impl Fn(&RenderArgs) -> Result<SignalGuard, CliError>,
) -> Result<(), CliError> {
    let console = Console { quiet: args.run.quiet };
    let say = |frame: u32, what: String| console.println(format_args!("frame {frame} of {frames}{what}"));
    let at = |frame: u32| format!(", at {:.3} s", args.input.timing.time_of(frame));
    let spec = args.checkpoint.shard.unwrap_or(ShardSpec::ALL);
    if !frames.indices().any(|frame| spec.holds(frame as usize)) {
        let (number, count) = (spec.index() + 1, spec.count());
        let what = if frames.is_single() { "does not have frame" } else { "has none of the frames" };
        return console.println(format_args!("note: shard {number} of {count} {what} {frames}"));
    }
    if frames.is_single() {
        // A single frame has no frame log.
        return frames.indices().filter(|frame| spec.holds(*frame as usize)).try_for_each(|frame| {
            signals::end_frame_on_signals(frame, false);
            say(frame, at(frame))?;
            render(&of_frame(args, frame)).map(drop).map_err(|error| error.in_frame(frame))
        });
    }
    refuse_shared_files(args)?;
    let mut log = FrameLog::open(&output(args), args.checkpoint.shard, frames, args.checkpoint.resume)?;
    let mut files = None;
    if !(args.checkpoint.resume || args.checkpoint.restart) {
        // Before finished frames are rendered again.
        let own = frames.indices().filter(|frame| spec.holds(*frame as usize));
        refuse_checkpoints(args, own, &mut files)?;
    }
    let mut saving = None;
    for (count, frame) in frames.indices().filter(|frame| spec.holds(*frame as usize)).enumerate() {
        signals::end_frame_on_signals(frame, count > 0);
        drop(saving.take());
        if signals::is_interrupted() {
            // The signal came when the previous frame was finished.
            return Err(CliError::InterruptedBetweenFrames.in_frame(frame));
        }
        let args = of_frame(args, frame);
        let identity = identity_of(&args, &mut files).map_err(|error| error.in_frame(frame))?;
        // Finished frames depend on stop rule and tone mapping as well.
        let identity = identity.with(&format!("{:?}", (&args.stop, &args.development)));
        let image = output(&args);
        if log.has(frame, &identity, &args.input.scene, &image)? && results(&args).all(Path::exists) {
            say(frame, " exists already".to_owned())?;
            continue;
        }
        say(frame, at(frame))?;
        saving = Some(render(&args).map_err(|error| error.in_frame(frame))?);
        log.add(frame, &identity, &image)?;
    }
    Ok(())
}

/// All frames of the animations of the scene and its models.
pub(super) fn all(args: &RenderArgs) -> Result<Frames, CliError> {
    let input = InputArgs { at_time: Some(0.0), ..args.input.clone() };
    let loaded = input::read(&input, Some(&args.image), Console { quiet: true })?;
    let (scene, fps) = (args.input.scene.display(), args.input.timing.fps);
    let Some(end) = loaded.options.animation_end.seconds() else {
        return usage(format!(
            "--frames all: nothing in {scene} is animated; remove --frames to render a single image"
        ));
    };
    Frames::of_animation(end, fps).ok_or_else(|| {
        CliError::Usage(format!(
            "--frames all: {end} s at {fps} frames per second are too many frames; choose a range such as 0..47"
        ))
    })
}

/// Output files of a frame.
fn results(args: &RenderArgs) -> impl Iterator<Item = &Path> {
    let aovs = args.aov.iter().map(|aov| aov.file.as_path());
    args.output.as_deref().into_iter().chain(args.run.stats.as_deref()).chain(aovs)
}

/// Refuses checkpoints of unfinished frames.
fn refuse_checkpoints(
    args: &RenderArgs,
    frames: impl Iterator<Item = u32>,
    files: &mut Option<Vec<PathBuf>>,
) -> Result<(), CliError> {
    for frame in frames {
        let args = of_frame(args, frame);
        let file = checkpointer::path_for(&args.checkpoint, &output(&args));
        if file.exists() {
            let refuse = |identity| checkpointer::refuse_unfinished(&file, identity, args.input.memory.limit());
            identity_of(&args, files).and_then(refuse).map_err(|error| error.in_frame(frame))?;
        }
    }
    Ok(())
}

/// Identity of the image of a frame. The input files are the same for all frames.
fn identity_of(args: &RenderArgs, files: &mut Option<Vec<PathBuf>>) -> Result<Identity, CliError> {
    if files.is_none() {
        *files = Some(input::read(&args.input, Some(&args.image), Console { quiet: true })?.files);
    }
    Identity::new(&args.input, &args.image, files.as_deref().unwrap_or_default(), &InputHashes::default())
}

/// Arguments of a single frame.
fn of_frame(args: &RenderArgs, frame: u32) -> RenderArgs {
    let name = |path: &Path| numbered(path, frame).unwrap_or_else(|| path.to_owned());
    RenderArgs {
        input: InputArgs { at_time: Some(args.input.timing.time_of(frame)), ..args.input.clone() },
        output: Some(name(&output(args))),
        aov: args.aov.iter().map(|arg| AovArg { content: arg.content.clone(), file: name(&arg.file) }).collect(),
        checkpoint: CheckpointArgs {
            shard: None,
            checkpoint: args.checkpoint.checkpoint.as_deref().map(name),
            ..args.checkpoint.clone()
        },
        run: RunArgs { stats: args.run.stats.as_deref().map(name), ..args.run.clone() },
        ..args.clone()
    }
}

/// Refuses output names without `####` for the frame number.
fn refuse_shared_files(args: &RenderArgs) -> Result<(), CliError> {
    let output = output(args);
    let others = [args.run.stats.as_deref(), args.checkpoint.checkpoint.as_deref(), Some(output.as_path())];
    let mut all = args.aov.iter().map(|arg| arg.file.as_path()).chain(others.into_iter().flatten());
    match all.find(|path| numbered(path, 0).is_none()) {
        None => Ok(()),
        Some(path) => usage(format!(
            "all frames would be written to {}: put #### in place of the frame number, such as out-####.png",
            path.display()
        )),
    }
}

/// Pattern of the image names: `--output`, or the name of the scene with `-####` and the extension of the format.
fn output(args: &RenderArgs) -> PathBuf {
    args.output.clone().unwrap_or_else(|| {
        let mut name = args.input.scene.file_stem().unwrap_or_default().to_owned();
        let format = args.output_format.unwrap_or(ImageFormat::Png);
        name.push(format!("-####.{}", image_file::extension_of(format)));
        PathBuf::from(name)
    })
}

/// Replaces the last run of `#` in the file name by a zero-padded number; `None` without `#`.
fn numbered(path: &Path, frame: u32) -> Option<PathBuf> {
    let name = path.file_name()?.to_str()?;
    let end = name.rfind('#')? + 1;
    let start = name[..end].trim_end_matches('#').len();
    let number = format!("{frame:0width$}", width = end - start);
    Some(path.with_file_name([&name[..start], &number, &name[end..]].concat()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_run_of_hashes_becomes_the_number() {
        for (pattern, frame, expected) in [
            ("out-####.png", 7, "out-0007.png"),
            ("a/b#/out.##.exr", 123, "a/b#/out.123.exr"),
            ("#1-###.png", 42, "#1-042.png"),
            ("####", 0, "0000"),
            ("é#ü.png", 5, "é5ü.png"),
        ] {
            assert_eq!(numbered(Path::new(pattern), frame), Some(PathBuf::from(expected)));
        }
        for none in ["out.png", "a#/out.png", "", "/", ".."] {
            assert_eq!(numbered(Path::new(none), 1), None, "{none}");
        }
    }
}
