//! Finite cones.

use crate::error::{ShapeError, check_length, check_radius};
use crate::lateral::Lateral;
use crate::truncated::Truncated;
use crate::{ShapeHit, SurfaceInteraction, SurfaceNeeds};
use rt_math::{Aabb, DVec3, Interval, Ray};

/// A cone that stands on the plane y = 0 with its apex above: a closed solid with a cap below, or open without. Its
/// normal points outwards, away from the axis on the side; at the apex it is opposite to the ray that arrives.
///
/// Texture coordinates are those of a [`Cylinder`](crate::Cylinder).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone(Truncated);

impl Cone {
    /// The cone with its base of this radius at y = 0 and its apex at y = `height`; only its side if it has no `caps`.
    ///
    /// # Errors
    /// If the radius or the height is not positive (at least 1e-60), or not finite.
    pub fn new(radius: f64, height: f64, caps: bool) -> Result<Self, ShapeError> {
        check_radius(radius)?;
        check_length("height", height)?;
        let side = Lateral { height, radius: 0.0, slope: -radius / height };
        Ok(Self(Truncated { side, bottom: 0.0, top: height, caps }))
    }

    /// Height of the apex, positive.
    pub const fn height(&self) -> f64 {
        self.0.top
    }

    /// True for a closed solid, false for an open cone.
    pub const fn has_caps(&self) -> bool {
        self.0.caps
    }

    /// The smallest box around the cone, rounded outwards.
    pub fn bounds(&self) -> Aabb {
        self.0.bounds()
    }

    /// How far the cone reaches in a direction: the greatest dot product with one of its points.
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
