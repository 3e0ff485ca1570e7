//! Errors of light constructors.

use rt_geometry::ShapeError;
use rt_math::{Rgb, TransformError};

/// Largest component of a radiance: sums over images and areas stay far from overflow.
const MAX_RADIANCE: f64 = 1e100;

/// Checks that a radiance can be summed and sampled.
pub(super) fn check_radiance(radiance: Rgb) -> Result<(), LightError> {
    let is_usable = |x: f64| (0.0..=MAX_RADIANCE).contains(&x);
    if radiance.to_array().into_iter().all(is_usable) { Ok(()) } else { Err(LightError::BadRadiance(radiance)) }
}

/// Invalid parameter of a light. Each variant holds the offending value.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum LightError {
    /// Radiance that is NaN, negative, or too great to be summed.
    #[error("radiance ({}, {}, {}) must have components from 0 to 1e100", .0.r, .0.g, .0.b)]
    BadRadiance(Rgb),
    /// Pixel of an image with an invalid radiance.
    #[error("pixel ({column}, {row}) has the radiance ({}, {}, {}); components must be from 0 to 1e100", .radiance.r, .radiance.g, .radiance.b)]
    BadPixel {
        /// Column, from the left.
        column: usize,
        /// Row, from the top.
        row: usize,
        /// Radiance of the pixel.
        radiance: Rgb,
    },
    /// Image without pixels, or with a number of pixels that is not width times height.
    #[error("an image of {width}×{height} pixels cannot have {pixels} of them")]
    BadImage {
        /// Pixels from left to right.
        width: usize,
        /// Pixels from top to bottom.
        height: usize,
        /// Number of pixels.
        pixels: usize,
    },
    /// Area that is zero or not finite.
    #[error("the area {0} of the light must be positive")]
    BadArea(f64),
    /// Invalid shape.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// Invalid rotation.
    #[error(transparent)]
    Rotation(#[from] TransformError),
}
