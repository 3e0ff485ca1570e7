//! `table1`: Table 1 of the report that this ray tracer began with, compared with our measurements.
//!
//! Counts come from a render that counts, times from one that does not.

use std::{path::Path, time::Duration};

use crate::{
    error::TaskError,
    files,
    number::grouped,
    processor::processor,
    renderer::Renderer,
    statistics::{REPORT, REPORT_PRIMARY, ReportRow, Statistics, measure},
    table::Table,
    workspace::Workspace,
};

const TIMEOUT: Duration = Duration::from_secs(3600);

#[derive(Debug, clap::Args)]
pub(crate) struct Table1Options {
    /// Replace the table between the markers in docs/REPORT.md.
    #[arg(long)]
    write: bool,
}

/// Renders, prints the table, and with `--write` writes it.
pub(crate) fn run(workspace: &Workspace, options: &Table1Options) -> Result<(), TaskError> {
    let renderer = Renderer::new(workspace.build_release_renderer()?, TIMEOUT);
    let folder = workspace.fresh_folder("table1")?;
    let mut table = Table::new(2, HEADER);
    for report in &REPORT {
        let scene = workspace.root.join(report.scene);
        let counts = measure(&renderer, &folder, &scene, &["--accel", "linear"])?;
        let seconds = [time(&renderer, &folder, &scene, "linear")?, time(&renderer, &folder, &scene, "auto")?];
        push_rows(&mut table, report, &counts, seconds);
    }
    let table = table.to_string();
    print!("{table}");
    if options.write {
        let path = workspace.root.join("docs/REPORT.md");
        files::replace_block(&path, "table1", &format!("{}{table}\n", origin(&processor(), &workspace.commit())))?;
    }
    Ok(())
}

/// Sentence about the origin of the rows of our figures.
fn origin(processor: &str, commit: &str) -> String {
    format!(
        "\nThe rows \"ours\" were written by `cargo xtask table1 --write` on one thread of one {processor}, \
         at commit {commit}.\n\n"
    )
}

/// Wall-clock seconds of the whole program on one thread.
fn time(renderer: &Renderer, folder: &Path, scene: &Path, accel: &str) -> Result<f64, TaskError> {
    let scene = scene.to_string_lossy();
    let args =
        ["render", &scene, "-o", "picture.png", "--quiet", "--dither", "off", "--threads", "1", "--accel", accel];
    Ok(renderer.measure(folder, &args)?.wall_seconds)
}

const HEADER: [&str; 9] = [
    "spheres",
    "",
    "primary rays",
    "shadow rays",
    "sphere tests",
    "hits",
    "time, brute force",
    "per test",
    "time, automatic",
];

/// Adds the row of the report and ours; the seconds are those of brute force and of the default accelerator.
fn push_rows(table: &mut Table, report: &ReportRow, counts: &Statistics, [linear_seconds, auto_seconds]: [f64; 2]) {
    let shadow = format!("{:.2} million", report.shadow_rays * 1e-6);
    let (spheres, primary) = (report.spheres.to_string(), grouped(REPORT_PRIMARY));
    let seconds = format!("{} s", report.seconds);
    table.push([&spheres, "report", &primary, &shadow, "", "", &seconds, "20 ns", ""]);
    let total = counts.rays.total;
    table.push([
        String::new(),
        "ours".to_owned(),
        grouped(counts.rays.primary.rays),
        format!("{} ({} traced)", grouped(counts.shadow_rays()), grouped(counts.rays.shadow.rays)),
        grouped(total.primitive_tests),
        grouped(total.hits),
        format!("{linear_seconds:.2} s"),
        format!("{:.2} ns", linear_seconds * 1e9 / total.primitive_tests.max(1) as f64),
        format!("{auto_seconds:.2} s"),
    ]);
}
