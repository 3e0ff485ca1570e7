//! Zeros of functions of one variable that are known to change their sign.

/// Ordinary functions need ten steps.
const MAX_INTERPOLATIONS: u32 = 40;

/// A zero of `f` between `a` and `b`, where its signs differ, to the last digits: within `tolerance`, or two
/// neighbouring numbers. The bracket shrinks in every step, so that no function leads astray.
///
/// After [`MAX_INTERPOLATIONS`] steps it bisects: the work is bounded for any function.
///
/// Inverse quadratic interpolation where it is safe, bisection elsewhere (Chandrupatla, "A new hybrid
/// quadratic/bisection algorithm for finding the zero of a nonlinear function without using derivatives", 1997).
pub(crate) fn bracketed_root(f: impl Fn(f64) -> f64, [mut a, mut b]: [f64; 2], tolerance: f64) -> f64 {
    let (mut fa, mut fb) = (f(a), f(b));
    let mut fraction = 0.5;
    let mut steps = 0;
    loop {
        let t = a + fraction * (b - a);
        let ft = f(t);
        // `c` is the end that is given up, `a` the newest one.
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
