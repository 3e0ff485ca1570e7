//! Errors of checkpoints and shards.

use std::io;
use std::path::{Path, PathBuf};

use rt_scene_io::{MemoryError, unreadable};
use serde::{Deserialize, Serialize};

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum ArtifactKind {
    /// State of an unfinished render.
    Checkpoint,
    /// Finished shard of an image.
    Shard,
}

#[derive(Debug, thiserror::Error)]
pub(crate) enum ArtifactError {
    #[error("{}: {}", file.display(), unreadable(source))]
    Read { file: PathBuf, source: io::Error },
    #[error("{}: is not a regular file; give the path of a file", .0.display())]
    NotAFile(PathBuf),
    #[error("{}: is empty (0 bytes); remove it, and render again", .0.display())]
    Empty(PathBuf),
    #[error("{}: {cause}", file.display())]
    Memory { file: PathBuf, cause: MemoryError },
    #[error("{}: another render uses this checkpoint; wait for its end, or choose another --checkpoint", .0.display())]
    InUse(PathBuf),
    /// The hash is right, and a value is not.
    #[error("{}: is not a valid {kind}: {reason}", file.display())]
    Content { file: PathBuf, kind: ArtifactKind, reason: String },
    #[error("{}: is not a {kind}; remove it, or choose another file", file.display())]
    OtherKind { file: PathBuf, kind: ArtifactKind },
    #[error("{}; remove it, and render again", damaged(.0))]
    Damaged(PathBuf),
    #[error("{}: is not a list of finished frames; remove it to start over", .0.display())]
    Log(PathBuf),
    #[error("{}; use that version, or render it again with this version, {}", other_version(file, version), env!("CARGO_PKG_VERSION"))]
    Version { file: PathBuf, version: String },
    #[error("{}: was made with other options; use the same --stats, --aov, --time and --target-error, or start over \
             with --restart", .0.display())]
    OtherOptions(PathBuf),
    #[error("{}: is of another image: the scene ({scene}), an asset or an option differs{advice}", file.display())]
    Foreign { file: PathBuf, scene: String, advice: &'static str },
}

impl ArtifactError {
    /// Cause without the advice on a file that is in the way.
    pub(crate) fn cause(&self) -> String {
        match self {
            Self::Damaged(file) => damaged(file),
            Self::Version { file, version } => other_version(file, version),
            other => other.to_string(),
        }
    }
}

fn damaged(file: &Path) -> String {
    format!("{}: is damaged: its content does not match its hash", file.display())
}

fn other_version(file: &Path, version: &str) -> String {
    format!("{}: was written by version {version} of this program", file.display())
}

impl core::fmt::Display for ArtifactKind {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Checkpoint => "checkpoint",
            Self::Shard => "shard of an image",
        })
    }
}
