//! Options of `bench rays`.

use std::path::PathBuf;

use clap::builder::TypedValueParser;
use rt_accel::{AcceleratorKind, wide::Quality};

use super::trace::Query;
use crate::bench::common::{accelerator, quality};

/// Options of `bench rays`.
#[derive(Debug, clap::Args)]
pub(in crate::bench) struct RayOptions {
    /// Pairs of files: a mesh and rays through it.
    #[arg(value_name = "MESH RAYS", required_unless_present = "folder")]
    pub(super) files: Vec<PathBuf>,
    /// Measure every SCENE.mesh of this folder with every SCENE.KIND.rays, against SCENE.KIND.ref where it exists.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["files", "reference"])]
    pub(super) folder: Option<PathBuf>,
    /// Measure only these scenes of the folder.
    #[arg(long, value_delimiter = ',', requires = "folder")]
    pub(super) scene: Vec<String>,
    /// Measure only these kinds of rays of the folder.
    #[arg(long, value_delimiter = ',', requires = "folder")]
    pub(super) kind: Vec<String>,
    /// Accelerators to measure.
    #[arg(long, value_delimiter = ',', default_value = "bvh", value_parser = accelerator())]
    pub(super) accel: Vec<AcceleratorKind>,
    /// Build quality of the wide BVH.
    #[arg(long, default_value = "medium", value_parser = quality())]
    pub(super) quality: Quality,
    /// Query for each ray; by default any hit for files `*.shadow.rays`, the closest hit for others.
    #[arg(long)]
    pub(super) query: Option<Query>,
    /// Trace batches of this many rays instead of single rays.
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "4096", value_name = "RAYS",
          value_parser = positive())]
    pub(super) batch: Option<usize>,
    /// Threads that build and trace.
    #[arg(long, default_value_t = 1, value_parser = positive())]
    pub(super) threads: usize,
    /// Measurements of each figure, after a pass that is checked and not timed.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    pub(super) reps: u32,
    /// Trace only every so many-th ray.
    #[arg(long, default_value_t = 1, value_parser = positive())]
    pub(super) every: usize,
    /// Write the hits to this file, or those of a folder into this folder.
    #[arg(long, value_name = "HITS")]
    pub(super) out: Option<PathBuf>,
    /// Count wrong hits by this file; give it once for each pair.
    #[arg(long, value_name = "REF")]
    pub(super) reference: Vec<PathBuf>,
    /// Absolute tolerance of t, in addition to 1e-4 of it: a number or a file with one. By default MESH with the
    /// extension `.eps`, or 1e-5.
    #[arg(long)]
    pub(super) eps: Option<String>,
    /// Count the rays for which this accelerator, as single rays, gives an answer with other bits.
    #[arg(long, value_name = "ACCEL", value_parser = accelerator())]
    pub(super) same_as: Option<AcceleratorKind>,
}

fn positive() -> impl TypedValueParser<Value = usize> {
    clap::value_parser!(u32).range(1..).map(|number| number as usize)
}

/// Parses options.
#[cfg(test)]
pub(super) fn parsed(args: &[&str]) -> RayOptions {
    use clap::{Args, FromArgMatches};
    let command = RayOptions::augment_args(clap::Command::new("rays").no_binary_name(true));
    RayOptions::from_arg_matches(&command.get_matches_from(args)).unwrap()
}
