//! Spheres.

use crate::error::{ShapeError, check_coordinates};
use rt_math::DVec3;

/// A sphere; its normal points outwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    pub(crate) centre: DVec3,
    pub(crate) radius: f64,
}

impl Sphere {
    /// A sphere around `centre`.
    ///
    /// # Errors
    /// If the radius is not positive or a number is not finite.
    pub fn new(centre: DVec3, radius: f64) -> Result<Self, ShapeError> {
        check_coordinates([centre, DVec3::splat(radius)])?;
        if radius > 0.0 { Ok(Self { centre, radius }) } else { Err(ShapeError::BadRadius(radius)) }
    }

    /// The centre.
    pub const fn centre(&self) -> DVec3 {
        self.centre
    }

    /// The radius, positive.
    pub const fn radius(&self) -> f64 {
        self.radius
    }
}
