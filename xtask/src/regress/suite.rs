//! Suites: chapters of named cases, which count trials and failures.

use std::error::Error;

use super::{
    checks::Checks,
    unit::{Context, Findings, Trial, Unit},
};
use crate::{error::TaskError, workspace::Workspace};

/// Result of a step that can fail for want of a scene or a shape.
pub(super) type Fallible<T> = Result<T, Box<dyn Error + Send + Sync>>;

#[derive(Clone, Copy, Debug)]
pub(super) struct Case {
    pub id: &'static str,
    pub title: &'static str,
    pub expected: &'static str,
    pub tolerance: &'static str,
    /// Adds the checks to those given.
    pub run: fn(&Conditions, &mut Checks) -> Fallible<()>,
}

/// Declares the cases of a chapter: id, title, expected value, tolerance, function.
macro_rules! cases {
    ($($id:literal, $title:literal, $expected:literal, $tolerance:literal, $run:expr;)*) => {
        pub(super) const CASES: &[Case] =
            &[$(Case { id: $id, title: $title, expected: $expected, tolerance: $tolerance, run: $run }),*];
        #[cfg(test)]
        pub(super) const IDS: &[&str] = &[$($id),*];
    };
}
pub(super) use cases;

/// Declares the chapters of a suite, and the ids of their cases. A test that reads only the ids compiles none of the cases; a
/// `static` would compile them all.
macro_rules! chapters {
    ($($chapter:ident),* $(,)?) => {
        const CHAPTERS: &[&[Case]] = &[$($chapter::CASES),*];
        #[cfg(test)]
        const IDS: &[&[&str]] = &[$($chapter::IDS),*];
    };
}
pub(super) use chapters;

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

    /// Numbers of seeds and of samples of most estimates.
    pub(super) const fn effort(&self) -> [u64; 2] {
        [self.count(64, 256), self.count(64, 256)]
    }
}

/// One unit for each case of the chapters of the suite of this name.
pub(super) fn units(suite: &'static str, chapters: &'static [&'static [Case]]) -> impl Iterator<Item = Unit> {
    chapters.iter().copied().flatten().map(move |case| Unit {
        runs_in_process: true,
        ..Unit::new(format!("{suite}/{}", case.id), |context, _, findings| case.run(context, findings))
    })
}

impl Case {
    fn run(&self, context: &Context, findings: &mut Findings) -> Result<(), TaskError> {
        let conditions = Conditions { full: context.full, workspace: &context.workspace };
        let mut checks = Checks::default();
        (self.run)(&conditions, &mut checks).map_err(TaskError::other)?;
        *findings = self.findings(checks);
        Ok(())
    }

    fn findings(&self, checks: Checks) -> Findings {
        let mut findings = Findings::default();
        if checks.failed > 0 {
            findings.problem(format!("{} of {} failed", checks.failed, checks.tried));
        }
        if checks.tried == 0 {
            findings.problem("nothing was tried");
        }
        findings.problems.extend(checks.problems);
        findings.notes = checks.notes;
        let Self { title, expected, tolerance, .. } = *self;
        let Checks { tried, failed, worst, .. } = checks;
        findings.trial = Some(Trial { title, expected, tolerance, tried, failed, worst });
        findings
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_case_that_tries_nothing_or_fails_does_not_pass() {
        let case = Case { id: "", title: "", expected: "", tolerance: "", run: |_, _| Ok(()) };
        assert_eq!(case.findings(Checks::default()).problems, ["nothing was tried"]);
        let mut checks = Checks::default();
        checks.check(true, String::new);
        checks.check(false, || "wrong".to_owned());
        let findings = case.findings(checks);
        assert_eq!(findings.problems, ["1 of 2 failed", "wrong"]);
        assert_eq!(findings.trial.map(|trial| (trial.tried, trial.failed)), Some((2, 1)));
    }
}
