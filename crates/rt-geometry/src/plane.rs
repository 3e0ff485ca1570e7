//! Infinite planes.

use crate::error::{ShapeError, check_coordinates};
use rt_math::DVec3;

/// An infinite plane; its front is the side of the normal. It has no bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    pub(crate) point: DVec3,
    pub(crate) normal: DVec3,
}

impl Plane {
    /// The plane through `point`, perpendicular to `normal` (any non-zero length).
    ///
    /// # Errors
    /// If the normal is zero or a number is not finite.
    pub fn new(point: DVec3, normal: DVec3) -> Result<Self, ShapeError> {
        check_coordinates([point, normal])?;
        let normal = normal.try_normalize().ok_or(ShapeError::ZeroNormal)?;
        Ok(Self { point, normal })
    }

    /// A point on the plane: the origin of its texture coordinates.
    pub const fn point(&self) -> DVec3 {
        self.point
    }

    /// The unit normal.
    pub const fn normal(&self) -> DVec3 {
        self.normal
    }
}
