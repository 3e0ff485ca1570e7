//! Statistics of a render as a JSON file; `--stats` in `render --help` documents it.

use std::path::Path;

use indexmap::IndexMap;
use rt_render::{
    Clamping, Criterion, ErrorEstimate, Explanation, PlanOptions, RayKind, RayStats, RenderPlan, Rendering,
    SampleRange, ShadingCounts, StopRule, Stopped,
};
use rt_scene_io::Scene;
use serde::Serialize;

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

#[derive(Debug, Serialize)]
pub(crate) struct StatsFile<'a> {
    program: &'static str,
    version: &'static str,
    scene: String,
    settings: SettingsStats<'a>,
    plan: PlanStats,
    samples: u64,
    /// Camera samples that hit a surface.
    camera_hits: u64,
    pixel_samples: PixelSamples,
    /// Pixels without edges, which took the minimum of samples.
    simple_pixels: u64,
    passes: u32,
    stopped: &'static str,
    /// Pixels that missed the target error; `null` without `--target-error-pixels`.
    unconverged_pixels: Option<u64>,
    /// `null` after a single pass.
    estimated_error: Option<ErrorStats>,
    /// `null` without `--clamp`.
    clamping: Option<ClampingStats>,
    /// NaN, infinite or negative; they count as black.
    bad_samples: u64,
    /// Camera rays skipped because their part of the view is empty.
    primary_rays_spared: u64,
    /// Rays by kind, and their total.
    rays: IndexMap<&'static str, RayTotals>,
    shading: ShadingStats,
    seconds: Seconds,
    mega_rays_per_second: f64,
    /// `null` if unknown.
    peak_memory_bytes: Option<u64>,
}

#[derive(Debug, Serialize)]
struct PixelSamples {
    least: u32,
    mean: f64,
    most: u32,
}

#[derive(Debug, Serialize)]
struct ErrorStats {
    rmse: f64,
    /// 95 % confidence interval.
    rmse_interval: [f64; 2],
    relative: f64,
    largest: f64,
    /// Mean radiance of the image.
    mean: f64,
    /// `rmse / mean`; `null` if it is infinite.
    relative_rmse: f64,
    /// 95 % confidence interval.
    relative_rmse_interval: [f64; 2],
}

#[derive(Debug, Serialize)]
struct ClampingStats {
    bound: f64,
    contributions: u64,
    lost_share: f64,
}

/// Settings of the image, and the number of threads, which does not change it.
#[derive(Debug, Serialize)]
struct SettingsStats<'a> {
    width: u32,
    height: u32,
    /// Left, top, width and height in pixels; `null` for the whole image.
    crop: Option<[u32; 4]>,
    camera: &'a str,
    integrator: &'static str,
    sampler: &'static str,
    /// Maximum with a stop rule.
    samples_per_pixel: u32,
    /// Samples of pixels without edges; `null` if all pixels take the same number.
    least_samples_per_pixel: Option<u32>,
    seconds: Option<f64>,
    target_error: Option<f64>,
    /// `null` for the error of the whole image.
    target_error_pixels: Option<f64>,
    two_stage: bool,
    clamp: Option<f64>,
    depth: u32,
    min_contribution: f64,
    accel: &'static str,
    seed: u64,
    transparent: bool,
    full_plan: bool,
    threads: usize,
}

#[derive(Debug, Serialize)]
struct PlanStats {
    used: Vec<String>,
    /// Removed features with the reason.
    left_out: IndexMap<&'static str, String>,
    /// Predicted memory.
    memory_bytes: IndexMap<&'static str, u64>,
}

#[derive(Debug, Serialize)]
struct RayTotals {
    rays: u64,
    nodes: u64,
    primitive_tests: u64,
    hits: u64,
}

#[derive(Debug, Serialize)]
struct ShadingStats {
    /// Shadow rays skipped because the light is behind the surface, or its contribution is zero.
    shadow_rays_spared: u64,
    highlights: u64,
    mirrors: u64,
    refractions: u64,
    fresnel: u64,
    absorption: u64,
    /// Index-matched interfaces that were crossed.
    passages: u64,
    /// Paths that ended at a mirror or at glass by the maximum depth.
    depth_limited: u64,
    /// Surfaces of media that were ignored because the medium stack was full.
    interior_overflows: u64,
}

/// Wall-clock times.
#[derive(Debug, Serialize)]
struct Seconds {
    load: f64,
    build: f64,
    render: f64,
    output: f64,
}

