//! Lanes with two types of numbers: `f32` for shading, and `f64` for positions.
//!
//! ```text
//!   SimdLanes   eight in registers, AVX2 or AVX-512
//!   OneLane     one: any processor
//!   Float64Lane one, with `f64` for shading as well: the reference of tests
//! ```

use crate::lanes::{LaneMask, Lanes, Simd};
use core::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};
use fearless_simd::{ExtractToken, Select, SimdBase, SimdFloat, SimdFrom, SimdMask, f32x8, f64x8, mask32x8, u32x8};
use rt_geometry::StreamArray;
use rt_math::{DVec3, F32, Float64, Mask, Real, Rgb, Vector3, transcendental::Pow};

/// Lanes that shade hits.
///
/// Masks of bits have bit `i` for lane `i`. Arrays hold the numbers of eight lanes, whatever the number of lanes.
pub(crate) trait LaneSet: Copy {
    /// Number of lanes.
    const N: usize;

    /// Numbers for shading: directions, reflectances and radiance.
    type F: Pow;

    /// Numbers for positions.
    type D: Float64;

    /// Element of [`F`](Self::F) in memory.
    type Element: Copy + Default + Into<f64>;

    /// The same number for shading in all lanes.
    fn splat(self, x: f64) -> Self::F;

    /// The same number for positions in all lanes.
    fn splat_f64(self, x: f64) -> Self::D;

    fn load(self, from: &[Self::Element; 8]) -> Self::F;

    fn load_f64(self, from: &[f64; 8]) -> Self::D;

    fn store(self, x: Self::F, to: &mut [Self::Element; 8]);

    fn store_f64(self, x: Self::D, to: &mut [f64; 8]);

    fn widen(self, x: Self::F) -> Self::D;

    /// Rounds to the numbers for shading.
    fn narrow(self, x: Self::D) -> Self::F;

    fn bits(self, mask: <Self::F as Real>::Mask) -> u8;

    fn bits_f64(self, mask: <Self::D as Real>::Mask) -> u8;

    fn mask(self, bits: u8) -> <Self::F as Real>::Mask;

    /// Stores the lanes of a mask, one after the other; what is behind them is overwritten.
    fn compress(self, x: Self::F, mask: u8, to: &mut [Self::Element; 8]);

    /// Version of [`compress`](Self::compress) for positions.
    fn compress_f64(self, x: Self::D, mask: u8, to: &mut [f64; 8]);

    /// Version of [`compress`](Self::compress) for integers in memory.
    fn compress_u32(self, from: &[u32; 8], mask: u8, to: &mut [u32; 8]);

    /// Largest integers that are not greater.
    fn floor_f64(self, x: Self::D) -> Self::D;

    /// Element of a number, rounded.
    fn element(self, x: f64) -> Self::Element;

    /// Lanes in which an index equals `index`.
    fn equal(self, indices: &[u32; 8], index: u32) -> u8;

    /// Stores points.
    #[inline(always)]
    fn store_point(self, p: Vector3<Self::D>) -> [[f64; 8]; 3] {
        let mut numbers = [[0.0; 8]; 3];
        let [x, y, z] = &mut numbers;
        self.store_f64(p.x, x);
        self.store_f64(p.y, y);
        self.store_f64(p.z, z);
        numbers
    }

    /// Stores vectors.
    #[inline(always)]
    fn store_vector(self, v: Vector3<Self::F>) -> [[Self::Element; 8]; 3] {
        let mut numbers = [[Self::Element::default(); 8]; 3];
        let [x, y, z] = &mut numbers;
        self.store(v.x, x);
        self.store(v.y, y);
        self.store(v.z, z);
        numbers
    }

    /// The same vector for positions in all lanes.
    #[inline(always)]
    fn splat_point(self, p: DVec3) -> Vector3<Self::D> {
        Vector3::splat(self.splat_f64(0.0), p)
    }

