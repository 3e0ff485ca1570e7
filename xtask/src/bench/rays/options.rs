//! Options of `bench rays`.

use std::path::PathBuf;

use clap::builder::TypedValueParser;
use rt_accel::{AcceleratorKind, wide::Quality};

use crate::bench::common::{accelerator, named};

#[derive(Debug, clap::Args)]
pub(in crate::bench) struct RayOptions {
    /// Measure all SCENE.mesh with SCENE.KIND.rays in this directory, against SCENE.KIND.ref if it exists.
    #[arg(long, value_name = "DIR")]
    pub(super) folder: PathBuf,
    /// Measure only these scenes.
    #[arg(long, value_delimiter = ',')]
    pub(super) scene: Vec<String>,
    /// Measure these accelerators.
    #[arg(long, value_delimiter = ',', default_value = "bvh", value_parser = accelerator())]
    pub(super) accel: Vec<AcceleratorKind>,
    /// Choose the build quality of the wide BVH.
    #[arg(long, default_value = "medium", value_parser = named(Quality::ALL, Quality::name))]
    pub(super) quality: Quality,
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
    /// Count the rays whose hit is not bit-identical to that of this accelerator, traced as single rays.
    #[arg(long, value_name = "ACCEL", value_parser = accelerator())]
    pub(super) same_as: Option<AcceleratorKind>,
}

fn positive() -> impl TypedValueParser<Value = usize> {
    clap::value_parser!(u32).range(1..).map(|number| number as usize)
}

/// Parses options for a folder.
#[cfg(test)]
pub(super) fn parsed(folder: &std::path::Path, args: &[&str]) -> RayOptions {
    use clap::{Args, FromArgMatches};
    let command = RayOptions::augment_args(clap::Command::new("rays").no_binary_name(true));
    let all = [&["--folder", folder.to_str().unwrap()], args].concat();
    RayOptions::from_arg_matches(&command.get_matches_from(all)).unwrap()
}
