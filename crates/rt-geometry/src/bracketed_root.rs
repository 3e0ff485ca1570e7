//! Root finding in one variable within a bracket.

/// Maximum number of interpolation steps; ordinary functions need ten.
const MAX_INTERPOLATIONS: u32 = 40;

/// Root of `f` between `a` and `b`, where its signs differ, to the last digits: within `tolerance`, or two neighbouring
/// numbers. The bracket shrinks in every step for any function.
///
/// Bisects after [`MAX_INTERPOLATIONS`] steps, which bounds the work for any function.
///
/// Inverse quadratic interpolation where it is safe, bisection elsewhere. Source: Chandrupatla, "A new hybrid
/// quadratic/bisection algorithm for finding the zero of a nonlinear function without using derivatives", 1997.
pub(crate) fn bracketed_root(f: impl Fn(f64) -> f64, [mut a, mut b]: [f64; 2], tolerance: f64) -> f64 {
    let (mut fa, mut fb) = (f(a), f(b));
    let mut fraction = 0.5;
    let mut steps = 0;
    loop {
        let t = a + fraction * (b - a);
        let ft = f(t);
        // `c` is the discarded end, `a` the newest one.
        let (c, fc);
        if (ft < 0.0) == (fa < 0.0) {
            (c, fc) = (a, fa);
        } else {
            (c, fc) = (b, fb);
            (b, fb) = (a, fa);
        }
        (a, fa) = (t, ft);
        let best = if fa.abs() < fb.abs() { a } else { b };
        let width = (b - a).abs();
        let step = tolerance.max(2.0 * f64::EPSILON * best.abs()) / width;
        // Written so that a NaN ends the search.
        if !(step < 0.5) || fa == 0.0 {
            return best;
        }
        let (xi, phi) = ((a - b) / (c - b), (fa - fb) / (fc - fb));
        steps += 1;
        let is_safe = steps < MAX_INTERPOLATIONS && phi * phi < xi && (1.0 - phi) * (1.0 - phi) < 1.0 - xi;
        let interpolated =
            || fa / (fb - fa) * (fc / (fb - fc)) + (c - a) / (b - a) * (fa / (fc - fa)) * (fb / (fc - fb));
        fraction = if is_safe { interpolated() } else { 0.5 }.clamp(step, 1.0 - step);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rt_math::transcendental::{atan, exp};
    use std::cell::Cell;

    /// Function, bracket, zero.
    type Case = (fn(f64) -> f64, [f64; 2], f64);

    #[test]
    fn zeros_are_found_to_the_last_digits_in_few_steps() {
        let cases: [Case; 5] = [
            (|x| x * x - 2.0, [0.0, 2.0], std::f64::consts::SQRT_2),
            (|x| x * x * x - 2.0 * x - 5.0, [3.0, 2.0], 2.094_551_481_542_326_6),
            (|x| exp(x) - 2.0, [-4.0, 1.0], std::f64::consts::LN_2),
            (|x| atan(x - 0.25) * 1e-30, [-1e6, 1e3], 0.25),
            (|x| if x < 0.1 { -1.0 } else { 1e-9 }, [-1.0, 1.0], 0.1),
        ];
        for (f, bracket, zero) in cases {
            let steps = Cell::new(0);
            let counted = |x| {
                steps.set(steps.get() + 1);
                f(x)
            };
            let found = bracketed_root(counted, bracket, 1e-300);
            assert!((found - zero).abs() <= 4.0 * f64::EPSILON * zero, "{found} instead of {zero}");
            assert!(steps.get() < 80, "{} steps to {zero}", steps.get());
        }
    }

    /// Root of such a high order that interpolation fails.
    #[test]
    fn the_work_is_bounded() {
        let steps = Cell::new(0);
        let flat = |x: f64| {
            steps.set(steps.get() + 1);
            let cube = (x - 0.3) * (x - 0.3) * (x - 0.3);
            cube * cube * cube
        };
        assert!((bracketed_root(flat, [-1.0, 1.0], 0.0) - 0.3).abs() < 1e-6);
        assert!(steps.get() < 1200, "{} steps", steps.get());
    }

    #[test]
    fn a_function_without_values_ends_the_search() {
        assert!((0.0..=1.0).contains(&bracketed_root(|_| f64::NAN, [0.0, 1.0], 1e-9)));
    }
}
