//! Inverse functions of sine, cosine and tangent.

use super::parts::{elementary, fast_two_sum, high_26, is_between, or_else, polynomial};
use crate::{Float64, Mask};
use core::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// π/2 − `FRAC_PI_2`.
const FRAC_PI_2_LOW: f64 = 6.123233995736766e-17;

/// π/4 − `FRAC_PI_4`. The high part has 50 bits, so that small multiples are exact.
const FRAC_PI_4_LOW: f64 = FRAC_PI_2_LOW / 2.0;

/// tan(π/8).
const TAN_PI_8: f64 = 0.41421356237309503;

/// Absolute values of arguments of [`atan2`] whose ratio is computed here; others, and NaN, go through `libm`.
const SIZES: [f64; 2] = [power_of_two(-400), power_of_two(400)];

/// (atan √z / √z − 1) / z for 0 ≤ z ≤ tan²(π/8); minimax. The error of atan t is at most 2⁻⁵⁹ t.
const ARCTANGENT: [f64; 11] = [
    -0.333333333333332,
    0.1999999999995382,
    -0.14285714280224815,
    0.11111110785079346,
    -0.09090897808928623,
    0.07692061188096065,
    -0.06663115641074042,
    0.0584797649447477,
    -0.050397070048997815,
    0.03807495915413633,
    -0.017918739963042062,
];

/// (asin √z / √z − 1) / z for 0 ≤ z ≤ 1/4; minimax. The error of asin s is at most 2⁻⁵⁹ s.
const ARCSINE: [f64; 13] = [
    0.16666666666666763,
    0.0749999999997013,
    0.044642857175252806,
    0.030381942676977913,
    0.0223722158555535,
    0.01735159644517857,
    0.01398100675727529,
    0.011397392827115126,
    0.010788744062118546,
    0.003674428217271234,
    0.02178504347647642,
    -0.02110859234920017,
    0.0326969616131875,
];

/// 2ⁿ for exponents of normal numbers.
const fn power_of_two(n: i64) -> f64 {
    f64::from_bits(((1023 + n) as u64) << 52)
}

elementary! {
    /// Arctangent, from −π/2 to π/2. Error: at most 0.8 ulp.
    atan(x) = atan_lanes by map;

    /// Angle of the vector (x, y) with the x axis, from −π to π; the second argument is x. Error: at most 0.8 ulp.
    ///
    /// The signs of zeros count, as IEEE 754 specifies: `atan2(0, -0)` is π.
    atan2(y, x) = atan2_lanes by map2;

    /// Arc cosine, from 0 to π; NaN outside of −1 to 1. Error: at most 0.8 ulp.
    acos(x) = acos_lanes by map;

    /// Arc sine, from −π/2 to π/2; NaN outside of −1 to 1. Error: at most 0.8 ulp.
    asin(x) = asin_lanes by map;
}

#[inline(always)]
fn atan_lanes<R: Float64>(x: R) -> R {
    let size = x.abs();
    if size.le(x.splat(TAN_PI_8)).all() {
        // These are the bits of `angle`, too, because dividing by 1 leaves no remainder.
        let z = x * x;
        return (x + x * (z * polynomial(z, ARCTANGENT))).copysign(x);
    }
    let size = R::select(size.eq(x.splat(0.0)), x.splat(1.0), size);
    let is_inside = is_between(size, SIZES[0], SIZES[1]);
    or_else!(is_inside, angle(x.splat(1.0), x), x.map(libm::atan))
}

#[inline(always)]
fn atan2_lanes<R: Float64>(y: R, x: R) -> R {
    let (smaller, greater) = sorted_sizes(x, y);
    let nonzero = R::select(smaller.eq(x.splat(0.0)), greater, smaller);
    let is_inside = R::select(nonzero.ge(x.splat(SIZES[0])), greater, x.splat(f64::INFINITY)).le(x.splat(SIZES[1]));
    or_else!(is_inside, angle(x, y), y.map2(x, libm::atan2))
}

/// The smaller and the greater absolute value; at least one is NaN if one of the arguments is.
#[inline(always)]
fn sorted_sizes<R: Float64>(x: R, y: R) -> (R, R) {
    let (size_x, size_y) = (x.abs(), y.abs());
    let is_steep = size_y.gt(size_x);
    (R::select(is_steep, size_x, size_y), R::select(is_steep, size_y, size_x))
}

