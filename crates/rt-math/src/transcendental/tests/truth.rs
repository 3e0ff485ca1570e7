//! Elementary functions as series in integers, and errors in ulp against them.

use num_bigint::BigInt;
use std::sync::LazyLock;

/// Binary digits behind the point.
const FRACTION: u32 = 384;

/// `mantissa · 2^(exponent − 384)`, where the mantissa has at least some 200 digits, or is 0.
#[derive(Clone, Debug)]
pub(super) struct Truth {
    mantissa: BigInt,
    exponent: i64,
}

/// Integer and exponent of a finite number: `x = m · 2^e`.
fn parts(x: f64) -> (i64, i64) {
    let bits = x.to_bits();
    let biased = ((bits >> 52) & 0x7ff) as i64;
    let fraction = (bits & ((1 << 52) - 1)) as i64;
    let mantissa = if biased == 0 { fraction } else { fraction | 1 << 52 };
    (if x < 0.0 { -mantissa } else { mantissa }, biased.max(1) - 1075)
}

fn shifted(x: &BigInt, left: i64) -> BigInt {
    if left >= 0 { x << left as u64 } else { x >> (-left) as u64 }
}

/// Fixed-point number of `x`; exact from 2⁻³³¹ upwards.
fn fixed(x: f64) -> BigInt {
    let (mantissa, exponent) = parts(x);
    shifted(&BigInt::from(mantissa), exponent + i64::from(FRACTION))
}

fn one() -> BigInt {
    BigInt::from(1) << FRACTION
}

fn multiply(a: &BigInt, b: &BigInt) -> BigInt {
    (a * b) >> FRACTION
}

fn divide(a: &BigInt, b: &BigInt) -> BigInt {
    (a << FRACTION) / b
}

/// Sum of `x^(2k+1) / (2k+1)` with alternating signs (atan x), or with equal ones (artanh x); for |x| below 1/2.
fn odd_series(x: &BigInt, is_alternating: bool) -> BigInt {
    let square = multiply(x, x);
    let square = if is_alternating { -square } else { square };
    let (mut power, mut sum, mut k) = (x.clone(), x.clone(), 1);
    while power.bits() > 1 {
        power = multiply(&power, &square);
        k += 2;
        sum += &power / k;
    }
    sum
}

/// π by Machin's formula, 16 atan(1/5) − 4 atan(1/239).
static PI: LazyLock<BigInt> =
    LazyLock::new(|| odd_series(&(one() / 5), true) * 16 - odd_series(&(one() / 239), true) * 4);

/// ln 2 = 2 artanh(1/3).
static LN_2: LazyLock<BigInt> = LazyLock::new(|| odd_series(&(one() / 3), false) * 2);

/// Nearest integer to `a / b`.
fn nearest_multiple(a: &BigInt, b: &BigInt) -> i64 {
    let quotient = divide(a, b) + (BigInt::from(1) << (FRACTION - 1));
    i64::try_from(&(quotient >> FRACTION)).unwrap()
}

fn exp_fixed(x: &BigInt) -> Truth {
    let n = nearest_multiple(x, &LN_2);
    let r = x - &*LN_2 * n;
    let (mut term, mut sum, mut k) = (one(), one(), 0);
    while term.bits() > 1 {
        k += 1;
        term = multiply(&term, &r) / k;
        sum += &term;
    }
    Truth { mantissa: sum, exponent: n }
}

