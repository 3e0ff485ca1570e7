//! Arithmetic on eight `f32`, or four `f64`, for kernels that are written once.

use core::mem::MaybeUninit;

/// Lane-wise arithmetic. A value of the type proves that the processor has the instructions.
///
/// Comparisons return a bit for each lane, clear where a number is NaN.
pub(in crate::wide) trait Simd: Copy {
    type F32x8: Copy;
    type F64x4: Copy;
    type F64x8: Copy;

    /// True if a ray takes so few instructions that interleaving rays hides memory latency.
    const INTERLEAVE: bool;
    /// True if [`mul_add`](Self::mul_add) rounds once.
    const FUSED: bool;

    /// Runs a part of a kernel. The portable level calls it, so that all kernels share one copy and the crate builds sooner. Other
    /// levels inline it.
    fn call_part<R>(self, part: impl FnOnce() -> R) -> R;

    fn splat(self, x: f32) -> Self::F32x8;
    fn load(self, from: &[f32; 8]) -> Self::F32x8;
    fn to_array(self, a: Self::F32x8) -> [f32; 8];
    /// Replaces one lane.
    fn insert(self, a: Self::F32x8, lane: usize, by: f32) -> Self::F32x8;
    fn add(self, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8;
    fn sub(self, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8;
    fn mul(self, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8;
    fn div(self, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8;
    fn sqrt(self, a: Self::F32x8) -> Self::F32x8;
    fn abs(self, a: Self::F32x8) -> Self::F32x8;
    /// Minimum; either number where one is NaN.
    fn min(self, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8;
    /// Maximum; either number where one is NaN.
    fn max(self, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8;
    /// `a·b + c`, rounded once or twice.
    fn mul_add(self, a: Self::F32x8, b: Self::F32x8, c: Self::F32x8) -> Self::F32x8;
    /// `a·b − c`, rounded once or twice.
    fn mul_sub(self, a: Self::F32x8, b: Self::F32x8, c: Self::F32x8) -> Self::F32x8;
    /// `c − a·b`, rounded once or twice.
    fn neg_mul_add(self, a: Self::F32x8, b: Self::F32x8, c: Self::F32x8) -> Self::F32x8;
    fn le(self, a: Self::F32x8, b: Self::F32x8) -> u32;
    fn lt(self, a: Self::F32x8, b: Self::F32x8) -> u32;
    /// Bit equality, also of NaNs.
    fn eq_bits(self, a: Self::F32x8, b: Self::F32x8) -> u32;
    /// `a` where the mask has a bit, otherwise `b`.
    fn select(self, mask: u32, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8;
    /// `positive` where `by` is positive or 0, `negative` where it is negative, and either where it is −0.
    fn select_by_sign_f32(self, by: Self::F32x8, positive: Self::F32x8, negative: Self::F32x8) -> Self::F32x8;
    /// Replaces the bits of `mask` by those of `bits`, which has no others.
    fn replace_bits(self, a: Self::F32x8, mask: u32, bits: u32) -> Self::F32x8;
    /// `enter` where it is at most `leave`, otherwise infinity.
    fn or_inf(self, enter: Self::F32x8, leave: Self::F32x8) -> Self::F32x8;
    fn reduce_min(self, a: Self::F32x8) -> f32;
    /// Writes the lanes with `enter ≤ leave` in descending order of `enter`, with their words, and returns their number.
    ///
    /// No `enter` may be negative; it may be written with its last three bits cleared. Entries after the count have no
    /// meaning.
    fn compress_sorted(
        self,
        enter: Self::F32x8,
        leave: Self::F32x8,
        words: &[u32; 8],
        enters: &mut [MaybeUninit<f32>; 8],
        hit: &mut [MaybeUninit<u32>; 8],
    ) -> usize;

    fn f64x4(self, of: [f64; 4]) -> Self::F64x4;
    fn to_f64(self, of: [f32; 4]) -> Self::F64x4;
    /// Rounds to the nearest `f32`.
    fn round_to_f32(self, a: Self::F64x4) -> Self::F64x4;
    fn concat_to_f32(self, low: Self::F64x4, high: Self::F64x4) -> Self::F32x8;
    fn to_f32(self, a: Self::F64x4) -> [f32; 4];
    fn to_f64_array(self, a: Self::F64x4) -> [f64; 4];
    fn add_f64(self, a: Self::F64x4, b: Self::F64x4) -> Self::F64x4;
    fn sub_f64(self, a: Self::F64x4, b: Self::F64x4) -> Self::F64x4;
    fn mul_f64(self, a: Self::F64x4, b: Self::F64x4) -> Self::F64x4;
    fn div_f64(self, a: Self::F64x4, b: Self::F64x4) -> Self::F64x4;
    fn sqrt_f64(self, a: Self::F64x4) -> Self::F64x4;
    fn abs_f64(self, a: Self::F64x4) -> Self::F64x4;
    /// `a` where `a < b`, otherwise `b`, also where one is NaN.
    fn min_f64(self, a: Self::F64x4, b: Self::F64x4) -> Self::F64x4;
    /// `a` where `a > b`, otherwise `b`, also where one is NaN.
    fn max_f64(self, a: Self::F64x4, b: Self::F64x4) -> Self::F64x4;
    /// `negative` where the sign bit of `by` is set, otherwise `positive`.
    fn select_by_sign(self, by: Self::F64x4, positive: Self::F64x4, negative: Self::F64x4) -> Self::F64x4;
    /// `a` where the mask has a bit, otherwise `b`.
    fn select_f64(self, mask: u32, a: Self::F64x4, b: Self::F64x4) -> Self::F64x4;
    /// Sign bits of the four numbers.
    fn signs(self, a: Self::F64x4) -> u32;
    fn lt_f64(self, a: Self::F64x4, b: Self::F64x4) -> u32;
    fn le_f64(self, a: Self::F64x4, b: Self::F64x4) -> u32;
    fn f64x8(self, of: [f64; 8]) -> Self::F64x8;
    fn to_f64x8(self, of: [f32; 8]) -> Self::F64x8;
    /// Rounds to the nearest `f32`.
    fn narrow_f64x8(self, a: Self::F64x8) -> Self::F32x8;
    /// The first four and the last four numbers.
    fn halves(self, a: Self::F64x8) -> [Self::F64x4; 2];
    fn add_f64x8(self, a: Self::F64x8, b: Self::F64x8) -> Self::F64x8;
    fn sub_f64x8(self, a: Self::F64x8, b: Self::F64x8) -> Self::F64x8;
    fn mul_f64x8(self, a: Self::F64x8, b: Self::F64x8) -> Self::F64x8;
    fn div_f64x8(self, a: Self::F64x8, b: Self::F64x8) -> Self::F64x8;
    fn sqrt_f64x8(self, a: Self::F64x8) -> Self::F64x8;
    fn abs_f64x8(self, a: Self::F64x8) -> Self::F64x8;
    /// See [`min_f64`](Self::min_f64).
    fn min_f64x8(self, a: Self::F64x8, b: Self::F64x8) -> Self::F64x8;
    /// See [`max_f64`](Self::max_f64).
    fn max_f64x8(self, a: Self::F64x8, b: Self::F64x8) -> Self::F64x8;
    /// See [`select_by_sign`](Self::select_by_sign).
    fn select_by_sign_f64x8(self, by: Self::F64x8, positive: Self::F64x8, negative: Self::F64x8) -> Self::F64x8;
    /// See [`select_f64`](Self::select_f64).
    fn select_f64x8(self, mask: u32, a: Self::F64x8, b: Self::F64x8) -> Self::F64x8;
    /// Sign bits of the eight numbers.
    fn signs_f64x8(self, a: Self::F64x8) -> u32;
    fn lt_f64x8(self, a: Self::F64x8, b: Self::F64x8) -> u32;
    fn le_f64x8(self, a: Self::F64x8, b: Self::F64x8) -> u32;

    /// The first three numbers in the order 1, 2, 0.
    fn yzx(self, a: Self::F64x4) -> Self::F64x4;
    /// The first three numbers in the order 2, 0, 1.
    fn zxy(self, a: Self::F64x4) -> Self::F64x4;
    /// Axis of the maximum of the first three; [`WatertightRay`](rt_geometry::WatertightRay) breaks ties in the same
    /// way.
    fn max_axis(self, a: Self::F64x4) -> usize;
    /// Rotates the first three cyclically until this axis is the last.
    fn rotate_axis_last(self, a: Self::F64x4, axis: usize) -> Self::F64x4;
    /// Prefetches the cache line at any address.
    fn prefetch<T>(self, line: *const T);
}

/// Eight `f64` as twice four, for levels without such vectors.
macro_rules! f64x8_as_halves {
    () => {
        $crate::wide::simd::lanes::f64x8_as_halves! {
            add_f64x8(a, b) = add_f64;
            sub_f64x8(a, b) = sub_f64;
            mul_f64x8(a, b) = mul_f64;
            div_f64x8(a, b) = div_f64;
            sqrt_f64x8(a) = sqrt_f64;
            abs_f64x8(a) = abs_f64;
            min_f64x8(a, b) = min_f64;
            max_f64x8(a, b) = max_f64;
            select_by_sign_f64x8(by, positive, negative) = select_by_sign;
        }
    };
    ($($name:ident($($arg:ident),*) = $half:ident;)+) => {
        type F64x8 = [Self::F64x4; 2];

        #[inline(always)]
        fn f64x8(self, [a, b, c, d, e, f, g, h]: [f64; 8]) -> Self::F64x8 {
            [self.f64x4([a, b, c, d]), self.f64x4([e, f, g, h])]
        }

        #[inline(always)]
        fn to_f64x8(self, [a, b, c, d, e, f, g, h]: [f32; 8]) -> Self::F64x8 {
            [self.to_f64([a, b, c, d]), self.to_f64([e, f, g, h])]
        }

        #[inline(always)]
        fn narrow_f64x8(self, [low, high]: Self::F64x8) -> Self::F32x8 {
            self.concat_to_f32(low, high)
        }

        #[inline(always)]
        fn halves(self, a: Self::F64x8) -> [Self::F64x4; 2] {
            a
        }

        #[inline(always)]
        fn select_f64x8(self, mask: u32, a: Self::F64x8, b: Self::F64x8) -> Self::F64x8 {
            [self.select_f64(mask, a[0], b[0]), self.select_f64(mask >> 4, a[1], b[1])]
        }

        #[inline(always)]
        fn signs_f64x8(self, [low, high]: Self::F64x8) -> u32 {
            self.signs(low) | self.signs(high) << 4
        }

        #[inline(always)]
        fn lt_f64x8(self, a: Self::F64x8, b: Self::F64x8) -> u32 {
            self.lt_f64(a[0], b[0]) | self.lt_f64(a[1], b[1]) << 4
        }

        #[inline(always)]
        fn le_f64x8(self, a: Self::F64x8, b: Self::F64x8) -> u32 {
            self.le_f64(a[0], b[0]) | self.le_f64(a[1], b[1]) << 4
        }

        $(
            #[inline(always)]
            fn $name(self, $($arg: Self::F64x8),*) -> Self::F64x8 {
                [self.$half($($arg[0]),*), self.$half($($arg[1]),*)]
            }
        )+
    };
}

pub(in crate::wide) use f64x8_as_halves;

/// A computation that is compiled for every level. `run` must be `#[inline(always)]`.
///
/// Implementors and arguments should be at most two pointers, so that all travel in registers. A wide load of data that
/// was just stored in small pieces stalls for as long as a node takes.
pub(in crate::wide) trait WithSimd<A, B> {
    fn run<S: Simd>(self, simd: S, a: A, b: B);
}

/// Removes the lowest lane from a mask that is not 0, and returns it.
#[inline(always)]
pub(in crate::wide) fn take_lane(mask: &mut u32) -> usize {
    let lane = mask.trailing_zeros() as usize;
    *mask &= *mask - 1;
    lane & 7
}
