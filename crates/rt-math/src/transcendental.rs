//! Elementary functions with the same bits on every platform.
//!
//! IEEE 754 specifies + − × ÷ and √ bit for bit, and no more. The functions here are those of the `libm` crate:
//! plain Rust, one result everywhere. Angles are in radians.

pub use libm::{acos, asin, atan, atan2, cbrt, cos, exp, exp2, hypot, lgamma, log, log2, pow, sin, sincos, tan};
