//! Arguments of `merge`.

use std::path::PathBuf;

use clap::{Args, ValueHint};
use rt_image::ImageFormat;

use super::{AovArg, DevelopmentArgs, MemoryArgs, values};

/// Arguments of `merge`.
#[derive(Debug, Args)]
pub(crate) struct MergeArgs {
    /// All parts of the picture, in any order
    #[arg(required = true, value_hint = ValueHint::FilePath)]
    pub(crate) parts: Vec<PathBuf>,

    /// Picture to write: .png, .jpg, .exr, .hdr or .pfm, or - for standard output
    #[arg(short, long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) output: PathBuf,

    /// Format of the picture, whatever its name says; by default told by the ending of the name, and png for `-`
    #[arg(long, value_name = "NAME", value_parser = values::image_format())]
    pub(crate) output_format: Option<ImageFormat>,

    #[command(flatten)]
    pub(crate) development: DevelopmentArgs,

    /// Write what is known of each pixel beside its radiance: `variance` or `samples`, to any format
    #[arg(long, value_name = "NAME=FILE", value_parser = values::aov, long_help = super::stop::AOV_HELP)]
    pub(crate) aov: Vec<AovArg>,

    /// Where results go that cannot be written where they should; by default the folder for temporary files, then the current one
    #[arg(long, value_name = "FOLDER", value_hint = ValueHint::DirPath)]
    pub(crate) fallback: Option<PathBuf>,

    #[command(flatten)]
    pub(crate) memory: MemoryArgs,

    /// Print nothing but errors
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

pub(super) const MERGE_HELP: &str = "\
Join the parts of a picture that machines have rendered with --shard I/N

The picture has the bits that one run on one machine would give. Parts may come in any order. All N of them must be there, each \
once, finished, and of the same scene, options and version of the program; what is missing, doubled or foreign is named, and \
nothing is written (exit code 3).";
