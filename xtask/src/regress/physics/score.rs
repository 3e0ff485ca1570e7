//! Scores of differences between two estimates, on the scale of a normal distribution.
//!
//! ```text
//!      t = (a − b) / √(σ_a² + σ_b² + floor²)        ν by Welch and Satterthwaite        z = normal equivalent of t with ν
//! ```
//!
//! Sources: Welch 1947 (degrees of freedom), Wallace 1959 (normal equivalent of Student's t), Wilson and Hilferty 1931
//! (normal equivalent of χ²).

use rt_math::transcendental::{cbrt, exp, lgamma, log};

/// Smallest variance of a difference, so that equal exact numbers score 0.
const LEAST_VARIANCE: f64 = 1e-18;
/// Fewest degrees of freedom that Welch's formula may give.
const LEAST_FREEDOM: f64 = 2.0;
/// Most degrees of freedom: Student's distribution is the normal one there.
const MOST_FREEDOM: f64 = 1e6;

/// A mean with the variance of that mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Estimate {
    pub mean: f64,
    /// Square of the standard error; 0 for an exact number.
    pub variance: f64,
    /// Degrees of freedom of the variance.
    pub freedom: f64,
}

/// Allowed difference in addition to the noise, as a standard deviation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tolerance {
    /// Fraction of the larger of the two means.
    pub relative: f64,
    /// Radiance.
    pub absolute: f64,
}

/// A difference divided by its standard error.
#[derive(Clone, Copy, Debug)]
pub(super) struct Score {
    /// Normal equivalent of the t statistic.
    pub z: f64,
    /// Standard error of the difference, tolerance included.
    pub standard_error: f64,
    pub freedom: f64,
}

impl Estimate {
    /// Mean over independent seeds. One seed alone counts as exact, as stored integrals do.
    pub(super) fn of_seeds(values: &[f64]) -> Self {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        if values.len() < 2 {
            return Self { mean, variance: 0.0, freedom: 1.0 };
        }
        let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
        Self { mean, variance: squares / (n * (n - 1.0)), freedom: n - 1.0 }
    }

    /// Mean of independent estimates, with the degrees of freedom of Satterthwaite 1946.
    pub(super) fn mean_of(estimates: &[Self]) -> Self {
        let n = estimates.len() as f64;
        let sum = |f: fn(&Self) -> f64| estimates.iter().map(f).sum::<f64>();
        let variance = sum(|estimate| estimate.variance);
        let spread = sum(|estimate| estimate.variance * estimate.variance / estimate.freedom);
        let freedom = if spread > 0.0 { variance * variance / spread } else { 1.0 };
        Self { mean: sum(|estimate| estimate.mean) / n, variance: variance / (n * n), freedom }
    }

    /// The estimate of `factor` times the quantity.
    pub(super) fn scaled(self, factor: f64) -> Self {
        Self { mean: self.mean * factor, variance: self.variance * factor * factor, ..self }
    }
}

impl Score {
    /// Score of the difference of two independent estimates.
    pub(super) fn of(a: Estimate, b: Estimate, tolerance: Tolerance) -> Self {
        let relative = tolerance.relative * a.mean.abs().max(b.mean.abs());
        let floor = relative * relative + LEAST_VARIANCE + tolerance.absolute * tolerance.absolute;
        let variance = a.variance + b.variance + floor;
        let spread =
            a.variance * a.variance / a.freedom + b.variance * b.variance / b.freedom + floor * floor / MOST_FREEDOM;
        let freedom = (variance * variance / spread.max(1e-300)).clamp(LEAST_FREEDOM, MOST_FREEDOM);
        let standard_error = variance.sqrt();
        Self { z: normal_equivalent((a.mean - b.mean) / standard_error, freedom), standard_error, freedom }
    }

    /// Least difference that scores `z`.
    pub(super) fn difference_at(&self, z: f64) -> f64 {
        let scaled = z / wallace(self.freedom);
        self.standard_error * (self.freedom * (exp(scaled * scaled / self.freedom) - 1.0)).sqrt()
    }
}

/// Score of a normal distribution that is as likely to be exceeded as `t` of Student's distribution (Wallace 1959).
pub(super) fn normal_equivalent(t: f64, freedom: f64) -> f64 {
    (wallace(freedom) * (freedom * log(1.0 + t * t / freedom)).sqrt()).copysign(t)
}

fn wallace(freedom: f64) -> f64 {
    (8.0 * freedom + 1.0) / (8.0 * freedom + 3.0)
}

/// Score of a normal distribution for the sum of the squares of `n` normal scores (Wilson and Hilferty 1931).
pub(super) fn score_of_squares(sum: f64, n: usize) -> f64 {
    let spread = 2.0 / (9.0 * n as f64);
    (cbrt(sum / n as f64) - (1.0 - spread)) / spread.sqrt()
}

