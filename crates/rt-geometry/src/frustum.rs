//! Frusta: cones without their tip.

use crate::error::{ShapeError, check_length, check_radius};
use crate::lateral::Lateral;
use crate::truncated::Truncated;
use crate::{ShapeHit, SurfaceInteraction, SurfaceNeeds};
use rt_math::{Aabb, DVec3, Interval, Ray};

/// A cone cut off at both ends that stands on the plane y = 0: a closed solid with caps, or open without. Its normal
/// points outwards, away from the axis on the side.
///
/// Texture coordinates are those of a [`Cylinder`](crate::Cylinder).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frustum(Truncated);

impl Frustum {
    /// The solid from a disk at y = 0 to one at y = `height`; only its side if it has no `caps`. Either disk may be
    /// the larger one; a tip is for a [`Cone`](crate::Cone).
    ///
    /// # Errors
    /// If a radius or the height is not positive (at least 1e-60), or not finite.
    pub fn new(bottom_radius: f64, top_radius: f64, height: f64, caps: bool) -> Result<Self, ShapeError> {
        check_radius(bottom_radius)?;
        check_radius(top_radius)?;
        check_length("height", height)?;
        let slope = (top_radius - bottom_radius) / height;
        // Near the smaller end a rounding error matters most.
        let side = if bottom_radius < top_radius {
            Lateral { height: 0.0, radius: bottom_radius, slope }
        } else {
            Lateral { height, radius: top_radius, slope }
        };
        Ok(Self(Truncated { side, bottom: 0.0, top: height, caps }))
    }

    /// Height of the upper end, positive.
    pub const fn height(&self) -> f64 {
        self.0.top
    }

    /// True for a closed solid, false for an open surface.
    pub const fn has_caps(&self) -> bool {
        self.0.caps
    }

    /// The smallest box around the frustum, rounded outwards.
    pub fn bounds(&self) -> Aabb {
        self.0.bounds()
    }

    /// How far the frustum reaches in a direction: the greatest dot product with one of its points.
    pub(crate) fn support(&self, direction: DVec3) -> f64 {
        self.0.support(direction)
    }

    /// The first crossing of the surface within `span`. `None` on a miss, and for rays without a direction. See
    /// [`DoubleCone`](crate::DoubleCone) for the arithmetic.
    #[inline]
    pub fn intersect(&self, ray: &Ray, span: Interval) -> Option<ShapeHit> {
        self.0.intersect(ray, span)
    }

    /// The surface at a hit of [`intersect`](Self::intersect).
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit, needs: SurfaceNeeds) -> SurfaceInteraction {
        self.0.surface(ray, hit, needs)
    }
}
