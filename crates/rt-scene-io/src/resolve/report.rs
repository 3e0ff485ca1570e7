//! Collects what is wrong, so that one run names every mistake in a file.

use std::fmt::Display;
use std::path::Path;

use crate::{LoadError, Place, Problem, Reason, Warning};

/// After this many problems the rest of a file is not worth a look.
const MAX_PROBLEMS: usize = 20;

/// The problems and warnings met while a file is resolved.
pub(super) struct Report {
    file: String,
    problems: Vec<Problem>,
    pub(super) warnings: Vec<Warning>,
}

impl Report {
    pub(super) fn new(file: &Path) -> Self {
        Self { file: file.display().to_string(), problems: Vec::new(), warnings: Vec::new() }
    }

    /// The value, or `None` after noting the problem at a path in the document such as `nodes[2].material`.
    pub(super) fn check<T>(&mut self, path: impl Display, result: Result<T, impl Into<Reason>>) -> Option<T> {
        match result {
            Ok(value) => Some(value),
            Err(reason) => {
                let place = Place::from(path.to_string());
                self.add([Problem { file: self.file.clone(), place, reason: reason.into() }]);
                None
            }
        }
    }

    /// Notes problems that were found elsewhere, such as in an included file.
    pub(super) fn add(&mut self, problems: impl IntoIterator<Item = Problem>) {
        let room = MAX_PROBLEMS.saturating_sub(self.problems.len());
        self.problems.extend(problems.into_iter().take(room));
    }

    /// The warnings, or everything that is wrong.
    pub(super) fn finish(self) -> Result<Vec<Warning>, LoadError> {
        match LoadError::from_problems(self.problems) {
            Some(error) => Err(error),
            None => Ok(self.warnings),
        }
    }
}
