//! Eight `f64`, or eight `f32`, in SIMD lanes, behind types of our own. `lane_set.rs` pairs both.
//!
//! Code in lanes is generic over [`Real`]. It must be `#[inline(always)]` up to the `vectorize` around a stage: only inlined code is
//! compiled for the instruction set. Closures of `array::map` and `array::from_fn` are not inlined, so that loops are written out.

use core::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Shl, Shr, Sub};
pub(crate) use fearless_simd::Simd;
use fearless_simd::{
    ExtractToken, Select, SimdBase, SimdFloat, SimdFrom, SimdMask, f32x8, f64x8, mask32x8, mask64x8, u64x8,
};
use rt_math::{DVec3, Float64, Mask, Real, Vector3};

pub(crate) const LANES: usize = 8;

/// Mask of bits with all lanes.
pub(crate) const ALL_LANES: u8 = !0;

/// Mask of bits with the first `count` lanes.
#[inline(always)]
pub(crate) const fn first_lanes(count: usize) -> u8 {
    ((1 << count) - 1) as u8
}

/// One number per lane, in memory.
pub(crate) type LaneArray = [f64; LANES];

/// Instruction set for code in lanes. The results are the same at all levels.
#[derive(Clone, Copy, Debug)]
pub struct LaneLevel(pub(crate) LaneToken);

/// Proof that the processor has the instructions of a level.
#[derive(Clone, Copy, Debug)]
pub(crate) enum LaneToken {
    #[cfg(target_arch = "x86_64")]
    Avx2(fearless_simd::Avx2),
    /// AVX-512 of Ice Lake and later processors.
    #[cfg(target_arch = "x86_64")]
    Avx512(fearless_simd::Avx512),
}

impl LaneLevel {
    /// AVX-512 or AVX2, whatever this processor has; `None` without AVX2.
    pub fn best() -> Option<Self> {
        #[cfg(target_arch = "x86_64")]
        if let Some(avx512) = fearless_simd::Level::new().as_avx512() {
            return Some(Self(LaneToken::Avx512(avx512)));
        }
        Self::avx2()
    }

    /// AVX2; `None` if this processor lacks it.
    pub fn avx2() -> Option<Self> {
        #[cfg(target_arch = "x86_64")]
        return fearless_simd::Level::new().as_avx2().map(|avx2| Self(LaneToken::Avx2(avx2)));
        #[cfg(not(target_arch = "x86_64"))]
        None
    }
}

/// Evaluates an expression with the token `$simd` of a level.
macro_rules! dispatch {
    ($level:expr, $simd:ident => $body:expr) => {
        match $level.0 {
            #[cfg(target_arch = "x86_64")]
            $crate::lanes::LaneToken::Avx2($simd) => $body,
            #[cfg(target_arch = "x86_64")]
            $crate::lanes::LaneToken::Avx512($simd) => $body,
        }
    };
}

pub(crate) use dispatch;

/// Bits of eight numbers in registers.
#[derive(Clone, Copy)]
pub(crate) struct LaneBits<S: Simd>(u64x8<S>);

impl<S: Simd> Lanes<S> {
    /// Largest integers that are not greater.
    #[inline(always)]
    pub(crate) fn floor(self) -> Self {
        Self(self.0.floor())
    }

    #[inline(always)]
    pub(crate) fn store_vector(v: Vector3<Self>) -> Vector3<LaneArray> {
        Vector3::new(v.x.store(), v.y.store(), v.z.store())
    }
}

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

/// Implements an operator with the same `f64`, rounded to the type of the lanes, in all lanes.
macro_rules! with_rounded_number {
    ($type:ident, $trait:ident, $function:ident, $number:ident) => {
        impl<S: Simd> $trait<f64> for $type<S> {
            type Output = Self;

            #[inline(always)]
            fn $function(self, other: f64) -> Self {
                Self(self.0.$function(other as $number))
            }
        }
    };
}

/// Implements an operator with the same number in all lanes.
macro_rules! with_number {
    ($type:ident, $trait:ident, $function:ident, $number:ident) => {
        impl<S: Simd> $trait<$number> for $type<S> {
            type Output = Self;

            #[inline(always)]
            fn $function(self, other: $number) -> Self {
                Self(self.0.$function(other))
            }
        }
    };
}

binary!(LaneBits, BitXor, bitxor);
with_number!(LaneBits, Add, add, u64);
with_number!(LaneBits, BitAnd, bitand, u64);
with_number!(LaneBits, Shl, shl, u32);
with_number!(LaneBits, Shr, shr, u32);

