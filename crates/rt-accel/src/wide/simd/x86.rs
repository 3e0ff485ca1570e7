//! AVX2 and AVX-512.
//!
//! Only `detect` creates values of these types, so a value proves that the processor has the instructions. Methods are
//! inlined into the functions that `dispatch` compiles for the level.

use core::arch::x86_64::*;
use core::mem::MaybeUninit;

use super::lanes::{Simd, WithSimd, f64x8_as_halves};

/// Sorts eight numbers in descending order by a bitonic network (Batcher 1968), without branches.
///
/// # Safety
///
/// The processor must have AVX.
#[inline(always)]
unsafe fn descending(a: __m256) -> __m256 {
    // SAFETY: as the caller promises.
    unsafe {
        let b = _mm256_permute_ps::<0b10_11_00_01>(a);
        let a = _mm256_blend_ps::<0b1010_1010>(_mm256_max_ps(a, b), _mm256_min_ps(a, b));
        let b = _mm256_permute_ps::<0b00_01_10_11>(a);
        let a = _mm256_blend_ps::<0b1100_1100>(_mm256_max_ps(a, b), _mm256_min_ps(a, b));
        let b = _mm256_permute_ps::<0b10_11_00_01>(a);
        let a = _mm256_blend_ps::<0b1010_1010>(_mm256_max_ps(a, b), _mm256_min_ps(a, b));
        let b = _mm256_permute_ps::<0b00_01_10_11>(_mm256_permute2f128_ps::<1>(a, a));
        let a = _mm256_blend_ps::<0b1111_0000>(_mm256_max_ps(a, b), _mm256_min_ps(a, b));
        let b = _mm256_permute_ps::<0b01_00_11_10>(a);
        let a = _mm256_blend_ps::<0b1100_1100>(_mm256_max_ps(a, b), _mm256_min_ps(a, b));
        let b = _mm256_permute_ps::<0b10_11_00_01>(a);
        _mm256_blend_ps::<0b1010_1010>(_mm256_max_ps(a, b), _mm256_min_ps(a, b))
    }
}

/// Axis of the maximum of three, indexed by the bits `x ≤ y` (1), `x ≤ z` (2) and `y ≤ z` (4).
const MAX_AXIS: [u8; 8] = [0, 1, 1, 1, 0, 2, 2, 2];

/// By axis: 32-bit lanes that rotate three `f64` cyclically until this axis is the last. The fourth row is spare.
static AXIS_LAST: [[u32; 8]; 4] =
    [[2, 3, 4, 5, 0, 1, 6, 7], [4, 5, 0, 1, 2, 3, 6, 7], [0, 1, 2, 3, 4, 5, 6, 7], [0, 1, 2, 3, 4, 5, 6, 7]];

/// Wraps expressions of intrinsics as inlined methods.
macro_rules! methods {
    ($(fn $name:ident($($arg:ident: $type:ty),*) -> $out:ty { $($body:tt)* })*) => {$(
        #[inline(always)]
        fn $name(self, $($arg: $type),*) -> $out {
            // SAFETY: `self` proves that the processor has the instructions. Loads and stores are unaligned and cover
            // exactly the array that they name.
            unsafe { $($body)* }
        }
    )*};
}

