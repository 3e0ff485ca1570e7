//! Suites: chapters of named cases, each of which counts what it tried and what failed.

use std::{error::Error, path::Path};

use super::{
    tally::Tally,
    unit::{Context, Findings, Trial, Unit},
};
use crate::{error::TaskError, workspace::Workspace};

/// Result of a step that can fail for want of a scene or a shape.
pub(super) type Fallible<T> = Result<T, Box<dyn Error + Send + Sync>>;

/// Checks of a case.
pub(super) type Found = Fallible<Tally>;

/// A named case.
#[derive(Clone, Copy, Debug)]
pub(super) struct Case {
    pub id: &'static str,
    pub title: &'static str,
    pub expected: &'static str,
    pub tolerance: &'static str,
    pub run: fn(&Conditions) -> Found,
}

/// Declares the cases of a chapter: id, title, expected value, tolerance, function.
macro_rules! cases {
    ($($id:literal, $title:literal, $expected:literal, $tolerance:literal, $run:expr;)*) => {
        pub(super) const CASES: &[Case] =
            &[$(Case { id: $id, title: $title, expected: $expected, tolerance: $tolerance, run: $run }),*];
    };
}
pub(super) use cases;

/// Inputs of a case.
#[derive(Clone, Copy, Debug)]
pub(super) struct Conditions<'c> {
    /// Full size rather than a sample of it.
    pub full: bool,
    /// For scene files.
    pub workspace: &'c Workspace,
}

impl Conditions<'_> {
    /// Number of trials.
    pub(super) const fn count(&self, reduced: u64, full: u64) -> u64 {
        if self.full { full } else { reduced }
    }
}

/// One unit for each case of the chapters of the suite of this name.
pub(super) fn units(suite: &'static str, chapters: &'static [&'static [Case]]) -> impl Iterator<Item = Box<dyn Unit>> {
    chapters.iter().copied().flatten().map(move |case| Box::new(Entry { suite, case: *case }) as Box<dyn Unit>)
}

/// A case of a suite.
struct Entry {
    suite: &'static str,
    case: Case,
}

impl Unit for Entry {
    fn name(&self) -> String {
        format!("{}/{}", self.suite, self.case.id)
    }

    fn runs_in_process(&self) -> bool {
        true
    }

    fn run(&self, context: &Context, _: &Path) -> Result<Findings, TaskError> {
        let conditions = Conditions { full: context.full, workspace: &context.workspace };
        let tally = (self.case.run)(&conditions).map_err(|error| TaskError::Other(error.to_string()))?;
        Ok(self.case.findings(tally))
    }
}

impl Case {
    fn findings(&self, tally: Tally) -> Findings {
        let mut findings = Findings::default();
        if tally.failed > 0 {
            findings.problem(format!("{} of {} failed", tally.failed, tally.tried));
        }
        if tally.tried == 0 {
            findings.problem("nothing was tried");
        }
        findings.problems.extend(tally.problems);
        findings.notes = tally.notes;
        let Self { title, expected, tolerance, .. } = *self;
        let Tally { tried, failed, worst, .. } = tally;
        findings.trial = Some(Trial { title, expected, tolerance, tried, failed, worst });
        findings
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_case_that_tries_nothing_or_fails_does_not_pass() {
        let case = Case { id: "", title: "", expected: "", tolerance: "", run: |_| Ok(Tally::default()) };
        assert_eq!(case.findings(Tally::default()).problems, ["nothing was tried"]);
        let mut tally = Tally::default();
        tally.check(true, String::new);
        tally.check(false, || "wrong".to_owned());
        let findings = case.findings(tally);
        assert_eq!(findings.problems, ["1 of 2 failed", "wrong"]);
        assert_eq!(findings.trial.map(|trial| (trial.tried, trial.failed)), Some((2, 1)));
    }
}
