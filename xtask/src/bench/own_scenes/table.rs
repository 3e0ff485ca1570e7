//! The figures as Markdown.

use rt_accel::AcceleratorKind;

use super::{Figures, Options, TraceFigure};
use crate::{matrix::Matrix, number::three_digits};

/// The page `docs/BENCHMARKS.md` around the tables.
pub(super) fn page(tables: &str, options: &Options, provenance: &str) -> String {
    let Options { rays, reps, .. } = options;
    format!(
        "# How fast each structure is\n\n\
         Written by `cargo xtask bench --write --rays {rays} --reps {reps}` on {provenance}. Times vary with the machine and \
         its load: only the ratios, which stand in brackets, say anything about structures. Rays are traced on one \
         thread, by the clock of its processor, and structures take turns; trees are built on all threads, by the clock \
         on the wall. The least of all measurements is shown. All structures hit as often as brute force \
         on the rays that it was given.\n\n\
         * `mound`: the report's heap of overlapping spheres of similar size.\n\
         * `balls`: spheres on spheres, after Haines, \"A Proposal for Standard Graphics Environments\", 1987.\n\
         * `rock`: a closed mesh of small triangles.\n\n\
         Shadow rays ask whether anything is hit, the others for the first hit; diffuse and random rays are incoherent.\n\n\
         {tables}"
    )
}

/// Three tables: rays per second, build times, memory.
pub(super) fn markdown(figures: &Figures) -> String {
    let tables = [trace_table(figures), build_table(figures), memory_table(figures)];
    let tables = tables.map(|table| format!("## {}\n\n{}", table.title, table.markdown()));
    tables.join("\n")
}

fn trace_table(figures: &Figures) -> Matrix {
    let mut rows: Vec<(&str, &str)> = figures.traces.iter().map(|figure| (figure.scene, figure.kind)).collect();
    rows.dedup();
    let rows = rows.into_iter().map(|row| (format!("{} {}", row.0, row.1), row));
    Matrix::new("Millions of rays per second (ratio to `bvh`)", rows, |&(scene, kind), structure| {
        let of = |structure| {
            let key = (scene, kind, structure);
            let same = |figure: &&TraceFigure| (figure.scene, figure.kind, figure.structure) == key;
            figures.traces.iter().find(same).map(TraceFigure::mega_rays)
        };
        let own = of(structure)?;
        let ratio = own / of(AcceleratorKind::Bvh.name())?;
        Some(format!("{} ({})", three_digits(own), three_digits(ratio)))
    })
}

fn build_table(figures: &Figures) -> Matrix {
    builds(figures, "Build, milliseconds", |figure| three_digits(figure.seconds.min * 1e3))
}

fn memory_table(figures: &Figures) -> Matrix {
    builds(figures, "Memory, bytes per primitive", |figure| {
        three_digits(figure.bytes as f64 / figure.primitives as f64)
    })
}

fn builds(figures: &Figures, title: &str, cell: impl Fn(&super::BuildFigure) -> String) -> Matrix {
    let mut rows: Vec<(&str, usize)> = figures.builds.iter().map(|figure| (figure.scene, figure.primitives)).collect();
    rows.dedup();
    let rows = rows.into_iter().map(|row| (format!("{} {}", row.0, crate::number::grouped(row.1 as u64)), row.0));
    Matrix::new(title, rows, |&scene, structure| {
        figures.builds.iter().find(|figure| (figure.scene, figure.structure) == (scene, structure)).map(&cell)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::spread::Spread;

    fn figure(structure: &'static str, least: f64) -> TraceFigure {
        let seconds = Spread { median: 7.0, min: least, max: 9.0 };
        TraceFigure { scene: "s", structure, kind: "primary", rays: 1_000_000, hits: 1, seconds }
    }

    #[test]
    fn ratios_are_to_the_hierarchy() {
        let traces = vec![figure("linear", 10.0), figure("grid", 1.0), figure("bvh", 0.5)];
        let text = markdown(&Figures { traces, ..Figures::default() });
        assert!(text.contains("| s primary | 0.100 (0.0500) | 1.00 (0.500) | 2.00 (1.00) | –"), "{text}");
    }
}
