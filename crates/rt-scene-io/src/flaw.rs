//! What is wrong in a line of a text, before it is known in which file.

use std::fmt::Display;

use crate::Reason;

/// What is wrong in a line.
#[derive(Debug)]
pub(crate) struct Flaw {
    /// Counted from 1.
    pub(crate) line: usize,
    pub(crate) reason: Reason,
}

impl Flaw {
    /// A value in a line that breaks a rule.
    pub(crate) fn new(line: usize, value: impl Display, rule: impl Into<String>) -> Self {
        Self { line, reason: Reason::invalid(value, rule) }
    }
}
