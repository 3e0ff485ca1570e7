//! Findings of a rule.

/// Breaches fail the task, warnings do not.
#[derive(Debug, Default)]
pub(super) struct Report {
    pub breaches: Vec<String>,
    pub warnings: Vec<String>,
}
