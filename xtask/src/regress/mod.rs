//! `regress`: comparison with golden images, theory and independent references.
//!
//! Owns the loop over units and the verdict. Each kind of unit is a file.

use std::{
    fs,
    num::NonZero,
    path::{Path, PathBuf},
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicUsize, Ordering},
    },
    thread,
    time::{Duration, Instant},
};

use self::unit::{Context, Findings, Outcome, Unit, Verdict, count, summary};
use crate::{error::TaskError, files, renderer::Renderer, workspace::Workspace};

mod analytic;
mod case;
mod checks;
mod compare;
mod golden;
mod kills;
mod minray;
mod numerics;
mod panels;
mod physics;
mod precision;
mod report;
mod same_image;
mod shape_tracer;
mod suite;
mod table1_counts;
mod trial_table;
mod unit;

/// A render that takes longer than this hangs.
const TIMEOUT: Duration = Duration::from_secs(120);
/// Full-size brute force takes its time.
const FULL_TIMEOUT: Duration = Duration::from_secs(2 * 3600);

#[derive(Debug, clap::Args)]
pub(crate) struct RegressOptions {
    /// Run only units whose name contains this, or a suite such as `golden/`.
    filter: Option<String>,
    /// Replace the expected images that differ, and list them; the exit code is still 1.
    #[arg(long)]
    bless: bool,
    /// Run checks at full size, which takes hours instead of minutes.
    #[arg(long)]
    full: bool,
    /// Add pairs for `physics` from this directory [default: ../shared/reference/physics/pairs, if it exists].
    #[arg(long, value_name = "FOLDER")]
    pairs: Option<PathBuf>,
    /// Write the table of all pairs of `physics` into docs/PHYSICS.md.
    #[arg(long, requires = "full")]
    write: bool,
    /// Test this program [default: rt-cli, built with the profile of this task].
    #[arg(long, value_name = "FILE")]
    program: Option<PathBuf>,
    /// Set the number of simultaneous renders [default: one per processor].
    #[arg(long, default_value_t = 0, hide_default_value = true)]
    jobs: usize,
}

/// Runs everything that matches the filter. True if none of it failed.
pub(crate) fn run(workspace: Workspace, options: &RegressOptions) -> Result<bool, TaskError> {
    let mut units = units(&workspace, options)?;
    if let Some(filter) = &options.filter {
        // Earlier name of the suite.
        let filter = &filter.replace("stiff", "numerics");
        if options.write && filter != "physics" {
            return Err(TaskError::Other("--write needs all pairs: `regress physics --full --write`".to_owned()));
        }
        units.retain(|unit| matches(&unit.name, filter));
    }
    if units.is_empty() {
        return Err(TaskError::Other("no unit matches the filter".to_owned()));
    }
    let program = match &options.program {
        Some(program) => fs::canonicalize(program).map_err(TaskError::file(program))?,
        None if units.iter().all(|unit| unit.runs_in_process) => PathBuf::new(),
        None => workspace.build_renderer()?,
    };
    let folder = workspace.fresh_folder("regress")?;
    let renderer = Renderer::new(program, if options.full { FULL_TIMEOUT } else { TIMEOUT });
    let context = Context { workspace, renderer, bless: options.bless, full: options.full };
    let outcomes = run_all(&units, options.jobs, &|unit| run_unit(unit, &context, &folder))?;

    let page = folder.join("index.html");
    files::write(&page, report::html(&outcomes)?)?;
    if let Some(table) = trial_table::table(&outcomes) {
        println!("\n{table}");
        let path = folder.join("trials.md");
        files::write(&path, table.to_string())?;
    }
    physics::finish(&context.workspace, &outcomes, &folder, options.full, options.write)?;
    println!("{}; see {}", summary(&outcomes), context.workspace.relative(&page));
    Ok(count(&outcomes, Verdict::Failed) == 0)
}

