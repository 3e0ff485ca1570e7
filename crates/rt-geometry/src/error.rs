//! What can be wrong with a shape.

use rt_math::DVec3;

/// Why a shape cannot be made. Each variant holds the offending value.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ShapeError {
    /// A coordinate is NaN, infinite, or beyond the range in which kernels keep their precision.
    #[error("coordinate {0} is not a finite number of magnitude at most 1e60")]
    BadCoordinate(f64),
    /// The radius is not positive, or so small that its square underflows.
    #[error("radius {0} must be positive (at least 1e-60)")]
    BadRadius(f64),
    /// A box whose minimum exceeds its maximum.
    #[error("box minimum {min} exceeds maximum {max} on axis {axis}")]
    InvertedBox {
        /// Axis: 0, 1 or 2.
        axis: usize,
        /// Its minimum.
        min: f64,
        /// Its maximum.
        max: f64,
    },
    /// A normal of length zero.
    #[error("the normal must not be zero")]
    ZeroNormal,
    /// A triangle without area.
    #[error("the triangle {0:?} has no area")]
    NoArea([DVec3; 3]),
}

/// Largest magnitude of a coordinate: squares and cubes of it stay far from overflow.
const MAX_COORDINATE: f64 = 1e60;

/// Checks that all components are usable coordinates.
pub(crate) fn check_coordinates(points: impl IntoIterator<Item = DVec3>) -> Result<(), ShapeError> {
    match points.into_iter().flat_map(|p| p.to_array()).find(|c| !c.is_finite() || c.abs() > MAX_COORDINATE) {
        Some(bad) => Err(ShapeError::BadCoordinate(bad)),
        None => Ok(()),
    }
}
