//! Numbers of computations that are written once, for one number or for several in SIMD lanes.

use core::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Shl, Shr, Sub};

/// A real number, or several in SIMD lanes that do not affect each other.
///
/// All operations are exact or correctly rounded, as IEEE 754 specifies. A computation thus gives the same bits for one `f64` as for
/// `f64` lanes of any width. Only the bits of a NaN may differ, its sign included: `copysign` must not take the sign of one.
/// Comparisons with NaN are false.
///
/// ```
/// use rt_math::Real;
///
/// fn length<R: Real>([x, y]: [R; 2]) -> R {
///     (x * x + y * y).sqrt()
/// }
/// assert_eq!(length([3.0, 4.0]), 5.0);
/// ```
pub trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
{
    /// Result of a comparison: one truth value per lane.
    type Mask: Mask;

    /// Largest finite number of the type.
    const MAX: f64;

    /// The number `x` in all lanes, rounded to the type.
    fn splat(self, x: f64) -> Self;

    /// Square root, correctly rounded; NaN below 0.
    fn sqrt(self) -> Self;

    /// Absolute value.
    fn abs(self) -> Self;

    /// Absolute value of `self` with the sign of `sign`, also for zeros.
    fn copysign(self, sign: Self) -> Self;

    /// `self < other`.
    fn lt(self, other: Self) -> Self::Mask;

    /// `self <= other`.
    fn le(self, other: Self) -> Self::Mask;

    /// `self == other`; true for zeros of different signs.
    fn eq(self, other: Self) -> Self::Mask;

    /// `a` where the mask is true, `b` elsewhere.
    fn select(mask: Self::Mask, a: Self, b: Self) -> Self;

    /// `self > other`.
    #[inline(always)]
    fn gt(self, other: Self) -> Self::Mask {
        other.lt(self)
    }

    /// `self >= other`.
    #[inline(always)]
    fn ge(self, other: Self) -> Self::Mask {
        other.le(self)
    }

    /// The greater number; `self` if they are equal, and if one is NaN.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self::select(self.lt(other), other, self)
    }

    /// The smaller number; `self` if they are equal, and if one is NaN.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self::select(other.lt(self), other, self)
    }

    /// Quotient of 1 and the number.
    #[inline(always)]
    fn recip(self) -> Self {
        self.splat(1.0) / self
    }
}

/// An `f64`, or several in SIMD lanes, with access to the bits: the type of elementary functions.
pub trait Float64: Real {
    /// Representation of the number, as an unsigned integer of 64 bits per lane. Additions must not overflow.
    type Bits: Copy
        + Add<u64, Output = Self::Bits>
        + BitAnd<u64, Output = Self::Bits>
        + BitXor<Output = Self::Bits>
        + Shl<u32, Output = Self::Bits>
        + Shr<u32, Output = Self::Bits>;

    /// True for a type that holds one number. Large functions are then called instead of inlined.
    const IS_SCALAR: bool = false;

    /// A function of each lane by itself.
    fn map(self, f: impl Fn(f64) -> f64) -> Self;

    /// A function of each lane of two numbers.
    fn map2(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self;

    /// Representation in the format binary64 of IEEE 754.
    fn to_bits(self) -> Self::Bits;

    /// Number of this representation.
    fn from_bits(bits: Self::Bits) -> Self;
}

/// Truth values of lanes.
pub trait Mask: Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> {
    /// True if any lane is.
    fn any(self) -> bool;

    /// True if all lanes are.
    #[inline(always)]
    fn all(self) -> bool {
        !(!self).any()
    }
}

impl Mask for bool {
    #[inline(always)]
    fn any(self) -> bool {
        self
    }
}

impl Real for f64 {
    type Mask = bool;

    const MAX: f64 = Self::MAX;

    #[inline(always)]
    fn splat(self, x: f64) -> Self {
        x
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self::abs(self)
    }

    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        Self::copysign(self, sign)
    }

    #[inline(always)]
    fn lt(self, other: Self) -> bool {
        self < other
    }

    #[inline(always)]
    fn le(self, other: Self) -> bool {
        self <= other
    }

    #[inline(always)]
    fn eq(self, other: Self) -> bool {
        self == other
    }

    #[inline(always)]
    fn select(mask: bool, a: Self, b: Self) -> Self {
        core::hint::select_unpredictable(mask, a, b)
    }
}

impl Float64 for f64 {
    type Bits = u64;

    const IS_SCALAR: bool = true;

    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        f(self)
    }

    #[inline(always)]
    fn map2(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        f(self, other)
    }

    #[inline(always)]
    fn to_bits(self) -> u64 {
        Self::to_bits(self)
    }

    #[inline(always)]
    fn from_bits(bits: u64) -> Self {
        Self::from_bits(bits)
    }
}

/// One `f32` as a [`Real`] number.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct F32(pub f32);

impl From<F32> for f64 {
    #[inline(always)]
    fn from(x: F32) -> Self {
        Self::from(x.0)
    }
}

/// Implements operators of [`F32`] by those of `f32`.
macro_rules! f32_operators {
    ($($trait:ident $function:ident),*) => {$(
        impl $trait for F32 {
            type Output = Self;

            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                Self(self.0.$function(other.0))
            }
        }
    )*};
}

/// Implements operators of [`F32`] with a number that is rounded first.
macro_rules! f32_operators_with_f64 {
    ($($trait:ident $function:ident),*) => {$(
        impl $trait<f64> for F32 {
            type Output = Self;

            #[inline(always)]
            fn $function(self, other: f64) -> Self {
                Self(self.0.$function(other as f32))
            }
        }
    )*};
}

f32_operators!(Add add, Sub sub, Mul mul, Div div);
f32_operators_with_f64!(Add add, Sub sub, Mul mul);

impl Neg for F32 {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Real for F32 {
    type Mask = bool;

    const MAX: f64 = f32::MAX as f64;

    #[inline(always)]
    fn splat(self, x: f64) -> Self {
        Self(x as f32)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs())
    }

    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        Self(self.0.copysign(sign.0))
    }

    #[inline(always)]
    fn lt(self, other: Self) -> bool {
        self.0 < other.0
    }

    #[inline(always)]
    fn le(self, other: Self) -> bool {
        self.0 <= other.0
    }

    #[inline(always)]
    fn eq(self, other: Self) -> bool {
        self.0 == other.0
    }

    #[inline(always)]
    fn select(mask: bool, a: Self, b: Self) -> Self {
        core::hint::select_unpredictable(mask, a, b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comparisons_with_nan_are_false_and_keep_self() {
        let nan = f64::NAN;
        assert!(
            !(Real::lt(nan, 1.0) | Real::le(nan, 1.0) | Real::gt(nan, 1.0) | Real::ge(nan, 1.0) | Real::eq(nan, nan))
        );
        assert_eq!((Real::max(1.0, nan), Real::min(1.0, nan)), (1.0, 1.0));
        assert!(Real::max(nan, 1.0).is_nan() && Real::min(nan, 1.0).is_nan());
    }

    #[test]
    fn zeros_are_equal() {
        assert_eq!(Real::max(-0.0f64, 0.0).to_bits(), (-0.0f64).to_bits());
        assert_eq!(Real::min(0.0, -0.0).to_bits(), 0.0f64.to_bits());
    }
}
