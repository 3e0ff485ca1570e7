//! Renders that take long, or more than one machine.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueHint};
use rt_render::Share;

use super::values;

/// What is kept of a render, and where.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Long renders")]
pub(crate) struct KeepArgs {
    /// Go on from the checkpoint of an earlier run of the same scene and options; without one, begin
    ///
    /// The picture has the same bits as if nothing had interrupted it, but for --time. Neither this nor --restart is needed where the
    /// checkpoint is of another scene or other options: a note says so, and the render begins anew.
    #[arg(long)]
    pub(crate) resume: bool,

    /// Begin anew, whatever an earlier run has left
    #[arg(long, conflicts_with = "resume")]
    pub(crate) restart: bool,

    /// Where checkpoints go; by default beside the picture, under its name with .checkpoint behind it
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) checkpoint: Option<PathBuf>,

    /// How often a checkpoint is written: 30s, 10min, or never. One is also written at Ctrl-C
    #[arg(long, value_name = "TIME", value_parser = values::every, default_value = "1min")]
    pub(crate) checkpoint_every: Every,

    /// Where results go that cannot be written where they should; by default the folder for temporary files, then the current one
    #[arg(long, value_name = "FOLDER", value_hint = ValueHint::DirPath)]
    pub(crate) fallback: Option<PathBuf>,

    /// Render part I of N of the tiles, to a .part file; `merge` makes a picture of all parts, with the bits of one run. With --frames: every N-th frame, whole
    #[arg(long, value_name = "I/N", value_parser = values::share)]
    pub(crate) shard: Option<Share>,
}

/// How often something is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Every {
    /// Whenever so much time has passed.
    Time(Duration),
    /// Never.
    Never,
}