impl<'a> StatsFile<'a> {
    pub(crate) fn new(outcome: &Outcome<'a>) -> Self {
        let rendering = outcome.rendering;
        let statistics = &rendering.statistics;
        let SampleRange { least, mean, most } = rendering.samples_per_pixel;
        let counters = &statistics.counters;
        let by_kind = RayKind::ALL.map(|kind| (kind.name(), RayTotals::from(counters.of(kind))));
        Self {
            program: env!("CARGO_PKG_NAME"),
            version: env!("CARGO_PKG_VERSION"),
            scene: outcome.scene_file.display().to_string(),
            settings: SettingsStats::new(outcome),
            plan: PlanStats::from(outcome.plan.explain()),
            samples: statistics.samples,
            camera_hits: statistics.camera_hits,
            pixel_samples: PixelSamples { least, mean, most },
            simple_pixels: statistics.simple_pixels,
            passes: statistics.passes,
            stopped: stopped_by(rendering.stopped),
            unconverged_pixels: rendering.unconverged,
            estimated_error: rendering.error.map(ErrorStats::from),
            clamping: outcome.plan.clamping(rendering).map(ClampingStats::from),
            bad_samples: statistics.bad_samples,
            primary_rays_spared: statistics.primary_rays_spared,
            rays: by_kind.into_iter().chain([("total", counters.total().into())]).collect(),
            shading: statistics.shading.into(),
            seconds: Seconds {
                load: outcome.load_seconds,
                build: statistics.build_seconds,
                render: statistics.render_seconds,
                output: outcome.output_seconds,
            },
            mega_rays_per_second: statistics.mega_rays_per_second(),
            peak_memory_bytes: memory::peak_bytes(),
        }
    }
}

const fn stopped_by(stopped: Stopped) -> &'static str {
    match stopped {
        Stopped::Samples => "samples",
        Stopped::Time => "time",
        Stopped::Target => "target-error",
        Stopped::Interrupted => "interrupted",
    }
}

impl From<ErrorEstimate> for ErrorStats {
    fn from(estimate: ErrorEstimate) -> Self {
        let ErrorEstimate { rmse, interval, mean, relative, largest } = estimate;
        Self {
            rmse,
            rmse_interval: interval,
            relative,
            largest,
            mean,
            relative_rmse: estimate.relative_rmse(),
            relative_rmse_interval: estimate.relative_interval(),
        }
    }
}

impl From<Clamping> for ClampingStats {
    fn from(Clamping { bound, contributions, lost_share }: Clamping) -> Self {
        Self { bound, contributions, lost_share }
    }
}

impl<'a> SettingsStats<'a> {
    fn new(outcome: &Outcome<'a>) -> Self {
        let Outcome { scene, options, .. } = outcome;
        let (film, settings) = (&scene.film, &scene.settings);
        let target = outcome.rule.and_then(|rule| rule.target);
        Self {
            width: film.width,
            height: film.height,
            crop: options.crop.map(|crop| [crop.x, crop.y, crop.width, crop.height]),
            camera: scene.cameras.get(options.camera).map_or("", |camera| &camera.name),
            integrator: settings.integrator.name(),
            sampler: settings.pattern.name(),
            samples_per_pixel: outcome.rule.map_or(outcome.plan.samples_per_pixel(), |rule| rule.max_spp),
            least_samples_per_pixel: outcome.plan.least_samples_per_pixel(),
            seconds: outcome.rule.and_then(|rule| rule.time).map(|time| time.as_secs_f64()),
            target_error: target.map(|target| target.relative),
            target_error_pixels: target.and_then(|target| match target.criterion {
                Criterion::Image => None,
                Criterion::Pixels { share } => Some(share),
            }),
            two_stage: target.is_some_and(|target| target.two_stage),
            clamp: settings.clamp,
            depth: settings.depth,
            min_contribution: settings.min_contribution,
            accel: settings.accel.name(),
            seed: settings.seed,
            transparent: options.transparent,
            full_plan: options.full,
            threads: outcome.rendering.statistics.threads,
        }
    }
}

impl From<Explanation> for PlanStats {
    fn from(explanation: Explanation) -> Self {
        Self {
            used: explanation.used.into_iter().map(|line| line.trim().to_owned()).collect(),
            left_out: explanation.left_out.into_iter().map(|left| (left.what, left.why)).collect(),
            memory_bytes: explanation.memory.parts().into_iter().collect(),
        }
    }
}

impl From<RayStats> for RayTotals {
    fn from(RayStats { rays, nodes, tests, hits }: RayStats) -> Self {
        Self { rays, nodes, primitive_tests: tests, hits }
    }
}

impl From<ShadingCounts> for ShadingStats {
    fn from(counts: ShadingCounts) -> Self {
        let ShadingCounts {
            shadow_rays_spared,
            highlights,
            mirrors,
            refractions,
            fresnel,
            absorption,
            passages,
            depth_limited,
            interior_overflows,
            clamped: _,
            clamped_units: _,
        } = counts;
        Self {
            shadow_rays_spared,
            highlights,
            mirrors,
            refractions,
            fresnel,
            absorption,
            passages,
            depth_limited,
            interior_overflows,
        }
    }
}
