//! Units of `regress`: something to run that passes or fails by itself, and its findings.

use std::path::{Path, PathBuf};

use super::physics::table::PairRow;
use crate::{error::TaskError, renderer::Renderer, workspace::Workspace};

/// Inputs of every unit.
#[derive(Debug)]
pub(super) struct Context {
    pub workspace: Workspace,
    pub renderer: Renderer,
    pub bless: bool,
    pub full: bool,
}

/// Work of a unit in a folder, which is empty and its own.
type UnitWork = dyn Fn(&Context, &Path, &mut Findings) -> Result<(), TaskError> + Sync;

/// Something to run that passes or fails by itself.
pub(super) struct Unit {
    /// Unique; slashes make folders.
    pub name: String,
    /// True if it calls the crates instead of the program.
    pub runs_in_process: bool,
    pub run: Box<UnitWork>,
}

impl Unit {
    /// A unit that runs the program.
    pub(super) fn new(
        name: impl Into<String>,
        run: impl Fn(&Context, &Path, &mut Findings) -> Result<(), TaskError> + Sync + 'static,
    ) -> Self {
        Self { name: name.into(), runs_in_process: false, run: Box::new(run) }
    }
}

#[derive(Debug, Default)]
pub(super) struct Findings {
    /// Failures; the unit passes without any.
    pub problems: Vec<String>,
    /// Further lines of the report.
    pub notes: Vec<String>,
    /// Image for the report.
    pub image: Option<PathBuf>,
    /// Row of the table of trials.
    pub trial: Option<Trial>,
    /// Reason of a unit that could not run completely.
    pub skipped: Option<String>,
    /// Comparison of an image with an independent reference, for the table of pairs.
    pub pair: Option<PairRow>,
}

/// Counts of something that was tried many times.
#[derive(Debug)]
pub(super) struct Trial {
    pub title: &'static str,
    /// Expected value, as text.
    pub expected: &'static str,
    pub tolerance: &'static str,
    pub tried: u64,
    pub failed: u64,
    /// Maximum error, in the measure of the tolerance; `None` where there is nothing to measure.
    pub worst: Option<f64>,
}

impl Findings {
    pub(super) fn problem(&mut self, problem: impl Into<String>) {
        self.problems.push(problem.into());
    }

    /// Adds a line to the report: a problem unless it `holds`.
    pub(super) fn line(&mut self, holds: bool, line: String) {
        if holds { self.note(line) } else { self.problem(line) }
    }

    /// Lines of the report, problems first.
    pub(super) fn lines(&self) -> impl Iterator<Item = &str> {
        self.problems.iter().chain(&self.skipped).chain(&self.notes).map(String::as_str)
    }

    pub(super) fn note(&mut self, note: impl Into<String>) {
        self.notes.push(note.into());
    }

    /// Skips the unit for want of something that is not everywhere available.
    pub(super) fn skip(&mut self, reason: impl Into<String>) {
        self.skipped = Some(reason.into());
    }

    /// Turns a skip into a problem if `all` must run (`RT_REQUIRE_ALL=1`).
    pub(super) fn require(&mut self, all: bool) {
        if all && let Some(reason) = self.skipped.take() {
            self.problem(format!("must not be skipped, as {} is 1: {reason}", rt_tests::REQUIRE_ALL));
        }
    }
}

/// A unit that has run.
#[derive(Debug)]
pub(super) struct Outcome {
    pub name: String,
    pub findings: Findings,
    pub seconds: f64,
}

impl Outcome {
    pub(super) fn verdict(&self) -> Verdict {
        match &self.findings {
            findings if !findings.problems.is_empty() => Verdict::Failed,
            findings if findings.skipped.is_some() => Verdict::Skipped,
            _ => Verdict::Passed,
        }
    }
}

/// Verdicts of a unit, the worst first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Verdict {
    Failed,
    Skipped,
    Passed,
}

impl Verdict {
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Failed => "failed",
            Self::Skipped => "skipped",
            Self::Passed => "passed",
        }
    }
}

/// Number of units with this verdict.
pub(super) fn count(outcomes: &[Outcome], verdict: Verdict) -> usize {
    outcomes.iter().filter(|outcome| outcome.verdict() == verdict).count()
}

/// Units that passed, and those that were skipped if there are any.
pub(super) fn summary(outcomes: &[Outcome]) -> String {
    let passed = format!("{} of {} passed", count(outcomes, Verdict::Passed), outcomes.len());
    match count(outcomes, Verdict::Skipped) {
        0 => passed,
        skipped => format!("{passed}, {skipped} skipped"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outcome(findings: Findings) -> Outcome {
        Outcome { name: "unit".to_owned(), findings, seconds: 0.0 }
    }

    /// Regression: such a unit passed, like one that had run.
    #[test]
    fn a_unit_that_cannot_run_is_skipped_and_fails_where_all_must_run() {
        let mut findings = Findings::default();
        findings.skip("there is no moon");
        let outcomes = [outcome(Findings::default()), outcome(findings)];
        assert_eq!(outcomes.each_ref().map(Outcome::verdict), [Verdict::Passed, Verdict::Skipped]);
        assert_eq!(summary(&outcomes), "1 of 2 passed, 1 skipped");
        assert_eq!(summary(&outcomes[..1]), "1 of 1 passed");
        let [_, Outcome { mut findings, .. }] = outcomes;
        findings.require(false);
        assert!(findings.problems.is_empty());
        findings.require(true);
        assert_eq!(findings.problems, ["must not be skipped, as RT_REQUIRE_ALL is 1: there is no moon"]);
        assert_eq!(outcome(findings).verdict(), Verdict::Failed);
    }
}
