//! The image and the settings.

use rt_camera::{FilmSettings, Filter};
use rt_image::{Development, Dither, Encoding};
use rt_math::DVec2;

use super::value::{not_negative, positive, within};
use crate::diagnostics::Diagnostics;
use crate::format;
use crate::{AdaptiveSampling, Integrator, LoadErrorKind, RenderSettings, limits};

/// The image. A field that is wrong keeps its default after it is reported.
pub(super) fn film(report: &mut Diagnostics, film: &format::Film) -> FilmSettings {
    let default = FilmSettings::default();
    let (width, height) = report.check("film.size", size(film.size)).unwrap_or((default.width, default.height));
    let [x, y] = film.sample_offset;
    report.check("film.sample_offset", within(x, 0.0, 1.0).and(within(y, 0.0, 1.0)));
    report
        .check("film.exposure", within(film.exposure, *Development::EXPOSURES.start(), *Development::EXPOSURES.end()));
    let filter = match film.filter {
        format::Filter::Box => Filter::Box,
        format::Filter::Tent => Filter::Tent,
        format::Filter::Gaussian(sigma) => {
            report.check("film.filter", positive(sigma).and(within(sigma, 0.0, limits::FILTER_SIGMA)));
            Filter::Gaussian { sigma }
        }
        format::Filter::Mitchell => Filter::Mitchell,
    };
    let encoding = match film.encoding {
        format::Encoding::Srgb => Encoding::Srgb,
        format::Encoding::Gamma(gamma) => {
            report.check("film.encoding", within(gamma, *Development::GAMMAS.start(), *Development::GAMMAS.end()));
            Encoding::Power(gamma)
        }
    };
    let development = Development {
        exposure: film.exposure,
        tone: film.tone.into(),
        encoding,
        dither: film.dither.then(Dither::default),
    };
    FilmSettings { width, height, sample_offset: DVec2::new(x, y), filter, development }
}

fn size((width, height): (u64, u64)) -> Result<(u32, u32), LoadErrorKind> {
    let shown = || format!("{width} x {height}");
    if width == 0 || height == 0 {
        return Err(LoadErrorKind::invalid(shown(), "pixels: both sides must be at least 1"));
    }
    if width.saturating_mul(height) > limits::FILM_PIXELS {
        return Err(LoadErrorKind::invalid(shown(), "pixels are more than 2^28: choose a smaller image"));
    }
    // Both fit, because their product does.
    Ok((width as u32, height as u32))
}

/// The settings. A field that is wrong keeps its default after it is reported.
pub(super) fn settings(report: &mut Diagnostics, settings: &format::Settings, default: Integrator) -> RenderSettings {
    let spp = report.check("settings.spp", within(settings.spp, 1, limits::SAMPLES)).unwrap_or(1);
    let passes = settings.passes.and_then(|passes| report.check("settings.passes", within(passes, 1, limits::PASSES)));
    let adaptive = settings.adaptive.map(|format::Adaptive::ObjectSpace { min_spp }| {
        let min_spp =
            min_spp.and_then(|spp| report.check("settings.adaptive.min_spp", within(spp, 1, limits::SAMPLES)));
        AdaptiveSampling::ObjectSpace { min_spp: min_spp.map(|spp| spp as u32) }
    });
    let depth = report.check("settings.max_depth", within(settings.max_depth, 0, limits::RAY_DEPTH)).unwrap_or(0);
    report.check("settings.min_contribution", not_negative(settings.min_contribution));
    let rr_start_depth =
        report.check("settings.rr_start_depth", within(settings.rr_start_depth, 0, limits::RAY_DEPTH)).unwrap_or(0);
    let clamp = settings.clamp.and_then(|clamp| report.check("settings.clamp", positive(clamp)));
    let occlusion_distance = settings
        .occlusion_distance
        .map_or(Some(f64::INFINITY), |distance| report.check("settings.occlusion_distance", positive(distance)));
    RenderSettings {
        integrator: settings.integrator.unwrap_or(default),
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
