//! Instruction sets, and the choice among them at run time.

use super::lanes::WithSimd;
use super::portable::Portable;
#[cfg(target_arch = "x86_64")]
use super::x86;

/// Instruction set of the traversal kernels.
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

    /// True if this processor supports the level.
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

/// A level that the processor supports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::wide) enum DetectedSimd {
    Portable(Portable),
    #[cfg(target_arch = "x86_64")]
    Avx2(x86::Avx2),
    #[cfg(target_arch = "x86_64")]
    Avx512(x86::Avx512),
}

impl DetectedSimd {
    /// The given level, or the portable one if the processor does not support it.
    pub(in crate::wide) fn new(level: SimdLevel) -> Self {
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

    pub(in crate::wide) const fn level(self) -> SimdLevel {
        match self {
            Self::Portable(_) => SimdLevel::Portable,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(_) => SimdLevel::Avx2,
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(_) => SimdLevel::Avx512,
        }
    }

    /// Runs a kernel with the instructions of this level.
    #[inline(always)]
    pub(in crate::wide) fn dispatch<A, B, K: WithSimd<A, B>>(self, kernel: K, a: A, b: B) {
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
    fn default() -> Self {
        Self::new(SimdLevel::best())
    }
}

impl Default for SimdLevel {
    fn default() -> Self {
        Self::best()
    }
}
