//! `regress`: does the renderer still do what it did, and what theory says?
//!
//! Owns the loop over units of work and the verdict. Each kind of unit is a file of its own: golden images, and
//! checks that need no blessed picture.

use std::{
    fs,
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use rayon::prelude::*;

use crate::{error::TaskError, renderer::Renderer, workspace::Workspace};

mod analytic;
mod bad_inputs;
mod case;
mod compare;
mod golden;
mod kills;
mod minray;
mod one_picture;
mod panels;
mod physics;
mod report;
mod stiff;
mod suite;
mod table1_counts;
mod tally;
mod trials;

/// A render that takes longer than this hangs.
const TIMEOUT: Duration = Duration::from_secs(120);
/// Full-size brute force takes its time.
const FULL_TIMEOUT: Duration = Duration::from_secs(2 * 3600);

/// What the command line asks for.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// Run only what has this in its name.
    filter: Option<String>,
    /// Replace the expected pictures that differ, list them, and still fail.
    #[arg(long)]
    bless: bool,
    /// Run checks at full size: hours instead of minutes.
    #[arg(long)]
    full: bool,
    /// Folder of further pairs for `physics` [default: ../shared/reference/physics/pairs, if it exists].
    #[arg(long, value_name = "FOLDER")]
    pairs: Option<PathBuf>,
    /// Write the table of all pairs of `physics` into docs/PHYSICS.md.
    #[arg(long, requires = "full")]
    write: bool,
    /// The program under test, instead of a build of what is here by the profile of this task.
    #[arg(long, value_name = "FILE")]
    program: Option<PathBuf>,
    /// Renders at the same time; by default one per processor.
    #[arg(long, default_value_t = 0, hide_default_value = true)]
    jobs: usize,
}

/// What every unit may use.
#[derive(Debug)]
struct Context {
    workspace: Workspace,
    renderer: Renderer,
    bless: bool,
    full: bool,
}

/// Something to run that passes or fails by itself.
trait Unit: Sync {
    /// Unique; slashes make folders.
    fn name(&self) -> String;

    /// True if it calls the crates on all processors rather than the program: it then runs alone, so that its seconds
    /// are its own.
    fn runs_in_process(&self) -> bool {
        false
    }

    /// Runs in `folder`, which is empty and its own.
    fn run(&self, context: &Context, folder: &Path) -> Result<Findings, TaskError>;
}

/// What a unit found.
#[derive(Debug, Default)]
struct Findings {
    /// What is wrong; the unit passes if nothing is.
    problems: Vec<String>,
    /// What else is worth a line.
    notes: Vec<String>,
    /// A picture that shows it.
    picture: Option<PathBuf>,
    /// How often something was tried, for the table at the end.
    trial: Option<Trial>,
    /// Reason for which the unit could not run, or not all of it.
    skipped: Option<String>,
    /// Comparison of an image with an independent reference, for the table of pairs.
    pair: Option<physics::Row>,
}

/// Something that was tried many times.
#[derive(Debug)]
struct Trial {
    title: &'static str,
    /// What theory says, and how near to it is near enough.
    expected: &'static str,
    tolerance: &'static str,
    tried: u64,
    failed: u64,
    /// Greatest error, in the measure of the tolerance; `None` where there is nothing to measure.
    worst: Option<f64>,
}

impl Findings {
    fn problem(&mut self, problem: impl Into<String>) {
        self.problems.push(problem.into());
    }

    /// All that is worth a line, problems first.
    fn lines(&self) -> impl Iterator<Item = &str> {
        self.problems.iter().chain(&self.skipped).chain(&self.notes).map(String::as_str)
    }

    fn note(&mut self, note: impl Into<String>) {
        self.notes.push(note.into());
    }

    /// States that the unit cannot run here, and why: something that not everybody has is not there.
    fn skip(&mut self, reason: impl Into<String>) {
        self.skipped = Some(reason.into());
    }

    /// Makes a problem of a skip where everything must run, which is for `RT_REQUIRE_ALL=1` to say.
    fn require(&mut self, all: bool) {
        if all && let Some(reason) = self.skipped.take() {
            self.problem(format!("must not be skipped, as {} is 1: {reason}", rt_tests::REQUIRE_ALL));
        }
    }
}

/// A unit that has run.
#[derive(Debug)]
struct Outcome {
    name: String,
    findings: Findings,
    seconds: f64,
}

impl Outcome {
    fn verdict(&self) -> Verdict {
        match &self.findings {
            findings if !findings.problems.is_empty() => Verdict::Failed,
            findings if findings.skipped.is_some() => Verdict::Skipped,
            _ => Verdict::Passed,
        }
    }
}

/// What became of a unit, the worst first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Verdict {
    Failed,
    Skipped,
    Passed,
}

impl Verdict {
    const fn name(self) -> &'static str {
        match self {
            Self::Failed => "failed",
            Self::Skipped => "skipped",
            Self::Passed => "passed",
        }
    }
}

