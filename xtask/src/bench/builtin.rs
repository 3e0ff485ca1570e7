//! Rays per second, build time and memory of every accelerator on three built-in scenes.

use rt_accel::AcceleratorKind;

use super::common::print;
use crate::{
    costs::{self, Figure},
    error::TaskError,
    files,
    number::three_digits,
    scenes,
    workspace::Workspace,
};

/// Options of `bench` without a subcommand.
#[derive(Debug, clap::Args)]
// The group of these would have the name of that of the options around them.
#[group(skip)]
pub(super) struct BuiltinOptions {
    /// Also write the page docs/BENCHMARKS.md.
    #[arg(long)]
    write: bool,
    /// Set the number of rays of each kind; brute force gets fewer on large scenes.
    #[arg(long, default_value_t = 100_000, value_parser = clap::value_parser!(u32).range(100..))]
    rays: u32,
    /// Measure each time this often.
    #[arg(long, default_value_t = 7, value_parser = clap::value_parser!(u32).range(1..))]
    reps: u32,
}

/// Measures, prints, and writes the page with `--write`.
pub(super) fn run(workspace: &Workspace, options: &BuiltinOptions) -> Result<(), TaskError> {
    let BuiltinOptions { rays, reps, .. } = *options;
    let mut figures = costs::measure_scene(&scenes::mound(1_000)?, rays, reps, true)?;
    figures.extend(costs::measure_scene(&scenes::sphereflake(7_000)?, rays, reps, true)?);
    figures.extend(costs::measure_scene(&scenes::rock(80_000)?, rays, reps, true)?);
    let tables = tables(&figures);
    print(&figures, &tables)?;
    if options.write {
        let path = workspace.root.join("docs/BENCHMARKS.md");
        files::write(&path, page(&tables, rays, reps, &workspace.provenance()))?;
    }
    Ok(())
}

fn page(tables: &str, rays: u32, reps: u32, provenance: &str) -> String {
    format!(
        "# Benchmarks of the accelerators\n\n\
         After reading this page you can compare rays per second, build time and memory of all accelerators.\n\n\
         Written by `cargo xtask bench --write --rays {rays} --reps {reps}` on {provenance}. Times vary with the machine and \
         its load: compare the ratios in brackets. Rays are traced on one thread and timed by its CPU clock; the accelerators \
         alternate. Trees are built on all threads and timed by wall clock. Each time is the minimum of all \
         measurements. All accelerators give bit-identical results on every ray of a table.\n\n\
         * `mound`: the report's heap of overlapping spheres of similar size.\n\
         * `balls`: spheres on spheres, after Haines, \"A Proposal for Standard Graphics Environments\", 1987.\n\
         * `rock`: a closed mesh of small triangles.\n\n\
         Shadow rays are any-hit queries, the others closest-hit queries. Diffuse and random rays are incoherent.\n\n\
         {tables}"
    )
}

/// Rays per second by kind, build times, memory.
fn tables(figures: &[Figure]) -> String {
    let bvh = |figure: &Figure, kind: &str| {
        let is_bvh = |other: &&Figure| other.scene == figure.scene && other.accelerator == AcceleratorKind::Bvh.name();
        Some(figures.iter().find(is_bvh)?.of(kind)?.mega_rays())
    };
    let rates = ["primary", "shadow", "diffuse", "random"].map(|kind| {
        costs::each(figures, &format!("Millions of {kind} rays per second (ratio to `bvh`)"), |figure| {
            let rate = figure.of(kind)?.mega_rays();
            Some(format!("{} ({})", three_digits(rate), three_digits(rate / bvh(figure, kind)?)))
        })
    });
    let others = [
        costs::each(figures, "Build, milliseconds", |figure| Some(three_digits(figure.build_seconds * 1e3))),
        costs::each(figures, "Memory, bytes per primitive", |figure| Some(three_digits(figure.bytes_per_primitive()))),
    ];
    rates.into_iter().chain(others).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_run_measures_everything_relative_to_the_bvh() {
        let figures = costs::measure_scene(&scenes::mound(1_000).unwrap(), 400, 1, true).unwrap();
        assert_eq!(figures.len(), AcceleratorKind::ALL.len());
        let text = tables(&figures);
        let rows: Vec<Vec<&str>> = text
            .lines()
            .filter(|line| line.starts_with("| mound 1,000 "))
            .map(|line| line.split('|').collect())
            .collect();
        let column = 2 + AcceleratorKind::ALL.iter().position(|kind| *kind == AcceleratorKind::Bvh).unwrap();
        assert_eq!(rows.len(), 6, "{text}");
        assert!(rows[..4].iter().all(|row| row[column].ends_with(" (1.00) ")), "{text}");
    }
}
