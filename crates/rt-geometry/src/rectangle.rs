//! Rectangles: finite planes.

use crate::error::{ShapeError, check_length};
use crate::{InteractionFlags, ShapeHit, SurfaceInteraction};
use rt_math::float::gamma;
use rt_math::{Aabb, DVec3, Interval, Ray};

/// A flat rectangle around the origin in the plane y = 0 with sides along x and z; its front faces +y.
///
/// Texture coordinates run from 0 to 1, `u` along +x and `v` along −z. Seen from above with +x to the right, an image
/// is upright and unmirrored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    width: f64,
    depth: f64,
}

impl Rectangle {
    /// The rectangle that is `width` long along x and `depth` along z.
    ///
    /// # Errors
    /// If a side is not positive (at least 1e-60) or not finite.
    pub fn new(width: f64, depth: f64) -> Result<Self, ShapeError> {
        check_length("width", width)?;
        check_length("depth", depth)?;
        Ok(Self { width, depth })
    }

    /// The extent along x, positive.
    pub const fn width(&self) -> f64 {
        self.width
    }

    /// The extent along z, positive.
    pub const fn depth(&self) -> f64 {
        self.depth
    }

    fn corner(&self) -> DVec3 {
        DVec3::new(0.5 * self.width, 0.0, 0.5 * self.depth)
    }

    /// The smallest box around the rectangle; it has no height.
    pub fn bounds(&self) -> Aabb {
        Aabb::new(-self.corner(), self.corner())
    }

    /// Support function: the largest dot product of a direction with a point of the rectangle.
    pub(crate) fn support(&self, direction: DVec3) -> f64 {
        self.corner().dot(direction.abs())
    }

    /// Intersection from either side, edges included. `None` if the ray misses the rectangle or is parallel, also
    /// within it.
    #[inline]
    pub fn intersect(&self, ray: &Ray, span: Interval) -> Option<ShapeHit> {
        let t = -ray.origin.y / ray.direction.y;
        if !(span.contains(t) && t.is_finite()) {
            return None;
        }
        let (point, corner) = (ray.at(t), self.corner());
        (point.x.abs() <= corner.x && point.z.abs() <= corner.z).then_some(ShapeHit { t, uv: [0.0; 2] })
    }

    /// The surface at a hit of [`intersect`](Self::intersect). The point lies exactly in the plane.
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit, needs: InteractionFlags) -> SurfaceInteraction {
        let (on_ray, corner) = (ray.at(hit.t), self.corner());
        let point = DVec3::new(on_ray.x.clamp(-corner.x, corner.x), 0.0, on_ray.z.clamp(-corner.z, corner.z));
        // The point is exact across the plane. The bound is for a ray that leaves it at coordinate 0, where
        // neighbouring numbers are too close to distinguish.
        let point_error = DVec3::Y * (gamma(3) * corner.max_element());
        let uv = if needs.uv { [0.5 + point.x / self.width, 0.5 - point.z / self.depth] } else { [0.0; 2] };
        SurfaceInteraction::flat(point, point_error, DVec3::Y, uv)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hit(origin: [f64; 3], direction: [f64; 3]) -> Option<(f64, [f64; 2])> {
        let rectangle = Rectangle::new(4.0, 2.0).expect("a rectangle");
        let ray = Ray::new(origin.into(), direction.into());
        let hit = rectangle.intersect(&ray, Interval::FORWARD)?;
        let surface = rectangle.surface(&ray, &hit, InteractionFlags::ALL);
        assert_eq!((surface.point, surface.geometric_normal), (ray.at(hit.t), DVec3::Y));
        Some((hit.t, surface.uv))
    }

    #[test]
    fn known_values() {
        assert_eq!(hit([-1.0, 3.0, -0.5], [0.0, -1.0, 0.0]), Some((3.0, [0.25, 0.75])));
        assert_eq!(hit([0.0, -3.0, 0.0], [0.0, 1.0, 0.0]), Some((3.0, [0.5, 0.5])), "from below");
        assert_eq!(hit([2.0, 3.0, 1.0], [0.0, -1.0, 0.0]), Some((3.0, [1.0, 0.0])), "a corner");
        assert_eq!(hit([2.0f64.next_up(), 3.0, 0.0], [0.0, -1.0, 0.0]), None);
        assert_eq!(hit([0.0, 3.0, -(1.0f64.next_up())], [0.0, -1.0, 0.0]), None);
        assert_eq!(hit([-3.0, 0.0, 0.0], [1.0, 0.0, 0.0]), None, "within the rectangle");
        assert_eq!(hit([0.0, 1.0, 0.0], [0.0, 1.0, 0.0]), None, "behind");
    }
}