/// Number of units with this verdict.
fn count(outcomes: &[Outcome], verdict: Verdict) -> usize {
    outcomes.iter().filter(|outcome| outcome.verdict() == verdict).count()
}

/// Units that passed, and those that were skipped if there are any.
fn summary(outcomes: &[Outcome]) -> String {
    let passed = format!("{} of {} passed", count(outcomes, Verdict::Passed), outcomes.len());
    match count(outcomes, Verdict::Skipped) {
        0 => passed,
        skipped => format!("{passed}, {skipped} skipped"),
    }
}

/// Runs everything that matches the filter. True if none of it failed.
pub(crate) fn run(workspace: Workspace, options: &Options) -> Result<bool, TaskError> {
    let mut units = units(&workspace, options)?;
    if let Some(filter) = &options.filter {
        if options.write && filter != "physics" {
            return Err(TaskError::Other("--write needs all pairs: `regress physics --full --write`".to_owned()));
        }
        units.retain(|unit| unit.name().contains(filter.as_str()));
    }
    if units.is_empty() {
        return Err(TaskError::Other("nothing matches the filter".to_owned()));
    }
    let program = match &options.program {
        Some(program) => fs::canonicalize(program).map_err(TaskError::file(program))?,
        None if units.iter().all(|unit| unit.runs_in_process()) => PathBuf::new(),
        None => workspace.build_renderer()?,
    };
    let folder = workspace.fresh_folder("regress")?;
    let renderer = Renderer::new(program, if options.full { FULL_TIMEOUT } else { TIMEOUT });
    let context = Context { workspace, renderer, bless: options.bless, full: options.full };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(options.jobs).build();
    let pool = pool.map_err(|error| TaskError::Other(error.to_string()))?;
    let (alone, together): (Vec<_>, Vec<_>) = units.into_iter().partition(|unit| unit.runs_in_process());
    let run = |unit: &dyn Unit| run_unit(unit, &context, &folder);
    let mut outcomes: Vec<Outcome> = pool.install(|| together.par_iter().map(|unit| run(unit.as_ref())).collect());
    outcomes.extend(alone.iter().map(|unit| pool.install(|| run(unit.as_ref()))));

    let page = folder.join("index.html");
    fs::write(&page, report::html(&outcomes)?).map_err(TaskError::file(&page))?;
    if let Some(table) = trials::markdown(&outcomes) {
        println!("\n{table}");
        let path = folder.join("trials.md");
        fs::write(&path, table).map_err(TaskError::file(&path))?;
    }
    physics::finish(&context.workspace, &outcomes, &folder, options.full, options.write)?;
    println!("{}; see {}", summary(&outcomes), context.workspace.relative(&page));
    Ok(count(&outcomes, Verdict::Failed) == 0)
}

fn units(workspace: &Workspace, options: &Options) -> Result<Vec<Box<dyn Unit>>, TaskError> {
    let mut units: Vec<Box<dyn Unit>> = Vec::new();
    // The long ones come first, so that they do not run alone at the end.
    units.push(Box::new(minray::Minray));
    units.extend(table1_counts::units());
    units.extend(one_picture::units(workspace)?);
    units.extend(kills::units());
    units.extend(bad_inputs::units());
    units.extend(physics::units(workspace, options.pairs.as_deref())?);
    units.extend(golden::units(workspace)?);
    units.extend(stiff::units());
    units.extend(analytic::units());
    Ok(units)
}

/// Runs one unit. Whatever goes wrong is a finding, so that it does not hide the other units.
fn run_unit(unit: &dyn Unit, context: &Context, folder: &Path) -> Outcome {
    let started = Instant::now();
    let name = unit.name();
    let folder = folder.join(&name);
    let found = fs::create_dir_all(&folder).map_err(TaskError::file(&folder)).and_then(|()| unit.run(context, &folder));
    let mut findings =
        found.unwrap_or_else(|error| Findings { problems: vec![error.to_string()], ..Findings::default() });
    if let Some(reason) = &findings.skipped {
        rt_tests::report_skipped(format_args!("regress::{name}"), reason);
    }
    findings.require(rt_tests::requires_all());
    let outcome = Outcome { name, findings, seconds: started.elapsed().as_secs_f64() };
    print(&outcome);
    outcome
}

fn print(outcome: &Outcome) {
    let verdict = match outcome.verdict() {
        Verdict::Passed => "ok     ",
        Verdict::Skipped => "skipped",
        Verdict::Failed => "FAILED ",
    };
    let mut lines = format!("{verdict} {} ({:.1} s)", outcome.name, outcome.seconds);
    for line in outcome.findings.lines() {
        lines.push_str("\n       ");
        lines.push_str(&line.replace('\n', "\n       "));
    }
    println!("{lines}");
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outcome(findings: Findings) -> Outcome {
        Outcome { name: "unit".to_owned(), findings, seconds: 0.0 }
    }

    /// Such a unit passed, and nobody could tell it from one that had run.
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
