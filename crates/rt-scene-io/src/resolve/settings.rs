//! Settings of the render.

use super::value::{positive, within};
use crate::diagnostics::Diagnostics;
use crate::format;
use crate::{AdaptiveSampling, Integrator, LoadOptions, RenderSettings, limits};

/// The settings. A field that is wrong keeps its default after it is reported.
pub(super) fn settings(
    report: &mut Diagnostics,
    settings: &format::Settings,
    default: Integrator,
    options: &LoadOptions,
) -> RenderSettings {
    let spp = report.check("settings.spp", within(settings.spp, 1, limits::SAMPLES)).unwrap_or(1);
    let passes = settings.passes.and_then(|passes| report.check("settings.passes", within(passes, 1, limits::PASSES)));
    let integrator = settings.integrator.unwrap_or(default);
    let adaptive =
        settings.adaptive.map(|adaptive| adaptive_sampling(report, adaptive, settings.spp, integrator, options));
    let depth = report.check("settings.max_depth", within(settings.max_depth, 0, limits::RAY_DEPTH)).unwrap_or(0);
    report.check("settings.min_contribution", within(settings.min_contribution, 0.0, 1.0));
    let rr_start_depth =
        report.check("settings.rr_start_depth", within(settings.rr_start_depth, 0, limits::RAY_DEPTH)).unwrap_or(0);
    let clamp = settings.clamp.and_then(|clamp| report.check("settings.clamp", positive(clamp)));
    let occlusion_distance = settings
        .occlusion_distance
        .map_or(Some(f64::INFINITY), |distance| report.check("settings.occlusion_distance", positive(distance)));
    RenderSettings {
        integrator,
        pattern: settings.sampler.into(),
        spp: spp as u32,
        passes: passes.map(|passes| passes as u32),
        adaptive,
        depth: depth as u32,
        min_contribution: settings.min_contribution,
        accel: settings.accel,
        seed: settings.seed,
        light_sampling: settings.light_sampling.into(),
        rr_start_depth: rr_start_depth as u32,
        clamp,
        occlusion_distance: occlusion_distance.unwrap_or(f64::INFINITY),
    }
}

/// Adaptive sampling of a scene with this integrator and number of samples, unless the options override them.
fn adaptive_sampling(
    report: &mut Diagnostics,
    adaptive: format::Adaptive,
    spp: u64,
    integrator: Integrator,
    options: &LoadOptions,
) -> AdaptiveSampling {
    const FIELD: &str = "settings.adaptive";
    let format::Adaptive::ObjectSpace { min_spp } = adaptive;
    if options.overrides_adaptive {
        return AdaptiveSampling::ObjectSpace { min_spp: None };
    }
    if options.integrator.is_none() && integrator != Integrator::Whitted {
        let rule = format!(
            "supports the integrator `whitted` only, not `{}`: remove it, or change the integrator",
            integrator.name()
        );
        report.refuse::<()>(FIELD, "object_space", &rule);
    }
    let most = options.spp.map_or(spp, u64::from).clamp(1, limits::SAMPLES);
    let min_spp = min_spp.and_then(|min_spp| report.check(format_args!("{FIELD}.min_spp"), within(min_spp, 1, most)));
    AdaptiveSampling::ObjectSpace { min_spp: min_spp.map(|spp| spp as u32) }
}
