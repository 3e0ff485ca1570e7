//! `stiff`: the cases at which ray tracers break, with what is exactly right.
//!
//! Each chapter is a file of its own with its list of cases; a case counts what it tried and what failed. Expected
//! values are closed forms, or roots that were computed with 80 digits from the numbers as `f64` has them.

use std::{error::Error, path::Path};

use super::{Context, Findings, Trial, Unit};
use crate::{error::TaskError, workspace::Workspace};

mod accelerators;
mod boxes_planes;
mod differential;
mod exact;
mod invariance;
mod meshes;
mod optics;
mod pictures;
mod polygons;
mod quadrics;
mod scenes;
mod spawn;
mod spheres;
mod tally;

use tally::{FOUR_U, Tally, Tolerance};

/// What a case found; an error is one that keeps it from being tried.
type Found = Result<Tally, Box<dyn Error + Send + Sync>>;

/// A named case.
#[derive(Clone, Copy, Debug)]
struct Case {
    id: &'static str,
    title: &'static str,
    expected: &'static str,
    tolerance: &'static str,
    run: fn(&Conditions) -> Found,
}

/// What cases may use.
#[derive(Clone, Copy, Debug)]
struct Conditions<'c> {
    /// Full size rather than a sample of it.
    full: bool,
    /// For scene files.
    workspace: &'c Workspace,
}

impl Conditions<'_> {
    /// How often to try.
    const fn count(&self, reduced: u64, full: u64) -> u64 {
        if self.full { full } else { reduced }
    }
}

const CHAPTERS: [&[Case]; 11] = [
    spheres::CASES,
    boxes_planes::CASES,
    quadrics::CASES,
    meshes::CASES,
    polygons::CASES,
    spawn::CASES,
    accelerators::CASES,
    differential::CASES,
    optics::CASES,
    pictures::CASES,
    invariance::CASES,
];

/// One unit per case.
pub(super) fn units() -> impl Iterator<Item = Box<dyn Unit>> {
    CHAPTERS.into_iter().flatten().map(|case| Box::new(*case) as Box<dyn Unit>)
}

impl Unit for Case {
    fn name(&self) -> String {
        format!("stiff/{}", self.id)
    }

    fn runs_in_process(&self) -> bool {
        true
    }

    fn run(&self, context: &Context, _: &Path) -> Result<Findings, TaskError> {
        let conditions = Conditions { full: context.full, workspace: &context.workspace };
        let tally = (self.run)(&conditions).map_err(|error| TaskError::Other(error.to_string()))?;
        Ok(self.findings(tally))
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
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn every_case_of_the_table_is_here_once() {
        let ids: Vec<&str> = CHAPTERS.into_iter().flatten().map(|case| case.id).collect();
        let numbers = (1..=57).chain([70, 71, 80]).map(|number| format!("S{number:02}"));
        let expected: BTreeSet<String> = numbers.chain(["differential".to_owned()]).collect();
        assert_eq!(ids.len(), expected.len(), "{ids:?}");
        assert_eq!(ids.into_iter().map(str::to_owned).collect::<BTreeSet<_>>(), expected);
    }

    #[test]
    fn a_case_that_tries_nothing_or_fails_does_not_pass() {
        let case = spheres::CASES[0];
        assert_eq!(case.findings(Tally::default()).problems, ["nothing was tried"]);
        let mut tally = Tally::default();
        tally.check(true, String::new);
        tally.check(false, || "wrong".to_owned());
        let findings = case.findings(tally);
        assert_eq!(findings.problems, ["1 of 2 failed", "wrong"]);
        assert_eq!(findings.trial.map(|trial| (trial.tried, trial.failed)), Some((2, 1)));
    }
}
