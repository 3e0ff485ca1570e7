//! The virtual pinhole camera.

use rt_math::{DVec2, Transform};

/// Which side of the image the field of view spans.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FovAxis {
    /// The height of the image.
    Vertical,
    /// The width of the image.
    Horizontal,
}

/// How points are projected on the image plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Through a pinhole.
    Perspective {
        /// Full opening angle in radians, in (0, π).
        fov: f64,
        /// The side of the image that it spans.
        axis: FovAxis,
    },
    /// Along parallel rays.
    Orthographic {
        /// Height of the visible part of the world, in world units.
        height: f64,
    },
}

/// Everything about a camera but the image that it exposes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraSettings {
    /// The camera looks along its −z, with +y up and +x to the right.
    pub world_from_camera: Transform,
    /// The projection.
    pub projection: Projection,
    /// Shift of the lens, as a part of the image's width and height: (0.5, 0) shows what lies half an image further
    /// to the right.
    pub lens_shift: DVec2,
}
