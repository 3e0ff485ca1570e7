//! Exponential functions, logarithms and powers.

use super::parts::{
    INTEGER_SHIFT, SIGN, elementary, fast_two_sum, high_16, high_26, is_between, or_else, polynomial, round,
};
use crate::{F32, Float64, Mask, Real};
use core::f64::consts::{LN_2, LOG2_E};

/// ln 2 in two parts. The first has 42 bits, so that its products with integers up to 2¹¹ are exact.
const LN_2_PARTS: [f64; 2] = [0.6931471805598903, 5.497923018708371e-14];

/// ln 2 in two parts. The first has 26 bits.
const LN_2_SHORT: [f64; 2] = [0.6931471675634384, 1.2996506893889889e-08];

/// 1 / ln 2 in two parts. The first has 26 bits.
const LOG2_E_SHORT: [f64; 2] = [1.4426950216293335, 1.9259629911266175e-08];

/// (eʳ − 1 − r) / r² for |r| ≤ ln 2 / 2; minimax. The error of eʳ is at most 2⁻⁶⁰.
const EXPONENTIAL: [f64; 11] = [
    0.5,
    0.16666666666666685,
    0.04166666666666673,
    0.008333333333316722,
    0.0013888888888858645,
    0.00019841269897100726,
    2.480158737347837e-05,
    2.7557234193723015e-06,
    2.7557233511425355e-07,
    2.511225528330391e-08,
    2.0926911278321714e-09,
];

/// (2 artanh √z / √z − 2) / z for 0 ≤ z ≤ 0.1716²; minimax. The error of ln is at most 2⁻⁵⁸ of 2 √z.
const LOGARITHM: [f64; 7] = [
    0.6666666666666734,
    0.3999999999941666,
    0.28571428742022537,
    0.22222198605639537,
    0.18183562824258087,
    0.153140854345138,
    0.14795628201363067,
];

/// (2 artanh √z / (√z ln 2) − C₁ − C₃ z) / z² for 0 ≤ z ≤ 1/256 with the constants below; minimax.
/// The relative error of log₂ is at most 2⁻⁷².
const LOGARITHM_2: [f64; 5] =
    [0.5770780163555966, 0.41219858308184637, 0.3205989254943841, 0.26229619580499314, 0.22441669481620966];

/// C₁ = 2 / ln 2, and two parts of it. The first part has 36 bits.
const C1: f64 = 2.8853900817779268;
const C1_PARTS: [f64; 2] = [2.885390081733931, 4.399595873039319e-11];

/// C₃ = 2 / (3 ln 2), and two parts of it. The first part has 5 bits.
const C3: f64 = 0.9617966939259756;
const C3_PARTS: [f64; 2] = [0.96875, -0.006953306074024395];

/// Centres of parts of [√½, √2], less 1, and their log₂ in two parts, the first of 40 bits. The middle part has the centre 1.
const CENTRES: [[f64; 3]; 2] =
    [[-0.203125, -0.3275746580284249, -7.951818330761124e-14], [0.25, 0.32192809488697094, 3.914087556296025e-13]];

/// Limits between the parts: geometric means of the centres.
const MEANS: [f64; 2] = [0.8926785535678562, 1.118033988749895];

/// Largest absolute value of the exponent of a power that is computed here.
const LARGEST_EXPONENT: f64 = (1u128 << 64) as f64;

elementary! {
    /// Exponential function. Error: at most 0.8 ulp; 1 ulp where the result is subnormal.
    exp(x) = exp_lanes by map;

    /// 2 to the power of the argument; exact for integers. Error: at most 0.8 ulp; 1 ulp where the result is subnormal.
    exp2(x) = exp2_lanes by map;

    /// Natural logarithm: −∞ for 0, NaN for negative numbers. Error: at most 0.9 ulp.
    log(x) = log_lanes by map;

    /// Logarithm to base 2: −∞ for 0, NaN for negative numbers; exact for powers of two. Error: at most 0.85 ulp.
    log2(x) = log2_lanes by map;

    /// `x` to the power of `y`, with the special cases of IEEE 754. Error: at most 0.8 ulp; 1 ulp where the result is subnormal.
    ///
    /// Powers that are normal `f64` without rounding are returned exactly.
    pow(x, y) = pow_lanes by map2;
}

#[inline(always)]
fn exp_lanes<R: Float64>(x: R) -> R {
    if x.abs().le(x.splat(700.0)).all() {
        let (mantissa, n) = exp_unscaled(x);
        return mantissa * power_of_two(n);
    }
    // Outside of these limits the result is 0 or infinite.
    let (mantissa, n) = exp_unscaled(x.max(x.splat(-750.0)).min(x.splat(750.0)));
    scale(mantissa, n)
}

#[inline(always)]
fn exp2_lanes<R: Float64>(x: R) -> R {
    exp2_of_sum(x, x.splat(0.0))
}

