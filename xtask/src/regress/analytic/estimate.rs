//! Means over independent seeds, and their deviation from the truth.

use std::fmt::Display;

use rayon::prelude::*;
use rt_camera::{PixelSampler, SampleStream, SamplerKind};
use rt_math::random::hash;

use super::{Checks, Fallible};

/// Maximum deviation of a sound estimate, in standard errors.
pub(super) const MAX_Z: f64 = 5.0;

/// Closed forms and sums agree to this part of the truth, the spacing of `f32`: less than it is not noise.
const ROUNDING: f64 = 1.2e-7;

/// A mean over independent seeds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Estimate {
    pub mean: f64,
    pub standard_error: f64,
}

/// Estimate by a seed.
type SeedEstimator<'e> = dyn Fn(u64) -> Fallible<f64> + Sync + 'e;

impl Estimate {
    /// Mean of `of_seed` over seeds that no estimate of another name has.
    pub(super) fn of_seeds(name: &str, seeds: u64, of_seed: impl Fn(u64) -> Fallible<f64> + Sync) -> Fallible<Self> {
        Self::in_parallel(name, seeds, &of_seed)
    }

    /// [`of_seeds`](Self::of_seeds), compiled once for all estimates.
    fn in_parallel(name: &str, seeds: u64, of_seed: &SeedEstimator<'_>) -> Fallible<Self> {
        let key = name.bytes().fold(0, |key, byte| hash(&[key, byte.into()]));
        let of_index = |index| of_seed(hash(&[key, index]));
        let values = (0..seeds).into_par_iter().map(of_index).collect::<Fallible<Vec<f64>>>()?;
        let n = seeds as f64;
        let mean = values.iter().sum::<f64>() / n;
        let squares = values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>();
        Ok(Self { mean, standard_error: (squares / (n - 1.0) / n).sqrt() })
    }

    /// Deviation of the mean from the truth in standard errors; infinite for a deviation without noise.
    pub(super) fn z(&self, truth: f64) -> f64 {
        let off = self.mean - truth;
        if off.abs() <= ROUNDING * truth.abs() { 0.0 } else { off / self.standard_error }
    }
}

/// The mean of an integrand over the samples that a pattern has for one pixel.
pub(super) fn mean_of(pattern: SamplerKind, spp: u32, seed: u64, value: impl Fn(&mut SampleStream) -> f64) -> f64 {
    let sampler = PixelSampler::new(pattern, spp, seed);
    let spp = sampler.spp();
    (0..spp).map(|index| value(&mut sampler.sample([0, 0], index))).sum::<f64>() / f64::from(spp)
}

/// Compares an estimator with the truth for all unbiased patterns, and notes each z.
pub(super) fn hold(
    checks: &mut Checks,
    what: impl Display,
    truth: f64,
    seeds: u64,
    estimate: impl Fn(SamplerKind, u64) -> Fallible<f64> + Sync,
) -> Fallible<()> {
    let mut note = if truth == 0.0 || truth >= 1e-3 {
        format!("{what} = {truth:.10}: z")
    } else {
        format!("{what} = {truth:.10e}: z")
    };
    for pattern in SamplerKind::unbiased() {
        let name = format!("{what}, {}", pattern.name());
        let found = Estimate::of_seeds(&name, seeds, |seed| estimate(pattern, seed))?;
        let z = found.z(truth);
        note.push_str(&format!(" {} {z:+.2}", pattern.name()));
        let Estimate { mean, standard_error } = found;
        checks.limit(z, MAX_Z, format_args!("{name}: {mean:e} ± {standard_error:.1e} instead of {truth:e}"));
    }
    checks.note(note);
    Ok(())
}

#[cfg(test)]
mod tests {
    use rt_math::Sampler;

    use super::*;

    #[test]
    fn the_standard_error_is_that_of_the_mean() {
        let next = std::sync::atomic::AtomicU64::new(0);
        let value = |_| Ok([1.0, 3.0, 5.0, 7.0][next.fetch_add(1, std::sync::atomic::Ordering::Relaxed) as usize]);
        let estimate = Estimate::of_seeds("four", 4, value).unwrap();
        assert_eq!(estimate.mean, 4.0);
        assert!((estimate.standard_error - (20.0f64 / 3.0 / 4.0).sqrt()).abs() < 1e-15);
        assert!((estimate.z(5.0) + 1.0 / estimate.standard_error).abs() < 1e-12);
        let exact = Estimate { mean: 2.0, standard_error: 0.0 };
        assert_eq!((exact.z(2.0), exact.z(2.0 + 1e-12), exact.z(1.0)), (0.0, 0.0, f64::INFINITY));
    }

    #[test]
    fn estimates_of_different_names_are_independent() {
        let of = |name| Estimate::of_seeds(name, 8, |seed| Ok(seed as f64)).unwrap().mean;
        assert_eq!(of("a"), of("a"));
        assert_ne!(of("a"), of("b"));
    }

    #[test]
    fn a_wrong_truth_is_a_failure_and_the_right_one_is_none() {
        let half = |pattern, seed| Ok(mean_of(pattern, 16, seed, |sample| sample.next_2d()[0]));
        let mut checks = Checks::default();
        hold(&mut checks, "half", 0.5, 64, half).unwrap();
        assert_eq!((checks.tried, checks.failed), (6, 0), "{:?}", checks.problems);
        hold(&mut checks, "half", 0.6, 64, half).unwrap();
        assert_eq!((checks.tried, checks.failed), (12, 6));
    }
}
