//! Random numbers.

use rt_math::random::{hash, unit};
use rt_math::transcendental::sincos;
use rt_math::{DVec3, Frame};
use std::f64::consts::TAU;

/// A reproducible stream of random numbers.
#[derive(Clone, Debug)]
pub struct Draw {
    seed: u64,
    count: u64,
}

impl Draw {
    /// The stream of this seed.
    pub const fn new(seed: u64) -> Self {
        Self { seed, count: 0 }
    }

    /// The stream of item `index` of a set: streams of different items are independent.
    pub fn of(seed: u64, index: u64) -> Self {
        Self::new(hash(&[seed, index]))
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.count += 1;
        hash(&[self.seed, self.count])
    }

    /// A whole number below `limit`; 0 if that is 0.
    pub fn below(&mut self, limit: usize) -> usize {
        (self.bits() % (limit as u64).max(1)) as usize
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        unit(self.bits())
    }

    /// Uniform in [low, high).
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + self.unit() * (high - low)
    }

    /// True once in `n` times.
    pub fn one_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    /// One of the choices, of which there must be one.
    pub fn pick<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len())]
    }

    /// Uniform in [−1, 1)³.
    pub fn point(&mut self) -> DVec3 {
        DVec3::new(self.between(-1.0, 1.0), self.between(-1.0, 1.0), self.between(-1.0, 1.0))
    }

    /// A unit vector, uniform over the sphere (Archimedes' hat-box theorem).
    pub fn direction(&mut self) -> DVec3 {
        self.above(DVec3::Z, -1.0)
    }

    /// A unit vector whose cosine to the unit `normal` is uniform from `min_cosine` to 1.
    pub fn above(&mut self, normal: DVec3, min_cosine: f64) -> DVec3 {
        let cosine = self.between(min_cosine, 1.0);
        let (sin, cos) = sincos(TAU * self.unit());
        let ring = ((1.0 - cosine) * (1.0 + cosine)).max(0.0).sqrt();
        Frame::from_z(normal).from_local(DVec3::new(ring * cos, ring * sin, cosine))
    }

    /// `x` or a number next to it.
    pub fn neighbour(&mut self, x: f64) -> f64 {
        match self.below(4) {
            0 => x.next_up(),
            1 => x.next_down(),
            2 => x.next_up().next_up(),
            _ => x,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_unit_and_on_their_side() {
        let mut draw = Draw::new(1);
        let mut sum = DVec3::ZERO;
        for _ in 0..10_000 {
            let direction = draw.direction();
            assert!((direction.length() - 1.0).abs() < 1e-14);
            sum += direction;
            let above = draw.above(DVec3::NEG_Y, 0.25);
            assert!(-above.y > 0.25 - 1e-14);
        }
        assert!(sum.length() < 300.0, "no direction is preferred: {sum}");
    }
}
