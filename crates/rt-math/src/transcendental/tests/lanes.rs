//! Four numbers at a time have the bits of scalar calls.

use super::{super::*, special_values};
use crate::{Float64, Mask, Real, random::hash};
use core::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Shl, Shr, Sub};

/// Values of four lanes.
#[derive(Clone, Copy, Debug)]
struct Lanes<T>([T; 4]);

impl<T: Copy> Lanes<T> {
    fn each<U>(self, f: impl Fn(T) -> U) -> Lanes<U> {
        Lanes(self.0.map(f))
    }

    fn pairs<U>(self, other: Self, f: impl Fn(T, T) -> U) -> Lanes<U> {
        Lanes(core::array::from_fn(|i| f(self.0[i], other.0[i])))
    }
}

macro_rules! operations {
    ($($operation:ident $method:ident $operator:tt $number:ty;)*) => {$(
        impl $operation for Lanes<$number> {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                self.pairs(other, |a, b| a $operator b)
            }
        }
        impl $operation<$number> for Lanes<$number> {
            type Output = Self;
            fn $method(self, other: $number) -> Self {
                self.each(|a| a $operator other)
            }
        }
    )*};
}
operations! {
    Add add + f64;
    Sub sub - f64;
    Mul mul * f64;
    Div div / f64;
    Add add + u64;
    BitAnd bitand & u64;
    BitXor bitxor ^ u64;
    BitAnd bitand & bool;
    BitOr bitor | bool;
}

impl Neg for Lanes<f64> {
    type Output = Self;
    fn neg(self) -> Self {
        self.each(|x| -x)
    }
}

impl Not for Lanes<bool> {
    type Output = Self;
    fn not(self) -> Self {
        self.each(|x| !x)
    }
}

impl Shl<u32> for Lanes<u64> {
    type Output = Self;
    fn shl(self, places: u32) -> Self {
        self.each(|x| x << places)
    }
}

impl Shr<u32> for Lanes<u64> {
    type Output = Self;
    fn shr(self, places: u32) -> Self {
        self.each(|x| x >> places)
    }
}

impl Mask for Lanes<bool> {
    fn any(self) -> bool {
        self.0.contains(&true)
    }
}

impl Real for Lanes<f64> {
    type Mask = Lanes<bool>;

    const MAX: f64 = f64::MAX;

    fn splat(self, x: f64) -> Self {
        Self([x; 4])
    }

    fn sqrt(self) -> Self {
        self.each(f64::sqrt)
    }

    fn abs(self) -> Self {
        self.each(f64::abs)
    }

    fn copysign(self, sign: Self) -> Self {
        self.pairs(sign, f64::copysign)
    }

    fn lt(self, other: Self) -> Lanes<bool> {
        self.pairs(other, |a, b| a < b)
    }

    fn le(self, other: Self) -> Lanes<bool> {
        self.pairs(other, |a, b| a <= b)
    }

    fn eq(self, other: Self) -> Lanes<bool> {
        self.pairs(other, |a, b| a == b)
    }

    fn select(mask: Lanes<bool>, a: Self, b: Self) -> Self {
        Self(core::array::from_fn(|i| if mask.0[i] { a.0[i] } else { b.0[i] }))
    }
}

impl Float64 for Lanes<f64> {
    type Bits = Lanes<u64>;

    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        self.each(f)
    }

    fn map2(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        self.pairs(other, f)
    }

    fn to_bits(self) -> Lanes<u64> {
        self.each(f64::to_bits)
    }

    fn from_bits(bits: Lanes<u64>) -> Self {
        bits.each(f64::from_bits)
    }
}

/// Asserts that each lane has the bits of the scalar call; NaN of any bits.
fn assert_same(name: &str, arguments: [Lanes<f64>; 2], results: Lanes<f64>, scalar: impl Fn(f64, f64) -> f64) {
    for lane in 0..4 {
        let [x, y] = arguments.map(|a| a.0[lane]);
        let (a, b) = (results.0[lane], scalar(x, y));
        assert!(a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan()), "{name} {x:?} {y:?}: {a:?}, {b:?}");
    }
}

/// Arguments of all kinds stand side by side: special values, ordinary ones, and ones of any size.
#[test]
fn lanes_have_the_bits_of_scalar_calls() {
    let special = special_values();
    let draw = |index: u64| {
        let bits = hash(&[91, index]);
        match bits % 4 {
            0 => special[(bits >> 8) as usize % special.len()],
            1 => f64::from_bits(hash(&[bits])),
            2 => 2.0 * crate::random::unit(hash(&[bits])) - 1.0,
            _ => 40.0 * crate::random::unit(hash(&[bits])) - 20.0,
        }
    };
    for i in 0..30_000 {
        let [x, y] = [0, 4].map(|first| Lanes(core::array::from_fn(|lane| draw(8 * i + first + lane as u64))));
        let arguments = [x, y];
        assert_same("sin", arguments, sin(x), |x, _| sin(x));
        assert_same("cos", arguments, cos(x), |x, _| cos(x));
        let (sine, cosine) = sincos(x);
        assert_same("sincos", arguments, sine, |x, _| sin(x));
        assert_same("sincos", arguments, cosine, |x, _| cos(x));
        assert_same("atan", arguments, atan(x), |x, _| atan(x));
        assert_same("atan2", arguments, atan2(y, x), |x, y| atan2(y, x));
        assert_same("acos", arguments, acos(x), |x, _| acos(x));
        assert_same("asin", arguments, asin(x), |x, _| asin(x));
        assert_same("exp", arguments, exp(x), |x, _| exp(x));
        assert_same("exp2", arguments, exp2(x), |x, _| exp2(x));
        assert_same("log", arguments, log(x), |x, _| log(x));
        assert_same("log2", arguments, log2(x), |x, _| log2(x));
        assert_same("pow", arguments, pow(x, y), pow);
    }
}
