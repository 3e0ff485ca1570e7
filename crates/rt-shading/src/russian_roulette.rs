//! Russian roulette.

use rt_math::{Rgb, Sampler};

/// Paths go on with at most this chance once roulette is played, so that none goes on for ever. Where all surfaces reflect ρ
/// of the light, what paths carry has a finite variance only if ρ² is less than this chance.
const MOST_LIKELY: f64 = 0.999;

/// Russian roulette (Arvo, Kirk 1990): whether a path survives that carries this much, and how much it then carries. The chance
/// follows the weight as it is in air, where media squeeze radiance by the factor `eta_scale`.
pub(crate) fn russian_roulette(throughput: &mut Rgb, eta_scale: f64, sampler: &mut impl Sampler) -> bool {
    let chance = (throughput.max_component() * eta_scale).min(MOST_LIKELY);
    if sampler.next_1d() >= chance {
        return false;
    }
    *throughput = *throughput / chance;
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Draws the same number for ever.
    struct Constant(f64);

    impl Sampler for Constant {
        fn next_1d(&mut self) -> f64 {
            self.0
        }

        fn next_2d(&mut self) -> [f64; 2] {
            [self.0; 2]
        }
    }

    /// With a chance of 0.95 at most, what a path carried grew by 4 % at each wall of 0.99, and the variance was infinite.
    #[test]
    fn roulette_does_not_let_the_weight_grow_among_walls_that_are_almost_white() {
        let mut throughput = Rgb::WHITE;
        for bounces in 0..1000 {
            throughput *= Rgb::gray(0.99);
            assert!(russian_roulette(&mut throughput, 1.0, &mut Constant(0.5)));
            assert!(throughput.g <= 1.0 + 1e-9, "{} after {bounces} bounces", throughput.g);
        }
    }

    #[test]
    fn roulette_keeps_the_mean() {
        let (mut sum, count) = (0.0, 100_000);
        for index in 0..count {
            let mut throughput = Rgb::gray(0.3);
            let mut sampler = Constant((f64::from(index) + 0.5) / f64::from(count));
            sum += if russian_roulette(&mut throughput, 1.0, &mut sampler) { throughput.g } else { 0.0 };
        }
        assert!((sum / f64::from(count) - 0.3).abs() < 1e-4, "{}", sum / f64::from(count));
    }
}
