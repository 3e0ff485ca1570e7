//! Instruction sets, and the choice among them at run time.

use super::lanes::WithSimd;
use super::portable::Portable;
#[cfg(target_arch = "x86_64")]
use super::x86;

/// Instruction set of the traversal kernels.
///
/// On x86-64, the feature `all-simd` of the crate compiles trees for AVX-512, and portable packets, which take half of the time to
/// build the crate. Without it, AVX2 replaces AVX-512 in trees, but not in lists of few primitives. Rays of a stream are then traced one
/// by one at the portable level. The results are the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum SimdLevel {
    /// Twice four numbers: SSE2, NEON, or scalar arithmetic.
    Portable,
    /// AVX2 with fused multiply-add.
    Avx2,
    /// AVX-512: mask registers, and eight `f64` in a vector.
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
        DetectedSimd::detect(self).is_some()
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
    /// The given level, or the most demanding available one below it.
    pub(in crate::wide) fn new(level: SimdLevel) -> Self {
        let mut not_above = SimdLevel::ALL.iter().rev().filter(|&&other| other <= level);
        not_above.find_map(|&level| Self::detect(level)).unwrap_or(Self::Portable(Portable))
    }

    /// `None` if the processor does not support the level, or it is not compiled.
    fn detect(level: SimdLevel) -> Option<Self> {
        match level {
            SimdLevel::Portable => Some(Self::Portable(Portable)),
            #[cfg(target_arch = "x86_64")]
            SimdLevel::Avx2 => x86::Avx2::detect().map(Self::Avx2),
            #[cfg(target_arch = "x86_64")]
            SimdLevel::Avx512 => x86::Avx512::detect().map(Self::Avx512),
            #[cfg(not(target_arch = "x86_64"))]
            _ => None,
        }
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
            #[cfg(all(target_arch = "x86_64", feature = "all-simd"))]
            Self::Avx512(simd) => simd.dispatch(kernel, a, b),
            #[cfg(all(target_arch = "x86_64", not(feature = "all-simd")))]
            Self::Avx512(simd) => simd.as_avx2().dispatch(kernel, a, b),
        }
    }

    /// Runs a kernel for many rays. False, without running it, if such kernels are not compiled for this level.
    #[must_use]
    #[inline(always)]
    pub(in crate::wide) fn dispatch_packets<A, B, K: WithSimd<A, B>>(self, kernel: K, a: A, b: B) -> bool {
        match self {
            #[cfg(any(not(target_arch = "x86_64"), feature = "all-simd"))]
            Self::Portable(simd) => simd.dispatch(kernel, a, b),
            #[cfg(all(target_arch = "x86_64", not(feature = "all-simd")))]
            Self::Portable(_) => return false,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(simd) => simd.dispatch(kernel, a, b),
            #[cfg(all(target_arch = "x86_64", feature = "all-simd"))]
            Self::Avx512(simd) => simd.dispatch(kernel, a, b),
            #[cfg(all(target_arch = "x86_64", not(feature = "all-simd")))]
            Self::Avx512(simd) => simd.as_avx2().dispatch(kernel, a, b),
        }
        true
    }

    /// Version of [`dispatch_packets`](Self::dispatch_packets) for small kernels, which are always compiled for AVX-512.
    #[must_use]
    #[inline(always)]
    pub(in crate::wide) fn dispatch_lists<A, B, K: WithSimd<A, B>>(self, kernel: K, a: A, b: B) -> bool {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(simd) => {
                simd.dispatch(kernel, a, b);
                true
            }
            _ => self.dispatch_packets(kernel, a, b),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_most_demanding_available_level_replaces_one_that_is_not_available() {
        for (i, &level) in SimdLevel::ALL.iter().enumerate() {
            let expected = SimdLevel::ALL[..=i].iter().rev().find(|level| level.is_available());
            assert_eq!(Some(&DetectedSimd::new(level).level()), expected);
        }
        assert!(SimdLevel::Portable.is_available());
    }
}
