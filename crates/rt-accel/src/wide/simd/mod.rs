//! F64x8 numbers of single precision at a time, on whatever the processor has.
//!
//! What is written once against [`Simd`] runs on AVX-512, AVX2, or anything. Which one is asked for by
//! [`SimdLevel`]; results differ in the last bits of what filters compute, and never in what a query answers.

mod portable;
#[cfg(target_arch = "x86_64")]
mod x86;

use core::mem::MaybeUninit;

use portable::Portable;

/// Arithmetic on eight numbers side by side. Having a value of the type proves that the processor can do it.
pub(super) trait Simd: Copy {
    /// F64x8 numbers.
    type F32x8: Copy;

    /// True if rays are tested in so few instructions that it pays to have others go on while one waits.
    const INTERLEAVE: bool;

    /// True if [`mul_add`](Self::mul_add) rounds once.
    const FUSED: bool;

    /// The same number eight times.
    fn splat(self, x: f32) -> Self::F32x8;
    /// F64x8 numbers in a row.
    fn load(self, from: &[f32; 8]) -> Self::F32x8;
    /// The numbers by lane.
    fn to_array(self, a: Self::F32x8) -> [f32; 8];
    /// The same numbers but for that of one lane.
    fn insert(self, a: Self::F32x8, lane: usize, by: f32) -> Self::F32x8;
    /// `a + b`
    fn add(self, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8;
    /// `a − b`
    fn sub(self, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8;
    /// `a·b`
    fn mul(self, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8;
    /// `a/b`
    fn div(self, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8;
    /// `√a`
    fn sqrt(self, a: Self::F32x8) -> Self::F32x8;
    /// `|a|`
    fn abs(self, a: Self::F32x8) -> Self::F32x8;
    /// The lesser of both; either where one is NaN.
    fn min(self, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8;
    /// The greater of both; either where one is NaN.
    fn max(self, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8;
    /// `a·b + c`, rounded once or twice.
    fn mul_add(self, a: Self::F32x8, b: Self::F32x8, c: Self::F32x8) -> Self::F32x8;
    /// `a·b − c`, rounded once or twice.
    fn mul_sub(self, a: Self::F32x8, b: Self::F32x8, c: Self::F32x8) -> Self::F32x8;
    /// `c − a·b`, rounded once or twice.
    fn neg_mul_add(self, a: Self::F32x8, b: Self::F32x8, c: Self::F32x8) -> Self::F32x8;
    /// A bit for each lane, set where `a ≤ b`; never where one is NaN.
    fn le(self, a: Self::F32x8, b: Self::F32x8) -> u32;
    /// A bit for each lane, set where `a < b`; never where one is NaN.
    fn lt(self, a: Self::F32x8, b: Self::F32x8) -> u32;
    /// A bit for each lane whose bits are the same.
    fn eq_bits(self, a: Self::F32x8, b: Self::F32x8) -> u32;
    /// `a` where the mask has a bit, otherwise `b`.
    fn select(self, mask: u32, a: Self::F32x8, b: Self::F32x8) -> Self::F32x8;
    /// `enter` where it is at most `leave`, otherwise infinity.
    fn or_inf(self, enter: Self::F32x8, leave: Self::F32x8) -> Self::F32x8;
    /// The least of the eight.
    fn least(self, a: Self::F32x8) -> f32;
    /// Writes where `enter ≤ leave`, from the greatest `enter` to the least, and the words of those lanes; returns how
    /// many they are. What is written after them means nothing. No `enter` may be negative. Each may be written with its
    /// last three bits cleared.
    fn compress_sorted(
        self,
        enter: Self::F32x8,
        leave: Self::F32x8,
        words: &[u32; 8],
        enters: &mut [MaybeUninit<f32>; 8],
        passed: &mut [MaybeUninit<u32>; 8],
    ) -> usize;
    /// Four numbers of double precision.
    type F64x4: Copy;

    /// Four numbers.
    fn doubles(self, of: [f64; 4]) -> Self::F64x4;
    /// Four numbers, widened.
    fn widened(self, of: [f32; 4]) -> Self::F64x4;
    /// The numbers of single precision that are nearest.
    fn round_to_f32(self, a: Self::F64x4) -> Self::F64x4;
    /// F64x8 numbers, rounded.
    fn concat_to_f32(self, low: Self::F64x4, high: Self::F64x4) -> Self::F32x8;
    /// Four numbers, rounded.
    fn to_f32(self, a: Self::F64x4) -> [f32; 4];
    /// The numbers by lane.
    fn to_doubles(self, a: Self::F64x4) -> [f64; 4];
    /// `a + b`
    fn add_doubles(self, a: Self::F64x4, b: Self::F64x4) -> Self::F64x4;
    /// `a − b`
    fn sub_doubles(self, a: Self::F64x4, b: Self::F64x4) -> Self::F64x4;
    /// `a·b`
    fn mul_doubles(self, a: Self::F64x4, b: Self::F64x4) -> Self::F64x4;
    /// `a/b`
    fn div_doubles(self, a: Self::F64x4, b: Self::F64x4) -> Self::F64x4;
    /// `√a`
    fn sqrt_doubles(self, a: Self::F64x4) -> Self::F64x4;
    /// `|a|`
    fn abs_doubles(self, a: Self::F64x4) -> Self::F64x4;
    /// `a` where it is less than `b`, otherwise `b`, also where one is NaN.
    fn min_doubles(self, a: Self::F64x4, b: Self::F64x4) -> Self::F64x4;
    /// `a` where it is greater than `b`, otherwise `b`, also where one is NaN.
    fn max_doubles(self, a: Self::F64x4, b: Self::F64x4) -> Self::F64x4;
    /// `negative` where the sign of `by` is, otherwise `positive`.
    fn select_by_sign(self, by: Self::F64x4, positive: Self::F64x4, negative: Self::F64x4) -> Self::F64x4;
    /// A bit for each of the four, set where the sign is negative.
    fn signs(self, a: Self::F64x4) -> u32;
    /// A bit for each of the four, set where `a ≤ b`; never where one is NaN.
    fn le_doubles(self, a: Self::F64x4, b: Self::F64x4) -> u32;
    /// The first three in the order 1, 2, 0.
    fn yzx(self, a: Self::F64x4) -> Self::F64x4;
    /// The first three in the order 2, 0, 1.
    fn zxy(self, a: Self::F64x4) -> Self::F64x4;
    /// The axis of the greatest of the first three, as [`WatertightRay`](rt_geometry::WatertightRay) chooses among equals.
    fn greatest_axis(self, a: Self::F64x4) -> usize;
    /// The first three in the cyclic order in which this axis comes last.
    fn rotate_axis_last(self, a: Self::F64x4, axis: usize) -> Self::F64x4;
    /// Asks for the cache line at this address to be fetched; any address will do.
    fn prefetch<T>(self, line: *const T);
}

/// A computation that is to be compiled for every kind of processor. `run` must be `#[inline(always)]`.
///
/// What implements it should be no more than two pointers, and so should its arguments: then all travel in registers.
/// What has just been stored in small pieces cannot be loaded in larger ones without a wait for the memory, which costs
/// as much as a node.
pub(super) trait WithSimd<A, B> {
    /// Does it.
    fn run<S: Simd>(self, simd: S, a: A, b: B);
}

/// What the processor can do with eight numbers at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum SimdLevel {
    /// Four numbers twice, by what every processor of its kind can do: SSE2, NEON, or plain arithmetic.
    Portable,
    /// AVX2 with fused multiply-add.
    Avx2,
    /// AVX-512 with 256-bit vectors: as AVX2, with masks in registers of their own.
    Avx512,
}

impl SimdLevel {
    /// All of them, from the least to the most demanding.
    pub const ALL: &[Self] = &[Self::Portable, Self::Avx2, Self::Avx512];

    /// Its name in lower case.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Portable => "portable",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
        }
    }

    /// The most demanding that this processor can do.
    pub fn best() -> Self {
        Self::ALL.iter().rev().copied().find(|level| level.is_available()).unwrap_or(Self::Portable)
    }

    /// True if this processor can do it.
    pub fn is_available(self) -> bool {
        #[cfg(target_arch = "x86_64")]
        match self {
            Self::Portable => true,
            Self::Avx2 => x86::Avx2::detect().is_some(),
            Self::Avx512 => x86::Avx512::detect().is_some(),
        }
        #[cfg(not(target_arch = "x86_64"))]
        {
            self == Self::Portable
        }
    }
}

/// A level that the processor has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DetectedSimd {
    Portable(Portable),
    #[cfg(target_arch = "x86_64")]
    Avx2(x86::Avx2),
    #[cfg(target_arch = "x86_64")]
    Avx512(x86::Avx512),
}

impl DetectedSimd {
    /// The level, or the portable one if the processor does not have it.
    pub(super) fn new(level: SimdLevel) -> Self {
        #[cfg(target_arch = "x86_64")]
        let available = match level {
            SimdLevel::Portable => None,
            SimdLevel::Avx2 => x86::Avx2::detect().map(Self::Avx2),
            SimdLevel::Avx512 => x86::Avx512::detect().map(Self::Avx512),
        };
        #[cfg(not(target_arch = "x86_64"))]
        let available = None;
        available.unwrap_or(Self::Portable(Portable))
    }

    pub(super) const fn level(self) -> SimdLevel {
        match self {
            Self::Portable(_) => SimdLevel::Portable,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(_) => SimdLevel::Avx2,
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(_) => SimdLevel::Avx512,
        }
    }

    /// Runs a kernel by the instructions of this level.
    #[inline(always)]
    pub(super) fn dispatch<A, B, K: WithSimd<A, B>>(self, kernel: K, a: A, b: B) {
        match self {
            Self::Portable(simd) => simd.dispatch(kernel, a, b),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(simd) => simd.dispatch(kernel, a, b),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(simd) => simd.dispatch(kernel, a, b),
        }
    }
}

impl Default for DetectedSimd {
    /// The best.
    fn default() -> Self {
        Self::new(SimdLevel::best())
    }
}

impl Default for SimdLevel {
    fn default() -> Self {
        Self::best()
    }
}
