//! The Mitchell–Netravali filter in one dimension (1988, equation 8 with B = C = 1/3), and its sampling by inversion.
//!
//! With s = 2 − |x|, the outer piece factors into s²·(7s − 6)/18. So the filter changes its sign at |x| = 8/7, and all
//! of its integrals are fractions.

/// The filter is 0 from here on, in pixels.
pub(crate) const RADIUS: f64 = 2.0;
/// Zero of the filter.
const ZERO: f64 = 8.0 / 7.0;
/// Integral over [0, 1].
const CORE_MASS: f64 = 37.0 / 72.0;
/// Integral over [0, 8/7].
const POSITIVE_MASS: f64 = 355.0 / 686.0;
/// Integral of the absolute value over [0, 2]; the integral of the filter itself is 1/2.
const HALF_MASS: f64 = 367.0 / 686.0;

/// The filter at distance `x` from the centre; its integral over the line is 1.
pub(crate) fn value(x: f64) -> f64 {
    let x = x.abs();
    if x < 1.0 {
        (x * x * (7.0 * x - 12.0) + 16.0 / 3.0) / 6.0
    } else if x < RADIUS {
        let s = RADIUS - x;
        s * s * (7.0 * s - 6.0) / 18.0
    } else {
        0.0
    }
}

/// The integral of |f| over [0, x], for x in [0, 2].
fn mass(x: f64) -> f64 {
    // The antiderivative of the outer piece in s: K(s) = s³·(7s − 8)/72, with K(1) = −1/72 and K(6/7) = −6/343.
    let outer = |x: f64| {
        let s = RADIUS - x;
        s * s * s * (7.0 * s - 8.0) / 72.0
    };
    if x < 1.0 {
        x * (x * x * (1.75 * x - 4.0) + 16.0 / 3.0) / 6.0
    } else if x < ZERO {
        CORE_MASS - 1.0 / 72.0 - outer(x)
    } else {
        HALF_MASS + outer(x)
    }
}

/// Offset with density |f| / ∫|f| and its weight ±∫|f|, for `u` in [0, 1).
pub(crate) fn sample(u: f64) -> [f64; 2] {
    let side = if u < 0.5 { -1.0 } else { 1.0 };
    let target = (2.0 * u - 1.0).abs() * HALF_MASS;
    let (low, high, sign) = if target < POSITIVE_MASS { (0.0, ZERO, 1.0) } else { (ZERO, RADIUS, -1.0) };
    [side * invert_mass(target, low, high), sign * 2.0 * HALF_MASS]
}

/// Solution x of `mass(x) = target` between `low` and `high`. Takes about five steps of Newton's method, with a
/// bisection whenever it would leave the bracket, as next to zeros of the density.
fn invert_mass(target: f64, mut low: f64, mut high: f64) -> f64 {
    let mut x = 0.5 * (low + high);
    for _ in 0..53 {
        let excess = mass(x) - target;
        if excess < 0.0 {
            low = x;
        } else {
            high = x;
        }
        let newton = x - excess / value(x).abs();
        if !(newton >= low && newton <= high) {
            x = 0.5 * (low + high);
        } else if (newton - x).abs() <= 1e-9 {
            // Each step doubles the digits, so that this one has them all.
            return newton;
        } else {
            x = newton;
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn pieces_of_the_filter_and_of_its_integral_meet() {
        for (x, expected) in [(0.0, 8.0 / 9.0), (1.0, 1.0 / 18.0), (ZERO, 0.0), (RADIUS, 0.0)] {
            for side in [-1e-9, 1e-9] {
                assert!((value(x + side) - expected).abs() < 1e-8, "at {x}: {}", value(x + side));
            }
        }
        assert!(value(1.5) < 0.0);
        for (x, expected) in [(0.0, 0.0), (1.0, CORE_MASS), (ZERO, POSITIVE_MASS), (RADIUS, HALF_MASS)] {
            assert!((mass(x) - expected).abs() < 1e-15, "at {x}: {}", mass(x));
        }
    }

    #[test]
    fn mass_is_the_integral_of_the_absolute_value() {
        let steps = 20_000;
        let step = RADIUS / f64::from(steps);
        let mut sum = 0.0;
        for index in 0..steps {
            sum += value((f64::from(index) + 0.5) * step).abs() * step;
            let reached = f64::from(index + 1) * step;
            assert!((sum - mass(reached)).abs() < 1e-8, "at {reached}");
        }
    }

    #[test]
    fn weights_average_to_one() {
        let positive = POSITIVE_MASS / HALF_MASS;
        let [_, weight] = sample(0.5);
        assert!(((positive - (1.0 - positive)) * weight - 1.0).abs() < 1e-15);
    }

    proptest! {
        #[test]
        fn sampling_inverts_the_mass(u in 0.0..1.0f64) {
            let [x, weight] = sample(u);
            prop_assert!((mass(x.abs()) - (2.0 * u - 1.0).abs() * HALF_MASS).abs() < 1e-14);
            prop_assert_eq!(x < 0.0, u < 0.5);
            prop_assert_eq!(weight > 0.0, x.abs() < ZERO);
        }
    }
}
