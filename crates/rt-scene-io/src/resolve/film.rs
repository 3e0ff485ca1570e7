//! The image and the settings.

use rt_camera::{FilmSettings, Filter, SamplerKind};
use rt_image::{Development, Dither, Encoding, ToneCurve};
use rt_math::DVec2;
use rt_shading::emitter::LightSampling;

use super::report::Report;
use super::value::{not_negative, positive, within};
use crate::format;
use crate::{Accel, Adaptive, Integrator, Reason, Settings, limits};

/// The image. A field that is wrong keeps its default after it is reported.
pub(super) fn film(report: &mut Report, film: &format::Film) -> FilmSettings {
    let default = FilmSettings::default();
    let (width, height) = report.check("film.size", size(film.size)).unwrap_or((default.width, default.height));
    let [x, y] = film.sample_offset;
    report.check("film.sample_offset", within(x, 0.0, 1.0).and(within(y, 0.0, 1.0)));
    report.check("film.exposure", within(film.exposure, -100.0, 100.0));
    let filter = match film.filter {
        format::Filter::Box => Filter::Box,
        format::Filter::Tent => Filter::Tent,
        format::Filter::Gaussian(sigma) => {
            report.check("film.filter", positive(sigma).and(within(sigma, 0.0, limits::FILTER_SIGMA)));
            Filter::Gaussian { sigma }
        }
        format::Filter::Mitchell => Filter::Mitchell,
    };
    let tone = match film.tone {
        format::Tone::Clamp => ToneCurve::Clamp,
        format::Tone::Reinhard => ToneCurve::Reinhard,
        format::Tone::Aces => ToneCurve::Aces,
    };
    let encoding = match film.encoding {
        format::Encoding::Srgb => Encoding::Srgb,
        format::Encoding::Gamma(gamma) => {
            report.check("film.encoding", within(gamma, 0.1, 10.0));
            Encoding::Power(gamma)
        }
    };
    let development =
        Development { exposure: film.exposure, tone, encoding, dither: film.dither.then(Dither::default) };
    FilmSettings { width, height, sample_offset: DVec2::new(x, y), filter, development }
}

fn size((width, height): (u64, u64)) -> Result<(u32, u32), Reason> {
    let shown = || format!("{width} x {height}");
    if width == 0 || height == 0 {
        return Err(Reason::invalid(shown(), "pixels: both sides must be at least 1"));
    }
    if width.saturating_mul(height) > limits::FILM_PIXELS {
        return Err(Reason::invalid(shown(), "pixels are more than 2^28: choose a smaller image"));
    }
    // Both fit, because their product does.
    Ok((width as u32, height as u32))
}

/// The settings. A field that is wrong keeps its default after it is reported.
pub(super) fn settings(report: &mut Report, settings: &format::Settings, default: Integrator) -> Settings {
    let spp = report.check("settings.spp", within(settings.spp, 1, limits::SAMPLES)).unwrap_or(1);
    let passes = settings.passes.and_then(|passes| report.check("settings.passes", within(passes, 1, limits::PASSES)));
    let adaptive = settings.adaptive.map(|format::Adaptive::ObjectSpace { least }| {
        let least = least.and_then(|least| report.check("settings.adaptive.least", within(least, 1, limits::SAMPLES)));
        Adaptive::ObjectSpace { least: least.map(|least| least as u32) }
    });
    let depth = report.check("settings.depth", within(settings.depth, 0, limits::RAY_DEPTH)).unwrap_or(0);
    report.check("settings.min_contribution", not_negative(settings.min_contribution));
    let roulette_from =
        report.check("settings.roulette_from", within(settings.roulette_from, 0, limits::RAY_DEPTH)).unwrap_or(0);
    let clamp = settings.clamp.and_then(|clamp| report.check("settings.clamp", positive(clamp)));
    let occlusion_distance = settings
        .occlusion_distance
        .map_or(Some(f64::INFINITY), |distance| report.check("settings.occlusion_distance", positive(distance)));
    Settings {
        integrator: settings.integrator.map_or(default, integrator),
        pattern: pattern(settings.sampler),
        spp: spp as u32,
        passes: passes.map(|passes| passes as u32),
        adaptive,
        depth: depth as u32,
        min_contribution: settings.min_contribution,
        accel: accel(settings.accel),
        seed: settings.seed,
        light_sampling: light_sampling(settings.light_sampling),
        roulette_from: roulette_from as u32,
        clamp,
        occlusion_distance: occlusion_distance.unwrap_or(f64::INFINITY),
    }
}

pub(super) const fn integrator(integrator: format::Integrator) -> Integrator {
    match integrator {
        format::Integrator::Whitted => Integrator::Whitted,
        format::Integrator::Distributed => Integrator::Distributed,
        format::Integrator::Path => Integrator::Path,
        format::Integrator::Direct => Integrator::Direct,
        format::Integrator::Caustics => Integrator::Caustics,
        format::Integrator::AmbientOcclusion => Integrator::AmbientOcclusion,
        format::Integrator::Normals => Integrator::Normals,
        format::Integrator::Depth => Integrator::Depth,
        format::Integrator::Uv => Integrator::Uv,
        format::Integrator::Cost => Integrator::Cost,
    }
}

const fn light_sampling(sampling: format::LightSampling) -> LightSampling {
    match sampling {
        format::LightSampling::Uniform => LightSampling::Uniform,
        format::LightSampling::Power => LightSampling::Power,
        format::LightSampling::Tree => LightSampling::Tree,
    }
}

const fn pattern(sampler: format::Sampler) -> SamplerKind {
    match sampler {
        format::Sampler::Centre => SamplerKind::Centre,
        format::Sampler::Grid => SamplerKind::Grid,
        format::Sampler::Random => SamplerKind::Random,
        format::Sampler::Jittered => SamplerKind::Jittered,
        format::Sampler::HalfJittered => SamplerKind::HalfJittered,
        format::Sampler::MultiJittered => SamplerKind::MultiJittered,
        format::Sampler::Sobol => SamplerKind::Sobol,
        format::Sampler::Halton => SamplerKind::Halton,
        format::Sampler::BlueNoise => SamplerKind::BlueNoise,
    }
}

const fn accel(accel: format::Accel) -> Accel {
    match accel {
        format::Accel::Auto => Accel::Auto,
        format::Accel::Linear => Accel::Linear,
        format::Accel::Grid => Accel::Grid,
        format::Accel::Bvh => Accel::Bvh,
        format::Accel::Wide => Accel::Wide,
        format::Accel::Spheres => Accel::Spheres,
        format::Accel::Cylinders => Accel::Cylinders,
        format::Accel::Kd => Accel::Kd,
        format::Accel::Bsp => Accel::Bsp,
        format::Accel::Bih => Accel::Bih,
        format::Accel::BihLazy => Accel::BihLazy,
    }
}
