//! Rendered reference: the mean of two renders by another sampler, with seeds of their own.

use rt_camera::SamplerKind;

use super::methods::Method;
use super::reference::Reference;
use super::runner::BenchRunner;
use crate::error::{CliError, usage};

/// Samples of the reference relative to the largest sample count: an eighth of the noise, a seventieth of the squared error.
const TIMES_SAMPLES: u32 = 64;

/// Share of the time limit for the reference.
const SHARE_OF_TIME: f64 = 0.5;

/// Distance of the seeds of the reference from those of the methods.
const SEED_DISTANCE: u64 = 1 << 32;

/// Unbiased samplers, the best first.
const SAMPLERS: [SamplerKind; 6] = [
    SamplerKind::Sobol,
    SamplerKind::Halton,
    SamplerKind::MultiJittered,
    SamplerKind::Jittered,
    SamplerKind::BlueNoise,
    SamplerKind::Random,
];

/// Renders the reference with 64 times the largest sample count, or as many as half of the time limit allows.
pub(super) fn render(
    runner: &mut BenchRunner<'_>,
    methods: &[Method],
    max_spp: u32,
    planned: u64,
) -> Result<Reference, CliError> {
    let Some(first) = methods.first() else { return usage("there is no method") };
    let mut method = first.with_sampler(other_sampler(methods));
    let seed = first.scene.settings.seed.wrapping_add(SEED_DISTANCE);
    let measured = methods.iter().map(|method| method.samples_per_pixel(max_spp)).max().unwrap_or(max_spp);
    let wanted = measured.saturating_mul(TIMES_SAMPLES / 2).min(1 << 31);
    let spp = match runner.clock.limit() {
        None => wanted,
        Some(limit) => {
            let per_sample = seconds_per_sample(runner, &mut method, seed.wrapping_add(2), wanted, limit)?;
            let affordable = (limit * SHARE_OF_TIME / 2.0 / per_sample).min(f64::from(wanted)) as u32;
            // Round down, because samplers round up.
            if affordable >= wanted { wanted } else { (affordable / 2 + 1).next_power_of_two() }
        }
    };
    runner.set_total_samples(planned + 2 * method.samples(spp));
    let a = runner.render(&mut method, spp, seed)?;
    let b = runner.render(&mut method, spp, seed.wrapping_add(1))?;
    let note = format!(
        "two halves of {} samples per pixel each by {} and {}, together {} times the largest measured count of {measured}",
        a.spp,
        method.name.integrator,
        method.name.sampler,
        times(2.0 * f64::from(a.spp) / f64::from(measured)),
    );
    Reference::of_halves(&a.film, &b.film, note).map_err(|source| CliError::Pair {
        test: "one half of the reference".into(),
        reference: "the other".into(),
        source,
    })
}

/// Two digits of a ratio.
fn times(ratio: f64) -> String {
    if ratio < 10.0 { format!("{ratio:.1}") } else { format!("{ratio:.0}") }
}

/// Wall-clock time of one sample per pixel, measured with growing sample counts until a render takes a hundredth of the limit.
fn seconds_per_sample(
    runner: &mut BenchRunner<'_>,
    method: &mut Method,
    seed: u64,
    max_spp: u32,
    limit: f64,
) -> Result<f64, CliError> {
    let mut spp = 1;
    loop {
        let pilot = runner.render(method, spp, seed)?;
        if pilot.wall_seconds >= 0.01 * limit || spp >= max_spp / 4 {
            return Ok(pilot.wall_seconds.max(1e-9) / f64::from(pilot.spp));
        }
        spp *= 4;
    }
}

/// Best sampler that no method uses, because correlated patterns hide errors; the best of all if all are used.
fn other_sampler(methods: &[Method]) -> SamplerKind {
    let used = |pattern: &SamplerKind| methods.iter().any(|method| method.scene.settings.pattern == *pattern);
    SAMPLERS.into_iter().find(|pattern| !used(pattern)).unwrap_or(SAMPLERS[0])
}