/// Methods of [`Simd`] that are the same with AVX2 and AVX-512.
macro_rules! common_methods {
    () => {
        type F32x8 = __m256;
        type F64x4 = __m256d;

        const FUSED: bool = true;
        const INTERLEAVE: bool = true;

        #[inline(always)]
        fn call_part<R>(self, part: impl FnOnce() -> R) -> R {
            part()
        }

        methods! {
            fn splat(x: f32) -> __m256 { _mm256_set1_ps(x) }
            fn load(from: &[f32; 8]) -> __m256 { _mm256_loadu_ps(from.as_ptr()) }
            fn to_array(a: __m256) -> [f32; 8] {
                let mut to = [0.0; 8];
                _mm256_storeu_ps(to.as_mut_ptr(), a);
                to
            }
            fn insert(a: __m256, lane: usize, by: f32) -> __m256 {
                let lanes = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
                let is_lane = _mm256_cmpeq_epi32(lanes, _mm256_set1_epi32(lane as i32));
                _mm256_blendv_ps(a, _mm256_set1_ps(by), _mm256_castsi256_ps(is_lane))
            }
            fn add(a: __m256, b: __m256) -> __m256 { _mm256_add_ps(a, b) }
            fn sub(a: __m256, b: __m256) -> __m256 { _mm256_sub_ps(a, b) }
            fn mul(a: __m256, b: __m256) -> __m256 { _mm256_mul_ps(a, b) }
            fn div(a: __m256, b: __m256) -> __m256 { _mm256_div_ps(a, b) }
            fn sqrt(a: __m256) -> __m256 { _mm256_sqrt_ps(a) }
            fn abs(a: __m256) -> __m256 { _mm256_andnot_ps(_mm256_set1_ps(-0.0), a) }
            fn min(a: __m256, b: __m256) -> __m256 { _mm256_min_ps(a, b) }
            fn max(a: __m256, b: __m256) -> __m256 { _mm256_max_ps(a, b) }
            fn mul_add(a: __m256, b: __m256, c: __m256) -> __m256 { _mm256_fmadd_ps(a, b, c) }
            fn mul_sub(a: __m256, b: __m256, c: __m256) -> __m256 { _mm256_fmsub_ps(a, b, c) }
            fn neg_mul_add(a: __m256, b: __m256, c: __m256) -> __m256 { _mm256_fnmadd_ps(a, b, c) }
            fn eq_bits(a: __m256, b: __m256) -> u32 {
                let equal = _mm256_cmpeq_epi32(_mm256_castps_si256(a), _mm256_castps_si256(b));
                _mm256_movemask_ps(_mm256_castsi256_ps(equal)) as u32
            }
            fn select_by_sign_f32(by: __m256, positive: __m256, negative: __m256) -> __m256 {
                _mm256_blendv_ps(positive, negative, by)
            }
            fn replace_bits(a: __m256, mask: u32, bits: u32) -> __m256 {
                let kept = _mm256_andnot_ps(_mm256_castsi256_ps(_mm256_set1_epi32(mask as i32)), a);
                _mm256_or_ps(kept, _mm256_castsi256_ps(_mm256_set1_epi32(bits as i32)))
            }
            fn or_inf(enter: __m256, leave: __m256) -> __m256 {
                let is_hit = _mm256_cmp_ps::<_CMP_LE_OQ>(enter, leave);
                _mm256_blendv_ps(_mm256_set1_ps(f32::INFINITY), enter, is_hit)
            }
            fn reduce_min(a: __m256) -> f32 {
                let a = _mm_min_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps::<1>(a));
                let a = _mm_min_ps(a, _mm_movehl_ps(a, a));
                _mm_cvtss_f32(_mm_min_ss(a, _mm_movehdup_ps(a)))
            }
            fn f64x4(of: [f64; 4]) -> __m256d {
                let [a, b, c, d] = of;
                _mm256_setr_pd(a, b, c, d)
            }
            fn to_f64(of: [f32; 4]) -> __m256d {
                let [a, b, c, d] = of;
                _mm256_cvtps_pd(_mm_setr_ps(a, b, c, d))
            }
            fn round_to_f32(a: __m256d) -> __m256d { _mm256_cvtps_pd(_mm256_cvtpd_ps(a)) }
            fn concat_to_f32(low: __m256d, high: __m256d) -> __m256 {
                _mm256_set_m128(_mm256_cvtpd_ps(high), _mm256_cvtpd_ps(low))
            }
            fn to_f32(a: __m256d) -> [f32; 4] {
                let mut to = [0.0; 4];
                _mm_storeu_ps(to.as_mut_ptr(), _mm256_cvtpd_ps(a));
                to
            }
            fn to_f64_array(a: __m256d) -> [f64; 4] {
                let mut to = [0.0; 4];
                _mm256_storeu_pd(to.as_mut_ptr(), a);
                to
            }
            fn add_f64(a: __m256d, b: __m256d) -> __m256d { _mm256_add_pd(a, b) }
            fn sub_f64(a: __m256d, b: __m256d) -> __m256d { _mm256_sub_pd(a, b) }
            fn mul_f64(a: __m256d, b: __m256d) -> __m256d { _mm256_mul_pd(a, b) }
            fn div_f64(a: __m256d, b: __m256d) -> __m256d { _mm256_div_pd(a, b) }
            fn sqrt_f64(a: __m256d) -> __m256d { _mm256_sqrt_pd(a) }
            fn abs_f64(a: __m256d) -> __m256d { _mm256_andnot_pd(_mm256_set1_pd(-0.0), a) }
            fn min_f64(a: __m256d, b: __m256d) -> __m256d { _mm256_min_pd(a, b) }
            fn max_f64(a: __m256d, b: __m256d) -> __m256d { _mm256_max_pd(a, b) }
            fn select_by_sign(by: __m256d, positive: __m256d, negative: __m256d) -> __m256d {
                _mm256_blendv_pd(positive, negative, by)
            }
            fn select_f64(mask: u32, a: __m256d, b: __m256d) -> __m256d {
                let bits = _mm256_setr_epi64x(1, 2, 4, 8);
                let set = _mm256_and_si256(_mm256_set1_epi64x(i64::from(mask)), bits);
                _mm256_blendv_pd(b, a, _mm256_castsi256_pd(_mm256_cmpeq_epi64(set, bits)))
            }
            fn signs(a: __m256d) -> u32 { _mm256_movemask_pd(a) as u32 }
            fn lt_f64(a: __m256d, b: __m256d) -> u32 { _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(a, b)) as u32 }
            fn le_f64(a: __m256d, b: __m256d) -> u32 { _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LE_OQ>(a, b)) as u32 }
            fn yzx(a: __m256d) -> __m256d { _mm256_permute4x64_pd::<0b11_00_10_01>(a) }
            fn zxy(a: __m256d) -> __m256d { _mm256_permute4x64_pd::<0b11_01_00_10>(a) }
            fn max_axis(a: __m256d) -> usize {
                let (x_x_y, y_z_z) =
                    (_mm256_permute4x64_pd::<0b11_01_00_00>(a), _mm256_permute4x64_pd::<0b11_10_10_01>(a));
                let at_most = _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LE_OQ>(x_x_y, y_z_z));
                MAX_AXIS[at_most as usize & 7] as usize
            }
            fn rotate_axis_last(a: __m256d, axis: usize) -> __m256d {
                let order = _mm256_loadu_si256(AXIS_LAST[axis & 3].as_ptr().cast());
                _mm256_castps_pd(_mm256_permutevar8x32_ps(_mm256_castpd_ps(a), order))
            }
        }

        #[inline(always)]
        fn compress_sorted(
            self,
            enter: __m256,
            leave: __m256,
            words: &[u32; 8],
            enters: &mut [MaybeUninit<f32>; 8],
            hit: &mut [MaybeUninit<u32>; 8],
        ) -> usize {
            let count = self.le(enter, leave).count_ones() as usize;
            // SAFETY: `self` proves that there is AVX2; loads and stores cover the eight numbers of the arrays.
            unsafe {
                let is_hit = _mm256_cmp_ps::<_CMP_LE_OQ>(enter, leave);
                // The lane replaces the last three bits and is sorted along.
                let lanes = _mm256_castsi256_ps(_mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
                let low = _mm256_castsi256_ps(_mm256_set1_epi32(7));
                let key = _mm256_or_ps(_mm256_andnot_ps(low, enter), lanes);
                let key = descending(_mm256_blendv_ps(_mm256_set1_ps(-1.0), key, is_hit));
                let words = _mm256_loadu_si256(words.as_ptr().cast());
                let sorted = _mm256_permutevar8x32_epi32(words, _mm256_castps_si256(key));
                _mm256_storeu_ps(enters.as_mut_ptr().cast(), _mm256_andnot_ps(low, key));
                _mm256_storeu_si256(hit.as_mut_ptr().cast(), sorted);
            }
            count
        }

        #[inline(always)]
        fn prefetch<T>(self, line: *const T) {
            // SAFETY: a prefetch changes nothing and cannot fail.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(line.cast()) }
        }
    };
}

