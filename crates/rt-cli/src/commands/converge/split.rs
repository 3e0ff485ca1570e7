//! The reference that a study makes by itself: two halves by another sampler, with seeds that no method has.

use rt_camera::SamplerKind;

use super::laboratory::Laboratory;
use super::methods::Method;
use super::yardstick::Yardstick;
use crate::error::Failure;

/// Samples of the reference by the most of a method: noise of an eighth, or a seventieth of the squared error.
const TIMES_SAMPLES: u32 = 64;

/// The part of the time limit that the reference may take.
const PART_OF_TIME: f64 = 0.5;

/// Seeds of a study start at that of the scene and never get so far.
const SEED_DISTANCE: u64 = 1 << 32;

/// Samplers that make references, the best first. None is biased.
const SAMPLERS: [SamplerKind; 6] = [
    SamplerKind::Sobol,
    SamplerKind::Halton,
    SamplerKind::MultiJittered,
    SamplerKind::Jittered,
    SamplerKind::BlueNoise,
    SamplerKind::Random,
];

/// Renders the reference: of `most` samples per pixel 64 times as many, or what half of the time limit allows.
pub(super) fn render(
    laboratory: &mut Laboratory<'_>,
    methods: &[Method],
    most: u32,
    planned: u64,
) -> Result<Yardstick, Failure> {
    let Some(first) = methods.first() else { return Err(Failure::Usage("there is no method".to_owned())) };
    let mut method = first.with_sampler(other_sampler(methods));
    let seed = first.scene.settings.seed.wrapping_add(SEED_DISTANCE);
    let wanted = most.saturating_mul(TIMES_SAMPLES / 2).min(1 << 31);
    let spp = match laboratory.clock.limit() {
        None => wanted,
        Some(limit) => {
            let per_sample = seconds_per_sample(laboratory, &mut method, seed.wrapping_add(2), wanted, limit)?;
            // The conversion saturates.
            let affordable = (limit * PART_OF_TIME / 2.0 / per_sample).min(f64::from(wanted)) as u32;
            // Rounding down makes up for samplers that round up.
            if affordable >= wanted { wanted } else { (affordable / 2 + 1).next_power_of_two() }
        }
    };
    laboratory.plan(planned + 2 * method.samples(spp));
    let a = laboratory.render(&mut method, spp, seed)?;
    let b = laboratory.render(&mut method, spp, seed.wrapping_add(1))?;
    let samples = 2 * u64::from(a.spp);
    let note = format!(
        "two halves of {} samples per pixel each by {} and {}, together {:.0} times the {most} of the largest measured",
        a.spp,
        method.name.integrator,
        method.name.sampler,
        samples as f64 / f64::from(most),
    );
    Yardstick::of_halves(&a.film, &b.film, note).map_err(|source| Failure::Pair {
        test: "one half of the reference".into(),
        reference: "the other".into(),
        source,
    })
}

/// Time that passes for one sample of each pixel, by renders of more and more samples until one takes a hundredth of the
/// limit: shorter ones tell little.
fn seconds_per_sample(
    laboratory: &mut Laboratory<'_>,
    method: &mut Method,
    seed: u64,
    most: u32,
    limit: f64,
) -> Result<f64, Failure> {
    let mut spp = 1;
    loop {
        let pilot = laboratory.render(method, spp, seed)?;
        if pilot.wall_seconds >= 0.01 * limit || spp >= most / 4 {
            return Ok(pilot.wall_seconds.max(1e-9) / f64::from(pilot.spp));
        }
        spp *= 4;
    }
}

/// The best sampler that no method uses, for correlated patterns would hide errors; the best of all if all are used.
fn other_sampler(methods: &[Method]) -> SamplerKind {
    let used = |pattern: &SamplerKind| methods.iter().any(|method| method.scene.settings.pattern == *pattern);
    SAMPLERS.into_iter().find(|pattern| !used(pattern)).unwrap_or(SAMPLERS[0])
}
