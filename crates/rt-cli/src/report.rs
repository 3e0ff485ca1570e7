//! Statistics of a render as text.

use bytesize::ByteSize;
use comfy_table::{CellAlignment, Table, presets};
use indicatif::HumanCount;
use rt_render::{
    Clamping, Criterion, ErrorEstimate, Explanation, RayKind, RayStats, Rendering, SampleRange, ShadingCounts,
    Statistics, StopRule, Stopped,
};

use crate::memory;
use crate::stats::Outcome;

/// All statistics. `costs` adds the cost per ray, which only a render with `--stats` counts.
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
    lines.extend(outcome.rendering.error.as_ref().map(|estimate| error(outcome, estimate)));
    lines.join("\n")
}

/// Samples per pixel.
pub(crate) fn samples(rendering: &Rendering) -> String {
    let SampleRange { min, mean, max } = rendering.samples_per_pixel;
    if min == max { format!("{max} spp") } else { format!("{min} to {max} spp, {mean:.1} on average") }
}

/// Render time and rays.
pub(crate) fn effort(outcome: &Outcome<'_>) -> String {
    let statistics = &outcome.rendering.statistics;
    let rays = HumanCount(statistics.counters.total().rays);
    format!("in {:.3} s: {rays} rays, {:.2} Mrays/s", statistics.render_seconds, statistics.mega_rays_per_second())
}

/// One line: effect of the stop rule, estimated error, and effect of clamping.
pub(crate) fn stop_reason_and_error(outcome: &Outcome<'_>) -> String {
    let reason = outcome.rule.map(|rule| stop_reason(outcome, &rule));
    let clamped = outcome.plan.clamping(outcome.rendering).map(|clamping| clamped(&clamping));
    reason.into_iter().chain([short_error(outcome)]).chain(clamped).collect::<Vec<_>>().join("; ")
}

fn clamped(clamping: &Clamping) -> String {
    let Clamping { bound, contributions, lost_share } = *clamping;
    let (contributions, percent) = (HumanCount(contributions), 100.0 * lost_share);
    let bound = if bound < 1e-4 { format!("{bound:e}") } else { bound.to_string() };
    format!("biased: clamping to {bound} reduced {contributions} contributions and took {percent:.2} % of the light")
}

/// Share of the pixels with the minimum of samples.
fn shared_out(outcome: &Outcome<'_>) -> Option<String> {
    let min = outcome.plan.min_samples_per_pixel()?;
    let Rendering { film, statistics, samples_per_pixel: SampleRange { mean, .. }, .. } = outcome.rendering;
    let share = 100.0 * statistics.simple_pixels as f64 / film.pixels().len() as f64;
    Some(format!("{share:.1} % of the pixels show no edge and took {min} samples: {mean:.1} on average"))
}

/// Condition that ended the render.
fn stop_reason(outcome: &Outcome<'_>, rule: &StopRule) -> String {
    let rendering = outcome.rendering;
    let option = match rendering.stopped {
        Stopped::Samples => "--spp",
        Stopped::Time => "--time",
        Stopped::Target => "--target-error",
        Stopped::Interrupted => "an interruption",
    };
    let Some(target) = rule.target else { return format!("stopped by {option}") };
    let percent = shown_percent(target.relative);
    if rendering.stopped == Stopped::Target {
        let of_pixels = match target.criterion {
            Criterion::Image => String::new(),
            Criterion::Pixels { share } => format!(" in {} % of the pixels", shown_percent(share)),
        };
        return format!("stopped by {option} {percent} %{of_pixels}");
    }
    let option = match rendering.stopped {
        Stopped::Samples => format!("the cap of {} samples per pixel (--spp)", rule.max_spp),
        _ => option.to_owned(),
    };
    match rendering.unconverged {
        Some(missing) => {
            let pixels = rendering.film.pixels().len();
            format!("stopped by {option}: {percent} % is not reached in {missing} of {pixels} pixels")
        }
        // A render with fewer passes than a test needs may be below the target.
        None if rendering.error.is_some_and(|error| error.relative_rmse() <= target.relative) => {
            format!("stopped by {option}")
        }
        None => format!("stopped by {option}: {percent} % is not reached"),
    }
}