/// [`atan2`] for coordinates that are 0 or within [`SIZES`], not both 0.
#[inline(always)]
fn angle<R: Float64>(x: R, y: R) -> R {
    let (zero, one) = (x.splat(0.0), x.splat(1.0));
    let (size_x, size_y) = (x.abs(), y.abs());

    // The angle is `eighths` π/4 + `sign` atan(smaller / greater), with a ratio of at most 1.
    let is_steep = size_y.gt(size_x);
    let (smaller, greater) = sorted_sizes(x, y);
    let eighths = R::select(is_steep, x.splat(2.0), R::select(x.lt(zero), x.splat(4.0), zero));
    let sign = one.copysign(size_x - size_y) * one.copysign(x);

    // Above tan(π/8), atan(n / d) = π/4 + atan((n − d) / (n + d)), with the rounding errors of n − d and n + d.
    let far = R::select(smaller.gt(greater * TAN_PI_8), one, zero);
    let (to_subtract, to_add) = (greater * far, smaller * far);
    let numerator = smaller - to_subtract;
    let numerator_low = smaller - (numerator + to_subtract);
    let (denominator, denominator_low) = fast_two_sum(greater, to_add);
    let eighths = eighths + sign * far;

    // Divide with a remainder: the ratio is t + t_low.
    let reciprocal = denominator.recip();
    let t_high = high_26(numerator * reciprocal);
    let denominator_high = high_26(denominator);
    let remainder = ((numerator - t_high * denominator_high) - t_high * (denominator - denominator_high))
        + (numerator_low - t_high * denominator_low);
    let t_rest = remainder * reciprocal;
    let (t, t_low) = fast_two_sum(t_high, t_rest);

    let z = t * t;
    let rest = t_low + t * (z * polynomial(z, ARCTANGENT));
    let (sum, error) = fast_two_sum(eighths * FRAC_PI_4, t * sign);
    (sum + (error + (eighths * FRAC_PI_4_LOW + rest * sign))).copysign(y)
}

#[inline(always)]
fn acos_lanes<R: Float64>(x: R) -> R {
    // π/2 − asin x, or 2 asin √((1 − x)/2), or π − 2 asin √((1 + x)/2).
    let Arcsine { big, high, low } = Arcsine::new(x.abs());
    let sign_of_x = x.splat(1.0).copysign(x);
    let quarters = -(big * sign_of_x) + 1.0;
    let sign = (big * 2.0 - 1.0) * sign_of_x;
    let (sum, error) = fast_two_sum(quarters * FRAC_PI_2, high * sign);
    sum + (error + (quarters * FRAC_PI_2_LOW + low * sign))
}

#[inline(always)]
fn asin_lanes<R: Float64>(x: R) -> R {
    // asin |x|, or π/2 − 2 asin √((1 − |x|)/2).
    let Arcsine { big, high, low } = Arcsine::new(x.abs());
    let sign = big * -2.0 + 1.0;
    let (sum, error) = fast_two_sum(big * FRAC_PI_2, high * sign);
    (sum + (error + (big * FRAC_PI_2_LOW + low * sign))).copysign(x)
}

/// Sum `high + low`: asin a for a ≤ 1/2, and acos a = 2 asin √((1 − a)/2) above.
struct Arcsine<R> {
    /// 1 for a > 1/2, else 0.
    big: R,
    high: R,
    low: R,
}

impl<R: Float64> Arcsine<R> {
    /// Sum for a number that is not negative; NaN above 1.
    #[inline(always)]
    fn new(a: R) -> Self {
        let (zero, one) = (a.splat(0.0), a.splat(1.0));
        // 1 − a is exact in the upper half. The root has a remainder; the added number prevents 0 / 0.
        let half_complement = (one - a) * 0.5;
        let root = half_complement.sqrt();
        let root_high = high_26(root);
        let root_low = (half_complement - root_high * root_high) / ((root + root_high) + f64::MIN_POSITIVE);

        let is_big = a.gt(a.splat(0.5));
        let z = R::select(is_big, half_complement, a * a);
        let s = R::select(is_big, root * 2.0, a);
        let high = R::select(is_big, root_high * 2.0, a);
        let s_low = R::select(is_big, root_low * 2.0, zero);
        Self { big: R::select(is_big, one, zero), high, low: s_low + s * (z * polynomial(z, ARCSINE)) }
    }
}
