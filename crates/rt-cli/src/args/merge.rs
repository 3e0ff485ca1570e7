//! Arguments of `merge`.

use std::path::PathBuf;

use clap::{Args, ValueHint};
use rt_image::ImageFormat;

use super::aov::{self, AovArg};
use super::checkpoint::FallbackArgs;
use super::image::DevelopmentArgs;
use super::memory::MemoryArgs;
use super::values;

#[derive(Debug, Args)]
#[command(mut_args(DevelopmentArgs::of_shards))]
pub(crate) struct MergeArgs {
    /// All shards of the image (.part files), in any order
    #[arg(value_name = "SHARDS", required = true, value_hint = ValueHint::FilePath)]
    pub(crate) shards: Vec<PathBuf>,

    /// Write the image to this file: .png, .jpg, .exr, .hdr, .pfm, or -
    #[arg(short, long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) output: PathBuf,

    /// Set the image format [default: by file extension, png for -]
    #[arg(long, value_name = "FORMAT", value_parser = values::image_format())]
    pub(crate) output_format: Option<ImageFormat>,

    /// Write an additional image: stderr=FILE (standard error) or samples=FILE (sample count)
    #[arg(long, value_name = "NAME=FILE", value_parser = aov::aov_of_shards, long_help = aov::MAP_HELP)]
    pub(crate) aov: Vec<AovArg>,

    #[command(flatten)]
    pub(crate) fallback: FallbackArgs,

    /// Print errors only
    #[arg(short, long)]
    pub(crate) quiet: bool,

    #[command(flatten)]
    pub(crate) development: DevelopmentArgs,

    #[command(flatten)]
    pub(crate) memory: MemoryArgs,
}

pub(super) const MERGE_HELP: &str = "\
Merge the shards of an image rendered with --shard I/N

The image is bit-identical to that of a single run on one machine. All N shards must be given once each, in any order, finished, and \
of the same scene, options and program version. If a shard is missing, repeated or of another image, nothing is written (exit code 3).";
