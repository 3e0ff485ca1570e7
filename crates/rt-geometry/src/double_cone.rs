//! Infinite double cones.

use crate::error::{ShapeError, check_length};
use crate::lateral::{Lateral, longitude};
use crate::{ShapeHit, SurfaceInteraction, SurfaceNeeds};
use rt_math::{Interval, Ray};

/// Two endless cones around the y axis that meet in their apex at the origin; the normal points away from the axis, at
/// the apex against the ray that arrives. It has no bounds.
///
/// Texture coordinates: `u` runs once around +y as on a [`Sphere`](crate::Sphere), with +z at ½; `v` is y, a length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DoubleCone(Lateral);

impl DoubleCone {
    /// The cone x² + z² = slope²·y²: at height 1 it is `slope` wide from the axis.
    ///
    /// # Errors
    /// If the slope is not positive (at least 1e-60) or not finite.
    pub fn new(slope: f64) -> Result<Self, ShapeError> {
        check_length("slope", slope)?;
        Ok(Self(Lateral { height: 0.0, radius: 0.0, slope }))
    }

    /// The radius at height 1, positive.
    pub const fn slope(&self) -> f64 {
        self.0.slope
    }

    /// The first crossing of the surface within `span`. `None` on a miss, for rays within the surface, and for rays
    /// without a direction.
    ///
    /// With k the slope and |·| lengths across the axis, the crossings solve a·t² − 2b·t + c = 0 with
    /// a = (|d| − k|d_y|)(|d| + k|d_y|), c alike with the origin, and the discriminant k²|o_y·d − d_y·o|² − (o × d)²,
    /// factored as well. A ray along a generator has a = 0 and one crossing, c/2b.
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
