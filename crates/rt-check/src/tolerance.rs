//! Rounding errors of positions.

use rt_math::float::UNIT_ROUNDOFF;

/// Maximum computed distance of coincident surfaces: the errors of both transforms, and a few roundings of the
/// largest coordinate.
pub(crate) fn tolerance(placement_errors: f64, max_abs: f64) -> f64 {
    4.0 * placement_errors + 8.0 * UNIT_ROUNDOFF * max_abs
}