/// Defines numbers in registers, with their masks.
macro_rules! lanes {
    ($(#[$doc:meta])* $lanes:ident($vector:ident of $number:ident), $(#[$mask_doc:meta])* $mask:ident($mask_vector:ident)) => {
        $(#[$doc])*
        #[derive(Clone, Copy)]
        pub(crate) struct $lanes<S: Simd>(pub(crate) $vector<S>);

        $(#[$mask_doc])*
        #[derive(Clone, Copy)]
        pub(crate) struct $mask<S: Simd>(pub(crate) $mask_vector<S>);

        binary!($lanes, Add, add);
        binary!($lanes, Sub, sub);
        binary!($lanes, Mul, mul);
        binary!($lanes, Div, div);
        binary!($mask, BitAnd, bitand);
        binary!($mask, BitOr, bitor);
        with_rounded_number!($lanes, Add, add, $number);
        with_rounded_number!($lanes, Sub, sub, $number);
        with_rounded_number!($lanes, Mul, mul, $number);

        impl<S: Simd> $lanes<S> {
            #[inline(always)]
            pub(crate) fn splat(simd: S, x: f64) -> Self {
                Self($vector::splat(simd, x as $number))
            }

            #[inline(always)]
            pub(crate) fn load(simd: S, from: &[$number; LANES]) -> Self {
                Self($vector::simd_from(simd, *from))
            }

            #[inline(always)]
            pub(crate) fn store(self) -> [$number; LANES] {
                self.0.into()
            }
        }

        impl<S: Simd> $mask<S> {
            /// Lane `i` is bit `i`.
            #[inline(always)]
            pub(crate) fn from_bits(simd: S, bits: u8) -> Self {
                Self($mask_vector::from_bitmask(simd, u64::from(bits)))
            }

            /// Bit `i` is the value of lane `i`.
            #[inline(always)]
            pub(crate) fn bits(self) -> u8 {
                self.0.to_bitmask() as u8
            }
        }

        impl<S: Simd> Neg for $lanes<S> {
            type Output = Self;

            #[inline(always)]
            fn neg(self) -> Self {
                Self(-self.0)
            }
        }

        impl<S: Simd> Not for $mask<S> {
            type Output = Self;

            #[inline(always)]
            fn not(self) -> Self {
                Self(!self.0)
            }
        }

        impl<S: Simd> Mask for $mask<S> {
            #[inline(always)]
            fn any(self) -> bool {
                self.0.any_true()
            }

            #[inline(always)]
            fn all(self) -> bool {
                self.0.all_true()
            }
        }

        impl<S: Simd> Real for $lanes<S> {
            type Mask = $mask<S>;

            const MAX: f64 = $number::MAX as f64;

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
            fn copysign(self, sign: Self) -> Self {
                Self(self.0.copysign(sign.0))
            }

            #[inline(always)]
            fn lt(self, other: Self) -> $mask<S> {
                $mask(self.0.simd_lt(other.0))
            }

            #[inline(always)]
            fn le(self, other: Self) -> $mask<S> {
                $mask(self.0.simd_le(other.0))
            }

            #[inline(always)]
            fn eq(self, other: Self) -> $mask<S> {
                $mask(self.0.simd_eq(other.0))
            }

            #[inline(always)]
            fn select(mask: $mask<S>, a: Self, b: Self) -> Self {
                Self(mask.0.select(a.0, b.0))
            }
        }
    };
}

lanes!(
    /// Eight `f64` in registers.
    Lanes(f64x8 of f64),
    /// Eight truth values of `f64` in registers.
    LaneMask(mask64x8)
);
lanes!(
    /// Eight `f32` in registers.
    Lanes32(f32x8 of f32),
    /// Eight truth values of `f32` in registers.
    LaneMask32(mask32x8)
);

impl<S: Simd> Float64 for Lanes<S> {
    type Bits = LaneBits<S>;

    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        let [a, b, c, d, e, g, h, i] = self.store();
        Self::load(self.0.token(), &[f(a), f(b), f(c), f(d), f(e), f(g), f(h), f(i)])
    }

    #[inline(always)]
    fn map2(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let (mut numbers, other) = (self.store(), other.store());
        for (number, other) in numbers.iter_mut().zip(other) {
            *number = f(*number, other);
        }
        Self::load(self.0.token(), &numbers)
    }

    #[inline(always)]
    fn to_bits(self) -> LaneBits<S> {
        LaneBits(self.0.to_bits())
    }

    #[inline(always)]
    fn from_bits(bits: LaneBits<S>) -> Self {
        Self(f64x8::from_bits(bits.0))
    }
}

/// Indices of the lanes in a mask of bits, ascending.
#[inline(always)]
pub(crate) const fn each_lane(mask: u8) -> LaneIndices {
    LaneIndices(mask)
}

/// Indices of the lanes in a mask of bits.
pub(crate) struct LaneIndices(u8);

impl Iterator for LaneIndices {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        let lane = self.0.trailing_zeros() as usize;
        self.0 &= self.0.wrapping_sub(1);
        (lane < LANES).then_some(lane)
    }
}

/// Vector of one lane.
#[inline(always)]
pub(crate) fn get(lanes: &Vector3<LaneArray>, lane: usize) -> DVec3 {
    DVec3::new(lanes.x[lane], lanes.y[lane], lanes.z[lane])
}

/// True where all coordinates are zero.
#[inline(always)]
pub(crate) fn is_zero<R: Real>(v: Vector3<R>) -> R::Mask {
    let zero = v.x.splat(0.0);
    v.x.eq(zero) & v.y.eq(zero) & v.z.eq(zero)
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use super::*;
    use rt_math::{
        random::hash,
        transcendental::{acos, asin, atan2, cos, exp, exp2, log, log2, pow, sin, sincos},
    };

    /// Numbers of all sizes and signs, and special ones.
    fn numbers() -> impl Iterator<Item = f64> {
        let special = [0.0, -0.0, 1.0, -1.0, 0.5, 1e-320, f64::MAX, f64::INFINITY, f64::NEG_INFINITY, f64::NAN];
        let usual = (0..2000).map(|i| (hash(&[3, i]) >> 11) as f64 / 1e15 - 4.5);
        let any = (0..2000).map(|i| f64::from_bits(hash(&[4, i])));
        special.into_iter().chain(usual).chain(any)
    }

    fn assert_lanes_equal_scalars<S: Simd>(
        simd: S,
        name: &str,
        in_lanes: impl Fn(Lanes<S>, Lanes<S>) -> Lanes<S>,
        by_itself: impl Fn(f64, f64) -> f64,
    ) {
        let all: Vec<f64> = numbers().collect();
        for (at, a) in all.chunks_exact(LANES).enumerate() {
            let a: LaneArray = a.try_into().expect("four numbers");
            let b: LaneArray = core::array::from_fn(|lane| all[(at * 97 + lane * 31) % all.len()]);
            let found = in_lanes(Lanes::load(simd, &a), Lanes::load(simd, &b)).store();
            for lane in 0..LANES {
                let (x, y) = (a[lane], b[lane]);
                let expected = by_itself(x, y);
                let is_equal =
                    found[lane].to_bits() == expected.to_bits() || (found[lane].is_nan() && expected.is_nan());
                assert!(is_equal, "{name} of {x:e}, {y:e}: {} in lanes, {expected} by itself", found[lane]);
            }
        }
    }

    /// Asserts that a generic computation has the same bits in lanes and by itself.
    macro_rules! assert_same {
        ($simd:expr, $($name:literal: |$a:ident, $b:ident| $body:expr;)*) => {$({
            fn compute<R: Float64>($a: R, $b: R) -> R {
                let _ = ($a, $b);
                $body
            }
            assert_lanes_equal_scalars($simd, $name, |a, b| compute(a, b), |a, b| compute(a, b));
        })*};
    }

    #[test]
    fn computations_in_lanes_have_the_bits_of_those_by_themselves() {
        let levels = [LaneLevel::avx2(), LaneLevel::best()];
        if levels[0].is_none() {
            println!("skipped: this processor lacks AVX2");
        }
        for level in levels.into_iter().flatten() {
            dispatch!(level, simd => assert_same_bits(simd));
        }
    }

    fn assert_same_bits<S: Simd>(simd: S) {
        assert_same! { simd,
            "sum": |a, b| a + b * 0.5 - (a - 0.25);
            "product": |a, b| a * b;
            "quotient": |a, b| a / b;
            "square root": |a, b| a.sqrt();
            "absolute value": |a, b| -(a.abs());
            "sign": |a, b| a.copysign(b);
            "maximum": |a, b| a.max(b);
            "minimum": |a, b| a.min(b);
            "selection": |a, b| R::select((a.lt(b) & !a.eq(b)) | b.ge(a.splat(1.0)), a, b.recip());
            "function of lanes": |a, b| a.map(|x| x * 3.0).map2(b, |x, y| x - y);
            "bits": |a, b| R::from_bits(a.to_bits() ^ (b.to_bits() >> 3));
            "sin": |a, b| sin(a);
            "cos": |a, b| cos(a);
            "sincos": |a, b| { let (sin, cos) = sincos(a); sin + cos * 2.0 };
            "atan2": |a, b| atan2(a, b);
            "acos": |a, b| acos(a);
            "asin": |a, b| asin(a);
            "exp": |a, b| exp(a);
            "exp2": |a, b| exp2(a);
            "log": |a, b| log(a);
            "log2": |a, b| log2(a);
            "pow": |a, b| pow(a, b);
        }
    }
}
