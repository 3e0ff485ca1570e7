//! What a render took, as text for people.

use bytesize::ByteSize;
use comfy_table::{CellAlignment, Table, presets};
use indicatif::HumanCount;
use rt_render::{
    ErrorEstimate, Explanation, RayKind, Rendering, SampleRange, ShadingCounts, Statistics, StopRule, Stopped, Tally,
};

use crate::memory;
use crate::stats::Outcome;

/// The statistics of a render, ending without a line break. With `costs`, also what each ray cost; only a render that
/// counted this knows it.
pub(crate) fn statistics(outcome: &Outcome<'_>, costs: bool) -> String {
    let statistics = &outcome.rendering.statistics;
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
        lines.push(format!("peak memory {}", ByteSize(bytes)));
    }
    lines.extend(left_out(&outcome.plan.explain()));
    lines.extend(shared_out(outcome));
    lines.extend(outcome.rule.map(|rule| ending(outcome.rendering, &rule)));
    lines.push(error(outcome));
    lines.join("\n")
}

/// How many pixels took few samples.
fn shared_out(outcome: &Outcome<'_>) -> Option<String> {
    let least = outcome.plan.least_samples_per_pixel()?;
    let Rendering { film, statistics, samples_per_pixel: SampleRange { mean, .. }, .. } = outcome.rendering;
    let share = 100.0 * statistics.simple_pixels as f64 / film.pixels().len() as f64;
    Some(format!("{share:.1} % of the pixels show no edge and took {least} samples: {mean:.1} on average"))
}

/// What ended the render.
fn ending(rendering: &Rendering, rule: &StopRule) -> String {
    let SampleRange { least, mean, most } = rendering.samples_per_pixel;
    let samples = if least == most {
        format!("{most} samples per pixel")
    } else {
        format!("{least} to {most} samples per pixel, {mean:.1} on average,")
    };
    let option = match rendering.stopped {
        Stopped::Samples => "--spp",
        Stopped::Time => "--time",
        Stopped::Target => "--target-error",
        Stopped::Interrupted => "an interruption",
    };
    let ending = format!("stopped by {option} after {samples} in {} passes", rendering.statistics.passes);
    match (rule.target, rendering.unconverged) {
        (Some(target), Some(missing)) if missing > 0 => {
            let (percent, pixels) = (100.0 * target.relative, rendering.film.pixels().len());
            format!("{ending}: {percent} % is not reached in {missing} of {pixels} pixels")
        }
        _ => ending,
    }
}

/// How far the picture is from the truth, or why nobody knows.
fn error(outcome: &Outcome<'_>) -> String {
    let pattern = outcome.scene.settings.pattern;
    match outcome.rendering.error {
        Some(ErrorEstimate { rmse, interval: [low, high], relative, .. }) => {
            let bias = if pattern.is_biased() {
                format!("; the bias of {} samples adds to it", pattern.name())
            } else {
                String::new()
            };
            let percent = 100.0 * relative;
            format!("estimated RMSE {rmse:.3e} (95 %: {low:.3e} to {high:.3e}), relative {percent:.2} %{bias}")
        }
        None if !outcome.plan.passes_differ() => {
            format!("error not estimated: {} samples are the same in every pass", pattern.name())
        }
        None => {
            "error not estimated: one pass has nothing to be compared with (--passes 4 splits the samples)".to_owned()
        }
    }
}

fn ray_table(outcome: &Outcome<'_>, costs: bool) -> Table {
    let counters = &outcome.rendering.statistics.counters;
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
    let Statistics { primary_rays_spared, shading, .. } = outcome.rendering.statistics;
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
