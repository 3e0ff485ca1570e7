//! `render`: a picture of a scene.

use std::path::{Path, PathBuf};
use std::time::Instant;

use crate::aov_file::AovFile;
use crate::args::RenderArgs;
use crate::console::Console;
use crate::error::Failure;
use crate::input::Input;
use crate::job::Job;
use crate::output::OutputFile;
use crate::{input, overrides, picture_file};

pub(super) fn run(args: &RenderArgs) -> Result<(), Failure> {
    let console = Console { quiet: args.run.quiet };
    let scene_file = args.input.scene.as_path();
    let picture = args.output.clone().unwrap_or_else(|| default_output(scene_file));
    let format = picture_file::format_of(&picture)?;

    let started = Instant::now();
    let Input { mut scene, files } = input::read(&args.input, args.picture.size, console)?;
    let load_seconds = started.elapsed().as_secs_f64();
    if args.run.strict {
        input::refuse_warnings(scene_file, &scene)?;
    }
    let options = overrides::apply(&args.picture, &mut scene)?;
    overrides::apply_development(&args.development, &mut scene.film);

    let output = OutputFile::prepare(&picture, &files)?;
    let stats = args.run.stats.as_deref().map(|path| OutputFile::prepare(path, &files)).transpose()?;
    if stats.as_ref().is_some_and(|stats| stats.is_same_file(&output)) {
        return Err(Failure::Usage("the picture and the statistics cannot go to the same file".to_owned()));
    }
    let mut aovs: Vec<AovFile> = Vec::new();
    for arg in &args.aov {
        let aov = AovFile::prepare(arg, &files)?;
        let others = aovs.iter().map(AovFile::output).chain(&stats).chain([&output]);
        if others.into_iter().any(|other| other.is_same_file(aov.output())) {
            return Err(Failure::Usage(format!("something else goes to {} already", arg.file.display())));
        }
        aovs.push(aov);
    }
    let job = Job {
        scene_file,
        scene: &scene,
        load_seconds,
        options,
        format,
        output,
        stats,
        aovs,
        rule: args.stop.rule(args.picture.spp),
        threads: args.run.threads.unwrap_or(0).into(),
        strict: args.run.strict,
        console,
    };
    job.run()
}

/// The scene's name with `.png`, in the current folder.
fn default_output(scene: &Path) -> PathBuf {
    let mut name = scene.file_stem().unwrap_or_default().to_owned();
    name.push(".png");
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
            assert_eq!(default_output(Path::new(scene)), Path::new(picture));
        }
    }
}