/// Declares a level by its features, with detection and dispatch.
macro_rules! level {
    ($(#[$doc:meta])* $name:ident, $features:literal, [$($feature:tt),+]) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(in crate::wide) struct $name(());

        impl $name {
            /// Proof that this processor has the features.
            #[inline]
            pub(super) fn detect() -> Option<Self> {
                (true $(&& is_x86_feature_detected!($feature))+).then_some(Self(()))
            }

            /// Runs the kernel, compiled with all features of the level.
            #[inline]
            pub(super) fn dispatch<A, B, K: WithSimd<A, B>>(self, kernel: K, a: A, b: B) {
                #[target_feature(enable = $features)]
                fn compiled_for_it<A, B, K: WithSimd<A, B>>(simd: $name, kernel: K, a: A, b: B) {
                    kernel.run(simd, a, b)
                }
                // SAFETY: `self` exists, so `detect` has found all of these features.
                unsafe { compiled_for_it(self, kernel, a, b) }
            }
        }
    };
}

level!(
    /// AVX2 and FMA.
    Avx2, "avx2,fma,bmi1,bmi2,lzcnt,popcnt", ["avx2", "fma", "bmi1", "bmi2", "lzcnt", "popcnt"]
);
level!(
    /// AVX-512 with vectors of any length.
    Avx512,
    "avx512f,avx512vl,avx512dq,avx512bw,avx2,fma,bmi1,bmi2,lzcnt,popcnt",
    ["avx512f", "avx512vl", "avx512dq", "avx512bw", "avx2", "fma", "bmi1", "bmi2", "lzcnt", "popcnt"]
);

#[cfg(not(feature = "all-simd"))]
impl Avx512 {
    /// The level below.
    pub(super) const fn as_avx2(self) -> Avx2 {
        Avx2(())
    }
}

impl Simd for Avx2 {
    common_methods!();
    f64x8_as_halves!();
    methods! {
        fn le(a: __m256, b: __m256) -> u32 { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(a, b)) as u32 }
        fn lt(a: __m256, b: __m256) -> u32 { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(a, b)) as u32 }
        fn select(mask: u32, a: __m256, b: __m256) -> __m256 {
            let bits = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
            let set = _mm256_and_si256(_mm256_set1_epi32(mask as i32), bits);
            _mm256_blendv_ps(b, a, _mm256_castsi256_ps(_mm256_cmpeq_epi32(set, bits)))
        }
    }
}