    /// The same colour in all lanes.
    #[inline(always)]
    fn splat_rgb(self, Rgb { r, g, b }: Rgb) -> Vector3<Self::F> {
        Vector3::new(self.splat(r), self.splat(g), self.splat(b))
    }

    #[inline(always)]
    fn narrow_vector(self, v: Vector3<Self::D>) -> Vector3<Self::F> {
        Vector3::new(self.narrow(v.x), self.narrow(v.y), self.narrow(v.z))
    }

    #[inline(always)]
    fn widen_vector(self, v: Vector3<Self::F>) -> Vector3<Self::D> {
        Vector3::new(self.widen(v.x), self.widen(v.y), self.widen(v.z))
    }

    /// Vectors from the index `at` of three arrays on.
    #[inline(always)]
    fn load_vector(self, [x, y, z]: &[StreamArray<Self::Element>; 3], at: usize) -> Vector3<Self::F> {
        Vector3::new(self.load(x.vector(at)), self.load(y.vector(at)), self.load(z.vector(at)))
    }

    /// Points from the index `at` of three arrays on.
    #[inline(always)]
    fn load_point(self, [x, y, z]: &[StreamArray<f64>; 3], at: usize) -> Vector3<Self::D> {
        Vector3::new(self.load_f64(x.vector(at)), self.load_f64(y.vector(at)), self.load_f64(z.vector(at)))
    }

    /// Version of [`compress`](Self::compress) for vectors, to the index `at` of three arrays.
    #[inline(always)]
    fn compress_vector(
        self,
        v: Vector3<Self::F>,
        mask: u8,
        [x, y, z]: &mut [StreamArray<Self::Element>; 3],
        at: usize,
    ) {
        self.compress(v.x, mask, x.vector_mut(at));
        self.compress(v.y, mask, y.vector_mut(at));
        self.compress(v.z, mask, z.vector_mut(at));
    }

    /// Version of [`compress`](Self::compress) for points, to the index `at` of three arrays.
    #[inline(always)]
    fn compress_point(self, p: Vector3<Self::D>, mask: u8, [x, y, z]: &mut [StreamArray<f64>; 3], at: usize) {
        self.compress_f64(p.x, mask, x.vector_mut(at));
        self.compress_f64(p.y, mask, y.vector_mut(at));
        self.compress_f64(p.z, mask, z.vector_mut(at));
    }
}

