//! Infinite cylinders.

use crate::error::{ShapeError, check_radius};
use crate::lateral::{Lateral, longitude};
use crate::{ShapeHit, SurfaceInteraction, SurfaceNeeds};
use rt_math::{Interval, Ray};

/// An endless cylinder around the y axis; its normal points outwards. It has no bounds.
///
/// Texture coordinates: `u` runs once around +y as on a [`Sphere`](crate::Sphere), with +z at ½; `v` is y, a length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InfiniteCylinder(Lateral);

impl InfiniteCylinder {
    /// The cylinder x² + z² = radius².
    ///
    /// # Errors
    /// If the radius is not positive (at least 1e-60) or not finite.
    pub fn new(radius: f64) -> Result<Self, ShapeError> {
        check_radius(radius)?;
        Ok(Self(Lateral { height: 0.0, radius, slope: 0.0 }))
    }

    /// The radius, positive.
    pub const fn radius(&self) -> f64 {
        self.0.radius
    }

    /// The first crossing of the surface within `span`. `None` on a miss, for rays along the axis, also within the
    /// surface, and for rays without a direction. See [`Cylinder`](crate::Cylinder) for the arithmetic.
    #[inline]
    pub fn intersect(&self, ray: &Ray, span: Interval) -> Option<ShapeHit> {
        let t = self.0.first_crossing(ray, span, |_| true)?;
        Some(ShapeHit { t, uv: [0.0; 2] })
    }

    /// The surface at a hit of [`intersect`](Self::intersect).
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit, needs: SurfaceNeeds) -> SurfaceInteraction {
        let mut surface = self.0.surface(ray, hit.t, [f64::NEG_INFINITY, f64::INFINITY]);
        if needs.uv {
            surface.uv = [longitude(surface.point), surface.point.y];
        }
        surface
    }
}