#[inline(always)]
fn log_lanes<R: Float64>(x: R) -> R {
    or_else!(is_normal(x), Logarithm::new(x).natural(), x.map(libm::log))
}

#[inline(always)]
fn log2_lanes<R: Float64>(x: R) -> R {
    or_else!(is_normal(x), Logarithm::new(x).binary(), x.map(libm::log2))
}

/// A [`Real`] number with powers of real exponents.
pub trait Pow: Real {
    /// The number, which is not negative, to the power of `exponent`: that of [`pow`], rounded to the type.
    fn powf(self, exponent: f64) -> Self;
}

impl<R: Float64> Pow for R {
    #[inline(always)]
    fn powf(self, exponent: f64) -> Self {
        pow(self, self.splat(exponent))
    }
}

impl Pow for F32 {
    #[inline(always)]
    fn powf(self, exponent: f64) -> Self {
        Self(pow(f64::from(self.0), exponent) as f32)
    }
}

#[inline(always)]
fn pow_lanes<R: Float64>(x: R, y: R) -> R {
    let (zero, one) = (x.splat(0.0), x.splat(1.0));
    // Powers of +0 with a positive exponent are 0.
    let is_zero = R::select(x.eq(zero), y.min(one.copysign(x)), zero).gt(zero);
    let base = R::select(is_zero, one, x);
    let is_inside = R::select(is_normal(base), y.abs(), x.splat(f64::INFINITY)).le(x.splat(LARGEST_EXPONENT));
    or_else!(is_inside, R::select(is_zero, zero, pow_normal(base, y)), x.map2(y, libm::pow))
}

/// Power of a positive normal number, for exponents up to [`LARGEST_EXPONENT`].
#[inline(always)]
fn pow_normal<R: Float64>(x: R, y: R) -> R {
    // Multiply the logarithm by y. The product of the high parts is exact.
    let (sum, rest) = log2_as_sum(x);
    let log_high = high_26(sum + rest);
    let log_low = (sum - log_high) + rest;
    let y_high = high_26(y);
    exp2_of_sum(y_high * log_high, y * log_low + (y - y_high) * log_high)
}

/// Logarithm as a sum: `exponent` ln 2 + f − `half_square` + `rest`.
struct Logarithm<R> {
    exponent: R,
    /// From √½ − 1 to √2 − 1.
    f: R,
    /// f²/2.
    half_square: R,
    rest: R,
}

impl<R: Float64> Logarithm<R> {
    /// Logarithm of a positive normal number.
    #[inline(always)]
    fn new(x: R) -> Self {
        // ln(1 + f) = 2 artanh s = 2 s + s p with s = f / (2 + f). Because 2 s = f − s f, and s f = f²/2 − s f²/2,
        // it is f − f²/2 + s (f²/2 + p).
        let (mantissa, exponent) = split_exponent(x);
        let f = mantissa - 1.0;
        let s = f / (f + 2.0);
        let z = s * s;
        let half_square = f * f * 0.5;
        Self { exponent, f, half_square, rest: s * (half_square + z * polynomial(z, LOGARITHM)) }
    }

    /// Sum of the terms.
    #[inline(always)]
    fn natural(self) -> R {
        let (sum, error) = fast_two_sum(self.exponent * LN_2_PARTS[0], self.f);
        sum + ((self.rest + (error + self.exponent * LN_2_PARTS[1])) - self.half_square)
    }

    /// Logarithm to base 2.
    #[inline(always)]
    fn binary(self) -> R {
        // Multiply by 1 / ln 2. The product of the high parts is exact.
        let high = high_26(self.f - (self.half_square - self.rest));
        let low = ((self.f - high) - self.half_square) + self.rest;
        let (sum, error) = fast_two_sum(self.exponent, high * LOG2_E_SHORT[0]);
        sum + (error + (high * LOG2_E_SHORT[1] + low * LOG2_E))
    }
}

/// True for positive normal numbers.
#[inline(always)]
fn is_normal<R: Float64>(x: R) -> R::Mask {
    is_between(x, f64::MIN_POSITIVE, f64::MAX)
}

/// Numbers m from √½ to √2 and n such that a positive normal `x` is m · 2ⁿ.
#[inline(always)]
fn split_exponent<R: Float64>(x: R) -> (R, R) {
    const SQRT_HALF: u64 = core::f64::consts::FRAC_1_SQRT_2.to_bits();
    const ONE: u64 = 1.0f64.to_bits();
    const TWO_52: f64 = (1u64 << 52) as f64;
    let shifted = (x.to_bits() & !SIGN) + (ONE - SQRT_HALF);
    let mantissa = R::from_bits((shifted & ((1 << 52) - 1)) + SQRT_HALF);
    let exponent = R::from_bits((shifted >> 52) + TWO_52.to_bits()) - (TWO_52 + 1023.0);
    (mantissa, exponent)
}

