//! The tables, on the terminal and as a page.

use std::fmt::Display;

use rt_accel::AcceleratorKind;

use super::{
    claims,
    figure::Figure,
    growth::{Costs, Growth, Slope},
};
use crate::{
    number::{grouped, three_digits},
    table::Table,
};

/// Cell without a measurement.
const NO_VALUE: &str = "–";

/// All tables for the terminal.
pub(super) fn terminal(costs: &Costs) -> String {
    let tables = matrices(costs).into_iter().map(|matrix| format!("{matrix}\n"));
    tables.chain(claims::of(costs).into_iter().map(|claim| format!("* {claim}\n"))).collect()
}

/// The whole page `docs/COSTS.md`.
pub(super) fn markdown(costs: &Costs, full: bool, model: impl Display, provenance: &str) -> String {
    let command = if full { "cargo xtask costs --full --write" } else { "cargo xtask costs --write" };
    let mut text = format!(
        "# Costs of the accelerators\n\n\
         After reading this page you can choose an accelerator by its build time, memory and work per ray.\n\n\
         Written by `{command}` on {provenance}. Nodes, tests and bytes are equal in every run and on every machine. Times \
         vary with the machine and its load: compare their ratios only. Rays are traced on one thread, trees are built \
         on all. All accelerators gave bit-identical results on every counted ray. Where rays are very \
         expensive, fewer of them are traced.\n\n\
         * `mound`: the report's heap of overlapping spheres of similar size, in a half sphere.\n\
         * `balls`, `tree`, `gears`: after Haines, \"A Proposal for Standard Graphics Environments\", 1987. Spheres on \
           spheres; frusta and spheres that fork; gear wheels of thin triangles.\n\
         * `rock`: a closed mesh of small triangles.\n\
         * `stadium`: such a rock in the middle of a stadium a thousand times its size; the camera looks at the rock.\n\
         * `model`: the mesh `{model}`.\n\n\
         `bih-lazy` is measured after its rays have been traced once; its build time is that before the first ray. \
         Shadow rays are any-hit queries, the others closest-hit queries; diffuse rays are incoherent.\n\n\
         ## Claims of the report, the lecture and papers\n\n\
         n is the number of primitives. *Work* is the number of visited nodes plus the number of tested primitives.\n\n"
    );
    text.extend(claims::of(costs).into_iter().map(|claim| format!("* {claim}\n")));
    for matrix in matrices(costs) {
        text.push('\n');
        text.push_str(&matrix);
    }
    text
}

fn matrices(costs: &Costs) -> Vec<String> {
    let mut all = vec![
        each(&costs.figures, "Build, milliseconds", |figure| Some(three_digits(figure.build_seconds * 1e3))),
        each(&costs.figures, "Memory, bytes per primitive", |figure| Some(three_digits(figure.bytes_per_primitive()))),
    ];
    for kind in ["primary", "shadow", "diffuse"] {
        let title = format!("Nodes + tests of a {kind} ray");
        all.push(each(&costs.figures, &title, |figure| {
            let rays = figure.of(kind)?;
            Some(format!("{} + {}", three_digits(rays.nodes_per_ray()), three_digits(rays.tests_per_ray())))
        }));
    }
    for kind in ["primary", "shadow", "diffuse"] {
        let title = format!("Millions of {kind} rays per second");
        all.push(each(&costs.figures, &title, |figure| Some(three_digits(figure.of(kind)?.mega_rays()))));
    }
    all.push(growth(costs, "Growth of the build: k in time ~ nᵏ, ± standard error", |growth| growth.build));
    all.push(growth(costs, "Growth of memory: k in bytes ~ nᵏ", |growth| growth.memory));
    all.push(growth(costs, "Growth of work: k in nodes and tests of a ray ~ nᵏ, mean of all kinds", |growth| {
        growth.work
    }));
    all.push(growth(costs, "Growth of time: k in time of a ray ~ nᵏ, mean of all kinds", |growth| growth.time));
    all
}

/// A row for each scene and size.
pub(crate) fn each(figures: &[Figure], title: &str, cell: impl Fn(&Figure) -> Option<String>) -> String {
    let mut rows: Vec<(&str, usize)> = figures.iter().map(|figure| (figure.scene, figure.primitives)).collect();
    rows.dedup();
    // A stable sort by first appearance puts the sizes of a scene together.
    let first = |scene: &str| figures.iter().position(|figure| figure.scene == scene);
    rows.sort_by_key(|(scene, _)| first(scene));
    let rows = rows.into_iter().map(|row| (format!("{} {}", row.0, grouped(row.1 as u64)), row));
    matrix(title, rows, |&(scene, primitives), accelerator| {
        let key = (scene, primitives, accelerator);
        cell(figures.iter().find(|figure| (figure.scene, figure.primitives, figure.accelerator) == key)?)
    })
}

/// A row for each scene.
fn growth(costs: &Costs, title: &str, slope: impl Fn(&Growth) -> Slope) -> String {
    let mut rows: Vec<&str> = costs.growth.iter().map(|growth| growth.scene).collect();
    rows.dedup();
    matrix(title, rows.into_iter().map(|scene| (scene.to_owned(), scene)), |scene, accelerator| {
        let key = (*scene, accelerator);
        let Slope { exponent, error } =
            slope(costs.growth.iter().find(|growth| (growth.scene, growth.accelerator) == key)?);
        Some(format!("{exponent:.2} ± {error:.2}"))
    })
}

/// Section with a table of one quantity: a row for each scene, a column for each accelerator. The cells of each row are
/// `cell(row, accelerator)`.
fn matrix<R>(
    title: &str,
    rows: impl IntoIterator<Item = (String, R)>,
    cell: impl Fn(&R, &str) -> Option<String>,
) -> String {
    let names = || AcceleratorKind::ALL.iter().map(|kind| kind.name());
    let mut table = Table::new(1, std::iter::once("").chain(names()));
    for (name, row) in rows {
        let cells = names().map(|kind| cell(&row, kind).unwrap_or_else(|| NO_VALUE.to_owned()));
        table.push(std::iter::once(name).chain(cells));
    }
    format!("## {title}\n\n{table}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_and_columns_are_in_their_places() {
        let text = matrix("t", [("a".to_owned(), 7)], |row, kind| (kind == "grid").then(|| format!("{row}")));
        let lines: Vec<Vec<&str>> = text.lines().map(|line| line.split('|').map(str::trim).collect()).collect();
        assert_eq!((lines[0][0], &lines[2][1..5]), ("## t", &["", "linear", "grid", "bvh"][..]), "{text}");
        assert_eq!(lines[4][1..5], ["a", "–", "7", "–"], "{text}");
    }
}
