//! `costs`: what each structure costs on scenes of growing size, and how fast the costs grow.
//!
//! Owns the measurements, `target/costs/costs.json`, and `docs/COSTS.md`. Nodes, tests and bytes are the same in every
//! run; times are not, and only their ratios are worth comparing between machines.

use std::{
    fs,
    path::{Path, PathBuf},
};

use serde::Serialize;

use crate::{bench::run_release_build, error::TaskError, scenes, workspace::Workspace};

mod claims;
mod growth;
mod measure;
mod page;
mod query;

use growth::Growth;

/// What the command line asks for.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// Go on to 10⁶ primitives.
    #[arg(long)]
    full: bool,
    /// Replace docs/COSTS.md.
    #[arg(long)]
    write: bool,
    /// Rays of each kind.
    #[arg(long, default_value_t = 10_000, value_parser = clap::value_parser!(u32).range(100..))]
    rays: u32,
    /// Measurements of each time, of which the least counts.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..))]
    repeats: u32,
    /// The mesh of the scene "model", an OBJ file; by default the teapot of the gallery.
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
}

/// Sizes asked for; scenes that grow in steps take the nearest they have.
const SIZES: [usize; 4] = [1_000, 10_000, 100_000, 1_000_000];

/// One structure on one scene.
#[derive(Debug, Serialize)]
struct Figure {
    scene: &'static str,
    primitives: usize,
    structure: &'static str,
    /// Least time of a build, on all threads.
    build_seconds: f64,
    /// What it holds after all rays have been traced.
    bytes: usize,
    nodes: usize,
    leaves: usize,
    references: usize,
    max_depth: usize,
    rays: Vec<RayFigure>,
}

/// Rays of one kind through one structure of one scene.
#[derive(Debug, Serialize)]
struct RayFigure {
    kind: &'static str,
    rays: usize,
    /// Rays that hit something.
    hits: usize,
    /// Nodes or cells visited by all rays together.
    nodes: u64,
    /// Primitives offered to all rays together.
    tests: u64,
    /// Least time of all rays together, on one thread.
    seconds: f64,
    /// Time of the first pass, which counts and in which a lazy structure builds itself.
    first_seconds: f64,
}

impl Figure {
    fn of(&self, kind: &str) -> Option<&RayFigure> {
        self.rays.iter().find(|figure| figure.kind == kind)
    }

    fn bytes_per_primitive(&self) -> f64 {
        self.bytes as f64 / self.primitives as f64
    }

    /// Nodes and tests of a ray, the mean over all kinds.
    fn work(&self) -> f64 {
        self.rays.iter().map(RayFigure::work).sum::<f64>() / self.rays.len() as f64
    }

    /// Seconds of a ray, the mean over all kinds.
    fn seconds_per_ray(&self) -> f64 {
        self.rays.iter().map(|figure| figure.seconds / figure.rays as f64).sum::<f64>() / self.rays.len() as f64
    }
}

impl RayFigure {
    fn nodes_per_ray(&self) -> f64 {
        self.nodes as f64 / self.rays as f64
    }

    fn tests_per_ray(&self) -> f64 {
        self.tests as f64 / self.rays as f64
    }

    fn work(&self) -> f64 {
        self.nodes_per_ray() + self.tests_per_ray()
    }

    fn mega_rays(&self) -> f64 {
        self.rays as f64 / self.seconds * 1e-6
    }
}

/// All that was measured and what follows from it.
#[derive(Debug, Default, Serialize)]
struct Costs {
    figures: Vec<Figure>,
    growth: Vec<Growth>,
}

/// Measures, prints tables, and writes the files.
pub(crate) fn run(workspace: &Workspace, options: &Options) -> Result<(), TaskError> {
    if cfg!(debug_assertions) {
        return run_release_build();
    }
    let teapot = workspace.root.join("scenes/gallery/models/teapot.obj");
    let model = options.model.as_deref().unwrap_or(&teapot);
    let figures = figures(model, options)?;
    let costs = Costs { growth: growth::of(&figures), figures };
    let path = workspace.fresh_folder("costs")?.join("costs.json");
    let file = fs::File::create(&path).map_err(TaskError::file(&path))?;
    serde_json::to_writer_pretty(file, &costs).map_err(|source| TaskError::Json { path, source })?;
    print!("{}", page::terminal(&costs));
    if options.write {
        let path = workspace.root.join("docs/COSTS.md");
        fs::write(&path, page::markdown(&costs, options.full, workspace.relative(model), &workspace.provenance()))
            .map_err(TaskError::file(&path))?;
    }
    Ok(())
}

fn figures(model: &Path, options: &Options) -> Result<Vec<Figure>, TaskError> {
    let mut figures = Vec::new();
    for size in SIZES.into_iter().take(if options.full { 4 } else { 3 }) {
        eprintln!("about {size} primitives ...");
        figures.extend(measure::scene(&scenes::mound(size)?, options)?);
        figures.extend(measure::scene(&scenes::balls(size)?, options)?);
        figures.extend(measure::scene(&scenes::tree(size)?, options)?);
        figures.extend(measure::scene(&scenes::gears(size)?, options)?);
        figures.extend(measure::scene(&scenes::rock(size)?, options)?);
        figures.extend(measure::scene(&scenes::stadium(size)?, options)?);
    }
    figures.extend(measure::scene(&scenes::model(model)?, options)?);
    Ok(figures)
}