/// Probability of `k` or more successes in `n` trials that succeed with probability `p`, in (0, 1).
pub(super) fn binomial_tail(n: usize, k: usize, p: f64) -> f64 {
    let total = lgamma(n as f64 + 1.0);
    let term = |i: usize| {
        let (hits, misses) = (i as f64, (n - i) as f64);
        exp(total - lgamma(hits + 1.0) - lgamma(misses + 1.0) + hits * log(p) + misses * log(1.0 - p))
    };
    (k..=n).map(term).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: Tolerance = Tolerance { relative: 0.0, absolute: 0.0 };

    fn assert_near(value: f64, expected: f64, relative: f64) {
        assert!((value - expected).abs() <= relative * expected.abs(), "{value} instead of {expected}");
    }

    #[test]
    fn mean_and_standard_error_are_those_of_numpy() {
        // x.mean(), x.var(ddof=1) / 5
        let estimate = Estimate::of_seeds(&[1.0, 2.5, 2.0, 4.0, 3.5]);
        assert_near(estimate.mean, 2.6, 1e-15);
        assert_near(estimate.variance, 0.285, 1e-14);
        assert_eq!(estimate.freedom, 4.0);
        assert_eq!(Estimate::of_seeds(&[3.0]).variance, 0.0);
    }

    #[test]
    fn t_statistic_and_freedom_are_those_of_welch() {
        // scipy.stats.ttest_ind(a, b, equal_var=False)
        let a = Estimate::of_seeds(&[1.0, 2.5, 2.0, 4.0, 3.5]);
        let b = Estimate::of_seeds(&[3.1, 3.0, 3.3, 3.2, 3.05, 3.15]);
        let score = Score::of(a, b, NONE);
        assert_near(score.freedom, 4.054616101297, 1e-9);
        assert_near((a.mean - b.mean) / score.standard_error, -0.995634226059, 1e-9);
        // The normal quantile of the exact p-value; Wallace's formula is an approximation.
        assert_near(score.z, -0.887011387, 0.01);
    }

    #[test]
    fn normal_equivalents_are_near_exact_ones() {
        // (t, freedom, scipy.stats.norm.isf(scipy.stats.t.sf(t, freedom)))
        for (t, freedom, exact) in [
            (1.0, 3.0, 0.857801250841),
            (4.0, 3.0, 2.19716791699),
            (12.0, 3.0, 3.22836138684),
            (3.0, 7.0, 2.3274349741),
            (10.0, 7.0, 4.24982035536),
            (2.0, 15.0, 1.85256308753),
            (8.0, 15.0, 4.92098597039),
            (6.0, 45.0, 5.11590631476),
        ] {
            assert_near(normal_equivalent(t, freedom), exact, 0.02);
            assert_eq!(normal_equivalent(-t, freedom), -normal_equivalent(t, freedom));
        }
        assert_near(normal_equivalent(2.5, 1e6), 2.5, 1e-5);
    }

    #[test]
    fn scores_of_squares_are_near_exact_ones() {
        // (sum, n, scipy.stats.norm.isf(scipy.stats.chi2.sf(sum, n)))
        for (sum, n, exact) in [
            (64.0, 64, 0.0589692367764),
            (100.0, 64, 2.78380298108),
            (140.0, 64, 5.14412176673),
            (40.0, 64, -2.40475052695),
            (260.0, 192, 3.16173771795),
            (20.0, 12, 1.49785115834),
        ] {
            assert!((score_of_squares(sum, n) - exact).abs() < 0.05, "{} for {exact}", score_of_squares(sum, n));
        }
    }

    #[test]
    fn binomial_tails_are_exact() {
        // scipy.stats.binom.sf(k - 1, n, p)
        for (n, k, p, exact) in [
            (64, 1, 0.004, 0.226255350044),
            (64, 5, 0.004, 6.41502875804e-06),
            (144, 8, 0.004, 1.52117467108e-07),
            (192, 3, 0.01, 0.301570437349),
            (8, 8, 0.5, 0.00390625),
        ] {
            assert_near(binomial_tail(n, k, p), exact, 1e-9);
        }
        assert_near(binomial_tail(64, 0, 0.004), 1.0, 1e-9);
    }

    #[test]
    fn tolerances_add_in_quadrature() {
        let exact = |mean| Estimate { mean, variance: 0.0, freedom: 1.0 };
        // 0.03 / √((0.01 · 2)² + 0.01²)
        let score = Score::of(exact(2.0), exact(1.97), Tolerance { relative: 0.01, absolute: 0.01 });
        assert_near(score.z, 0.03 / 0.000_5_f64.sqrt(), 1e-5);
        assert_eq!(Score::of(exact(2.0), exact(2.0), NONE).z, 0.0);
    }

    #[test]
    fn a_difference_is_found_back_from_its_score() {
        let a = Estimate { mean: 1.0, variance: 0.04, freedom: 7.0 };
        let b = Estimate { mean: 1.9, variance: 0.01, freedom: 15.0 };
        let score = Score::of(a, b, NONE);
        assert_near(score.difference_at(score.z.abs()), 0.9, 1e-9);
    }

    #[test]
    fn the_mean_of_independent_estimates_has_their_freedoms_together() {
        let one = Estimate { mean: 3.0, variance: 0.5, freedom: 15.0 };
        let other = Estimate { mean: 1.0, ..one };
        assert_eq!(Estimate::mean_of(&[one, other]), Estimate { mean: 2.0, variance: 0.25, freedom: 30.0 });
    }
}
