//! Errors of camera settings.

use rt_math::{AnimatedTransformError, DVec2};

/// Error of [`Camera::new`](crate::Camera::new): settings of which no camera can be made.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum CameraError {
    /// The image has no pixels.
    #[error("the image is {0}x{1} pixels; both sides must be at least 1")]
    EmptyImage(u32, u32),
    /// The field of view (the value, in radians) is not usable.
    #[error("the field of view is {} degrees; it must lie between 0 and 180", .0.to_degrees())]
    FieldOfView(f64),
    /// The height of an orthographic view (the value, in world units) is not usable.
    #[error("the height of the orthographic view is {0}; it must be positive and finite")]
    Height(f64),
    /// The lens shift is NaN or infinite.
    #[error("the lens shift ({}, {}) must be finite", .0.x, .0.y)]
    LensShift(DVec2),
    /// The radius of the lens (the value, in units of the camera's space) is not usable.
    #[error("the radius of the lens is {0}; it must be finite and not negative")]
    LensRadius(f64),
    /// The depth of the plane of focus (the value, in units of the camera's space) is not usable.
    #[error("the focus distance is {0}; it must be positive and finite")]
    Focus(f64),
    /// The aperture has too few corners.
    #[error("the aperture has {0} blades; it must have at least 3, or none to be round")]
    Blades(u32),
    /// The angle of the aperture is NaN or infinite.
    #[error("the rotation of the aperture is {0}; it must be finite")]
    LensRotation(f64),
    /// The shutter (its two times) is not usable.
    #[error("the shutter is open from {} to {}; it must open and close between 0 and 1, and not close before it opens", .0[0], .0[1])]
    Shutter([f64; 2]),
    /// The two poses of the camera cannot be interpolated.
    #[error(transparent)]
    AnimatedTransform(#[from] AnimatedTransformError),
    /// The rays overflow: the transform scales, or the lens shift reaches, too far.
    #[error("the transform, lens and lens shift of the camera are so large that rays are not finite; reduce them")]
    Overflow,
}
