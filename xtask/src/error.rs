//! Error of a task that could not run.

use std::{
    io,
    path::{Path, PathBuf},
};

/// A task that could not do its work, as opposed to one that found something wrong.
#[derive(Debug, thiserror::Error)]
pub(crate) enum TaskError {
    #[error("{}: {source}", path.display())]
    File { path: PathBuf, source: io::Error },
    #[error("{}: {source}", path.display())]
    Image { path: PathBuf, source: image::ImageError },
    #[error("{}: {source}", path.display())]
    Toml { path: PathBuf, source: toml::de::Error },
    #[error("{}: {source}", path.display())]
    Json { path: PathBuf, source: serde_json::Error },
    #[error("`{command}` cannot be run: {reason}")]
    Command { command: String, reason: String },
    #[error("{0}")]
    Other(String),
}

impl TaskError {
    pub(crate) fn other(error: impl std::fmt::Display) -> Self {
        Self::Other(error.to_string())
    }

    /// Names the file that an I/O error is about.
    pub(crate) fn file(path: &Path) -> impl FnOnce(io::Error) -> Self + use<> {
        let path = path.to_path_buf();
        move |source| Self::File { path, source }
    }
}