/// One lane of these types.
macro_rules! one_lane {
    ($(#[$doc:meta])* $name:ident, $number:ty, $element:ty, |$x:ident| $from_f64:expr, $number_of:expr, $element_of:expr, $to_f64:expr) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug)]
        pub(crate) struct $name;

        impl LaneSet for $name {
            const N: usize = 1;

            type F = $number;
            type D = f64;
            type Element = $element;

            #[inline(always)]
            fn splat(self, $x: f64) -> $number {
                $from_f64
            }

            #[inline(always)]
            fn splat_f64(self, x: f64) -> f64 {
                x
            }

            #[inline(always)]
            fn load(self, from: &[$element; 8]) -> $number {
                $number_of(from[0])
            }

            #[inline(always)]
            fn load_f64(self, from: &[f64; 8]) -> f64 {
                from[0]
            }

            #[inline(always)]
            fn store(self, x: $number, to: &mut [$element; 8]) {
                to[0] = $element_of(x);
            }

            #[inline(always)]
            fn store_f64(self, x: f64, to: &mut [f64; 8]) {
                to[0] = x;
            }

            #[inline(always)]
            fn widen(self, x: $number) -> f64 {
                $to_f64(x)
            }

            #[inline(always)]
            fn narrow(self, $x: f64) -> $number {
                $from_f64
            }

            #[inline(always)]
            fn bits(self, mask: bool) -> u8 {
                u8::from(mask)
            }

            #[inline(always)]
            fn bits_f64(self, mask: bool) -> u8 {
                u8::from(mask)
            }

            #[inline(always)]
            fn mask(self, bits: u8) -> bool {
                bits & 1 == 1
            }


            #[inline(always)]
            fn compress(self, x: $number, mask: u8, to: &mut [$element; 8]) {
                if mask & 1 == 1 {
                    to[0] = $element_of(x);
                }
            }

            #[inline(always)]
            fn compress_f64(self, x: f64, mask: u8, to: &mut [f64; 8]) {
                if mask & 1 == 1 {
                    to[0] = x;
                }
            }

            #[inline(always)]
            fn compress_u32(self, from: &[u32; 8], mask: u8, to: &mut [u32; 8]) {
                if mask & 1 == 1 {
                    to[0] = from[0];
                }
            }

            #[inline(always)]
            fn floor_f64(self, x: f64) -> f64 {
                x.floor()
            }

            #[inline(always)]
            fn element(self, $x: f64) -> $element {
                $element_of($from_f64)
            }

            #[inline(always)]
            fn equal(self, indices: &[u32; 8], index: u32) -> u8 {
                u8::from(indices[0] == index)
            }
        }
    };
}

one_lane!(
    /// One hit at a time, with the results of [`SimdLanes`].
    OneLane, F32, f32, |x| F32(x as f32), F32, |x: F32| x.0, |x: F32| f64::from(x.0)
);
#[cfg(test)]
one_lane!(
    /// One hit at a time, shaded in `f64`: the reference.
    Float64Lane, f64, f64, |x| x, |x| x, |x| x, |x| x
);

/// Eight hits in registers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SimdLanes<S: Simd>(pub(crate) S);

/// Eight `f32` in registers.
pub(crate) struct Lanes32<S: Simd>(f32x8<S>);

/// Eight truth values in registers, of `f32`.
pub(crate) struct LaneMask32<S: Simd>(mask32x8<S>);

impl<S: Simd> Clone for Lanes32<S> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<S: Simd> Copy for Lanes32<S> {}

impl<S: Simd> Clone for LaneMask32<S> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<S: Simd> Copy for LaneMask32<S> {}

impl<S: Simd> LaneSet for SimdLanes<S> {
    const N: usize = 8;

    type F = Lanes32<S>;
    type D = Lanes<S>;
    type Element = f32;

    #[inline(always)]
    fn splat(self, x: f64) -> Lanes32<S> {
        Lanes32(f32x8::splat(self.0, x as f32))
    }

    #[inline(always)]
    fn splat_f64(self, x: f64) -> Lanes<S> {
        Lanes::splat(self.0, x)
    }

    #[inline(always)]
    fn load(self, from: &[f32; 8]) -> Lanes32<S> {
        Lanes32(f32x8::simd_from(self.0, *from))
    }

    #[inline(always)]
    fn load_f64(self, from: &[f64; 8]) -> Lanes<S> {
        Lanes(f64x8::simd_from(self.0, *from))
    }

    #[inline(always)]
    fn store(self, x: Lanes32<S>, to: &mut [f32; 8]) {
        *to = x.0.into();
    }

    #[inline(always)]
    fn store_f64(self, x: Lanes<S>, to: &mut [f64; 8]) {
        *to = x.0.into();
    }

    #[inline(always)]
    fn widen(self, x: Lanes32<S>) -> Lanes<S> {
        let (low, high) = self.0.widen_f32x8(x.0);
        Lanes(self.0.combine_f64x4(low, high))
    }

    #[inline(always)]
    fn narrow(self, x: Lanes<S>) -> Lanes32<S> {
        let (low, high) = self.0.split_f64x8(x.0);
        Lanes32(self.0.narrow_f64x4(low, high))
    }

    #[inline(always)]
    fn bits(self, mask: LaneMask32<S>) -> u8 {
        mask.0.to_bitmask() as u8
    }

    #[inline(always)]
    fn bits_f64(self, mask: LaneMask<S>) -> u8 {
        mask.bits()
    }

    #[inline(always)]
    fn mask(self, bits: u8) -> LaneMask32<S> {
        LaneMask32(mask32x8::from_bitmask(self.0, u64::from(bits)))
    }

    #[inline(always)]
    fn compress(self, x: Lanes32<S>, mask: u8, to: &mut [f32; 8]) {
        *to = x.0.compress(mask32x8::from_bitmask(self.0, u64::from(mask))).into();
    }

    #[inline(always)]
    fn compress_f64(self, x: Lanes<S>, mask: u8, to: &mut [f64; 8]) {
        *to = x.0.compress(LaneMask::from_bits(self.0, mask).0).into();
    }

    #[inline(always)]
    fn compress_u32(self, from: &[u32; 8], mask: u8, to: &mut [u32; 8]) {
        let mask = mask32x8::from_bitmask(self.0, u64::from(mask));
        *to = u32x8::simd_from(self.0, *from).compress(mask).into();
    }

    #[inline(always)]
    fn floor_f64(self, x: Lanes<S>) -> Lanes<S> {
        x.floor()
    }

    #[inline(always)]
    fn element(self, x: f64) -> f32 {
        x as f32
    }

    #[inline(always)]
    fn equal(self, indices: &[u32; 8], index: u32) -> u8 {
        u32x8::simd_from(self.0, *indices).simd_eq(u32x8::splat(self.0, index)).to_bitmask() as u8
    }
}

/// Implements a binary operator of a wrapper by that of its content.
macro_rules! binary {
    ($type:ident: $($trait:ident $function:ident),*) => {$(
        impl<S: Simd> $trait for $type<S> {
            type Output = Self;

            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                Self(self.0.$function(other.0))
            }
        }
    )*};
}

