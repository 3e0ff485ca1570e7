//! Four `f64` in SIMD lanes, behind types of our own. No other file uses `fearless_simd`.
//!
//! Code in lanes is generic over [`Real`]. All of it is `#[inline(always)]`, up to the `vectorize` that encloses a whole stage, so that it
//! is compiled for the instruction set. `map` and `from_fn` of arrays are not: their closures would be compiled without it.

use core::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};
use fearless_simd::{
    ExtractToken, Select, Simd, SimdBase, SimdFloat, SimdFrom, SimdMask, f64x4, i64x4, mask64x4, u64x4,
};
use rt_math::{Mask, Real, Vector3};

/// Number of lanes.
pub(crate) const LANES: usize = 4;

/// Numbers of all lanes in memory.
pub(crate) type Lane = [f64; LANES];

/// Instruction set for code in lanes.
#[derive(Clone, Copy, Debug)]
pub(crate) enum LaneLevel {
    /// AVX2.
    #[cfg(target_arch = "x86_64")]
    Avx2(fearless_simd::Avx2),
}

impl LaneLevel {
    /// Level of this processor; `None` if scalar code is faster there.
    pub(crate) fn detect() -> Option<Self> {
        #[cfg(target_arch = "x86_64")]
        return fearless_simd::Level::new().as_avx2().map(Self::Avx2);
        #[cfg(not(target_arch = "x86_64"))]
        None
    }
}

/// Four numbers in registers.
pub(crate) struct Lanes<S: Simd>(f64x4<S>);

/// Four truth values in registers.
///
/// All bits of a lane are equal. Vectors of integers combine faster than masks in builds with debug assertions.
pub(crate) struct LaneMask<S: Simd>(i64x4<S>);

impl<S: Simd> LaneMask<S> {
    #[inline(always)]
    fn new(mask: mask64x4<S>) -> Self {
        Self(mask.to_vector())
    }

    #[inline(always)]
    fn mask(self) -> mask64x4<S> {
        mask64x4::from_vector(self.0)
    }
}

impl<S: Simd> Lanes<S> {
    #[inline(always)]
    pub(crate) fn splat(simd: S, x: f64) -> Self {
        Self(f64x4::splat(simd, x))
    }

    #[inline(always)]
    pub(crate) fn load(simd: S, lane: &Lane) -> Self {
        Self(f64x4::simd_from(simd, *lane))
    }

    #[inline(always)]
    pub(crate) fn load_vector(simd: S, lanes: &Vector3<Lane>) -> Vector3<Self> {
        Vector3::new(Self::load(simd, &lanes.x), Self::load(simd, &lanes.y), Self::load(simd, &lanes.z))
    }

    #[inline(always)]
    pub(crate) fn store(self) -> Lane {
        self.0.into()
    }

    #[inline(always)]
    pub(crate) fn store_vector(v: Vector3<Self>) -> Vector3<Lane> {
        Vector3::new(v.x.store(), v.y.store(), v.z.store())
    }
}

impl<S: Simd> LaneMask<S> {
    /// Bit `i` is the value of lane `i`.
    #[inline(always)]
    pub(crate) fn bits(self) -> u8 {
        self.mask().to_bitmask() as u8
    }
}

impl<S: Simd> Clone for Lanes<S> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<S: Simd> Copy for Lanes<S> {}

impl<S: Simd> Clone for LaneMask<S> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<S: Simd> Copy for LaneMask<S> {}

/// Implements a binary operator of a wrapper by that of its content.
macro_rules! binary {
    ($type:ident, $trait:ident, $function:ident) => {
        impl<S: Simd> $trait for $type<S> {
            type Output = Self;

            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                Self(self.0.$function(other.0))
            }
        }
    };
}

/// Implements an operator with the same number in all lanes.
macro_rules! with_number {
    ($trait:ident, $function:ident) => {
        impl<S: Simd> $trait<f64> for Lanes<S> {
            type Output = Self;

            #[inline(always)]
            fn $function(self, other: f64) -> Self {
                Self(self.0.$function(other))
            }
        }
    };
}

binary!(Lanes, Add, add);
binary!(Lanes, Sub, sub);
binary!(Lanes, Mul, mul);
binary!(Lanes, Div, div);
with_number!(Add, add);
with_number!(Sub, sub);
with_number!(Mul, mul);
binary!(LaneMask, BitAnd, bitand);
binary!(LaneMask, BitOr, bitor);

impl<S: Simd> Neg for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl<S: Simd> Not for LaneMask<S> {
    type Output = Self;

    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
    }
}

impl<S: Simd> Mask for LaneMask<S> {
    #[inline(always)]
    fn any(self) -> bool {
        self.mask().any_true()
    }

    #[inline(always)]
    fn all(self) -> bool {
        self.mask().all_true()
    }
}

impl<S: Simd> Real for Lanes<S> {
    type Mask = LaneMask<S>;
    type Bits = u64x4<S>;

    #[inline(always)]
    fn splat(self, x: f64) -> Self {
        Self::splat(self.0.token(), x)
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
    fn floor(self) -> Self {
        Self(self.0.floor())
    }

    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        Self(self.0.copysign(sign.0))
    }

    #[inline(always)]
    fn lt(self, other: Self) -> LaneMask<S> {
        LaneMask::new(self.0.simd_lt(other.0))
    }

    #[inline(always)]
    fn le(self, other: Self) -> LaneMask<S> {
        LaneMask::new(self.0.simd_le(other.0))
    }

    #[inline(always)]
    fn eq(self, other: Self) -> LaneMask<S> {
        LaneMask::new(self.0.simd_eq(other.0))
    }

    #[inline(always)]
    fn select(mask: LaneMask<S>, a: Self, b: Self) -> Self {
        Self(mask.mask().select(a.0, b.0))
    }

    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        let [a, b, c, d] = self.store();
        Self::load(self.0.token(), &[f(a), f(b), f(c), f(d)])
    }

    #[inline(always)]
    fn map2(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let ([a, b, c, d], [e, g, h, i]) = (self.store(), other.store());
        Self::load(self.0.token(), &[f(a, e), f(b, g), f(c, h), f(d, i)])
    }

    #[inline(always)]
    fn to_bits(self) -> u64x4<S> {
        self.0.to_bits()
    }

    #[inline(always)]
    fn from_bits(bits: u64x4<S>) -> Self {
        Self(f64x4::from_bits(bits))
    }
}
