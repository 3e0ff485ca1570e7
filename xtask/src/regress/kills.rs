//! Kills: a render that is killed at any time continues from its checkpoint, bit-identical to one that was not killed.

use std::{
    fs,
    path::Path,
    time::{Duration, Instant},
};

use rt_math::random::{hash, unit};

use super::unit::{Context, Findings, Trial, Unit};
use crate::{
    error::TaskError,
    renderer::{Exit, Renderer},
    workspace::sorted_entries,
};

/// A render with its own kind of checkpoint.
struct Kills {
    name: &'static str,
    scene: &'static str,
    /// Options of `render`, separated by spaces.
    options: &'static str,
}

/// Tile by tile, pass by pass with light paths before each, growing passes, and passes of some pixels.
const ALL: [Kills; 6] = [
    kills("kills/path", "scenes/lecture/cornell-full.ron", "--size 128x128 --spp 16"),
    kills("kills/whitted", "scenes/report/mound100.ron", "--size 320x240 --spp 32 --aov samples=samples.pfm"),
    kills("kills/caustics", "scenes/gallery/caustics.ron", "--size 96x72 --spp 32 --passes 8"),
    kills(
        "kills/target-error",
        "scenes/lecture/cornell-direct.ron",
        "--size 96x96 --target-error 20% --aov samples=samples.pfm",
    ),
    kills(
        "kills/target-error-pixels",
        "scenes/lecture/cornell-direct.ron",
        "--size 96x96 --target-error 20% --target-error-pixels 100% --spp 1024 --aov samples=samples.pfm",
    ),
    kills(
        "kills/two-stage",
        "scenes/lecture/cornell-direct.ron",
        "--size 64x64 --target-error 20% --target-error-pixels 100% --two-stage --spp 1024",
    ),
];

const fn kills(name: &'static str, scene: &'static str, options: &'static str) -> Kills {
    Kills { name, scene, options }
}

/// Kills of each, and at full size.
const REDUCED: u64 = 3;
const FULL: u64 = 20;

/// Maximum number of runs per image; each of them but the last is killed.
const MOST_RUNS: u64 = 100;

pub(super) fn units() -> impl Iterator<Item = Unit> {
    ALL.into_iter()
        .map(|kills| Unit::new(kills.name, move |context, folder, findings| kills.run(context, folder, findings)))
}

impl Kills {
    fn run(&self, context: &Context, folder: &Path, findings: &mut Findings) -> Result<(), TaskError> {
        let scene = context.workspace.root.join(self.scene);
        let started = Instant::now();
        context.renderer.render(folder, &scene, "picture.pfm", self.options.split(' '))?;
        let seconds = started.elapsed().as_secs_f64();
        let expected = files(folder)?;
        let wanted = if context.full { FULL } else { REDUCED };
        let (mut kills, mut different, mut image) = (0, 0, 0);
        while kills < wanted {
            image += 1;
            clear(folder)?;
            let killed = self.finish(&context.renderer, folder, &scene, seconds, image)?;
            kills += killed;
            let found = files(folder)?;
            if found != expected {
                let names = |files: &[(String, Vec<u8>)], others: &[(String, Vec<u8>)]| {
                    files.iter().filter(|file| !others.contains(file)).map(|(name, _)| name.clone()).collect::<Vec<_>>()
                };
                different += killed.max(1);
                findings.problem(format!(
                    "image {image}, killed {killed} times, is not that of one run: {:?} instead of {:?}",
                    names(&found, &expected),
                    names(&expected, &found)
                ));
            }
        }
        findings.trial = Some(Trial {
            title: "killed at random moments, and continued",
            expected: "the bits of one run",
            tolerance: "none",
            tried: kills,
            failed: different,
            worst: None,
        });
        Ok(())
    }

    /// Renders one image, killed repeatedly at random times; returns the number of kills.
    fn finish(
        &self,
        renderer: &Renderer,
        folder: &Path,
        scene: &Path,
        seconds: f64,
        image: u64,
    ) -> Result<u64, TaskError> {
        let scene = scene.to_string_lossy();
        let mut args = vec!["render", &scene, "-o", "picture.pfm", "--quiet", "--resume", "--checkpoint-every", "5ms"];
        args.extend(self.options.split(' '));
        for run in 0..MOST_RUNS {
            let seconds_to_kill = seconds * unit(hash(&[image, run]));
            match renderer.run_at_most(folder, &args, Duration::from_secs_f64(seconds_to_kill))?.exit {
                Exit::TimedOut(_) => {}
                Exit::Code(0) => return Ok(run),
                exit => return Err(TaskError::Other(format!("run {run} of image {image}: {exit}"))),
            }
        }
        let last = renderer.run(folder, &args)?;
        last.succeeded()?;
        Ok(MOST_RUNS)
    }
}

/// All files of a folder but the log, with their names.
fn files(folder: &Path) -> Result<Vec<(String, Vec<u8>)>, TaskError> {
    let mut files = Vec::new();
    for path in sorted_entries(folder)? {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if name != "log.txt" {
            files.push((name, fs::read(&path).map_err(TaskError::file(&path))?));
        }
    }
    Ok(files)
}

fn clear(folder: &Path) -> Result<(), TaskError> {
    for (name, _) in files(folder)? {
        let path = folder.join(name);
        fs::remove_file(&path).map_err(TaskError::file(&path))?;
    }
    Ok(())
}