/// Implements an operator with the same number, rounded to `f32`, in all lanes.
macro_rules! with_number {
    ($($trait:ident $function:ident),*) => {$(
        impl<S: Simd> $trait<f64> for Lanes32<S> {
            type Output = Self;

            #[inline(always)]
            fn $function(self, other: f64) -> Self {
                Self(self.0.$function(other as f32))
            }
        }
    )*};
}

binary!(Lanes32: Add add, Sub sub, Mul mul, Div div);
binary!(LaneMask32: BitAnd bitand, BitOr bitor);
with_number!(Add add, Sub sub, Mul mul);

impl<S: Simd> Neg for Lanes32<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl<S: Simd> Not for LaneMask32<S> {
    type Output = Self;

    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
    }
}

impl<S: Simd> Mask for LaneMask32<S> {
    #[inline(always)]
    fn any(self) -> bool {
        self.0.any_true()
    }

    #[inline(always)]
    fn all(self) -> bool {
        self.0.all_true()
    }
}

impl<S: Simd> Real for Lanes32<S> {
    type Mask = LaneMask32<S>;

    const MAX: f64 = f32::MAX as f64;

    #[inline(always)]
    fn splat(self, x: f64) -> Self {
        Self(f32x8::splat(self.0.token(), x as f32))
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
    fn lt(self, other: Self) -> LaneMask32<S> {
        LaneMask32(self.0.simd_lt(other.0))
    }

    #[inline(always)]
    fn le(self, other: Self) -> LaneMask32<S> {
        LaneMask32(self.0.simd_le(other.0))
    }

    #[inline(always)]
    fn eq(self, other: Self) -> LaneMask32<S> {
        LaneMask32(self.0.simd_eq(other.0))
    }

    #[inline(always)]
    fn select(mask: LaneMask32<S>, a: Self, b: Self) -> Self {
        Self(mask.0.select(a.0, b.0))
    }
}

impl<S: Simd> Pow for Lanes32<S> {
    #[inline(always)]
    fn powf(self, exponent: f64) -> Self {
        let lanes = SimdLanes(self.0.token());
        lanes.narrow(lanes.widen(self).powf(exponent))
    }
}
