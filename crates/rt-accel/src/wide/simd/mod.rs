//! Eight `f32`, or four `f64`, at a time on any processor.
//!
//! Kernels are written once against [`Simd`] and compiled for AVX-512, AVX2 and a portable level. [`SimdLevel`] selects one
//! at run time. The last bits of filters differ between levels; query results do not.

mod portable;
#[cfg(target_arch = "x86_64")]
mod x86;

use core::mem::MaybeUninit;

use portable::Portable;

/// Lane-wise arithmetic. A value of the type proves that the processor has the instructions.
///
/// Comparisons return a bit for each lane, clear where a number is NaN.
pub(super) trait Simd: Copy {
    type F32x8: Copy;
    type F64x4: Copy;

    /// True if a ray takes so few instructions that interleaving rays hides memory latency.
    const INTERLEAVE: bool;
    /// True if [`mul_add`](Self::mul_add) rounds once.
    const FUSED: bool;

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
    /// Sign bits of the four numbers.
    fn signs(self, a: Self::F64x4) -> u32;
    fn le_f64(self, a: Self::F64x4, b: Self::F64x4) -> u32;
    /// The first three numbers in the order 1, 2, 0.
    fn yzx(self, a: Self::F64x4) -> Self::F64x4;
    /// The first three numbers in the order 2, 0, 1.
    fn zxy(self, a: Self::F64x4) -> Self::F64x4;
    /// Axis of the maximum of the first three; [`WatertightRay`](rt_geometry::WatertightRay) breaks ties alike.
    fn max_axis(self, a: Self::F64x4) -> usize;
    /// Rotates the first three cyclically until this axis is the last.
    fn rotate_axis_last(self, a: Self::F64x4, axis: usize) -> Self::F64x4;
    /// Prefetches the cache line at any address.
    fn prefetch<T>(self, line: *const T);
}

/// A computation that is compiled for every level. `run` must be `#[inline(always)]`.
///
/// Implementors and arguments should be at most two pointers, so that all travel in registers. A wide load of data that
/// was just stored in small pieces stalls for as long as a node takes.
pub(super) trait WithSimd<A, B> {
    fn run<S: Simd>(self, simd: S, a: A, b: B);
}

/// Instruction set of the traversal kernels.
///
/// On x86-64, the feature `all-simd` of the crate compiles AVX-512 and portable packets, which take half of the time to
/// build the crate. Without it, AVX2 stands in for AVX-512, and rays of a batch are traced one by one at the portable
/// level. The results are the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum SimdLevel {
    /// Twice four numbers: SSE2, NEON, or scalar arithmetic.
    Portable,
    /// AVX2 with fused multiply-add.
    Avx2,
    /// AVX-512 with 256-bit vectors: AVX2 plus mask registers.
    Avx512,
}

impl SimdLevel {
    /// All levels, from the least to the most demanding.
    pub const ALL: &[Self] = &[Self::Portable, Self::Avx2, Self::Avx512];

    /// Lower-case name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Portable => "portable",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
        }
    }

    /// The most demanding level that this processor supports.
    pub fn best() -> Self {
        Self::ALL.iter().rev().copied().find(|level| level.is_available()).unwrap_or(Self::Portable)
    }

    /// True if this processor supports the level, and the level is compiled.
    pub fn is_available(self) -> bool {
        DetectedSimd::detect(self).is_some()
    }
}

/// A level that the processor supports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DetectedSimd {
    Portable(Portable),
    #[cfg(target_arch = "x86_64")]
    Avx2(x86::Avx2),
    #[cfg(all(target_arch = "x86_64", feature = "all-simd"))]
    Avx512(x86::Avx512),
}

impl DetectedSimd {
    /// The given level, or the portable one if the processor does not support it.
    pub(super) fn new(level: SimdLevel) -> Self {
        Self::detect(level).unwrap_or(Self::Portable(Portable))
    }

    /// `None` if the processor does not support the level, or it is not compiled.
    fn detect(level: SimdLevel) -> Option<Self> {
        match level {
            SimdLevel::Portable => Some(Self::Portable(Portable)),
            #[cfg(target_arch = "x86_64")]
            SimdLevel::Avx2 => x86::Avx2::detect().map(Self::Avx2),
            #[cfg(all(target_arch = "x86_64", feature = "all-simd"))]
            SimdLevel::Avx512 => x86::Avx512::detect().map(Self::Avx512),
            #[cfg(not(all(target_arch = "x86_64", feature = "all-simd")))]
            _ => None,
        }
    }

    pub(super) const fn level(self) -> SimdLevel {
        match self {
            Self::Portable(_) => SimdLevel::Portable,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(_) => SimdLevel::Avx2,
            #[cfg(all(target_arch = "x86_64", feature = "all-simd"))]
            Self::Avx512(_) => SimdLevel::Avx512,
        }
    }

    /// True if [`dispatch_packets`](Self::dispatch_packets) is compiled for this level.
    pub(super) const fn has_packets(self) -> bool {
        cfg!(any(not(target_arch = "x86_64"), feature = "all-simd")) || !matches!(self, Self::Portable(_))
    }

    /// Runs a kernel with the instructions of this level.
    #[inline(always)]
    pub(super) fn dispatch<A, B, K: WithSimd<A, B>>(self, kernel: K, a: A, b: B) {
        match self {
            Self::Portable(simd) => simd.dispatch(kernel, a, b),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(simd) => simd.dispatch(kernel, a, b),
            #[cfg(all(target_arch = "x86_64", feature = "all-simd"))]
            Self::Avx512(simd) => simd.dispatch(kernel, a, b),
        }
    }

    /// Runs a kernel for many rays. Does nothing unless [`has_packets`](Self::has_packets).
    #[inline(always)]
    pub(super) fn dispatch_packets<A, B, K: WithSimd<A, B>>(self, kernel: K, a: A, b: B) {
        match self {
            #[cfg(any(not(target_arch = "x86_64"), feature = "all-simd"))]
            Self::Portable(simd) => simd.dispatch(kernel, a, b),
            #[cfg(all(target_arch = "x86_64", not(feature = "all-simd")))]
            Self::Portable(_) => {}
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(simd) => simd.dispatch(kernel, a, b),
            #[cfg(all(target_arch = "x86_64", feature = "all-simd"))]
            Self::Avx512(simd) => simd.dispatch(kernel, a, b),
        }
    }
}

impl Default for DetectedSimd {
    fn default() -> Self {
        Self::new(SimdLevel::best())
    }
}

impl Default for SimdLevel {
    fn default() -> Self {
        Self::best()
    }
}
