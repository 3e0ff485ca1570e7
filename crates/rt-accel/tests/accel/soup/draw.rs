//! Random numbers for tests.

use rt_accel::DVec3;
use rt_math::random::{hash, unit};

/// A reproducible stream of random numbers.
pub(crate) struct Draw {
    seed: u64,
    count: u64,
}

impl Draw {
    pub(crate) fn new(seed: u64) -> Self {
        Self { seed, count: 0 }
    }

    pub(crate) fn bits(&mut self) -> u64 {
        self.count += 1;
        hash(&[self.seed, self.count])
    }

    pub(crate) fn below(&mut self, limit: usize) -> usize {
        (self.bits() % limit as u64) as usize
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + unit(self.bits()) * (high - low)
    }

    pub(crate) fn one_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    pub(crate) fn pick<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len())]
    }

    /// Uniform in [-1, 1]³.
    pub(crate) fn point(&mut self) -> DVec3 {
        DVec3::new(self.between(-1.0, 1.0), self.between(-1.0, 1.0), self.between(-1.0, 1.0))
    }

    /// The seed of this run: the one given in the environment variable `RT_SEED`, or a fixed one.
    pub(crate) fn run_seed() -> u64 {
        std::env::var("RT_SEED").ok().and_then(|seed| seed.parse().ok()).unwrap_or(20_240_229)
    }
}