/// `x · 2ⁿ` for integers |n| ≤ 2000, in two steps, which allow subnormal results.
#[inline(always)]
fn scale<R: Float64>(x: R, n: R) -> R {
    let half = round(n * 0.5);
    x * power_of_two(half) * power_of_two(n - half)
}

/// 2ⁿ for integers from −1022 to 1023.
#[inline(always)]
fn power_of_two<R: Float64>(n: R) -> R {
    R::from_bits((n + (INTEGER_SHIFT + 1023.0)).to_bits() << 52)
}

/// exp(a + b) for |a| ≤ ln 2 / 2 and a far smaller b.
#[inline(always)]
fn exp_of_sum<R: Float64>(a: R, b: R) -> R {
    let (sum, error) = fast_two_sum(a.splat(1.0), a);
    let r = a + b;
    sum + (error + (b + r * r * polynomial(r, EXPONENTIAL)))
}

/// Numbers m from √½ to √2 and n such that exp x is m · 2ⁿ.
#[inline(always)]
fn exp_unscaled<R: Float64>(x: R) -> (R, R) {
    let n = round(x * LOG2_E);
    (exp_of_sum(x - n * LN_2_PARTS[0], -(n * LN_2_PARTS[1])), n)
}

/// 2 to the power of a + b, where b has at most 2⁻²⁵ of the size of a. Sizes beyond 1100 give 0 or infinity.
#[inline(always)]
fn exp2_of_sum<R: Float64>(a: R, b: R) -> R {
    if a.abs().le(a.splat(1000.0)).all() {
        let (mantissa, n) = exp2_unscaled(a, b);
        return mantissa * power_of_two(n);
    }
    let b = R::select(a.abs().gt(a.splat(1100.0)), a.splat(0.0), b);
    let (mantissa, n) = exp2_unscaled(a.max(a.splat(-1100.0)).min(a.splat(1100.0)), b);
    scale(mantissa, n)
}

/// Numbers m from √½ to √2 and n such that 2 to the power of a + b is m · 2ⁿ.
#[inline(always)]
fn exp2_unscaled<R: Float64>(a: R, b: R) -> (R, R) {
    /// 1.5 · 2²⁵: numbers near it are multiples of 2⁻²⁷.
    const SHIFT: f64 = 50_331_648.0;
    // Multiply the fraction by ln 2. The product of the high parts is exact.
    let n = round(a + b);
    let fraction = a - n;
    let high = ((fraction + b) + SHIFT) - SHIFT;
    let low = (fraction - high) + b;
    (exp_of_sum(high * LN_2_SHORT[0], high * LN_2_SHORT[1] + low * LN_2), n)
}

/// log₂ of a positive normal number as a sum, with a relative error of some 2⁻⁶⁷; the second number is smaller by 2⁻¹⁵.
#[inline(always)]
fn log2_as_sum<R: Float64>(x: R) -> (R, R) {
    /// 1.5 · 2¹⁹: numbers near it are multiples of 2⁻³³.
    const SHIFT: f64 = 786_432.0;

    // x = 2ⁿ · m, and m lies near the centre c.
    let (m, n) = split_exponent(x);
    let (zero, one) = (x.splat(0.0), x.splat(1.0));
    let low = R::select(m.lt(x.splat(MEANS[0])), one, zero);
    let high = R::select(m.gt(x.splat(MEANS[1])), one, zero);
    let [c, log_c, log_c_low] = [
        low * CENTRES[0][0] + high * CENTRES[1][0] + 1.0,
        low * CENTRES[0][1] + high * CENTRES[1][1],
        low * CENTRES[0][2] + high * CENTRES[1][2],
    ];

    // log₂(m / c) = C₁ s + C₃ s³ + ... with s = (m − c) / (m + c), here as a number of 16 bits and a rest.
    let difference = m - c;
    let reciprocal = (m + c).recip();
    let s_high = high_16(difference * reciprocal);
    let m_high = (m + SHIFT) - SHIFT;
    let remainder = (difference - s_high * (m_high + c)) - s_high * (m - m_high);
    let s_low = remainder * reciprocal;

    // Powers of the high part are exact, and so are their products with short constants.
    let s = s_high + s_low;
    let z = s * s;
    let square = s_high * s_high;
    let cube = s_high * square;
    let rest = s_high * C1_PARTS[1]
        + (s_low * ((z + s * s_high + square) * C3 + C1)
            + (cube * C3_PARTS[1] + s * z * z * polynomial(z, LOGARITHM_2)));
    let (sum, error) = fast_two_sum(n + log_c, s_high * C1_PARTS[0]);
    let (sum, second_error) = fast_two_sum(sum, cube * C3_PARTS[0]);
    (sum, rest + (log_c_low + (error + second_error)))
}
