//! Finite cylinders.

use crate::error::{ShapeError, check_coordinates, check_radius};
use crate::lateral::Lateral;
use crate::truncated::Truncated;
use crate::{ShapeHit, SurfaceInteraction, SurfaceNeeds};
use rt_math::{Aabb, DVec3, Interval, Ray};

/// A cylinder around the y axis, from a bottom to a top: a closed solid with caps, or an open tube without. Its normal
/// points outwards, away from the axis on the side.
///
/// Texture coordinates on the side: `u` runs once around +y as on a [`Sphere`](crate::Sphere), with +z at ½, and `v`
/// from 0 at the bottom to 1 at the top. On the caps they run from 0 to 1 over the square around the disk, upright and
/// unmirrored from outside: `v` runs along −z on the top and along +z on the bottom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder(Truncated);

impl Cylinder {
    /// The cylinder x² + z² ≤ radius² with `bottom` ≤ y ≤ `top`; only its side if it has no `caps`.
    ///
    /// # Errors
    /// If the radius is not positive (at least 1e-60), the top is not above the bottom, or a number is not finite.
    pub fn new(radius: f64, bottom: f64, top: f64, caps: bool) -> Result<Self, ShapeError> {
        check_coordinates([DVec3::new(bottom, top, 0.0)])?;
        check_radius(radius)?;
        if bottom >= top {
            return Err(ShapeError::NoHeight { bottom, top });
        }
        Ok(Self(Truncated { side: Lateral { height: bottom, radius, slope: 0.0 }, bottom, top, caps }))
    }

    /// The radius, positive.
    pub const fn radius(&self) -> f64 {
        self.0.side.radius
    }

    /// Heights of the bottom and of the top.
    pub const fn heights(&self) -> [f64; 2] {
        [self.0.bottom, self.0.top]
    }

    /// True for a closed solid, false for an open tube.
    pub const fn has_caps(&self) -> bool {
        self.0.caps
    }

    /// The smallest box around the cylinder, rounded outwards.
    pub fn bounds(&self) -> Aabb {
        self.0.bounds()
    }

    /// How far the cylinder reaches in a direction: the greatest dot product with one of its points.
    pub(crate) fn support(&self, direction: DVec3) -> f64 {
        self.0.support(direction)
    }

    /// The first crossing of the surface within `span`. `None` on a miss, and for rays without a direction.
    ///
    /// The circle that the side is from above is met as a sphere is: by the distance L at which the ray passes the
    /// axis, from (r − L)(r + L). A ray along the axis meets the caps alone, to and including their rims.
    #[inline]
    pub fn intersect(&self, ray: &Ray, span: Interval) -> Option<ShapeHit> {
        self.0.intersect(ray, span)
    }

    /// The surface at a hit of [`intersect`](Self::intersect).
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit, needs: SurfaceNeeds) -> SurfaceInteraction {
        self.0.surface(ray, hit, needs)
    }
}
