//! AVX2 and AVX-512.
//!
//! The types cannot be made but by `detect`, so that having one proves that the processor has the instructions. Their
//! methods are inlined into the functions that `dispatch` compiles for them.

use core::arch::x86_64::*;
use core::mem::MaybeUninit;

use super::{Simd, WithSimd};

/// Sorts eight numbers, the greatest first, by a bitonic network (Batcher 1968): without branches, as no order is more
/// likely than another.
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

/// The axis of the greatest of three: by whether the first is at most the second (1), the first at most the third (2), and
/// the second at most the third (4).
const GREATEST: [u8; 8] = [0, 1, 1, 1, 0, 2, 2, 2];

/// Which words come where if an axis is to be the last of three, each of which is two words. The last is spare.
static LAST: [[u32; 8]; 4] =
    [[2, 3, 4, 5, 0, 1, 6, 7], [4, 5, 0, 1, 2, 3, 6, 7], [0, 1, 2, 3, 4, 5, 6, 7], [0, 1, 2, 3, 4, 5, 6, 7]];

/// Makes a level of which all operations but comparisons and choices are those of AVX2.
macro_rules! level {
    ($name:ident, $doc:literal, $features:literal, [$($feature:tt),+], |$a:ident, $b:ident, $mask:ident| [$le:expr, $lt:expr, $chosen:expr]) => {
        #[doc = $doc]
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(in crate::wide) struct $name(());

        impl $name {
            /// Proof that this processor has it.
            #[inline]
            pub(super) fn detect() -> Option<Self> {
                (true $(&& is_x86_feature_detected!($feature))+).then_some(Self(()))
            }

            /// Runs the kernel with all that this level has.
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

        impl Simd for $name {
            type F32x8 = __m256;

            const FUSED: bool = true;
            const INTERLEAVE: bool = true;

            #[inline(always)]
            fn splat(self, x: f32) -> __m256 {
                // SAFETY: AVX is there, as `self` exists; so in all that follow.
                unsafe { _mm256_set1_ps(x) }
            }

            #[inline(always)]
            fn load(self, from: &[f32; 8]) -> __m256 {
                // SAFETY: reads the eight numbers of the array, at any alignment.
                unsafe { _mm256_loadu_ps(from.as_ptr()) }
            }

            #[inline(always)]
            fn to_array(self, a: __m256) -> [f32; 8] {
                let mut to = [0.0; 8];
                // SAFETY: writes the eight numbers of the array, at any alignment.
                unsafe { _mm256_storeu_ps(to.as_mut_ptr(), a) };
                to
            }

            #[inline(always)]
            fn insert(self, a: __m256, lane: usize, by: f32) -> __m256 {
                // SAFETY: AVX2 is there, as `self` exists.
                unsafe {
                    let lanes = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
                    let is_it = _mm256_cmpeq_epi32(lanes, _mm256_set1_epi32(lane as i32));
                    _mm256_blendv_ps(a, _mm256_set1_ps(by), _mm256_castsi256_ps(is_it))
                }
            }

            #[inline(always)]
            fn add(self, a: __m256, b: __m256) -> __m256 {
                // SAFETY: as `splat`.
                unsafe { _mm256_add_ps(a, b) }
            }

            #[inline(always)]
            fn sub(self, a: __m256, b: __m256) -> __m256 {
                // SAFETY: as `splat`.
                unsafe { _mm256_sub_ps(a, b) }
            }

            #[inline(always)]
            fn mul(self, a: __m256, b: __m256) -> __m256 {
                // SAFETY: as `splat`.
                unsafe { _mm256_mul_ps(a, b) }
            }

            #[inline(always)]
            fn div(self, a: __m256, b: __m256) -> __m256 {
                // SAFETY: as `splat`.
                unsafe { _mm256_div_ps(a, b) }
            }

            #[inline(always)]
            fn sqrt(self, a: __m256) -> __m256 {
                // SAFETY: as `splat`.
                unsafe { _mm256_sqrt_ps(a) }
            }

            #[inline(always)]
            fn abs(self, a: __m256) -> __m256 {
                // SAFETY: as `splat`.
                unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), a) }
            }

            #[inline(always)]
            fn min(self, a: __m256, b: __m256) -> __m256 {
                // SAFETY: as `splat`.
                unsafe { _mm256_min_ps(a, b) }
            }

            #[inline(always)]
            fn max(self, a: __m256, b: __m256) -> __m256 {
                // SAFETY: as `splat`.
                unsafe { _mm256_max_ps(a, b) }
            }

            #[inline(always)]
            fn mul_add(self, a: __m256, b: __m256, c: __m256) -> __m256 {
                // SAFETY: FMA is there, as `self` exists; so in the two that follow.
                unsafe { _mm256_fmadd_ps(a, b, c) }
            }

            #[inline(always)]
            fn mul_sub(self, a: __m256, b: __m256, c: __m256) -> __m256 {
                // SAFETY: as `mul_add`.
                unsafe { _mm256_fmsub_ps(a, b, c) }
            }

            #[inline(always)]
            fn neg_mul_add(self, a: __m256, b: __m256, c: __m256) -> __m256 {
                // SAFETY: as `mul_add`.
                unsafe { _mm256_fnmadd_ps(a, b, c) }
            }

            #[inline(always)]
            fn le(self, $a: __m256, $b: __m256) -> u32 {
                // SAFETY: as `splat`, and AVX-512 where this is its level.
                unsafe { $le }
            }

            #[inline(always)]
            fn lt(self, $a: __m256, $b: __m256) -> u32 {
                // SAFETY: as `le`.
                unsafe { $lt }
            }

            #[inline(always)]
            fn eq_bits(self, a: __m256, b: __m256) -> u32 {
                // SAFETY: AVX2 is there, as `self` exists.
                unsafe {
                    let same = _mm256_cmpeq_epi32(_mm256_castps_si256(a), _mm256_castps_si256(b));
                    _mm256_movemask_ps(_mm256_castsi256_ps(same)) as u32
                }
            }

            #[inline(always)]
            fn select(self, $mask: u32, $a: __m256, $b: __m256) -> __m256 {
                // SAFETY: AVX2 is there, as `self` exists, and AVX-512 where this is its level.
                unsafe { $chosen }
            }

            #[inline(always)]
            fn or_inf(self, enter: __m256, leave: __m256) -> __m256 {
                // SAFETY: as `splat`.
                unsafe {
                    let is_passed = _mm256_cmp_ps::<_CMP_LE_OQ>(enter, leave);
                    _mm256_blendv_ps(_mm256_set1_ps(f32::INFINITY), enter, is_passed)
                }
            }

            #[inline(always)]
            fn least(self, a: __m256) -> f32 {
                // SAFETY: as `splat`.
                unsafe {
                    let a = _mm_min_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps::<1>(a));
                    let a = _mm_min_ps(a, _mm_movehl_ps(a, a));
                    _mm_cvtss_f32(_mm_min_ss(a, _mm_movehdup_ps(a)))
                }
            }

            #[inline(always)]
            fn compress_sorted(
                self,
                enter: __m256,
                leave: __m256,
                words: &[u32; 8],
                enters: &mut [MaybeUninit<f32>; 8],
                passed: &mut [MaybeUninit<u32>; 8],
            ) -> usize {
                let count = self.le(enter, leave).count_ones() as usize;
                // SAFETY: AVX2 is there, as `self` exists; reads and writes the eight numbers of the arrays.
                unsafe {
                    let is_passed = _mm256_cmp_ps::<_CMP_LE_OQ>(enter, leave);
                    // The lane takes the place of the last three bits, and comes along.
                    let lanes = _mm256_castsi256_ps(_mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
                    let low = _mm256_castsi256_ps(_mm256_set1_epi32(7));
                    let key = _mm256_or_ps(_mm256_andnot_ps(low, enter), lanes);
                    let key = descending(_mm256_blendv_ps(_mm256_set1_ps(-1.0), key, is_passed));
                    let words = _mm256_loadu_si256(words.as_ptr().cast());
                    let sorted = _mm256_permutevar8x32_epi32(words, _mm256_castps_si256(key));
                    _mm256_storeu_ps(enters.as_mut_ptr().cast(), _mm256_andnot_ps(low, key));
                    _mm256_storeu_si256(passed.as_mut_ptr().cast(), sorted);
                }
                count
            }

            #[inline(always)]
            fn prefetch<T>(self, line: *const T) {
                // SAFETY: a prefetch changes nothing and cannot fail.
                unsafe { _mm_prefetch::<_MM_HINT_T0>(line.cast()) }
            }

            type F64x4 = __m256d;

            #[inline(always)]
            fn doubles(self, [a, b, c, d]: [f64; 4]) -> __m256d {
                // SAFETY: as `splat`.
                unsafe { _mm256_setr_pd(a, b, c, d) }
            }

            #[inline(always)]
            fn widened(self, [a, b, c, d]: [f32; 4]) -> __m256d {
                // SAFETY: as `splat`.
                unsafe { _mm256_cvtps_pd(_mm_setr_ps(a, b, c, d)) }
            }

            #[inline(always)]
            fn round_to_f32(self, a: __m256d) -> __m256d {
                // SAFETY: as `splat`.
                unsafe { _mm256_cvtps_pd(_mm256_cvtpd_ps(a)) }
            }

            #[inline(always)]
            fn concat_to_f32(self, low: __m256d, high: __m256d) -> __m256 {
                // SAFETY: as `splat`.
                unsafe { _mm256_set_m128(_mm256_cvtpd_ps(high), _mm256_cvtpd_ps(low)) }
            }

            #[inline(always)]
            fn to_f32(self, a: __m256d) -> [f32; 4] {
                let mut to = [0.0; 4];
                // SAFETY: writes the four numbers of the array, at any alignment.
                unsafe { _mm_storeu_ps(to.as_mut_ptr(), _mm256_cvtpd_ps(a)) };
                to
            }

            #[inline(always)]
            fn to_doubles(self, a: __m256d) -> [f64; 4] {
                let mut to = [0.0; 4];
                // SAFETY: writes the four numbers of the array, at any alignment.
                unsafe { _mm256_storeu_pd(to.as_mut_ptr(), a) };
                to
            }

            #[inline(always)]
            fn add_doubles(self, a: __m256d, b: __m256d) -> __m256d {
                // SAFETY: as `splat`.
                unsafe { _mm256_add_pd(a, b) }
            }

            #[inline(always)]
            fn sub_doubles(self, a: __m256d, b: __m256d) -> __m256d {
                // SAFETY: as `splat`.
                unsafe { _mm256_sub_pd(a, b) }
            }

            #[inline(always)]
            fn mul_doubles(self, a: __m256d, b: __m256d) -> __m256d {
                // SAFETY: as `splat`.
                unsafe { _mm256_mul_pd(a, b) }
            }

            #[inline(always)]
            fn div_doubles(self, a: __m256d, b: __m256d) -> __m256d {
                // SAFETY: as `splat`.
                unsafe { _mm256_div_pd(a, b) }
            }

            #[inline(always)]
            fn min_doubles(self, a: __m256d, b: __m256d) -> __m256d {
                // SAFETY: as `splat`.
                unsafe { _mm256_min_pd(a, b) }
            }

            #[inline(always)]
            fn max_doubles(self, a: __m256d, b: __m256d) -> __m256d {
                // SAFETY: as `splat`.
                unsafe { _mm256_max_pd(a, b) }
            }

            #[inline(always)]
            fn sqrt_doubles(self, a: __m256d) -> __m256d {
                // SAFETY: as `splat`.
                unsafe { _mm256_sqrt_pd(a) }
            }

            #[inline(always)]
            fn abs_doubles(self, a: __m256d) -> __m256d {
                // SAFETY: as `splat`.
                unsafe { _mm256_andnot_pd(_mm256_set1_pd(-0.0), a) }
            }

            #[inline(always)]
            fn select_by_sign(self, by: __m256d, positive: __m256d, negative: __m256d) -> __m256d {
                // SAFETY: as `splat`.
                unsafe { _mm256_blendv_pd(positive, negative, by) }
            }

            #[inline(always)]
            fn signs(self, a: __m256d) -> u32 {
                // SAFETY: as `splat`.
                unsafe { _mm256_movemask_pd(a) as u32 }
            }

            #[inline(always)]
            fn le_doubles(self, a: __m256d, b: __m256d) -> u32 {
                // SAFETY: as `splat`.
                unsafe { _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LE_OQ>(a, b)) as u32 }
            }

            #[inline(always)]
            fn yzx(self, a: __m256d) -> __m256d {
                // SAFETY: as `splat`.
                unsafe { _mm256_permute4x64_pd::<0b11_00_10_01>(a) }
            }

            #[inline(always)]
            fn zxy(self, a: __m256d) -> __m256d {
                // SAFETY: as `splat`.
                unsafe { _mm256_permute4x64_pd::<0b11_01_00_10>(a) }
            }

            #[inline(always)]
            fn greatest_axis(self, a: __m256d) -> usize {
                // SAFETY: as `splat`.
                let round_down = unsafe {
                    let (x_x_y, y_z_z) =
                        (_mm256_permute4x64_pd::<0b11_01_00_00>(a), _mm256_permute4x64_pd::<0b11_10_10_01>(a));
                    _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LE_OQ>(x_x_y, y_z_z))
                };
                GREATEST[round_down as usize & 7] as usize
            }

            #[inline(always)]
            fn rotate_axis_last(self, a: __m256d, axis: usize) -> __m256d {
                // SAFETY: as `splat`; reads the eight words of an array.
                unsafe {
                    let order = _mm256_loadu_si256(LAST[axis & 3].as_ptr().cast());
                    _mm256_castps_pd(_mm256_permutevar8x32_ps(_mm256_castpd_ps(a), order))
                }
            }
        }
    };
}