/// Sine and cosine.
fn sincos_fixed(x: &BigInt) -> (BigInt, BigInt) {
    let half_pi = &*PI >> 1u32;
    let n = nearest_multiple(x, &half_pi);
    let r = x - &half_pi * n;
    let (mut term, mut sums, mut k) = (one(), [one(), BigInt::from(0)], 0usize);
    while term.bits() > 1 {
        k += 1;
        term = multiply(&term, &r) / k as u64;
        if k % 4 < 2 {
            sums[k % 2] += &term;
        } else {
            sums[k % 2] -= &term;
        }
    }
    let [cosine, sine] = sums;
    match n.rem_euclid(4) {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}

/// Angle of a vector. A guess is corrected by the angle that remains after rotating the vector by it.
fn angle_fixed(x: &BigInt, y: &BigInt, guess: f64) -> BigInt {
    let guess = fixed(guess);
    let (sine, cosine) = sincos_fixed(&guess);
    let rotated_x = multiply(x, &cosine) + multiply(y, &sine);
    let rotated_y = multiply(y, &cosine) - multiply(x, &sine);
    guess + odd_series(&divide(&rotated_y, &rotated_x), true)
}

/// Natural logarithm of a positive number. A guess of that of the mantissa is corrected.
fn log_fixed(x: f64) -> BigInt {
    let (mantissa, exponent) = parts(x);
    let shift = 63 - i64::from(mantissa.leading_zeros());
    let mantissa = shifted(&BigInt::from(mantissa), i64::from(FRACTION) - shift);
    let guess = libm::log(x) - (exponent + shift) as f64 * core::f64::consts::LN_2;
    let Truth { mantissa: power, exponent: power_exponent } = exp_fixed(&fixed(-guess));
    let ratio = shifted(&multiply(&mantissa, &power), power_exponent);
    let correction = odd_series(&divide(&(&ratio - one()), &(&ratio + one())), false) * 2;
    fixed(guess) + correction + &*LN_2 * (exponent + shift)
}

impl From<BigInt> for Truth {
    fn from(mantissa: BigInt) -> Self {
        Self { mantissa, exponent: 0 }
    }
}

impl Truth {
    pub(super) fn sin(x: f64) -> Self {
        sincos_fixed(&fixed(x)).0.into()
    }

    pub(super) fn cos(x: f64) -> Self {
        sincos_fixed(&fixed(x)).1.into()
    }

    pub(super) fn atan2(y: f64, x: f64) -> Self {
        // Multiply both by a power of two, so that the greater one is near 1.
        let shift = parts(y).1.max(parts(x).1) + 52;
        let scaled = |number| {
            let (mantissa, exponent) = parts(number);
            shifted(&BigInt::from(mantissa), exponent - shift + i64::from(FRACTION))
        };
        angle_fixed(&scaled(x), &scaled(y), libm::atan2(y, x)).into()
    }

    pub(super) fn atan(x: f64) -> Self {
        Self::atan2(x, 1.0)
    }

    pub(super) fn asin(x: f64) -> Self {
        let sine = fixed(x);
        let cosine = ((one() << FRACTION) - &sine * &sine).sqrt();
        angle_fixed(&cosine, &sine, libm::asin(x)).into()
    }

    pub(super) fn acos(x: f64) -> Self {
        let cosine = fixed(x);
        let sine = ((one() << FRACTION) - &cosine * &cosine).sqrt();
        angle_fixed(&cosine, &sine, libm::acos(x)).into()
    }

    pub(super) fn exp(x: f64) -> Self {
        exp_fixed(&fixed(x))
    }

    pub(super) fn exp2(x: f64) -> Self {
        exp_fixed(&multiply(&fixed(x), &LN_2))
    }

    pub(super) fn log(x: f64) -> Self {
        log_fixed(x).into()
    }

    pub(super) fn log2(x: f64) -> Self {
        divide(&log_fixed(x), &LN_2).into()
    }

    pub(super) fn pow(x: f64, y: f64) -> Self {
        let (mantissa, exponent) = parts(y);
        exp_fixed(&shifted(&(log_fixed(x) * mantissa), exponent))
    }

    /// Distance of a result from the true value, in units in the last place of the true value.
    pub(super) fn error_in_ulp(&self, result: f64) -> f64 {
        if !result.is_finite() {
            return f64::INFINITY;
        }
        let exponent = self.mantissa.bits() as i64 - 1 - i64::from(FRACTION) + self.exponent;
        let last_place = (exponent - 52).max(-1074);
        // Both numbers in units of 2⁻⁶⁴ ulp.
        let (mantissa, result_exponent) = parts(result);
        let result = shifted(&BigInt::from(mantissa), result_exponent - last_place + 64);
        let truth = shifted(&self.mantissa, self.exponent - i64::from(FRACTION) - last_place + 64);
        let difference = i128::try_from(&(result - truth)).unwrap_or(i128::MAX);
        difference.unsigned_abs() as f64 / (1u128 << 64) as f64
    }
}

#[test]
fn constants_and_identities() {
    assert_eq!(Truth::from(PI.clone()).error_in_ulp(core::f64::consts::PI).round(), 0.0);
    assert!(Truth::from(LN_2.clone()).error_in_ulp(core::f64::consts::LN_2) <= 0.5);
    for x in [0.001, 0.3, 1.0, 2.5, 77.7] {
        // sin² + cos² = 1; exp(ln x) = x; tan(atan x) = x.
        let (sine, cosine) = sincos_fixed(&fixed(x));
        assert!((multiply(&sine, &sine) + multiply(&cosine, &cosine) - one()).bits() < 20);
        let power = exp_fixed(&log_fixed(x));
        assert!((shifted(&power.mantissa, power.exponent) - fixed(x)).bits() < 20);
        let (sine, cosine) = sincos_fixed(&Truth::atan(x).mantissa);
        assert!((divide(&sine, &cosine) - fixed(x)).bits() < 30);
    }
    // One unit in the last place is an error of one.
    assert!((Truth::from(fixed(1.5)).error_in_ulp(1.5 + f64::EPSILON) - 1.0).abs() < 1e-9);
    assert!((Truth::from(fixed(-0.7)).error_in_ulp(-0.7 + f64::EPSILON) - 2.0).abs() < 1e-9);
}
