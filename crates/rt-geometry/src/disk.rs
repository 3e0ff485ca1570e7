//! Disks and rings.

use crate::error::{ShapeError, check_coordinates, check_radius};
use crate::{InteractionFlags, ShapeHit, SurfaceInteraction};
use rt_math::float::gamma;
use rt_math::{Aabb, DVec3, Interval, Ray};

/// A flat disk around the origin in the plane y = 0, or a ring if it has a hole; its front faces +y.
///
/// Texture coordinates run from 0 to 1 over the square around the disk, `u` along +x and `v` along −z. Seen from above
/// with +x to the right, an image is upright and unmirrored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disk {
    radius: f64,
    inner_radius: f64,
}

impl Disk {
    /// The points of the plane between the two radii, both included; a full disk if `inner_radius` is 0.
    ///
    /// # Errors
    /// If the radius is not positive (at least 1e-60), the inner radius is negative or not less than the radius, or a
    /// number is not finite.
    pub fn new(radius: f64, inner_radius: f64) -> Result<Self, ShapeError> {
        check_coordinates([DVec3::splat(inner_radius)])?;
        check_radius(radius)?;
        if (0.0..radius).contains(&inner_radius) {
            Ok(Self { radius, inner_radius })
        } else {
            Err(ShapeError::BadInnerRadius { inner: inner_radius, outer: radius })
        }
    }

    /// The outer radius, positive.
    pub const fn radius(&self) -> f64 {
        self.radius
    }

    /// Radius of the hole; 0 if there is none.
    pub const fn inner_radius(&self) -> f64 {
        self.inner_radius
    }

    /// The smallest box around the disk; it has no height.
    pub fn bounds(&self) -> Aabb {
        let reach = DVec3::new(self.radius, 0.0, self.radius);
        Aabb::new(-reach, reach)
    }

    /// Support function: the largest dot product of a direction with a point of the disk.
    pub(crate) fn support(&self, direction: DVec3) -> f64 {
        self.radius * DVec3::new(direction.x, 0.0, direction.z).length()
    }

    /// Intersection from either side. `None` if the ray misses the disk or is parallel, also within it.
    #[inline]
    pub fn intersect(&self, ray: &Ray, span: Interval) -> Option<ShapeHit> {
        let t = -ray.origin.y / ray.direction.y;
        if !(span.contains(t) && t.is_finite()) {
            return None;
        }
        let DVec3 { x, z, .. } = ray.at(t);
        let square = x * x + z * z;
        let (inner, outer) = (self.inner_radius * self.inner_radius, self.radius * self.radius);
        (inner <= square && square <= outer).then_some(ShapeHit { t, uv: [0.0; 2] })
    }

    /// The surface at a hit of [`intersect`](Self::intersect). The point lies exactly in the plane.
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit, needs: InteractionFlags) -> SurfaceInteraction {
        let (point, point_error) = on_disk(ray, hit.t, 0.0, self.radius);
        let uv = if needs.uv { cap_uv(point, self.radius, 1.0) } else { [0.0; 2] };
        SurfaceInteraction::flat(point, point_error, DVec3::Y, uv)
    }
}

/// The hit point on a disk at a height, and its error.
///
/// The point is exact across the disk. The bound is for a ray that leaves a disk at height 0, where neighbouring
/// numbers are too close to distinguish.
pub(crate) fn on_disk(ray: &Ray, t: f64, y: f64, radius: f64) -> (DVec3, DVec3) {
    let on_ray = ray.at(t);
    let distance = DVec3::new(on_ray.x, 0.0, on_ray.z).length();
    let shrink = if distance > radius { radius / distance } else { 1.0 };
    (DVec3::new(on_ray.x * shrink, y, on_ray.z * shrink), DVec3::Y * (gamma(3) * radius.max(y.abs())))
}

/// Texture coordinates of a disk that faces up or down.
pub(crate) fn cap_uv(point: DVec3, radius: f64, facing: f64) -> [f64; 2] {
    [0.5 + 0.5 * point.x / radius, 0.5 - 0.5 * facing * point.z / radius]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hit(disk: Disk, origin: [f64; 3], direction: [f64; 3]) -> Option<(f64, DVec3, [f64; 2])> {
        let ray = Ray::new(origin.into(), direction.into());
        let hit = disk.intersect(&ray, Interval::FORWARD)?;
        let surface = disk.surface(&ray, &hit, InteractionFlags::ALL);
        assert_eq!((surface.point.y, surface.geometric_normal), (0.0, DVec3::Y));
        Some((hit.t, surface.point, surface.uv))
    }

    #[test]
    fn a_disk_is_hit_from_both_sides_up_to_its_rim() {
        let disk = Disk::new(2.0, 0.0).expect("a disk");
        assert_eq!(
            hit(disk, [1.0, 3.0, -1.0], [0.0, -1.0, 0.0]),
            Some((3.0, DVec3::new(1.0, 0.0, -1.0), [0.75, 0.75]))
        );
        assert_eq!(hit(disk, [0.0, -3.0, 0.0], [0.0, 2.0, 0.0]), Some((1.5, DVec3::ZERO, [0.5, 0.5])));
        assert!(hit(disk, [2.0, 1.0, 0.0], [0.0, -1.0, 0.0]).is_some(), "the rim");
        assert!(hit(disk, [2.0f64.next_up(), 1.0, 0.0], [0.0, -1.0, 0.0]).is_none());
        assert!(hit(disk, [0.0, 1.0, 0.0], [0.0, 1.0, 0.0]).is_none(), "behind");
        assert!(hit(disk, [-3.0, 0.0, 0.0], [1.0, 0.0, 0.0]).is_none(), "within the disk");
    }

    #[test]
    fn a_ring_has_a_hole_without_its_rim() {
        let ring = Disk::new(2.0, 1.0).expect("a ring");
        assert!(hit(ring, [0.0, 1.0, 0.0], [0.0, -1.0, 0.0]).is_none());
        assert!(hit(ring, [1.0f64.next_down(), 1.0, 0.0], [0.0, -1.0, 0.0]).is_none());
        assert!(hit(ring, [0.0, 1.0, 1.0], [0.0, -1.0, 0.0]).is_some(), "the inner rim");
        assert!(hit(ring, [0.0, 1.0, 1.5], [0.0, -1.0, 0.0]).is_some());
    }
}
