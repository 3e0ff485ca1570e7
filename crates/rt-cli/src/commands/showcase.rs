//! No command: renders the built-in scene, and prints commands to try next.

use std::env;
use std::path::Path;
use std::time::Instant;

use rt_scene_io::format::parse_ron;
use rt_scene_io::{LoadOptions, Scene, resolve};

use crate::console::Console;
use crate::error::CliError;
use crate::image_file;
use crate::job::{Job, JobOutput};
use crate::output::OutputFile;

const SCENE: &str = include_str!("../../../../scenes/gallery/still_life.ron");
/// For messages.
const SCENE_NAME: &str = "still_life.ron";
const IMAGE_FILE: &str = "still_life.png";

pub(super) fn run() -> Result<(), CliError> {
    let console = Console { quiet: false };
    let started = Instant::now();
    let scene = scene()?;
    let job = Job {
        scene_file: Path::new(SCENE_NAME),
        scene: &scene,
        load_seconds: started.elapsed().as_secs_f64(),
        options: rt_render::PlanOptions::default(),
        output: JobOutput::Image {
            format: image_file::format_of(Path::new(IMAGE_FILE))?,
            file: OutputFile::prepare(Path::new(IMAGE_FILE), &[])?,
            aovs: Vec::new(),
        },
        stats: None,
        rule: None,
        checkpoint: None,
        fallback_dir: None,
        threads: 0,
        strict: false,
        verbose: false,
        display_server: None,
        console,
    };
    console.println("rendering a built-in scene; --help lists all commands")?;
    job.run()?;
    console.println(next_steps())
}

fn scene() -> Result<Scene, CliError> {
    let name = Path::new(SCENE_NAME);
    Ok(resolve(&parse_ron(SCENE, name)?, name, &LoadOptions::default())?)
}

fn next_steps() -> String {
    // Cargo sets this variable for programs that it runs.
    let program = if env::var_os("CARGO").is_some() { "cargo run -p rt-cli --" } else { "rt-cli" };
    format!(
        "\ntry next\n  \
         {program} view scenes/gallery/still_life.ron\n  \
         {program} explain scenes/gallery/still_life.ron\n  \
         {program} render scenes/gallery/showcase.ron --size 1280x800 --look-from 4,2,9 -o larger.png"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_showcase_is_a_sound_scene() {
        let scene = scene().expect("sound");
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        assert_eq!((scene.film.width, scene.film.height), (576, 360));
    }
}
