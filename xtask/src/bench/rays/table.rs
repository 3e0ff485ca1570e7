//! The figures as Markdown.

use std::fmt::Write;

use super::{BuildFigure, Figures, RayFigure, Wrong};
use crate::{bench::spread::Spread, number::three_digits};

/// Rays per second, then builds.
pub(super) fn markdown(figures: &Figures) -> String {
    let mut text = String::from(
        "Millions of rays per second: median (least..greatest); by the processor's clock on one thread, else by the \
         wall's.\n\n| scene | rays | structure | Mrays/s | hits | leaks / ghosts / wrong t | other bits |\n\
         |---|---|---|---|---|---|---|\n",
    );
    text.extend(figures.rays.iter().map(ray_row));
    text.push_str(
        "\nBuilding: milliseconds of all processors together and on the wall, bytes per triangle.\n\n\
         | scene | triangles | structure | processors | wall | bytes | nodes | depth |\n|---|---|---|---|---|---|---|---|\n",
    );
    text.extend(figures.builds.iter().map(build_row));
    text
}

fn ray_row(figure: &RayFigure) -> String {
    let Spread { median, min, max } = figure.mega_rays();
    let rates = format!("{} ({}..{})", three_digits(median), three_digits(min), three_digits(max));
    let batch = figure.batch.map(|rays| format!(" in batches of {rays}")).unwrap_or_default();
    let wrong = figure.wrong.map(|Wrong { leaks, ghosts, wrong_t }| format!("{leaks} / {ghosts} / {wrong_t}"));
    let differing = figure.differing.map(|count| count.to_string());
    let mut row = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(
        row,
        "| {} | {} | {}{batch} | {rates} | {} of {} | {} | {} |",
        figure.scene,
        figure.kind,
        figure.structure,
        figure.hits,
        figure.rays,
        wrong.unwrap_or_default(),
        differing.unwrap_or_default(),
    );
    row
}

fn build_row(figure: &BuildFigure) -> String {
    format!(
        "| {} | {} | {} | {} | {} | {:.1} | {} | {} |\n",
        figure.scene,
        figure.triangles,
        figure.structure,
        three_digits(figure.cpu_seconds.median * 1e3),
        three_digits(figure.wall_seconds.median * 1e3),
        figure.bytes_per_triangle,
        figure.shape.nodes,
        figure.shape.max_depth,
    )
}
