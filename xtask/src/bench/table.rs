//! The figures as Markdown.

use std::fmt::Write;

use rt_accel::StructureKind;

use super::{Figures, TraceFigure};
use crate::number::three_digits;

/// Two tables: rays per second, and builds.
pub(super) fn markdown(figures: &Figures) -> String {
    let mut text = String::from(
        "Millions of rays per second on one thread (least time), and as a ratio to `bvh`.\n\n\
         | scene | rays | linear | grid | bvh | linear : bvh | grid : bvh |\n|---|---|---|---|---|---|---|\n",
    );
    for bvh in figures.traces.iter().filter(|figure| figure.structure == StructureKind::Bvh.name()) {
        let of = |kind: StructureKind| {
            figures.traces.iter().find(|figure| same_rays(figure, bvh) && figure.structure == kind.name())
        };
        let [linear, grid, own] = [StructureKind::Linear, StructureKind::Grid, StructureKind::Bvh]
            .map(|kind| of(kind).map_or(f64::NAN, TraceFigure::mega_rays));
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} | {} |",
            bvh.scene,
            bvh.kind,
            three_digits(linear),
            three_digits(grid),
            three_digits(own),
            three_digits(linear / own),
            three_digits(grid / own),
        );
    }
    text.push_str(
        "\nBuilding: milliseconds (least, median) and bytes per primitive.\n\n\
         | scene | primitives | structure | least | median | bytes |\n|---|---|---|---|---|---|\n",
    );
    for build in &figures.builds {
        let _ = writeln!(
            text,
            "| {} | {} | {} | {:.3} | {:.3} | {:.0} |",
            build.scene,
            build.primitives,
            build.structure,
            build.seconds.least * 1e3,
            build.seconds.median * 1e3,
            build.bytes as f64 / build.primitives as f64
        );
    }
    text
}

fn same_rays(a: &TraceFigure, b: &TraceFigure) -> bool {
    (a.scene, a.kind) == (b.scene, b.kind)
}

#[cfg(test)]
mod tests {
    use super::{super::Seconds, *};

    fn figure(structure: &'static str, least: f64) -> TraceFigure {
        let seconds = Seconds { least, median: least };
        TraceFigure { scene: "s", structure, kind: "primary", rays: 1_000_000, hits: 1, seconds }
    }

    #[test]
    fn ratios_are_to_the_hierarchy() {
        let traces = vec![figure("linear", 10.0), figure("grid", 1.0), figure("bvh", 0.5)];
        let text = markdown(&Figures { traces, ..Figures::default() });
        assert!(text.contains("| s | primary | 0.100 | 1.00 | 2.00 | 0.0500 | 0.500 |"), "{text}");
    }
}
