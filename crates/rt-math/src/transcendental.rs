//! Elementary functions with the same bits on every platform, for one number and for SIMD lanes.
//!
//! IEEE 754 specifies + − × ÷ and √ bit for bit, and no more. The functions that are generic over [`Float64`] consist of these
//! operations and of integer operations on bits, without fused multiply-adds. Each lane has the bits of the scalar call. The other
//! functions are those of the `libm` crate. Angles are in radians.
//!
//! Errors are given in ulp, units in the last place of the exact result. Tests compare with series in integers of 384 bits.
//!
//! A minimax polynomial has the least maximum of the error on its interval. Its coefficients were computed by the Remez exchange with
//! 400 bits. Except in `exp`, each of the first four was rounded to `f64` before the higher ones were fitted again. The errors that are
//! stated with the coefficients are those after rounding.
//!
//! [`Float64`]: crate::Float64

mod exponential;
mod inverse_trigonometric;
mod parts;
#[cfg(test)]
mod tests;
mod trigonometric;

pub use exponential::{Pow, exp, exp2, log, log2, pow};
pub use inverse_trigonometric::{acos, asin, atan, atan2};
pub use libm::{cbrt, hypot, lgamma, tan};
pub use trigonometric::{cos, sin, sincos};
