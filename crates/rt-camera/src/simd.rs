//! Computations in SIMD lanes, and the choice of the instruction set at run time.

#[cfg(target_arch = "x86_64")]
mod x86 {
    use std::sync::LazyLock;

    use fearless_simd::{Avx2, Avx512, Level, Simd};

    static LEVELS: LazyLock<(Option<Avx512>, Option<Avx2>)> =
        LazyLock::new(|| (Level::new().as_avx512(), Level::new().as_avx2()));

    #[inline(always)]
    pub(super) fn vectorize<R>(function: impl FnOnce() -> R) -> R {
        match *LEVELS {
            (Some(avx512), _) => avx512.vectorize(function),
            (_, Some(avx2)) => avx2.vectorize(function),
            _ => function(),
        }
    }

    #[inline(always)]
    pub(super) fn try_vectorize<R>(function: impl FnOnce() -> R) -> Option<R> {
        match *LEVELS {
            (Some(avx512), _) => Some(avx512.vectorize(function)),
            (_, Some(avx2)) => Some(avx2.vectorize(function)),
            _ => None,
        }
    }
}

/// Calls a function, in a version compiled for AVX-512 or AVX2 if the processor has it. Only what is inlined into `function` is
/// compiled so, hence everything that it calls must be `#[inline(always)]`.
///
/// The results are the same: all instruction sets compute integers exactly, and correctly rounded numbers.
#[inline(always)]
pub(crate) fn vectorize<R>(function: impl FnOnce() -> R) -> R {
    #[cfg(target_arch = "x86_64")]
    return x86::vectorize(function);
    #[cfg(not(target_arch = "x86_64"))]
    function()
}

/// Version of [`vectorize`] for functions that take long to compile: `None` on x86 processors without AVX2. The caller then computes one
/// value after the other.
#[inline(always)]
pub(crate) fn try_vectorize<R>(function: impl FnOnce() -> R) -> Option<R> {
    #[cfg(target_arch = "x86_64")]
    return x86::try_vectorize(function);
    #[cfg(not(target_arch = "x86_64"))]
    Some(function())
}

/// The value of each of `N` lanes.
///
/// The loop becomes vector instructions also in the dev profile, which calls the closure of `core::array::from_fn` for each element.
#[inline(always)]
pub(crate) fn lanes<T: Copy + Default, const N: usize>(value: impl Fn(usize) -> T) -> [T; N] {
    let mut values = [T::default(); N];
    for (lane, slot) in values.iter_mut().enumerate() {
        *slot = value(lane);
    }
    values
}
