//! Quantiles of the distributions behind confidence intervals.
//!
//! ```text
//!      Iₓ(a, b) = ∫₀ˣ tᵃ⁻¹ (1 − t)ᵇ⁻¹ dt / B(a, b)          P(F ≤ f) = Iₓ(m/2, n/2), x = m f / (m f + n)          t² ~ F(1, n)
//! ```
//!
//! They use functions with the same bits on every machine: adaptive sampling stops by them, and so do the bits of its image.

use crate::transcendental::{exp, lgamma, log};

/// Half width of a confidence interval of a mean in standard errors (Student 1908). `confidence` is in (0, 1); `freedom`, above
/// 0, is the number of degrees of freedom of the estimated standard error.
pub fn student_t(confidence: f64, freedom: f64) -> f64 {
    f_quantile(confidence, 1.0, freedom).sqrt()
}

/// Quantile of the ratio of two estimates of one variance with `m` and `n` degrees of freedom, above 0 (Snedecor 1934). The
/// probability is in (0, 1).
pub fn f_quantile(probability: f64, m: f64, n: f64) -> f64 {
    let (a, b) = (0.5 * m, 0.5 * n);
    // Solve for the smaller of x and 1 − x, which keeps all of its digits.
    if incomplete_beta(0.5, a, b) >= probability {
        let x = first_of_half(|x| incomplete_beta(x, a, b) >= probability);
        n * x / (m * (1.0 - x))
    } else {
        let y = first_of_half(|y| incomplete_beta(y, b, a) >= 1.0 - probability);
        n * (1.0 - y) / (m * y)
    }
}

/// Smallest number in (0, ½] that satisfies a condition. The condition holds from that number up to ½.
fn first_of_half(is_met: impl Fn(f64) -> bool) -> f64 {
    let (mut below, mut above) = (0.0, 0.5);
    loop {
        let middle = 0.5 * (below + above);
        if middle <= below || middle >= above {
            return above;
        }
        *(if is_met(middle) { &mut above } else { &mut below }) = middle;
    }
}

/// Regularised incomplete beta function Iₓ(a, b) for x in (0, 1) and positive a and b.
fn incomplete_beta(x: f64, a: f64, b: f64) -> f64 {
    // The fraction converges fast left of the mean; right of it, use the mirror image.
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - incomplete_beta(1.0 - x, b, a);
    }
    let log_front = a * log(x) + b * log(1.0 - x) + lgamma(a + b) - lgamma(a) - lgamma(b);
    exp(log_front) / (a * beta_fraction(x, a, b))
}

/// Continued fraction 1 + d₁/(1 + d₂/(1 + …)) of the incomplete beta function (DLMF 8.17.22), from its beginning
/// (Lentz 1976).
fn beta_fraction(x: f64, a: f64, b: f64) -> f64 {
    // Convergence takes about √max(a, b) steps; images have fewer degrees of freedom than 2²⁸ · 2¹⁶.
    const MAX_STEPS: u32 = 1 << 23;
    const TINY: f64 = 1e-300;
    let coefficient = |step: u32| {
        let k = f64::from(step / 2);
        if step.is_multiple_of(2) {
            k * (b - k) * x / ((a + 2.0 * k - 1.0) * (a + 2.0 * k))
        } else {
            -(a + k) * (a + b + k) * x / ((a + 2.0 * k) * (a + 2.0 * k + 1.0))
        }
    };
    let away_from_zero = |value: f64| if value.abs() < TINY { TINY } else { value };
    let (mut fraction, mut numerator, mut denominator) = (1.0, 1.0, 0.0);
    for step in 1..MAX_STEPS {
        let d = coefficient(step);
        denominator = 1.0 / away_from_zero(1.0 + d * denominator);
        numerator = away_from_zero(1.0 + d / numerator);
        let factor = numerator * denominator;
        fraction *= factor;
        if (factor - 1.0f64).abs() < 4.0 * f64::EPSILON {
            break;
        }
    }
    fraction
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transcendental::pow;

    fn assert_close(found: f64, expected: f64, digits: f64) {
        assert!((found / expected - 1.0).abs() < digits, "{found} is not {expected}");
    }

    #[test]
    fn students_factors_are_those_of_the_tables() {
        for (freedom, factor) in [
            (1.0, 12.706_204_736_174_7),
            (2.0, 4.302_652_729_749_46),
            (3.0, 3.182_446_305_283_71),
            (7.0, 2.364_624_251_592_78),
            (15.0, 2.131_449_545_559_78),
            (100.0, 1.983_971_518_523_55),
            (1e6, 1.959_966_356_8),
        ] {
            assert_close(student_t(0.95, freedom), factor, 1e-9);
        }
        assert_close(student_t(0.99, 3.0), 5.840_909_309_733_35, 1e-9);
    }

    #[test]
    fn ratios_of_variances_with_two_degrees_have_a_closed_form() {
        // P(F ≤ f) = 1 − (1 + 2 f / n)^(−n/2) for m = 2.
        for n in [1.0, 2.0, 3.5, 30.0] {
            for probability in [0.001, 0.025, 0.5, 0.975, 0.999] {
                let f = 0.5 * n * (pow(1.0 - probability, -2.0 / n) - 1.0);
                assert_close(f_quantile(probability, 2.0, n), f, 1e-9);
                assert_close(f_quantile(1.0 - probability, n, 2.0), 1.0 / f, 1e-9);
            }
        }
    }

    #[test]
    fn many_degrees_of_freedom_are_nearly_normal() {
        // The logarithm of F has the variance 2/m + 2/n to first order.
        for (m, n) in [(1e4, 3e4), (1e6, 3e6), (1e9, 1e9)] {
            let variance: f64 = 2.0 / m + 2.0 / n;
            assert_close(log(f_quantile(0.975, m, n)), 1.959_964 * variance.sqrt(), 0.03);
        }
    }
}
