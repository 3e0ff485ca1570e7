//! `bench`: how fast each structure answers each kind of ray, in one process, on scenes that are made here.
//!
//! Owns the table and the JSON. Only ratios are worth comparing between machines; structures take turns, so that a
//! machine that slows down meanwhile slows them all.

use std::{fs, path::PathBuf};

use serde::Serialize;

use crate::{
    error::TaskError,
    scenes,
    workspace::{cargo, output_of},
};

mod measure;
mod structure;
mod table;

/// What the command line asks for.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// Also write all figures to this file.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Rays of each kind; brute force gets fewer where there are many primitives.
    #[arg(long, default_value_t = 100_000, value_parser = clap::value_parser!(u32).range(1..))]
    rays: u32,
    /// Measurements of each figure.
    #[arg(long, default_value_t = 7, value_parser = clap::value_parser!(u32).range(1..))]
    repeats: u32,
}

/// The least and the middle of several measurements.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
struct Seconds {
    least: f64,
    median: f64,
}

/// Building one structure for one scene.
#[derive(Debug, Serialize)]
struct BuildFigure {
    scene: &'static str,
    primitives: usize,
    structure: &'static str,
    seconds: Seconds,
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
    seconds: Seconds,
}

impl TraceFigure {
    /// Millions of rays per second, from the least time.
    fn mega_rays(&self) -> f64 {
        self.rays as f64 / self.seconds.least * 1e-6
    }
}

/// All that was measured.
#[derive(Debug, Default, Serialize)]
struct Figures {
    builds: Vec<BuildFigure>,
    traces: Vec<TraceFigure>,
}

/// Measures, prints a table, and writes the JSON if asked for.
pub(crate) fn run(options: &Options) -> Result<(), TaskError> {
    if cfg!(debug_assertions) {
        return run_release_build();
    }
    let mut figures = Figures::default();
    measure::scene(&scenes::mound(1_000)?, options, &mut figures)?;
    measure::scene(&scenes::balls(7_000)?, options, &mut figures)?;
    measure::scene(&scenes::rock(80_000)?, options, &mut figures)?;
    print!("{}", table::markdown(&figures));
    if let Some(path) = &options.json {
        let file = fs::File::create(path).map_err(TaskError::file(path))?;
        serde_json::to_writer_pretty(file, &figures)
            .map_err(|source| TaskError::Json { path: path.clone(), source })?;
    }
    Ok(())
}

/// Figures of a build with overflow checks and without optimisation across crates are not what users get.
pub(crate) fn run_release_build() -> Result<(), TaskError> {
    let mut command = cargo();
    command.args(["run", "--quiet", "--release", "--package", "xtask", "--"]).args(std::env::args_os().skip(1));
    print!("{}", output_of(&mut command)?);
    Ok(())
}
