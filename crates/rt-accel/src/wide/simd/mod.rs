//! Eight `f32`, or four `f64`, at a time on any processor.
//!
//! Kernels are written once against [`Simd`] and compiled for AVX-512, AVX2 and a portable level. [`SimdLevel`] selects one
//! at run time. The last bits of filters differ between levels; query results do not.

mod lanes;
mod level;
mod portable;
#[cfg(target_arch = "x86_64")]
mod x86;

pub(super) use lanes::{Simd, WithSimd, take_lane};
pub(super) use level::DetectedSimd;
pub use level::SimdLevel;
