//! `costs`: costs of each accelerator on scenes of growing size, and their growth.
//!
//! Owns the measurements, `target/costs/costs.json`, and `docs/COSTS.md`. Nodes, tests and bytes are the same in every
//! run; times are not, and only their ratios are worth comparing between machines.

use std::{
    fs,
    path::{Path, PathBuf},
};

use crate::{error::TaskError, files, release_build::run_release_build, scenes, workspace::Workspace};

mod claims;
mod figure;
mod growth;
mod measure;
mod page;
mod query;

pub(crate) use figure::Figure;
use growth::Costs;
pub(crate) use measure::scene as measure_scene;
pub(crate) use page::each;
pub(crate) use query::RayAnswer;

#[derive(Debug, clap::Args)]
pub(crate) struct CostsOptions {
    /// Measure scenes of up to 10⁶ primitives.
    #[arg(long)]
    full: bool,
    /// Replace docs/COSTS.md.
    #[arg(long)]
    write: bool,
    /// Set the number of rays of each kind.
    #[arg(long, default_value_t = 10_000, value_parser = clap::value_parser!(u32).range(100..))]
    rays: u32,
    /// Measure each time this often, and report the minimum.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..))]
    repeats: u32,
    /// Use this OBJ file for the scene `model` [default: teapot of the gallery].
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
}

/// Wanted sizes; scenes that grow in steps take the nearest one.
const SIZES: [usize; 4] = [1_000, 10_000, 100_000, 1_000_000];

/// Measures, prints tables, and writes the files.
pub(crate) fn run(workspace: &Workspace, options: &CostsOptions) -> Result<(), TaskError> {
    if cfg!(debug_assertions) {
        return run_release_build();
    }
    let teapot = workspace.root.join("scenes/gallery/models/teapot.obj");
    let model = options.model.as_deref().unwrap_or(&teapot);
    let figures = figures(model, options)?;
    let costs = Costs { growth: growth::of(&figures), figures };
    let path = workspace.fresh_folder("costs")?.join("costs.json");
    let file = fs::File::create(&path).map_err(TaskError::file(&path))?;
    serde_json::to_writer_pretty(file, &costs).map_err(TaskError::file(&path))?;
    print!("{}", page::terminal(&costs));
    if options.write {
        let path = workspace.root.join("docs/COSTS.md");
        files::write(&path, page::markdown(&costs, options.full, workspace.relative(model), &workspace.provenance()))?;
    }
    Ok(())
}

fn figures(model: &Path, options: &CostsOptions) -> Result<Vec<Figure>, TaskError> {
    let mut figures = Vec::new();
    for size in SIZES.into_iter().take(if options.full { 4 } else { 3 }) {
        eprintln!("about {size} primitives ...");
        figures.extend(measure::scene(&scenes::mound(size)?, options.rays, options.repeats, false)?);
        figures.extend(measure::scene(&scenes::sphereflake(size)?, options.rays, options.repeats, false)?);
        figures.extend(measure::scene(&scenes::tree(size)?, options.rays, options.repeats, false)?);
        figures.extend(measure::scene(&scenes::gears::gears(size)?, options.rays, options.repeats, false)?);
        figures.extend(measure::scene(&scenes::rock(size)?, options.rays, options.repeats, false)?);
        figures.extend(measure::scene(&scenes::stadium(size)?, options.rays, options.repeats, false)?);
    }
    figures.extend(measure::scene(&scenes::model(model)?, options.rays, options.repeats, false)?);
    Ok(figures)
}
