//! Forecast of the number of samples at which a render reaches its error.
//!
//! ```text
//!      e(n) ~ n⁻ˢ        N = n (e / E)^(1 / s)        ½ ≤ s ≤ 1, measured; ½ for random samples
//! ```
//!
//! Error estimates are noisy, and so is N. Successive forecasts are averaged on a logarithmic scale. The reported share never
//! falls: if N grows, it stays constant until the forecast has caught up.

use rt_math::transcendental::{log, pow};

/// Progress of a render that ends at a target error.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Forecast {
    /// Total number of samples, averaged over forecasts.
    needed: Option<f64>,
    /// Last reported share.
    share: f64,
    /// First estimate: samples and error.
    first: Option<(f64, f64)>,
}

impl Forecast {
    /// Adds an error estimate after `samples` samples of the first of `stages` equal stages. A render has at most `most`
    /// samples.
    pub(crate) fn observe(&mut self, [samples, stages]: [f64; 2], error: f64, target: f64, most: f64) {
        let (first_samples, first_error) = *self.first.get_or_insert((samples, error));
        let slope = if samples >= 2.0 * first_samples && error > 0.0 && first_error > error {
            (log(first_error / error) / log(samples / first_samples)).clamp(0.5, 1.0)
        } else {
            0.5
        };
        let growth = if error > target { pow(error / target, 1.0 / slope) } else { 1.0 };
        self.add((samples * stages * growth).min(most));
    }

    /// Adds a forecast of the total number of samples.
    pub(crate) fn add(&mut self, needed: f64) {
        self.needed = Some(self.needed.map_or(needed, |before| (before * needed).sqrt()));
    }

    /// Replaces all forecasts by the known total number of samples.
    pub(crate) fn set_total(&mut self, needed: f64) {
        self.needed = Some(needed);
    }

    /// Forecast of the total number of samples, after `samples` of them; `None` before the first estimate.
    pub(crate) fn total(&mut self, samples: u64) -> Option<u64> {
        let needed = self.needed?;
        let done = samples as f64;
        self.share = self.share.max((done / needed.max(1.0)).min(1.0));
        let total = if self.share > 0.0 { done / self.share } else { needed };
        Some((total as u64).max(samples))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rt_math::random::{hash, unit};

    /// Errors that fall as n^−½ with 20 % noise. A firefly triples one of them.
    fn series() -> impl Iterator<Item = (u64, f64)> {
        (1..=64u64).map(|pass| {
            let scatter = 0.8 + 0.4 * unit(hash(&[17, pass]));
            let firefly = if pass == 20 { 3.0 } else { 1.0 };
            (1000 * pass, firefly * scatter * 0.4 / (pass as f64).sqrt())
        })
    }

    #[test]
    fn the_time_that_is_left_never_jumps_back() {
        let mut forecast = Forecast::default();
        let mut before: Option<(u64, u64)> = None;
        for (samples, error) in series() {
            forecast.observe([samples as f64, 1.0], error, 0.05, 1e9);
            let total = forecast.total(samples).expect("an estimate");
            if let Some((earlier, earlier_total)) = before {
                let share = |samples: u64, total: u64| samples as f64 / total as f64;
                assert!(share(samples, total) >= share(earlier, earlier_total) - 1e-4, "share falls at {samples}");
                // At a steady rate, the remaining number of samples grows at most as the elapsed time.
                let (left, left_before) = ((total - samples) as f64, (earlier_total - earlier) as f64);
                let growth = samples as f64 / earlier as f64;
                assert!(left <= left_before * growth + 1.0, "{left_before} becomes {left} at {samples}");
            }
            before = Some((samples, total));
        }
    }

    #[test]
    fn the_total_is_forecast_within_two_percent() {
        // Without scatter, 0.05 is reached at pass 64.
        let mut forecast = Forecast::default();
        for pass in 1..=64u64 {
            let samples = 1000 * pass;
            forecast.observe([samples as f64, 1.0], 0.4 / (pass as f64).sqrt(), 0.05, 1e9);
            let total = forecast.total(samples).expect("an estimate");
            assert!((63_000..=65_000).contains(&total), "{total} after {samples}");
        }
        assert_eq!(forecast.total(70_000), Some(70_000));
    }

    #[test]
    fn faster_convergence_is_measured() {
        let mut forecast = Forecast::default();
        for pass in 1..=8u64 {
            forecast.observe([1000.0 * pass as f64, 1.0], 0.4 / pass as f64, 0.01, 1e9);
        }
        let total = forecast.total(8000).expect("an estimate");
        // 40,000 is right; a slope of ½ would give 200,000, and the first forecasts were larger.
        assert!((30_000..120_000).contains(&total), "{total}");
    }

    #[test]
    fn the_cap_bounds_the_forecast() {
        let mut forecast = Forecast::default();
        assert_eq!(forecast.total(10), None);
        forecast.observe([100.0, 1.0], f64::INFINITY, 0.01, 5000.0);
        assert_eq!(forecast.total(100), Some(5000));
        forecast.set_total(300.0);
        assert_eq!(forecast.total(150), Some(300));
    }
}
