//! Eight `f64` at a time, whose loops become vector instructions within [`vectorize`](crate::simd::vectorize).

use core::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Shl, Shr, Sub};
use rt_math::{Float64, Mask, Real};

use crate::simd::lanes;

pub(crate) const LANES: usize = 8;

/// Eight numbers.
#[derive(Clone, Copy)]
pub(crate) struct FloatLanes(pub(crate) [f64; LANES]);

/// Eight truth values: all bits or none.
#[derive(Clone, Copy)]
pub(crate) struct MaskLanes([u64; LANES]);

/// Bits of eight numbers.
#[derive(Clone, Copy)]
pub(crate) struct BitLanes([u64; LANES]);

/// Implements a binary operator lane by lane.
macro_rules! binary {
    ($type:ident, $trait:ident, $function:ident) => {
        impl $trait for $type {
            type Output = Self;

            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                Self(lanes(
                    #[inline(always)]
                    |lane| self.0[lane].$function(other.0[lane]),
                ))
            }
        }
    };
}

/// Implements an operator with the same number in all lanes.
macro_rules! with_number {
    ($type:ident, $trait:ident<$number:ty>, $function:ident) => {
        impl $trait<$number> for $type {
            type Output = Self;

            #[inline(always)]
            fn $function(self, other: $number) -> Self {
                Self(lanes(
                    #[inline(always)]
                    |lane| self.0[lane].$function(other),
                ))
            }
        }
    };
}

binary!(FloatLanes, Add, add);
binary!(FloatLanes, Sub, sub);
binary!(FloatLanes, Mul, mul);
binary!(FloatLanes, Div, div);
binary!(MaskLanes, BitAnd, bitand);
binary!(MaskLanes, BitOr, bitor);
binary!(BitLanes, BitXor, bitxor);
with_number!(FloatLanes, Add<f64>, add);
with_number!(FloatLanes, Sub<f64>, sub);
with_number!(FloatLanes, Mul<f64>, mul);
with_number!(BitLanes, BitAnd<u64>, bitand);
with_number!(BitLanes, Shl<u32>, shl);
with_number!(BitLanes, Shr<u32>, shr);

impl Add<u64> for BitLanes {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: u64) -> Self {
        Self(lanes(
            #[inline(always)]
            |lane| self.0[lane].wrapping_add(other),
        ))
    }
}

impl Neg for FloatLanes {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(lanes(
            #[inline(always)]
            |lane| -self.0[lane],
        ))
    }
}

impl Not for MaskLanes {
    type Output = Self;

    #[inline(always)]
    fn not(self) -> Self {
        Self(lanes(
            #[inline(always)]
            |lane| !self.0[lane],
        ))
    }
}

impl Mask for MaskLanes {
    #[inline(always)]
    fn any(self) -> bool {
        self.0.iter().fold(
            0,
            #[inline(always)]
            |all, bits| all | bits,
        ) != 0
    }
}

/// All bits for true.
#[inline(always)]
const fn filled(is_true: bool) -> u64 {
    (is_true as u64).wrapping_neg()
}

impl Real for FloatLanes {
    type Mask = MaskLanes;

    const MAX: f64 = f64::MAX;

    #[inline(always)]
    fn splat(self, x: f64) -> Self {
        Self([x; LANES])
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(lanes(
            #[inline(always)]
            |lane| self.0[lane].sqrt(),
        ))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(lanes(
            #[inline(always)]
            |lane| self.0[lane].abs(),
        ))
    }

    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        Self(lanes(
            #[inline(always)]
            |lane| self.0[lane].copysign(sign.0[lane]),
        ))
    }

    #[inline(always)]
    fn lt(self, other: Self) -> MaskLanes {
        MaskLanes(lanes(
            #[inline(always)]
            |lane| filled(self.0[lane] < other.0[lane]),
        ))
    }

    #[inline(always)]
    fn le(self, other: Self) -> MaskLanes {
        MaskLanes(lanes(
            #[inline(always)]
            |lane| filled(self.0[lane] <= other.0[lane]),
        ))
    }

    #[inline(always)]
    fn eq(self, other: Self) -> MaskLanes {
        MaskLanes(lanes(
            #[inline(always)]
            |lane| filled(self.0[lane] == other.0[lane]),
        ))
    }

    #[inline(always)]
    fn select(mask: MaskLanes, a: Self, b: Self) -> Self {
        Self(lanes(
            #[inline(always)]
            |lane| if mask.0[lane] != 0 { a.0[lane] } else { b.0[lane] },
        ))
    }
}

impl Float64 for FloatLanes {
    type Bits = BitLanes;

    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self(lanes(
            #[inline(always)]
            |lane| f(self.0[lane]),
        ))
    }

    #[inline(always)]
    fn map2(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self(lanes(
            #[inline(always)]
            |lane| f(self.0[lane], other.0[lane]),
        ))
    }

    #[inline(always)]
    fn to_bits(self) -> BitLanes {
        BitLanes(lanes(
            #[inline(always)]
            |lane| self.0[lane].to_bits(),
        ))
    }

    #[inline(always)]
    fn from_bits(bits: BitLanes) -> Self {
        Self(lanes(
            #[inline(always)]
            |lane| f64::from_bits(bits.0[lane]),
        ))
    }
}
