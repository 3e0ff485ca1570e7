//! The report that lists findings.

use std::fmt;

use crate::finding::{Finding, Findings, Kind, MAX_LISTED, Severity};
use crate::measures::Measures;

/// Number of findings of one kind that a report does not list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct More {
    /// Severity of the findings.
    pub severity: Severity,
    /// Kind of the findings.
    pub kind: Kind,
    /// Number of findings beyond the listed ones.
    pub count: u64,
}

/// Numerical health of a scene; a function of the scene only.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// Measurements of the scene as a whole.
    pub measures: Measures,
    /// Findings, the severest first, then by kind, then in the order of the scene.
    pub findings: Vec<Finding>,
    /// Counts of unlisted findings, sorted by severity and kind.
    pub more: Vec<More>,
}

impl Report {
    /// Sorts the findings by severity and kind, stably.
    pub(crate) fn new(measures: Measures, findings: Findings) -> Self {
        let Findings { mut listed, counts } = findings;
        listed.sort_by(|a, b| b.severity.cmp(&a.severity).then(a.kind.cmp(&b.kind)));
        let more = counts.into_iter().filter(|(_, count)| *count > MAX_LISTED);
        let more = more.map(|((severity, kind), count)| More { severity: severity.0, kind, count: count - MAX_LISTED });
        Self { measures, findings: listed, more: more.collect() }
    }

    /// Number of findings of a severity, listed or not.
    pub fn count(&self, severity: Severity) -> u64 {
        let listed = self.findings.iter().filter(|finding| finding.severity == severity).count() as u64;
        listed + self.more.iter().filter(|more| more.severity == severity).map(|more| more.count).sum::<u64>()
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.measures)?;
        let mut findings = self.findings.iter().peekable();
        while let Some(finding) = findings.next() {
            let Finding { severity, kind, object, message, advice, .. } = finding;
            writeln!(f, "{}[{}] {object}: {message}", severity.name(), kind.code())?;
            writeln!(f, "    {advice}")?;
            if findings.peek().is_none_or(|next| (next.severity, next.kind) != (*severity, *kind)) {
                let more = self.more.iter().find(|more| (more.severity, more.kind) == (*severity, *kind));
                if let Some(more) = more {
                    writeln!(f, "{}[{}] and {} more", severity.name(), kind.code(), more.count)?;
                }
            }
        }
        if !self.findings.is_empty() {
            writeln!(f)?;
        }
        let count = |severity, one: &str, many: &str| match self.count(severity) {
            1 => format!("1 {one}"),
            n => format!("{n} {many}"),
        };
        let errors = count(Severity::Error, "error", "errors");
        let warnings = count(Severity::Warning, "warning", "warnings");
        writeln!(f, "{errors}, {warnings}, {}", count(Severity::Note, "note", "notes"))
    }
}
