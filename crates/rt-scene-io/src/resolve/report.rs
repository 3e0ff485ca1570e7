//! Collects what is wrong, so that one run names every mistake in a file.

use std::fmt::Display;
use std::path::Path;

use crate::{LoadError, Place, Problem, Reason, Warning, limits};

/// The problems and warnings met while a file is resolved.
pub(crate) struct Report {
    file: String,
    problems: Vec<Problem>,
    not_shown: usize,
    pub(crate) warnings: Vec<Warning>,
}

impl Report {
    pub(crate) fn new(file: &Path) -> Self {
        Self { file: file.display().to_string(), problems: Vec::new(), not_shown: 0, warnings: Vec::new() }
    }

    /// The value, or `None` after noting the problem at a path in the document such as `nodes[2].material`.
    pub(crate) fn check<T>(&mut self, path: impl Display, result: Result<T, impl Into<Reason>>) -> Option<T> {
        match result {
            Ok(value) => Some(value),
            Err(reason) => {
                let place = Place::from(path.to_string());
                self.add([Problem { file: self.file.clone(), place, reason: reason.into(), excerpt: None }]);
                None
            }
        }
    }

    /// Notes problems that were found elsewhere, such as in an included file.
    pub(crate) fn add(&mut self, problems: impl IntoIterator<Item = Problem>) {
        for problem in problems {
            if self.problems.len() < limits::PROBLEMS {
                self.problems.push(problem);
            } else {
                self.not_shown += 1;
            }
        }
    }

    /// The warnings, or everything that is wrong.
    pub(crate) fn finish(mut self) -> Result<Vec<Warning>, LoadError> {
        if self.not_shown > 0 {
            let reason = Reason::More(self.not_shown);
            self.problems.push(Problem { file: self.file, place: Place::File, reason, excerpt: None });
        }
        match LoadError::from_problems(self.problems) {
            Some(error) => Err(error),
            None => Ok(self.warnings),
        }
    }
}