level!(
    Avx2,
    "AVX2 and FMA are there.",
    "avx2,fma,bmi1,bmi2,lzcnt,popcnt",
    ["avx2", "fma", "bmi1", "bmi2", "lzcnt", "popcnt"],
    |a, b, mask| [
        _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(a, b)) as u32,
        _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(a, b)) as u32,
        {
            let bits = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
            let set = _mm256_and_si256(_mm256_set1_epi32(mask as i32), bits);
            _mm256_blendv_ps(b, a, _mm256_castsi256_ps(_mm256_cmpeq_epi32(set, bits)))
        }
    ]
);
level!(
    Avx512,
    "AVX-512 with vectors of any length is there.",
    "avx512f,avx512vl,avx512dq,avx512bw,avx2,fma,bmi1,bmi2,lzcnt,popcnt",
    ["avx512f", "avx512vl", "avx512dq", "avx512bw", "avx2", "fma", "bmi1", "bmi2", "lzcnt", "popcnt"],
    |a, b, mask| [
        u32::from(_mm256_cmp_ps_mask::<_CMP_LE_OQ>(a, b)),
        u32::from(_mm256_cmp_ps_mask::<_CMP_LT_OQ>(a, b)),
        _mm256_mask_blend_ps(mask as u8, b, a)
    ]
);
