//! `bench`: speed of rays, images, loading and building.
//!
//! All results go to standard output as JSON, and a table to standard error. Compare ratios of one run only.

pub(crate) use build::wrapped_rustc;

use crate::{error::TaskError, release_build::run_release_build, workspace::Workspace};

mod build;
mod builtin;
mod common;
mod cornell;
mod load;
mod rays;
mod render;

#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true)]
pub(crate) struct BenchOptions {
    #[command(subcommand)]
    what: Option<Benchmark>,
    #[command(flatten)]
    builtin: builtin::BuiltinOptions,
}

#[derive(Debug, clap::Subcommand)]
enum Benchmark {
    /// Trace rays from binary files of meshes and rays, and count wrong hits.
    Rays(rays::RayOptions),
    /// Render whole images from JSON scene descriptions, in separate processes.
    Render(render::RenderOptions),
    /// Measure error and efficiency on the Cornell box against a reference image.
    Cornell(cornell::CornellOptions),
    /// Measure time and memory to load a mesh in each format.
    Load(load::LoadOptions),
    /// Measure processor and wall seconds of a cold build, by package.
    Build(build::BuildOptions),
    /// Convert a JSON scene description to a scene file.
    Convert(render::convert::ConvertOptions),
}

/// Measures, and prints the JSON and a table.
pub(crate) fn run(workspace: &Workspace, options: &BenchOptions) -> Result<(), TaskError> {
    if cfg!(debug_assertions) && !matches!(options.what, Some(Benchmark::Build(_))) {
        return run_release_build();
    }
    match &options.what {
        Some(Benchmark::Build(options)) => build::run(workspace, options),
        None => builtin::run(workspace, &options.builtin),
        Some(Benchmark::Rays(options)) => rays::run(options),
        Some(Benchmark::Render(options)) => render::run(workspace, options),
        Some(Benchmark::Cornell(options)) => cornell::run(workspace, options),
        Some(Benchmark::Load(options)) => load::run(workspace, options),
        Some(Benchmark::Convert(options)) => render::convert::run(options),
    }
}
