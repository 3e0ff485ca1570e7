//! Common parts: rounding to integers, splitting of numbers, and polynomials.

use crate::{Float64, Mask};

/// 1.5 · 2⁵². Numbers near it are integers, whose low bits are those of the difference.
pub(super) const INTEGER_SHIFT: f64 = 6_755_399_441_055_744.0;

/// Sign bit.
pub(super) const SIGN: u64 = 1 << 63;

/// Nearest integer, the even one of two; for absolute values up to 2⁵¹.
#[inline(always)]
pub(super) fn round<R: Float64>(x: R) -> R {
    (x + INTEGER_SHIFT) - INTEGER_SHIFT
}

/// `x` rounded to 26 significant bits.
#[inline(always)]
pub(super) fn high_26<R: Float64>(x: R) -> R {
    without_low_bits(x, 27)
}

/// `x` rounded to 16 significant bits.
#[inline(always)]
pub(super) fn high_16<R: Float64>(x: R) -> R {
    without_low_bits(x, 37)
}

/// `x` without its last bits, of which there are `count` (Veltkamp's splitting, Dekker 1971).
#[inline(always)]
fn without_low_bits<R: Float64>(x: R, count: u32) -> R {
    let c = x * ((1u64 << count) + 1) as f64;
    c - (c - x)
}

/// `a + b` as the rounded sum and its exact error, if |a| ≥ |b| or a = 0 (Dekker 1971).
#[inline(always)]
pub(super) fn fast_two_sum<R: Float64>(a: R, b: R) -> (R, R) {
    let sum = a + b;
    (sum, (a - sum) + b)
}

/// Polynomial with the given coefficients, the constant one first.
///
/// Even and odd powers are summed by themselves, so that two chains of operations run side by side.
#[inline(always)]
pub(super) fn polynomial<R: Float64, const N: usize>(x: R, coefficients: [f64; N]) -> R {
    #[inline(always)]
    fn every_second<R: Float64, const N: usize>(square: R, coefficients: [f64; N], first: usize) -> R {
        let mut degree = N - 1 - (N - 1 - first) % 2;
        let mut sum = square.splat(coefficients[degree]);
        while degree > first {
            degree -= 2;
            sum = sum * square + coefficients[degree];
        }
        sum
    }
    let square = x * x;
    every_second(square, coefficients, 0) + x * every_second(square, coefficients, 1)
}

/// True from `low` to `high`; false for NaN.
#[inline(always)]
pub(super) fn is_between<R: Float64>(x: R, low: f64, high: f64) -> R::Mask {
    x.max(x.splat(low)).min(x.splat(high)).eq(x)
}

/// Defines functions by their versions for lanes. Those for one number are not inlined.
macro_rules! elementary {
    ($($(#[$doc:meta])* $name:ident($x:ident $(, $y:ident)?) = $lanes:ident by $map:ident;)*) => {
        $($(#[$doc])*
        #[inline(always)]
        pub fn $name<R: Float64>($x: R $(, $y: R)?) -> R {
            #[inline(never)]
            fn scalar($x: f64 $(, $y: f64)?) -> f64 {
                $lanes($x $(, $y)?)
            }
            if R::IS_SCALAR { $x.$map($($y,)? scalar) } else { $lanes($x $(, $y)?) }
        })*
    };
}
pub(super) use elementary;

/// The first value where the mask is true, and a function of single numbers elsewhere, which is called only if needed.
///
/// Closures are always inlined. A closure by itself is compiled without the instruction set of the lanes.
macro_rules! or_else {
    ($is_inside:expr, $inside:expr, $outside:expr) => {
        super::parts::select_or_else(
            $is_inside,
            #[inline(always)]
            || $inside,
            #[inline(always)]
            || $outside,
        )
    };
}
pub(super) use or_else;

#[inline(always)]
pub(super) fn select_or_else<R: Float64>(
    is_inside: R::Mask,
    inside: impl FnOnce() -> R,
    outside: impl FnOnce() -> R,
) -> R {
    if R::IS_SCALAR {
        return if is_inside.all() { inside() } else { outside() };
    }
    let value = inside();
    if is_inside.all() { value } else { R::select(is_inside, value, outside()) }
}

/// [`Real::select`](crate::Real::select) of two values, only one of which is computed if there is one number.
#[inline(always)]
pub(super) fn choose<R: Float64>(mask: R::Mask, a: impl FnOnce() -> R, b: impl FnOnce() -> R) -> R {
    if !R::IS_SCALAR {
        R::select(mask, a(), b())
    } else if mask.any() {
        a()
    } else {
        b()
    }
}
