//! Options of long renders: checkpoints, shards, fallback directories.

use std::path::PathBuf;

use clap::{Args, ValueHint};
use rt_render::ShardSpec;

use super::values::{self, CheckpointInterval};

#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Long renders")]
pub(crate) struct CheckpointArgs {
    /// Continue from the checkpoint of an earlier run of the same scene and options, if there is one
    ///
    /// The image is bit-identical to that of an uninterrupted run, except with --time. Without --resume and
    /// --restart, a checkpoint of this render is an error. One of another scene or of other options is renamed to CHECKPOINT.old.
    #[arg(long)]
    pub(crate) resume: bool,

    /// Start over, and discard the checkpoint of an earlier run
    #[arg(long, conflicts_with = "resume")]
    pub(crate) restart: bool,

    /// Write checkpoints to this file [default: IMAGE.checkpoint]
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) checkpoint: Option<PathBuf>,

    /// Write a checkpoint at this interval, such as 30s or 10min, or never; Ctrl-C always writes one
    #[arg(long, value_name = "TIME", value_parser = values::checkpoint_interval, allow_hyphen_values = true, default_value = "1min")]
    pub(crate) checkpoint_every: CheckpointInterval,

    #[command(flatten)]
    pub(crate) fallback: FallbackArgs,

    /// Render shard I of N of the tiles to a .part file; with --frames, every N-th frame
    ///
    /// `merge` combines the shards to an image that is bit-identical to that of a single run.
    #[arg(long, value_name = "I/N", value_parser = values::shard_spec, allow_hyphen_values = true)]
    pub(crate) shard: Option<ShardSpec>,
}

#[derive(Clone, Debug, Args)]
pub(crate) struct FallbackArgs {
    /// Write results to this directory if writing them fails after the render [default: $TMPDIR, then .]
    #[arg(long = "fallback-dir", alias = "fallback", value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) dir: Option<PathBuf>,
}
