//! Connection of a point to a camera.

use crate::{DVec2, DVec3};

/// Connection of a world point to a camera, for light tracing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraWiSample {
    /// Origin of the camera ray to the point, world space.
    pub origin: DVec3,
    /// Raster position of the point; possibly outside the image.
    pub raster: DVec2,
    /// Pixels that a unit of area covers at the point, if it faces along the ray.
    pub importance: f64,
}
