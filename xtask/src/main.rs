//! # xtask: the project's own tasks
//!
//! ```text
//!   cargo xtask regress    golden images and checks, through the real binary
//!   cargo xtask tidy       project rules that no compiler checks
//!   cargo xtask bench      benchmarks of rays, images, loading and builds
//!   cargo xtask costs      costs of each accelerator on scenes of growing size
//!   cargo xtask figures    the images in the guide of rt-accel, and the plot in docs/CONVERGENCE.md
//!   cargo xtask spd        the Standard Procedural Databases as NFF files
//!   cargo xtask table1     the table of the report that this ray tracer began with
//!   cargo xtask terarays   estimated time for the lecture's trillion rays of a Cornell box
//! ```
//!
//! **Owns** tasks that developers run in addition to `cargo test`. **Does not own** programs for users, nor the tests
//! of the crates.
//!
//! Exit codes: 0 all well, 1 something differs or breaks a rule, 2 the task could not run.

#![forbid(unsafe_code)]
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "tasks talk to the developer")]

use std::process::ExitCode;

use clap::{Parser, Subcommand};

mod bench;
mod costs;
mod error;
mod figures;
mod files;
mod line_fit;
mod number;
#[path = "../../crates/rt-cli/src/processor.rs"]
mod processor;
mod regress;
mod release_build;
mod renderer;
mod scenes;
mod spd;
mod statistics;
mod table;
mod table1;
mod terarays;
mod tidy;
mod timings;
mod workspace;

use error::TaskError;
use workspace::Workspace;

/// Developer tasks: golden images, measurements, generated pages.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask")]
struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Debug, Subcommand)]
enum Task {
    /// Render the golden cases and run the checks.
    Regress(regress::RegressOptions),
    /// Check crate edges, documentation, file lengths and stray paths.
    Tidy,
    /// Measure rays per second and build times of accelerators.
    Bench(Box<bench::BenchOptions>),
    /// Measure the costs of each accelerator on scenes of growing size.
    Costs(costs::CostsOptions),
    /// Render the images in the guide of rt-accel, or measure the plot in docs/CONVERGENCE.md.
    Figures(figures::FiguresOptions),
    /// Write the Standard Procedural Databases as NFF files.
    Spd(spd::SpdOptions),
    /// Repeat the measurements of Table 1 of the report.
    Table1(table1::Table1Options),
    /// Estimate the time for the lecture's trillion rays of a Cornell box.
    Terarays(terarays::TeraraysOptions),
}

fn main() -> ExitCode {
    if let Some(code) = bench::wrapped_rustc() {
        return code;
    }
    match run(Arguments::parse().task) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(1),
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

/// True if all is well.
fn run(task: Task) -> Result<bool, TaskError> {
    let workspace = Workspace::load()?;
    match task {
        Task::Regress(options) => regress::run(workspace, &options),
        Task::Tidy => tidy::run(&workspace),
        Task::Bench(options) => bench::run(&workspace, &options).map(|()| true),
        Task::Costs(options) => costs::run(&workspace, &options).map(|()| true),
        Task::Figures(options) => figures::run(&workspace, &options).map(|()| true),
        Task::Spd(options) => spd::run(&workspace, &options).map(|()| true),
        Task::Table1(options) => table1::run(&workspace, &options).map(|()| true),
        Task::Terarays(options) => terarays::run(&workspace, &options).map(|()| true),
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn options_of_all_tasks_fit_together() {
        Arguments::command().debug_assert();
    }
}