/// Share in percent with nine significant digits, without the rounding error of binary fractions.
pub(crate) fn shown_percent(share: f64) -> f64 {
    let percent = 100.0 * share;
    format!("{percent:.8e}").parse().unwrap_or(percent)
}

/// Estimated error relative to the mean, or the reason for its absence.
fn short_error(outcome: &Outcome<'_>) -> String {
    match &outcome.rendering.error {
        Some(error) => relative_error(error) + &bias(outcome),
        None => no_error(outcome),
    }
}

/// Estimated error relative to the mean.
pub(crate) fn relative_error(error: &ErrorEstimate) -> String {
    let [low, high] = error.relative_interval().map(|share| 100.0 * share);
    let percent = 100.0 * error.relative_rmse();
    format!("relative RMSE {percent:.2} % (95 %: {low:.2} to {high:.2} %)")
}

/// Estimated error in all units.
fn error(outcome: &Outcome<'_>, estimate: &ErrorEstimate) -> String {
    let ErrorEstimate { rmse, interval: [low, high], relative, mean, .. } = estimate;
    format!(
        "estimated RMSE {rmse:.3e} (95 %: {low:.3e} to {high:.3e}), mean {mean:.3e}, square root of relMSE {:.2} %{}",
        100.0 * relative,
        bias(outcome)
    )
}

fn bias(outcome: &Outcome<'_>) -> String {
    let pattern = outcome.scene.settings.pattern;
    if pattern.is_biased() { format!("; the bias of {} samples adds to it", pattern.name()) } else { String::new() }
}

fn no_error(outcome: &Outcome<'_>) -> String {
    if !outcome.plan.passes_differ() {
        return format!(
            "no error estimate: {} samples are the same in every pass",
            outcome.scene.settings.pattern.name()
        );
    }
    let advice = if outcome.rendering.stopped == Stopped::Time { "allow more --time" } else { "try --passes 4" };
    format!("no error estimate: needs at least two passes ({advice})")
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
    let Statistics { primary_rays_skipped, shading, .. } = outcome.rendering.statistics;
    for (kind, skipped) in
        [("primary, skipped", primary_rays_skipped), ("shadow, skipped", shading.shadow_rays_skipped)]
    {
        if skipped > 0 {
            table.add_row([kind.to_owned(), HumanCount(skipped).to_string()]);
        }
    }
    let ShadingCounts { interior_overflows, lanes, lanes_used, .. } = shading;
    if lanes > 0 {
        table.add_row([
            "SIMD lanes of shading in use".to_owned(),
            format!("{:.1} %", 100.0 * lanes_used as f64 / lanes as f64),
        ]);
    }
    if interior_overflows > 0 {
        table.add_row(["surfaces ignored: medium stack full".to_owned(), HumanCount(interior_overflows).to_string()]);
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

fn ray_row(name: &str, tally: RayStats, costs: bool) -> Vec<String> {
    let mut row = vec![name.to_owned(), HumanCount(tally.rays).to_string()];
    if costs {
        let per_ray = |count: u64| format!("{:.2}", count as f64 / tally.rays.max(1) as f64);
        row.extend([per_ray(tally.nodes), per_ray(tally.tests), HumanCount(tally.hits).to_string()]);
    }
    row
}

fn left_out(explanation: &Explanation) -> Option<String> {
    let removed: Vec<_> = explanation.left_out.iter().map(|left| left.what).collect();
    (!removed.is_empty())
        .then(|| format!("left out of the plan: {} (`explain` prints the reasons)", removed.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_targets_are_not_shown_as_zero() {
        for (share, text) in [(0.01, "1"), (0.07, "7"), (0.001, "0.1"), (1e-6, "0.0001"), (1e-11, "0.000000001")] {
            assert_eq!(shown_percent(share).to_string(), text);
        }
    }
}
