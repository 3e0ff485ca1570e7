//! Frame after frame of an animation, each a render of its own.

use std::path::{Path, PathBuf};

use rt_render::Share;

use rt_scene_io::InputHashes;

use crate::args::{AovArg, Frames, InputArgs, KeepArgs, RenderArgs, RunArgs};
use crate::console::Console;
use crate::error::Failure;
use crate::frame_log::FrameLog;
use crate::identity::Identity;
use crate::{input, interruption};

/// Renders the frames that are asked for, one after the other. It ends at the first that fails.
pub(super) fn each(
    args: &RenderArgs,
    frames: Frames,
    render: impl Fn(&RenderArgs) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let console = Console { quiet: args.run.quiet };
    let say = |frame: u32, what: String| console.say(format_args!("frame {frame} of {frames}{what}"));
    let at = |frame: u32| format!(", at {:.3} s", args.input.pace.moment(frame));
    let share = args.keep.shard.unwrap_or(Share::ALL);
    if frames.is_single() {
        // Machines that take a frame each have no file in common.
        return frames.numbers().filter(|frame| share.holds(*frame as usize)).try_for_each(|frame| {
            say(frame, at(frame))?;
            render(&of_frame(args, frame)).map_err(|source| failed(frame, source))
        });
    }
    refuse_shared_files(args)?;
    let mut log = FrameLog::open(&output(args), args.keep.shard, frames, args.keep.resume)?;
    let mut files = None;
    for frame in frames.numbers().filter(|frame| share.holds(*frame as usize)) {
        if interruption::is_interrupted() {
            // It came when the frame before was finished.
            return Err(failed(frame, Failure::Interrupted { percent: 0.0, picture: None, checkpoint: None }));
        }
        let args = of_frame(args, frame);
        if files.is_none() {
            files = Some(files_of(&args).map_err(|source| failed(frame, source))?);
        }
        let identity =
            Identity::new(&args.input, &args.picture, files.as_deref().unwrap_or_default(), &InputHashes::default())?;
        // A frame that is finished does not go on: what ends and develops it must be the same.
        let identity = identity.with(&format!("{:?}", (&args.stop, &args.development)));
        if log.has(frame, &identity, &args.input.scene)? && results(&args).all(Path::exists) {
            say(frame, " is there already".to_owned())?;
            continue;
        }
        say(frame, at(frame))?;
        render(&args).map_err(|source| failed(frame, source))?;
        let _listening = interruption::listen();
        log.add(frame, &identity)?;
    }
    Ok(())
}

/// All frames of what is animated in the scene or its models.
pub(super) fn all(args: &RenderArgs) -> Result<Frames, Failure> {
    let input = InputArgs { at_time: Some(0.0), ..args.input.clone() };
    let loaded = input::read(&input, Some(&args.picture), Console { quiet: true })?;
    let (scene, fps) = (args.input.scene.display(), args.input.pace.fps);
    let Some(end) = loaded.options.animation_end.seconds() else {
        return Err(Failure::Usage(format!(
            "--frames all: nothing in {scene} is animated; leave it out for a single picture"
        )));
    };
    Frames::of_animation(end, fps).ok_or_else(|| {
        Failure::Usage(format!(
            "--frames all: {end} s at {fps} frames a second are too many; give the first and the last as 0..47"
        ))
    })
}

/// All files that a frame is written to.
fn results(args: &RenderArgs) -> impl Iterator<Item = &Path> {
    let aovs = args.aov.iter().map(|aov| aov.file.as_path());
    args.output.as_deref().into_iter().chain(args.run.stats.as_deref()).chain(aovs)
}

fn failed(frame: u32, source: Failure) -> Failure {
    Failure::Frame { frame, source: Box::new(source) }
}

/// The files that a frame is made of, which are those of all frames.
fn files_of(args: &RenderArgs) -> Result<Vec<PathBuf>, Failure> {
    let mut files = input::read(&args.input, Some(&args.picture), Console { quiet: true })?.files;
    files.extend(args.picture.env.clone());
    Ok(files)
}

/// The arguments that render a frame by itself.
fn of_frame(args: &RenderArgs, frame: u32) -> RenderArgs {
    let name = |path: &Path| numbered(path, frame).unwrap_or_else(|| path.to_owned());
    RenderArgs {
        input: InputArgs { at_time: Some(args.input.pace.moment(frame)), ..args.input.clone() },
        output: Some(name(&output(args))),
        aov: args.aov.iter().map(|arg| AovArg { aov: arg.aov, file: name(&arg.file) }).collect(),
        keep: KeepArgs { shard: None, checkpoint: args.keep.checkpoint.as_deref().map(name), ..args.keep.clone() },
        run: RunArgs { stats: args.run.stats.as_deref().map(name), ..args.run.clone() },
        ..args.clone()
    }
}

/// Refuses names that all frames would be written to.
fn refuse_shared_files(args: &RenderArgs) -> Result<(), Failure> {
    let output = output(args);
    let others = [args.run.stats.as_deref(), args.keep.checkpoint.as_deref(), Some(output.as_path())];
    let mut all = args.aov.iter().map(|arg| arg.file.as_path()).chain(others.into_iter().flatten());
    match all.find(|path| numbered(path, 0).is_none()) {
        None => Ok(()),
        Some(path) => Err(Failure::Usage(format!(
            "all frames would be written to {}: write #### where the number of the frame goes, as in out-####.png",
            path.display()
        ))),
    }
}

/// Where pictures go; by default the scene's name with `-####.png`, in the current folder.
fn output(args: &RenderArgs) -> PathBuf {
    args.output.clone().unwrap_or_else(|| {
        let mut name = args.input.scene.file_stem().unwrap_or_default().to_owned();
        name.push("-####.png");
        PathBuf::from(name)
    })
}

/// The path with a number, padded with zeros, in place of the last run of `#` in the name of the file; `None` if there is none.
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
    fn the_last_run_of_hashes_is_the_number() {
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
