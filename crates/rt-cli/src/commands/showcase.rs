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
use crate::output_file::OutputFile;

const SCENE: &str = include_str!("../../../../scenes/gallery/still_life.ron");
/// For messages.
const SCENE_NAME: &str = "still_life.ron";
const IMAGE_FILE: &str = "still_life.png";

pub(super) fn run() -> Result<(), CliError> {
    let started = Instant::now();
    let scene = scene()?;
    render(&scene, started.elapsed().as_secs_f64(), Path::new(IMAGE_FILE))
}

/// Renders the scene to this file, and prints commands to try next.
fn render(scene: &Scene, load_seconds: f64, image: &Path) -> Result<(), CliError> {
    let console = Console { quiet: false };
    let job = Job {
        scene_file: Path::new(SCENE_NAME),
        scene,
        load_seconds,
        options: rt_render::PlanOptions::default(),
        output: JobOutput::Image {
            format: image_file::format_of(image)?,
            file: OutputFile::prepare(image, &[])?,
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
    drop(job.run()?);
    // The scenes are those of the repository.
    if Path::new(STILL_LIFE).is_file() { console.println(next_steps()) } else { Ok(()) }
}

fn scene() -> Result<Scene, CliError> {
    let name = Path::new(SCENE_NAME);
    Ok(resolve(&parse_ron(SCENE, name)?, name, &LoadOptions::default())?)
}

/// Scene file of the built-in scene in the repository.
const STILL_LIFE: &str = "scenes/gallery/still_life.ron";

fn next_steps() -> String {
    // Cargo sets this variable for programs that it runs.
    let program = if env::var_os("CARGO").is_some() { "cargo run -p rt-cli --" } else { "rt-cli" };
    format!(
        "\ntry next\n  \
         {program} view {STILL_LIFE}\n  \
         {program} explain {STILL_LIFE}\n  \
         {program} render scenes/gallery/showcase.ron --size 1280x800 --look-from 4,2,9 -o larger.png"
    )
}

#[cfg(test)]
mod tests {
    use clap::Parser as _;

    use super::*;
    use crate::args::Cli;

    #[test]
    fn the_showcase_is_a_sound_scene() {
        let scene = scene().expect("sound");
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        assert_eq!((scene.film.width, scene.film.height), (576, 360));
    }

    #[test]
    fn the_showcase_is_rendered_to_the_end() {
        let mut scene = scene().expect("sound");
        (scene.film.width, scene.film.height, scene.settings.spp) = (36, 24, 1);
        let folder = tempfile::tempdir().expect("a folder");
        let image = folder.path().join(IMAGE_FILE);
        render(&scene, 0.0, &image).expect("rendered");
        let image = rt_image::read_image(&image).expect("written");
        assert_eq!((image.width(), image.height()), (36, 24));
        let is_lit = |pixel: &&[f32; 3]| pixel.iter().all(|&value| value > 0.0);
        assert!(image.pixels().iter().filter(is_lit).count() > 36 * 24 / 2);
    }

    #[test]
    fn suggested_commands_are_valid() {
        let text = next_steps();
        let commands: Vec<_> = text.lines().skip_while(|line| *line != "try next").skip(1).collect();
        assert_eq!(commands.len(), 3, "{text}");
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        for command in commands {
            let words: Vec<_> = command.split_whitespace().skip_while(|word| !word.starts_with("rt-cli")).collect();
            // Cargo runs this test, too.
            let words = words.into_iter().filter(|word| *word != "--");
            Cli::try_parse_from(words.clone()).unwrap_or_else(|error| panic!("{command}: {error}"));
            let scene = words.clone().find(|word| word.ends_with(".ron")).expect("a scene");
            assert!(root.join(scene).is_file(), "{command}");
        }
    }
}