/// True if the name contains the filter, or starts with it if that is a suite: `golden/`.
fn matches(name: &str, filter: &str) -> bool {
    if filter.ends_with('/') { name.starts_with(filter) } else { name.contains(filter) }
}

fn units(workspace: &Workspace, options: &RegressOptions) -> Result<Vec<Unit>, TaskError> {
    // The long ones come first, so that they do not run alone at the end.
    let mut units = vec![minray::unit()];
    units.extend(table1_counts::units());
    units.extend(analytic::units());
    units.extend(numerics::units());
    units.extend(same_image::units(workspace)?);
    units.extend(precision::units(workspace)?);
    units.extend(kills::units());
    units.extend(physics::units(workspace, options.pairs.as_deref())?);
    units.extend(golden::units(workspace)?);
    Ok(units)
}

/// Runs all units, `jobs` at a time (0: one per processor), in their order. Loops within a unit share a processor, unless there
/// are fewer units than processors. Outcomes are in the order of the units.
fn run_all(units: &[Unit], jobs: usize, run: &(dyn Fn(&Unit) -> Outcome + Sync)) -> Result<Vec<Outcome>, TaskError> {
    let processors = thread::available_parallelism().map_or(1, NonZero::get);
    let jobs = if jobs == 0 { processors } else { jobs }.min(units.len()).max(1);
    let pool = || rayon::ThreadPoolBuilder::new().num_threads((processors / jobs).max(1)).build();
    let pools = (0..jobs).map(|_| pool()).collect::<Result<Vec<_>, _>>().map_err(TaskError::other)?;
    let next = AtomicUsize::new(0);
    let outcomes = Mutex::new(Vec::new());
    let work = || {
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(unit) = units.get(index) else { break };
            let outcome = run(unit);
            outcomes.lock().unwrap_or_else(PoisonError::into_inner).push((index, outcome));
        }
    };
    thread::scope(|scope| {
        for pool in &pools {
            scope.spawn(|| pool.install(work));
        }
    });
    let mut outcomes = outcomes.into_inner().unwrap_or_else(PoisonError::into_inner);
    outcomes.sort_by_key(|(index, _)| *index);
    Ok(outcomes.into_iter().map(|(_, outcome)| outcome).collect())
}

/// Runs one unit. Errors are findings, so that the other units run.
fn run_unit(unit: &Unit, context: &Context, folder: &Path) -> Outcome {
    let started = Instant::now();
    let name = unit.name.clone();
    let folder = folder.join(&name);
    let mut findings = Findings::default();
    let created = fs::create_dir_all(&folder).map_err(TaskError::file(&folder));
    if let Err(error) = created.and_then(|()| (unit.run)(context, &folder, &mut findings)) {
        findings.problem(error.to_string());
    }
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

    #[test]
    fn units_share_the_processors_and_outcomes_keep_their_order() {
        let processors = thread::available_parallelism().map_or(1, NonZero::get);
        for (units, jobs, threads) in [(50, 0, 1), (50, 3, (processors / 3).max(1)), (1, 0, processors), (0, 0, 0)] {
            let units: Vec<_> = (0..units).map(|index| Unit::new(index.to_string(), |_, _, _| Ok(()))).collect();
            let run = |unit: &Unit| {
                assert_eq!(rayon::current_num_threads(), threads);
                Outcome { name: unit.name.clone(), findings: Findings::default(), seconds: 0.0 }
            };
            let outcomes = run_all(&units, jobs, &run).unwrap();
            assert!(outcomes.iter().map(|outcome| &outcome.name).eq(units.iter().map(|unit| &unit.name)));
        }
    }

    #[test]
    fn a_suite_is_a_prefix_and_other_filters_are_found_anywhere() {
        assert!(matches("golden/cone", "golden/") && matches("golden/cone", "cone"));
        assert!(!matches("one-picture/tests/golden/cone/scene", "golden/"));
    }
}
