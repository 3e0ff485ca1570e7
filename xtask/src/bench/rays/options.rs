//! Options of `bench rays`.

use std::path::PathBuf;

use clap::builder::TypedValueParser;
use rt_accel::{AcceleratorKind, wide::Quality};

use super::trace::Query;
use crate::bench::common::{accelerator, quality};

/// Options of `bench rays`.
#[derive(Debug, clap::Args)]
pub(in crate::bench) struct RayOptions {
    /// Pairs of a mesh file and a ray file.
    #[arg(value_name = "MESH RAYS", required_unless_present = "folder")]
    pub(super) files: Vec<PathBuf>,
    /// Measure all SCENE.mesh with SCENE.KIND.rays in this directory, against SCENE.KIND.ref if it exists.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["files", "reference"])]
    pub(super) folder: Option<PathBuf>,
    /// Measure only these scenes of --folder.
    #[arg(long, value_delimiter = ',', requires = "folder")]
    pub(super) scene: Vec<String>,
    /// Measure only these kinds of rays of --folder.
    #[arg(long, value_delimiter = ',', requires = "folder")]
    pub(super) kind: Vec<String>,
    /// Measure these accelerators.
    #[arg(long, value_delimiter = ',', default_value = "bvh", value_parser = accelerator())]
    pub(super) accel: Vec<AcceleratorKind>,
    /// Choose the build quality of the wide BVH.
    #[arg(long, default_value = "medium", value_parser = quality())]
    pub(super) quality: Quality,
    /// Choose the query of each ray [default: occluded for *.shadow.rays, closest for others].
    #[arg(long)]
    pub(super) query: Option<Query>,
    /// Trace batches of this many rays instead of single rays.
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "4096", value_name = "RAYS",
          value_parser = positive())]
    pub(super) batch: Option<usize>,
    /// Set the number of threads for building and tracing.
    #[arg(long, default_value_t = 1, value_parser = positive())]
    pub(super) threads: usize,
    /// Measure each value this often, after a pass that is checked and not timed.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    pub(super) reps: u32,
    /// Trace only every N-th ray.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = positive())]
    pub(super) every: usize,
    /// Write the hits to this file, or to this directory with --folder.
    #[arg(long, value_name = "HITS")]
    pub(super) out: Option<PathBuf>,
    /// Count hits that differ from this file; once for each pair.
    #[arg(long, value_name = "REF")]
    pub(super) reference: Vec<PathBuf>,
    /// Set the absolute tolerance of t, in addition to 1e-4 · t: a number or a file [default: MESH with extension .eps, or 1e-5].
    #[arg(long)]
    pub(super) eps: Option<String>,
    /// Count the rays whose hit is not bit-identical to that of this accelerator, traced as single rays.
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
