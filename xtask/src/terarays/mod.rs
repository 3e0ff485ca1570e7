//! `terarays`: time of the lecture's trillion rays on this machine.
//!
//! Owns `target/terarays`, with the measured tiles, and `docs/TERARAYS.md`. The image would take days. A random sample
//! of its tiles is rendered instead, each as in the whole image, and more of them with each run.

use std::time::{Duration, Instant};

use crate::{error::TaskError, files, renderer::Renderer, workspace::Workspace};

mod estimate;
mod lecture_numbers;
mod page;
mod progress_file;
mod tile_job;

use lecture_numbers::Tile;
use progress_file::ProgressFile;
use tile_job::{TileRenderer, TileResult};

const SCENE: &str = "scenes/lecture/cornell.ron";
/// A render that takes longer than this has gone wrong.
const TIMEOUT: Duration = Duration::from_secs(600);

#[derive(Debug, clap::Args)]
pub(crate) struct TeraraysOptions {
    /// Measure for this time, such as 60s, 10min or 8h, to the end of the tile; 0s prints earlier results.
    #[arg(long, value_name = "TIME", value_parser = humantime::parse_duration, default_value = "60s")]
    budget: Duration,
    /// Discard earlier measurements.
    #[arg(long)]
    fresh: bool,
    /// Replace docs/TERARAYS.md.
    #[arg(long)]
    write: bool,
}

/// Measures more tiles, prints the table, and with `--write` writes the page.
pub(crate) fn run(workspace: &Workspace, options: &TeraraysOptions) -> Result<(), TaskError> {
    let path = workspace.build_release_renderer()?;
    let scene = workspace.root.join(SCENE);
    let folder = if options.fresh { workspace.fresh_folder("terarays")? } else { workspace.folder("terarays")? };
    let mut progress_file = ProgressFile::open(folder.join(progress_file::name(&path, &scene)?))?;
    let renderer = TileRenderer { renderer: Renderer::new(path, TIMEOUT), folder: &folder, scene: &scene };
    work(&mut progress_file, options.budget, |tile| renderer.measure(tile))?;
    let tiles = progress_file.units();
    if tiles.is_empty() {
        return Err(TaskError::Other("no measurements yet: measure with --budget 60s".to_owned()));
    }
    print!("{}", page::table(tiles));
    if options.write {
        let path = workspace.root.join("docs/TERARAYS.md");
        files::write(&path, page::markdown(tiles, &crate::processor::processor(), &workspace.commit()))?;
    }
    Ok(())
}

/// Measures tile after tile until the time is up or the image is complete.
fn work(
    progress_file: &mut ProgressFile,
    budget: Duration,
    measure: impl Fn(Tile) -> Result<TileResult, TaskError>,
) -> Result<(), TaskError> {
    let started = Instant::now();
    while started.elapsed() < budget
        && let Some(tile) = progress_file.next()
    {
        progress_file.append(measure(tile)?)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;

    use super::{tile_job::Measured, *};

    fn result(tile: Tile) -> TileResult {
        let one = Measured { cpu_seconds: 1.0, mse: 1.0 };
        TileResult { tile, rays_per_sample: 9.0, jittered: one, best: [one; 3] }
    }

    #[test]
    fn a_run_that_was_ended_goes_on_and_repeats_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let measured = RefCell::new(Vec::new());
        // Killed when so many tiles are measured.
        let run = |most: usize, budget: Duration| {
            let mut progress_file = ProgressFile::open(folder.path().join("tiles.jsonl")).unwrap();
            let result = work(&mut progress_file, budget, |tile| {
                if measured.borrow().len() == most {
                    return Err(TaskError::Other("killed".to_owned()));
                }
                measured.borrow_mut().push(tile);
                Ok(result(tile))
            });
            result.is_err()
        };
        assert!(run(5, Duration::MAX), "the first run is killed");
        assert!(!run(5, Duration::ZERO), "no time, no work");
        assert!(run(8, Duration::MAX));
        let expected: Vec<Tile> = (0..8).map_while(Tile::nth).collect();
        assert_eq!(measured.into_inner(), expected);
    }

    #[test]
    fn a_short_budget_is_one_tile() {
        let folder = tempfile::tempdir().unwrap();
        let mut progress_file = ProgressFile::open(folder.path().join("tiles.jsonl")).unwrap();
        let slow = |tile| {
            std::thread::sleep(Duration::from_millis(5));
            Ok(result(tile))
        };
        work(&mut progress_file, Duration::from_millis(1), slow).unwrap();
        assert_eq!(progress_file.units().len(), 1);
    }
}
