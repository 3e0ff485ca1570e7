//! Infinite planes.

use crate::error::{ShapeError, check_coordinates};
use crate::{ShapeHit, SurfaceInteraction, SurfaceNeeds};
use rt_math::float::{UNIT_ROUNDOFF, gamma};
use rt_math::{DVec3, Frame, Interval, Ray};

/// An infinite plane; its front is the side of the normal. It has no bounds.
///
/// Texture coordinates are lengths from [`point`](Self::point) along the tangents of [`Frame::from_z`] of the normal:
/// (x, −z) on a floor with normal +y, (x, y) for +z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    point: DVec3,
    normal: DVec3,
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

    /// Where the ray crosses the plane. `None` if it is parallel, also when it runs within the plane.
    ///
    /// There is no least angle: a grazing ray meets the plane far away, up to the horizon.
    #[inline]
    pub fn intersect(&self, ray: &Ray, span: Interval) -> Option<ShapeHit> {
        let t = self.normal.dot(self.point - ray.origin) / self.normal.dot(ray.direction);
        (span.contains(t) && t.is_finite()).then_some(ShapeHit { t, uv: [0.0; 2] })
    }

    /// The surface at a hit of [`intersect`](Self::intersect).
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit, needs: SurfaceNeeds) -> SurfaceInteraction {
        let normal = self.normal;
        let on_ray = ray.at(hit.t);
        let point = on_ray - normal * normal.dot(on_ray - self.point);
        // Rounding of the projection, and of the numerator when a spawned ray is tested against the plane.
        let distance = gamma(8) * normal.abs().dot(point.abs() + self.point.abs());
        let point_error = normal.abs() * distance + point.abs() * (2.0 * UNIT_ROUNDOFF);
        let uv = if needs.uv { self.uv(ray, hit.t) } else { [0.0; 2] };
        SurfaceInteraction::flat(point, point_error, normal, uv)
    }

    /// From the ray's parts: the hit point is rounded to the grid of its largest coordinate, the parts are not.
    fn uv(&self, ray: &Ray, t: f64) -> [f64; 2] {
        let frame = Frame::from_z(self.normal);
        let (origin, direction) = (ray.origin - self.point, ray.direction);
        [frame.x, frame.y].map(|axis| axis.dot(origin) + t * axis.dot(direction))
    }
}
