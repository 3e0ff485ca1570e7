//! Statistics of a render as JSON; `--stats` in `render --help` documents the fields.

use std::path::Path;

use rt_render::{
    Clamping, Criterion, ErrorEstimate, PlanOptions, RayKind, RayStats, RenderPlan, Rendering, StopRule, Stopped,
};
use rt_scene_io::Scene;
use serde_json::{Map, Value, json};

use crate::memory;

/// Inputs and result of a render.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outcome<'a> {
    pub(crate) scene_file: &'a Path,
    /// Scene with all options applied.
    pub(crate) scene: &'a Scene,
    pub(crate) options: &'a PlanOptions,
    pub(crate) plan: &'a RenderPlan<'a>,
    pub(crate) rendering: &'a Rendering,
    pub(crate) rule: Option<StopRule>,
    pub(crate) load_seconds: f64,
    pub(crate) output_seconds: f64,
}

/// Statistics of a render that counted nodes, tests and hits.
pub(crate) fn json(outcome: &Outcome<'_>) -> Value {
    let rendering = outcome.rendering;
    let statistics = &rendering.statistics;
    let samples = rendering.samples_per_pixel;
    let mut values = json!({
        "program": env!("CARGO_PKG_NAME"),
        "version": env!("CARGO_PKG_VERSION"),
        "scene": outcome.scene_file.display().to_string(),
        "settings": settings(outcome),
        "plan": plan(outcome),
        "pixel_samples": { "min": samples.min, "mean": samples.mean, "max": samples.max },
        "passes": statistics.passes,
        "stopped": stopped_by(rendering.stopped),
        "unconverged_pixels": rendering.unconverged,
        "estimated_error": rendering.error.as_ref().map(estimated_error),
        "clamping": outcome.plan.clamping(rendering).map(|Clamping { bound, contributions, lost_share }| {
            json!({ "bound": bound, "contributions": contributions, "lost_share": lost_share })
        }),
        "rays": rays(rendering),
        "shading": named(statistics.shading.named()),
        "seconds": {
            "load": outcome.load_seconds,
            "build": statistics.build_seconds,
            "render": statistics.render_seconds,
            "output": outcome.output_seconds,
        },
        "mega_rays_per_second": statistics.mega_rays_per_second(),
        "peak_memory_bytes": memory::peak_bytes(),
    });
    if let Value::Object(values) = &mut values {
        values.extend(named(statistics.named()));
    }
    values
}

/// Counts by their names.
fn named(counts: impl IntoIterator<Item = (&'static str, u64)>) -> Map<String, Value> {
    counts.into_iter().map(|(name, count)| (name.to_owned(), count.into())).collect()
}

const fn stopped_by(stopped: Stopped) -> &'static str {
    match stopped {
        Stopped::Samples => "samples",
        Stopped::Time => "time",
        Stopped::Target => "target-error",
        Stopped::Interrupted => "interrupted",
    }
}

fn estimated_error(estimate: &ErrorEstimate) -> Value {
    json!({
        "rmse": estimate.rmse,
        "rmse_interval": estimate.interval,
        "relative": estimate.relative,
        "largest": estimate.largest,
        "mean": estimate.mean,
        "relative_rmse": estimate.relative_rmse(),
        "relative_rmse_interval": estimate.relative_interval(),
    })
}

/// Settings that the image depends on besides the scene, and the number of threads, which does not change it.
fn settings(outcome: &Outcome<'_>) -> Value {
    let Outcome { scene, options, plan, rule, .. } = outcome;
    let (film, settings) = (&scene.film, &scene.settings);
    let target = rule.and_then(|rule| rule.target);
    json!({
        "width": film.width,
        "height": film.height,
        "crop": options.crop.map(|crop| [crop.x, crop.y, crop.width, crop.height]),
        "camera": scene.cameras.get(options.camera).map_or("", |camera| &camera.name),
        "integrator": settings.integrator.name(),
        "sampler": settings.pattern.name(),
        // The maximum with a stop rule.
        "samples_per_pixel": rule.map_or(plan.samples_per_pixel(), |rule| rule.max_spp),
        "least_samples_per_pixel": plan.min_samples_per_pixel(),
        "seconds": rule.and_then(|rule| rule.time).map(|time| time.as_secs_f64()),
        "target_error": target.map(|target| target.relative),
        "target_error_pixels": target.and_then(|target| match target.criterion {
            Criterion::Image => None,
            Criterion::Pixels { share } => Some(share),
        }),
        "two_stage": target.is_some_and(|target| target.two_stage),
        "clamp": settings.clamp,
        "depth": settings.depth,
        "min_contribution": settings.min_contribution,
        "accel": settings.accel.name(),
        "seed": settings.seed,
        "transparent": options.transparent,
        "full_plan": options.full,
        "threads": outcome.rendering.statistics.threads,
    })
}

fn plan(outcome: &Outcome<'_>) -> Value {
    let explanation = outcome.plan.explain();
    let used: Vec<_> = explanation.used.iter().map(|line| line.trim()).collect();
    let left_out: Map<_, _> =
        explanation.left_out.iter().map(|left| (left.what.to_owned(), left.reason.as_str().into())).collect();
    let memory: Map<_, _> =
        explanation.memory.parts().into_iter().map(|(part, bytes)| (part.to_owned(), bytes.into())).collect();
    json!({ "used": used, "left_out": left_out, "memory_bytes": memory })
}

/// Cost of the rays by kind, and in total.
fn rays(rendering: &Rendering) -> Map<String, Value> {
    let counters = &rendering.statistics.counters;
    let kinds = RayKind::ALL.map(|kind| (kind.name(), counters.of(kind)));
    let cost = |RayStats { rays, nodes, tests, hits }| json!({ "rays": rays, "nodes": nodes, "primitive_tests": tests, "hits": hits });
    kinds.into_iter().chain([("total", counters.total())]).map(|(name, stats)| (name.to_owned(), cost(stats))).collect()
}