impl Simd for Avx512 {
    type F64x8 = __m512d;

    common_methods!();
    methods! {
        fn f64x8(of: [f64; 8]) -> __m512d {
            let [a, b, c, d, e, f, g, h] = of;
            _mm512_setr_pd(a, b, c, d, e, f, g, h)
        }
        fn to_f64x8(of: [f32; 8]) -> __m512d {
            let [a, b, c, d, e, f, g, h] = of;
            _mm512_cvtps_pd(_mm256_setr_ps(a, b, c, d, e, f, g, h))
        }
        fn narrow_f64x8(a: __m512d) -> __m256 { _mm512_cvtpd_ps(a) }
        fn halves(a: __m512d) -> [__m256d; 2] { [_mm512_castpd512_pd256(a), _mm512_extractf64x4_pd::<1>(a)] }
        fn add_f64x8(a: __m512d, b: __m512d) -> __m512d { _mm512_add_pd(a, b) }
        fn sub_f64x8(a: __m512d, b: __m512d) -> __m512d { _mm512_sub_pd(a, b) }
        fn mul_f64x8(a: __m512d, b: __m512d) -> __m512d { _mm512_mul_pd(a, b) }
        fn div_f64x8(a: __m512d, b: __m512d) -> __m512d { _mm512_div_pd(a, b) }
        fn sqrt_f64x8(a: __m512d) -> __m512d { _mm512_sqrt_pd(a) }
        fn abs_f64x8(a: __m512d) -> __m512d { _mm512_abs_pd(a) }
        fn min_f64x8(a: __m512d, b: __m512d) -> __m512d { _mm512_min_pd(a, b) }
        fn max_f64x8(a: __m512d, b: __m512d) -> __m512d { _mm512_max_pd(a, b) }
        fn select_by_sign_f64x8(by: __m512d, positive: __m512d, negative: __m512d) -> __m512d {
            _mm512_mask_blend_pd(_mm512_movepi64_mask(_mm512_castpd_si512(by)), positive, negative)
        }
        fn select_f64x8(mask: u32, a: __m512d, b: __m512d) -> __m512d { _mm512_mask_blend_pd(mask as u8, b, a) }
        fn signs_f64x8(a: __m512d) -> u32 { u32::from(_mm512_movepi64_mask(_mm512_castpd_si512(a))) }
        fn lt_f64x8(a: __m512d, b: __m512d) -> u32 { u32::from(_mm512_cmp_pd_mask::<_CMP_LT_OQ>(a, b)) }
        fn le_f64x8(a: __m512d, b: __m512d) -> u32 { u32::from(_mm512_cmp_pd_mask::<_CMP_LE_OQ>(a, b)) }
        fn le(a: __m256, b: __m256) -> u32 { u32::from(_mm256_cmp_ps_mask::<_CMP_LE_OQ>(a, b)) }
        fn lt(a: __m256, b: __m256) -> u32 { u32::from(_mm256_cmp_ps_mask::<_CMP_LT_OQ>(a, b)) }
        fn select(mask: u32, a: __m256, b: __m256) -> __m256 { _mm256_mask_blend_ps(mask as u8, b, a) }
    }
}
