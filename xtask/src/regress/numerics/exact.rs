//! Arithmetic without rounding.

use std::ops::{Add, Mul, Sub};

use num_bigint::{BigInt, Sign};

/// A whole number times a power of two, as all finite `f64` are, and their sums and products.
#[derive(Clone, Debug)]
pub(super) struct Dyadic {
    mantissa: BigInt,
    exponent: i32,
}

impl From<f64> for Dyadic {
    /// Exact for finite numbers; others give the number in their bits.
    fn from(number: f64) -> Self {
        const FRACTION: u32 = f64::MANTISSA_DIGITS - 1;
        let bits = number.to_bits();
        let biased = ((bits >> FRACTION) & 0x7ff) as i32;
        let fraction = bits & ((1 << FRACTION) - 1);
        // Subnormal numbers lack the leading one and have the exponent of the next larger ones.
        let mantissa = if biased == 0 { fraction } else { fraction | 1 << FRACTION } as i64;
        let mantissa = BigInt::from(if number.is_sign_negative() { -mantissa } else { mantissa });
        Self { mantissa, exponent: biased.max(1) - 1075 }
    }
}

impl Dyadic {
    /// −1, 0 or 1.
    pub(super) fn signum(&self) -> i32 {
        match self.mantissa.sign() {
            Sign::Minus => -1,
            Sign::NoSign => 0,
            Sign::Plus => 1,
        }
    }

    /// The nearest `f64`, or nearly so: for measuring errors.
    pub(super) fn to_f64(&self) -> f64 {
        let digits = self.mantissa.bits();
        let cut = digits.saturating_sub(64);
        let leading = (self.mantissa.magnitude() >> cut).iter_u64_digits().next().unwrap_or(0) as f64;
        let scaled = scale(leading, self.exponent.saturating_add(i32::try_from(cut).unwrap_or(i32::MAX)));
        if self.signum() < 0 { -scaled } else { scaled }
    }

    /// Mantissas of both at the lower exponent.
    fn aligned(&self, other: &Self) -> (BigInt, BigInt, i32) {
        let exponent = self.exponent.min(other.exponent);
        let raised = |number: &Self| &number.mantissa << (number.exponent - exponent) as u32;
        (raised(self), raised(other), exponent)
    }
}

/// `x · 2^exponent` in steps that do not overflow before the result does.
fn scale(mut x: f64, mut exponent: i32) -> f64 {
    while exponent != 0 && x != 0.0 && x.is_finite() {
        let step = exponent.clamp(-512, 512);
        x *= rt_math::transcendental::exp2(f64::from(step));
        exponent -= step;
    }
    x
}

impl Mul for &Dyadic {
    type Output = Dyadic;

    fn mul(self, other: Self) -> Dyadic {
        Dyadic { mantissa: &self.mantissa * &other.mantissa, exponent: self.exponent + other.exponent }
    }
}

impl Add for &Dyadic {
    type Output = Dyadic;

    fn add(self, other: Self) -> Dyadic {
        let (a, b, exponent) = self.aligned(other);
        Dyadic { mantissa: a + b, exponent }
    }
}

impl Sub for &Dyadic {
    type Output = Dyadic;

    fn sub(self, other: Self) -> Dyadic {
        let (a, b, exponent) = self.aligned(other);
        Dyadic { mantissa: a - b, exponent }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_survive_the_way_there_and_back() {
        for number in [0.0, 1.0, -0.1, 1e300, -5e-324, 2.5e-310, f64::MAX, f64::MIN_POSITIVE, 1e17 + 16.0] {
            assert_eq!(Dyadic::from(number).to_f64(), number);
        }
    }

    #[test]
    fn nothing_is_rounded() {
        let [big, tiny, third] = [1e300, 1e-300, 1.0 / 3.0].map(Dyadic::from);
        assert_eq!((&(&(&big + &tiny) - &big) - &tiny).signum(), 0);
        assert_eq!((&(&third * &big) - &(&big * &third)).signum(), 0);
        let square = &third * &third;
        let rounded = Dyadic::from((1.0 / 3.0) * (1.0 / 3.0));
        let error = 1f64 / 3.0;
        let (_, low) = rt_math::float::two_product(error, error);
        assert_eq!((&(&square - &rounded) - &Dyadic::from(low)).signum(), 0);
        assert_eq!((&square - &Dyadic::from(0.111)).signum(), 1);
        assert_eq!(Dyadic::from(-1e-300).signum(), -1);
    }
}
