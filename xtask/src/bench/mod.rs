//! `bench`: how fast rays are traced and pictures rendered.
//!
//! ```text
//!   cargo xtask bench                    every structure on scenes that are made here
//!   cargo xtask bench rays MESH RAYS     meshes and rays from neutral files, which other tracers read as well
//!   cargo xtask bench render             whole pictures, from neutral descriptions
//!   cargo xtask bench cornell REFERENCE  error and efficiency on the Cornell box
//!   cargo xtask bench load               time and memory that a mesh takes to load
//!   cargo xtask bench convert JSON SCENE the scene file of such a description
//! ```
//!
//! All figures go to standard output as JSON, and the table for people to standard error. Only ratios of one run are
//! worth comparing between machines.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use rt_accel::{AcceleratorKind, wide::Quality};
use serde::Serialize;

use crate::{
    error::TaskError,
    workspace::{Workspace, cargo, output_of},
};

mod cornell;
mod load;
mod own_scenes;
mod rays;
mod render;
mod spread;

/// What the command line asks for.
#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true)]
pub(crate) struct Options {
    #[command(subcommand)]
    what: Option<What>,
    #[command(flatten)]
    own_scenes: own_scenes::Options,
}

#[derive(Debug, clap::Subcommand)]
enum What {
    /// Trace rays from neutral files, and count wrong hits.
    Rays(rays::Options),
    /// Render whole pictures from neutral descriptions, as processes of their own.
    Render(render::Options),
    /// Measure error and efficiency on the Cornell box against an image.
    Cornell(cornell::Options),
    /// Measure the time and memory that a mesh takes to load, in each format.
    Load(load::Options),
    /// Write the scene file of a neutral description.
    Convert(render::convert::Options),
}

/// Measures, prints the JSON and a table, and writes what was asked for.
pub(crate) fn run(workspace: &Workspace, options: &Options) -> Result<(), TaskError> {
    if cfg!(debug_assertions) {
        return run_release_build();
    }
    match &options.what {
        None => own_scenes::run(workspace, &options.own_scenes),
        Some(What::Rays(options)) => rays::run(options),
        Some(What::Render(options)) => render::run(workspace, options),
        Some(What::Cornell(options)) => cornell::run(workspace, options),
        Some(What::Load(options)) => load::run(workspace, options),
        Some(What::Convert(options)) => render::convert::run(options),
    }
}

/// Figures of a build with overflow checks and without optimisation across crates are not what users get.
pub(crate) fn run_release_build() -> Result<(), TaskError> {
    let mut command = cargo();
    command.args(["run", "--quiet", "--release", "--package", "xtask", "--"]).args(std::env::args_os().skip(1));
    print!("{}", output_of(&mut command)?);
    Ok(())
}

/// Prints the figures for programs on standard output, and the table for people on standard error.
fn print(figures: &impl Serialize, table: &str) -> Result<(), TaskError> {
    let json = serde_json::to_string_pretty(figures).map_err(|error| TaskError::Other(error.to_string()))?;
    println!("{json}");
    eprint!("{table}");
    Ok(())
}

/// The name of a structure on the command line.
fn structure() -> impl TypedValueParser<Value = AcceleratorKind> {
    let names = PossibleValuesParser::new(AcceleratorKind::ALL.iter().map(|kind| kind.name()));
    names.try_map(|name| {
        AcceleratorKind::ALL.iter().copied().find(|kind| kind.name() == name).ok_or("no such structure")
    })
}

/// The name of a quality on the command line.
fn quality() -> impl TypedValueParser<Value = Quality> {
    let names = PossibleValuesParser::new(Quality::ALL.iter().map(|quality| quality.name()));
    names.try_map(|name| Quality::ALL.iter().copied().find(|quality| quality.name() == name).ok_or("no such quality"))
}
