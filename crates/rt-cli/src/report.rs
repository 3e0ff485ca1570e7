//! What a render took, as text for people.

use comfy_table::{CellAlignment, Table, presets};
use indicatif::{HumanBytes, HumanCount};
use rt_render::{Explanation, RayKind, ShadingCounts, Statistics, Tally};

use crate::memory;
use crate::stats::Outcome;

/// The statistics of a render, ending without a line break. With `costs`, also what each ray cost; only a render that
/// counted this knows it.
pub(crate) fn statistics(outcome: &Outcome<'_>, costs: bool) -> String {
    let statistics = outcome.statistics;
    let threads = match statistics.threads {
        1 => "1 thread".to_owned(),
        n => format!("{n} threads"),
    };
    let mut lines = vec![
        ray_table(outcome, costs).to_string(),
        String::new(),
        format!(
            "load {:.3} s, build {:.3} s, render {:.3} s, output {:.3} s",
            outcome.load_seconds, statistics.build_seconds, statistics.render_seconds, outcome.output_seconds
        ),
        format!("{:.2} Mrays/s on {threads}", statistics.mega_rays_per_second()),
    ];
    if let Some(bytes) = memory::peak_bytes() {
        lines.push(format!("peak memory {}", HumanBytes(bytes)));
    }
    lines.extend(left_out(&outcome.plan.explain()));
    lines.join("\n")
}

fn ray_table(outcome: &Outcome<'_>, costs: bool) -> Table {
    let counters = &outcome.statistics.counters;
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    let mut header = vec!["rays", "traced"];
    if costs {
        header.extend(["nodes/ray", "tests/ray", "hits"]);
    }
    table.set_header(header);
    for kind in RayKind::ALL {
        let tally = counters.of(kind);
        if tally.rays > 0 {
            table.add_row(ray_row(kind.name(), tally, costs));
        }
    }
    table.add_row(ray_row("total", counters.total(), costs));
    let Statistics { primary_rays_spared, shading, .. } = *outcome.statistics;
    for (what, spared) in [("primary, spared", primary_rays_spared), ("shadow, spared", shading.shadow_rays_spared)] {
        if spared > 0 {
            table.add_row([what.to_owned(), HumanCount(spared).to_string()]);
        }
    }
    let ShadingCounts { interior_overflows, .. } = shading;
    if interior_overflows > 0 {
        table.add_row([
            "surfaces ignored inside of too many bodies".to_owned(),
            HumanCount(interior_overflows).to_string(),
        ]);
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

fn ray_row(name: &str, tally: Tally, costs: bool) -> Vec<String> {
    let mut row = vec![name.to_owned(), HumanCount(tally.rays).to_string()];
    if costs {
        let per_ray = |count: u64| format!("{:.2}", count as f64 / tally.rays.max(1) as f64);
        row.extend([per_ray(tally.nodes), per_ray(tally.tests), HumanCount(tally.hits).to_string()]);
    }
    row
}

fn left_out(explanation: &Explanation) -> Option<String> {
    let things: Vec<_> = explanation.left_out.iter().map(|left| left.what).collect();
    (!things.is_empty()).then(|| format!("left out: {} (`explain` says why)", things.join(", ")))
}
