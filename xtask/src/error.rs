//! Error of a task that could not run.

use std::{
    error::Error,
    path::{Path, PathBuf},
};

/// A task that could not do its work, as opposed to one that found something wrong.
#[derive(Debug, thiserror::Error)]
pub(crate) enum TaskError {
    /// A file that cannot be read, written, or understood.
    #[error("{}: {source}", path.display())]
    File { path: PathBuf, source: Box<dyn Error + Send + Sync> },
    #[error("`{command}` cannot be run: {reason}")]
    Command { command: String, reason: String },
    #[error("{0}")]
    Other(String),
}

impl TaskError {
    pub(crate) fn other(error: impl std::fmt::Display) -> Self {
        Self::Other(error.to_string())
    }

    /// Names the file that an error is about.
    pub(crate) fn file<E: Error + Send + Sync + 'static>(path: &Path) -> impl FnOnce(E) -> Self + use<E> {
        let path = path.to_path_buf();
        move |source| Self::File { path, source: source.into() }
    }
}
