//! Spheres.

use crate::error::{ShapeError, check_coordinates};
use crate::{ShapeHit, SurfaceInteraction, SurfaceNeeds};
use rt_math::float::{UNIT_ROUNDOFF, gamma};
use rt_math::transcendental::{atan2, hypot};
use rt_math::{Aabb, DVec3, Interval, Ray};
use std::f64::consts::{PI, TAU};

/// Least radius: its square and the square of that stay far from underflow.
const MIN_RADIUS: f64 = 1e-60;

/// The quick rejection must not lose a hit to its own rounding. Its three dot products, their products and their
/// difference are off by fewer than 24 roundings of their terms.
const REJECTION: f64 = gamma(24);

/// A sphere; its normal points outwards.
///
/// Texture coordinates: `u` runs once around +y, from −z over −x, +z (where it is ½) and +x, so that an image appears
/// upright and unmirrored from outside; `v` runs with the latitude from 0 at the south pole (−y) to 1 at the north.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    centre: DVec3,
    radius: f64,
}

impl Sphere {
    /// A sphere around `centre`.
    ///
    /// # Errors
    /// If the radius is not positive (at least 1e-60) or a number is not finite.
    pub fn new(centre: DVec3, radius: f64) -> Result<Self, ShapeError> {
        check_coordinates([centre, DVec3::splat(radius)])?;
        if radius >= MIN_RADIUS { Ok(Self { centre, radius }) } else { Err(ShapeError::BadRadius(radius)) }
    }

    /// The centre.
    pub const fn centre(&self) -> DVec3 {
        self.centre
    }

    /// The radius, positive.
    pub const fn radius(&self) -> f64 {
        self.radius
    }

    /// The smallest box around the sphere, rounded outwards.
    pub fn bounds(&self) -> Aabb {
        let (min, max) = (self.centre - self.radius, self.centre + self.radius);
        Aabb::new(min.map(f64::next_down), max.map(f64::next_up))
    }

    /// The first of the two crossings within `span`. `None` on a miss, and for rays without a direction.
    ///
    /// With f from the centre to the ray's origin, the crossings solve a·t² − 2b·t + c = 0. Three cancellations are
    /// avoided: the discriminant is taken from the ray's closest approach to the centre (Haines, Günther,
    /// Akenine-Möller, "Precision Improvements for Ray/Sphere Intersection", RTG 2019, ch. 7), c from a difference of
    /// lengths rather than of squares, and the smaller root from c/q.
    #[inline]
    pub fn intersect(&self, ray: &Ray, span: Interval) -> Option<ShapeHit> {
        let d = ray.direction;
        let f = ray.origin - self.centre;
        let (a, b, ff, rr) = (d.dot(d), -f.dot(d), f.dot(f), self.radius * self.radius);

        // Most offers end here. `excess` is positive only if the origin is outside beyond doubt.
        let excess = ff * (1.0 - REJECTION) - rr * (1.0 + REJECTION);
        let passes_by = b * b < a * excess;
        let lies_behind = excess > 0.0 && b < 0.0 && span.min >= 0.0;
        if passes_by || lies_behind {
            return None;
        }

        let closest = f + d * (b / a);
        let discriminant = a * (rr - closest.dot(closest));
        if !(0.0..f64::INFINITY).contains(&discriminant) {
            return None;
        }
        let q = b + discriminant.sqrt().copysign(b);
        let length = ff.sqrt();
        let c = (length - self.radius) * (length + self.radius);
        // Both roots are 0 for a tangent at its own origin.
        let (t0, t1) = if q == 0.0 { (0.0, 0.0) } else { (c / q, q / a) };
        let t = span.first(t0.min(t1), t0.max(t1))?;
        Some(ShapeHit { t, uv: [0.0; 2] })
    }

    /// The surface at a hit of [`intersect`](Self::intersect).
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit, needs: SurfaceNeeds) -> SurfaceInteraction {
        let f = (ray.origin - self.centre) + ray.direction * hit.t;
        // From so far away that rounding puts the hit on the centre, the best guess is the side of the viewer.
        let normal = f.try_normalize().unwrap_or_else(|| -ray.direction.normalize_or(DVec3::Y));
        let point = self.centre + normal * self.radius;
        let point_error = normal.abs() * (self.radius * gamma(10)) + point.abs() * (2.0 * UNIT_ROUNDOFF);
        let uv = if needs.uv { spherical_uv(normal) } else { [0.0; 2] };
        SurfaceInteraction::flat(point, point_error, normal, uv)
    }
}

/// Longitude and latitude of a direction as texture coordinates.
fn spherical_uv(n: DVec3) -> [f64; 2] {
    [0.5 + atan2(n.x, n.z) / TAU, 0.5 + atan2(n.y, hypot(n.x, n.z)) / PI]
}
