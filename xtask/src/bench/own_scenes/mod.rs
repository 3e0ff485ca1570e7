//! Every structure on every kind of ray, in one process, on scenes that are made here.
//!
//! Structures take turns, so that a machine that slows down meanwhile slows them all.

use serde::Serialize;

use super::{print, spread::Spread};
use crate::{error::TaskError, scenes, workspace::Workspace};

mod measure;
mod query;
mod table;

/// What the command line asks for.
#[derive(Debug, clap::Args)]
// The group of these would have the name of that of the options around them.
#[group(skip)]
pub(super) struct Options {
    /// Also write the page docs/BENCHMARKS.md.
    #[arg(long)]
    write: bool,
    /// Rays of each kind; brute force gets fewer where there are many primitives.
    #[arg(long, default_value_t = 100_000, value_parser = clap::value_parser!(u32).range(1..))]
    rays: u32,
    /// Measurements of each figure.
    #[arg(long, default_value_t = 7, value_parser = clap::value_parser!(u32).range(1..))]
    reps: u32,
}

/// Building one structure for one scene.
#[derive(Debug, Serialize)]
struct BuildFigure {
    scene: &'static str,
    primitives: usize,
    structure: &'static str,
    seconds: Spread,
    bytes: usize,
}

/// Tracing one kind of ray through one structure of one scene.
#[derive(Debug, Serialize)]
struct TraceFigure {
    scene: &'static str,
    structure: &'static str,
    kind: &'static str,
    rays: usize,
    /// Rays that hit something.
    hits: u64,
    seconds: Spread,
}

impl TraceFigure {
    /// Millions of rays per second, from the least time.
    fn mega_rays(&self) -> f64 {
        self.rays as f64 / self.seconds.min * 1e-6
    }
}

/// All that was measured.
#[derive(Debug, Default, Serialize)]
struct Figures {
    builds: Vec<BuildFigure>,
    traces: Vec<TraceFigure>,
}

/// Measures, prints, and writes the page if asked for.
pub(super) fn run(workspace: &Workspace, options: &Options) -> Result<(), TaskError> {
    let mut figures = Figures::default();
    measure::scene(&scenes::mound(1_000)?, options, &mut figures)?;
    measure::scene(&scenes::balls(7_000)?, options, &mut figures)?;
    measure::scene(&scenes::rock(80_000)?, options, &mut figures)?;
    let tables = table::markdown(&figures);
    print(&figures, &tables)?;
    if options.write {
        let path = workspace.root.join("docs/BENCHMARKS.md");
        std::fs::write(&path, table::page(&tables, options, &workspace.provenance()))
            .map_err(TaskError::file(&path))?;
    }
    Ok(())
}
