//! Axis-aligned boxes as shapes.

use crate::error::{ShapeError, check_coordinates};
use rt_math::{Aabb, DVec3};

/// A closed solid box with faces along the axes; its normal points outwards. It may be flat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisBox {
    pub(crate) bounds: Aabb,
}

impl AxisBox {
    /// The box from `min` to `max`.
    ///
    /// # Errors
    /// If `min` exceeds `max` on an axis or a number is not finite.
    pub fn new(min: DVec3, max: DVec3) -> Result<Self, ShapeError> {
        check_coordinates([min, max])?;
        match (0..3).find(|&axis| min[axis] > max[axis]) {
            Some(axis) => Err(ShapeError::InvertedBox { axis, min: min[axis], max: max[axis] }),
            None => Ok(Self { bounds: Aabb::new(min, max) }),
        }
    }

    /// The extent of the box.
    pub const fn bounds(&self) -> Aabb {
        self.bounds
    }
}
