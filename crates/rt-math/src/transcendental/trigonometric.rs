//! Sine and cosine.

use super::parts::{INTEGER_SHIFT, SIGN, choose, elementary, fast_two_sum, or_else, polynomial};
use crate::{Float64, Mask, float::two_sum};
use core::f64::consts::FRAC_2_PI;

/// Largest absolute value of an argument that is reduced here. Larger ones, infinities and NaN go through `libm`.
const LARGEST: f64 = 1e4;

/// Arguments up to this value, somewhat below π/4, are not reduced.
const SMALL: f64 = 0.78;

/// π/2 in three parts. The first two have 40 bits, so that their products with integers below 2¹³ are exact.
/// The sum differs from π/2 by less than 2⁻¹³⁴.
const FRAC_PI_2: [f64; 3] = [1.5707963267941523, 7.443547480480255e-13, 6.36831716351095e-25];

/// π/2 without the first part, rounded.
const FRAC_PI_2_REST: f64 = FRAC_PI_2[1] + FRAC_PI_2[2];

/// Least remainder, as a multiple of n, that needs two parts of π/2 only.
const FAR: f64 = 1.0 / (1u64 << 29) as f64;

/// (sin √z / √z − 1) / z for 0 ≤ z ≤ (π/4)²; minimax. The error of sin r is at most 2⁻⁵⁸ r.
const SINE: [f64; 6] = [
    -0.16666666666666632,
    0.00833333333332248,
    -0.00019841269829845514,
    2.755731370128382e-06,
    -2.50507591582867e-08,
    1.5896837162109933e-10,
];

/// (cos √z − 1 + z/2) / z² for 0 ≤ z ≤ (π/4)²; minimax. The error of cos r is at most 2⁻⁶⁴.
const COSINE: [f64; 6] = [
    0.0416666666666666,
    -0.001388888888887447,
    2.4801587289666814e-05,
    -2.75573143991541e-07,
    2.0875728962128654e-09,
    -1.1359914631961962e-11,
];

elementary! {
    /// Sine; NaN if the argument is not finite. Error: at most 0.85 ulp.
    sin(x) = sin_lanes by map;

    /// Cosine; NaN if the argument is not finite. Error: at most 0.85 ulp.
    cos(x) = cos_lanes by map;
}

#[inline(always)]
fn sin_lanes<R: Float64>(x: R) -> R {
    or_else!(is_inside(x), Reduced::new(x).sin(x), x.map(libm::sin))
}

#[inline(always)]
fn cos_lanes<R: Float64>(x: R) -> R {
    or_else!(is_inside(x), Reduced::new(x).cos(), x.map(libm::cos))
}

/// Sine and cosine, bit-identical to [`sin`] and [`cos`].
#[inline(always)]
pub fn sincos<R: Float64>(x: R) -> (R, R) {
    let reduced = Reduced::new(x);
    let (sin_r, cos_r) = (reduced.sin_r(), reduced.cos_r());
    let quadrant = reduced.quadrant(0.0);
    let is_odd = is_odd::<R>(quadrant);
    let sine = flip_sign(R::select(is_odd, cos_r, sin_r), quadrant ^ x.to_bits());
    let cosine = flip_sign(R::select(is_odd, sin_r, cos_r), reduced.quadrant(1.0));
    (or_else!(is_inside(x), sine, x.map(libm::sin)), or_else!(is_inside(x), cosine, x.map(libm::cos)))
}

/// True for arguments up to [`LARGEST`].
#[inline(always)]
fn is_inside<R: Float64>(x: R) -> R::Mask {
    x.abs().le(x.splat(LARGEST))
}

/// |x| = n π/2 + r + r_low with |r| ≤ π/4, for |x| up to [`LARGEST`].
struct Reduced<R> {
    /// n + [`INTEGER_SHIFT`].
    shifted: R,
    r: R,
    r_low: R,
}

impl<R: Float64> Reduced<R> {
    /// Subtracts the nearest multiple of π/2.
    #[inline(always)]
    fn new(x: R) -> Self {
        let size = x.abs();
        if size.le(x.splat(SMALL)).all() {
            return Self { shifted: x.splat(INTEGER_SHIFT), r: size, r_low: x.splat(0.0) };
        }
        let shifted = size * FRAC_2_PI + INTEGER_SHIFT;
        let n = shifted - INTEGER_SHIFT;
        let difference = size - n * FRAC_PI_2[0];
        let product = n * FRAC_PI_2_REST;
        let r = difference - product;
        let r_low = (difference - r) - product;

        // The rounding error of the product is below n 2⁻⁹⁴, which is negligible for r above n 2⁻²⁹.
        let is_far = difference.abs().ge(n * FAR);
        if is_far.all() {
            return Self { shifted, r, r_low };
        }
        // Near a multiple, r is at least 2⁻⁶⁰.
        let (difference, error) = two_sum(difference, -(n * FRAC_PI_2[1]));
        let rest = error - n * FRAC_PI_2[2];
        let near = difference + rest;
        let near_low = (difference - near) + rest;
        Self { shifted, r: R::select(is_far, r, near), r_low: R::select(is_far, r_low, near_low) }
    }

    /// Sine of x.
    #[inline(always)]
    fn sin(&self, x: R) -> R {
        let quadrant = self.quadrant(0.0);
        let value = choose(
            is_odd::<R>(quadrant),
            #[inline(always)]
            || self.cos_r(),
            #[inline(always)]
            || self.sin_r(),
        );
        flip_sign(value, quadrant ^ x.to_bits())
    }

    /// Cosine of x: the sine one quadrant further.
    #[inline(always)]
    fn cos(&self) -> R {
        let quadrant = self.quadrant(1.0);
        let value = choose(
            is_odd::<R>(quadrant),
            #[inline(always)]
            || self.cos_r(),
            #[inline(always)]
            || self.sin_r(),
        );
        flip_sign(value, quadrant)
    }

    /// n + `offset` modulo 4 in the two highest bits: the sign of the sine, and whether the quadrant is odd.
    #[inline(always)]
    fn quadrant(&self, offset: f64) -> R::Bits {
        (self.shifted + offset).to_bits() << 62
    }

    /// sin(r + r_low).
    #[inline(always)]
    fn sin_r(&self) -> R {
        let Self { r, r_low, .. } = *self;
        let z = r * r;
        r + (r * (z * polynomial(z, SINE)) + r_low * (r.splat(1.0) - z * 0.5))
    }

    /// cos(r + r_low).
    #[inline(always)]
    fn cos_r(&self) -> R {
        let Self { r, r_low, .. } = *self;
        let z = r * r;
        let (sum, error) = fast_two_sum(r.splat(1.0), z * -0.5);
        sum + (error + (z * (z * polynomial(z, COSINE)) - r * r_low))
    }
}

/// `x` with its sign changed where the highest bit is set.
#[inline(always)]
fn flip_sign<R: Float64>(x: R, bits: R::Bits) -> R {
    R::from_bits(x.to_bits() ^ (bits & SIGN))
}

/// True where the highest bit of the exponent is set: the number of these two bits is 2 or 0.
#[inline(always)]
fn is_odd<R: Float64>(quadrant: R::Bits) -> R::Mask {
    let number = R::from_bits(quadrant);
    number.abs().eq(number.splat(2.0))
}
