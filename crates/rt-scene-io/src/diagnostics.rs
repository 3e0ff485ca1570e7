//! Collection of errors and warnings, so that one run reports all of them.

use std::fmt::Display;
use std::path::Path;

use crate::{Diagnostic, LoadError, LoadErrorKind, Location, Warning, limits};

/// Errors and warnings about a file.
pub(crate) struct Diagnostics {
    file: String,
    errors: Vec<Diagnostic>,
    not_shown: usize,
    pub(crate) warnings: Vec<Warning>,
}

impl Diagnostics {
    pub(crate) fn new(file: &Path) -> Self {
        Self { file: file.display().to_string(), errors: Vec::new(), not_shown: 0, warnings: Vec::new() }
    }

    /// Returns the value, or `None` after recording the error at a path in the document such as `nodes[2].material`.
    pub(crate) fn check<T>(&mut self, path: impl Display, result: Result<T, impl Into<LoadErrorKind>>) -> Option<T> {
        match result {
            Ok(value) => Some(value),
            Err(kind) => {
                let (file, location) = (self.file.clone(), Location::from(path.to_string()));
                self.add([Diagnostic { file, location, kind: kind.into(), excerpt: None }]);
                None
            }
        }
    }

    /// Copies of the known names, for an error about an unknown one. Empty once errors are no longer listed.
    pub(crate) fn names<'n>(&self, names: impl IntoIterator<Item = &'n String>) -> Vec<String> {
        if self.errors.len() < limits::PROBLEMS { names.into_iter().cloned().collect() } else { Vec::new() }
    }

    /// Records a value that breaks a rule.
    pub(crate) fn refuse<T>(&mut self, path: impl Display, value: impl Display, rule: impl Into<String>) -> Option<T> {
        self.check(path, Err(LoadErrorKind::invalid(value, rule)))
    }

    /// Notes errors that were found elsewhere, such as in an included file.
    pub(crate) fn add(&mut self, errors: impl IntoIterator<Item = Diagnostic>) {
        for error in errors {
            if self.errors.len() < limits::PROBLEMS {
                self.errors.push(error);
            } else {
                self.not_shown += 1;
            }
        }
    }

    /// The warnings, or all errors.
    pub(crate) fn finish(mut self) -> Result<Vec<Warning>, LoadError> {
        if self.not_shown > 0 {
            let kind = LoadErrorKind::More(self.not_shown);
            self.errors.push(Diagnostic { file: self.file, location: Location::File, kind, excerpt: None });
        }
        match LoadError::from_diagnostics(self.errors) {
            Some(error) => Err(error),
            None => Ok(self.warnings),
        }
    }
}
