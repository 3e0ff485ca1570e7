//! Errors of shapes.

use rt_math::DVec3;

/// Error of the constructors of shapes, with the invalid value.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ShapeError {
    /// A coordinate is NaN, infinite, or beyond the range in which kernels keep their precision.
    #[error("coordinate {0:?} is not a finite number of magnitude at most 1e60")]
    BadCoordinate(f64),
    /// The radius is not finite, not positive, or so small or large that its square underflows or overflows.
    #[error("radius {} must be {}", short(*.0), limit(*.0))]
    BadRadius(f64),
    /// A length or a slope that is not finite, not positive, or so small or large that its square underflows or overflows.
    #[error("{} {} must be {}", .0, short(*.1), limit(*.1))]
    BadLength(&'static str, f64),
    /// A cylinder whose top is not above its bottom.
    #[error("the top {top} must be above the bottom {bottom}")]
    NoHeight {
        /// Height of the bottom.
        bottom: f64,
        /// Height of the top.
        top: f64,
    },
    /// A ring whose hole is negative or as large as the ring.
    #[error("inner radius {inner} must be at least 0 and less than the radius {outer}")]
    BadInnerRadius {
        /// Radius of the hole.
        inner: f64,
        /// Radius of the ring.
        outer: f64,
    },
    /// A torus that passes through itself.
    #[error("tube radius {tube_radius} must be less than the radius {radius} of the ring: there is no hole")]
    ClosedHole {
        /// Radius of the ring.
        radius: f64,
        /// Radius of the tube.
        tube_radius: f64,
    },
    /// A box whose minimum exceeds its maximum.
    #[error("box minimum {min} exceeds maximum {max} on the {} axis", ["x", "y", "z"].get(*axis).unwrap_or(&"?"))]
    InvertedBox {
        /// Axis: 0, 1 or 2.
        axis: usize,
        /// Its minimum.
        min: f64,
        /// Its maximum.
        max: f64,
    },
    /// A normal of length zero.
    #[error("the normal is zero; give a direction")]
    ZeroNormal,
    /// A triangle without area.
    #[error("the triangle {a}, {b}, {c} has no area; move one of its vertices", a = .0[0], b = .0[1], c = .0[2])]
    NoArea([DVec3; 3]),
}

/// Largest magnitude of a coordinate of shapes and meshes: squares and cubes of it stay far from overflow.
pub const MAX_COORDINATE: f64 = 1e60;

/// Checks that all components are usable coordinates.
pub(crate) fn check_coordinates(points: impl IntoIterator<Item = DVec3>) -> Result<(), ShapeError> {
    match points.into_iter().flat_map(|p| p.to_array()).find(|c| !c.is_finite() || c.abs() > MAX_COORDINATE) {
        Some(bad) => Err(ShapeError::BadCoordinate(bad)),
        None => Ok(()),
    }
}

/// Minimum radius or length: its square and the square of that stay far from underflow.
const MIN_LENGTH: f64 = 1e-60;

/// A number without hundreds of zeros.
fn short(value: f64) -> String {
    if value.abs() < 1e-4 && value != 0.0 || value.abs() > 1e16 { format!("{value:?}") } else { value.to_string() }
}

/// Limit that a radius or length violates.
fn limit(value: f64) -> &'static str {
    if value > MAX_COORDINATE { "at most 1e60" } else { "positive (at least 1e-60)" }
}

fn is_length(value: f64) -> bool {
    (MIN_LENGTH..=MAX_COORDINATE).contains(&value)
}

/// Checks a radius: positive and finite.
pub(crate) fn check_radius(radius: f64) -> Result<(), ShapeError> {
    if is_length(radius) { Ok(()) } else { Err(ShapeError::BadRadius(radius)) }
}

/// Checks a length or slope other than a radius: positive and finite. `what` names it in the message.
pub(crate) fn check_length(what: &'static str, length: f64) -> Result<(), ShapeError> {
    if is_length(length) { Ok(()) } else { Err(ShapeError::BadLength(what, length)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refused_radii_are_named_in_few_digits() {
        let message = |radius| check_radius(radius).expect_err("a refused radius").to_string();
        assert_eq!(message(0.0), "radius 0 must be positive (at least 1e-60)");
        assert_eq!(message(1e-320), "radius 1e-320 must be positive (at least 1e-60)");
        assert_eq!(message(f64::NAN), "radius NaN must be positive (at least 1e-60)");
        assert_eq!(message(1e300), "radius 1e300 must be at most 1e60");
        assert_eq!(message(f64::INFINITY), "radius inf must be at most 1e60");
    }
}
