//! Infinite planes.

use crate::error::{ShapeError, check_coordinates};
use crate::{InteractionFlags, ShapeHit, SurfaceInteraction};
use rt_math::float::{UNIT_ROUNDOFF, gamma};
use rt_math::{DVec3, Interval, Ray, Real, Vector3, tangents};

/// An infinite plane; its front is the side of the normal. It has no bounds.
///
/// Texture coordinates are lengths from [`point`](Self::point) along the tangents of
/// [`Frame::from_z`](rt_math::Frame::from_z) of the normal. They are (x, −z) on a floor with normal +y, (x, y) for +z.
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

    /// Intersection with the plane. `None` if the ray is parallel, also within the plane.
    ///
    /// Grazing rays of any angle hit the plane far away, up to the horizon.
    #[inline]
    pub fn intersect(&self, ray: &Ray, span: Interval) -> Option<ShapeHit> {
        let t = self.normal.dot(self.point - ray.origin) / self.normal.dot(ray.direction);
        (span.contains(t) && t.is_finite()).then_some(ShapeHit { t, uv: [0.0; 2] })
    }

    /// The surface at a hit of [`intersect`](Self::intersect).
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit, needs: InteractionFlags) -> SurfaceInteraction {
        let (on_plane, normal) = (self.point.into(), self.normal.into());
        let (point, point_error) = plane_point(on_plane, normal, ray.at(hit.t).into());
        let uv = if needs.uv {
            plane_uv(on_plane, normal, [ray.origin.into(), ray.direction.into()], hit.t)
        } else {
            [0.0; 2]
        };
        SurfaceInteraction::flat(point.into(), point_error.into(), self.normal, uv)
    }
}

/// Projection of a point of a ray on a plane, and its error bound, as in [`SurfaceInteraction`].
///
/// The bound is for the rounding of the projection, and of the numerator when a spawned ray is tested against the plane. The
/// length of the normal is 1 but for rounding. A part of the way to the plane is left, so that the point on the ray counts as well.
#[inline(always)]
pub fn plane_point<R: Real>(on_plane: Vector3<R>, normal: Vector3<R>, on_ray: Vector3<R>) -> (Vector3<R>, Vector3<R>) {
    let point = on_ray - normal * normal.dot(on_ray - on_plane);
    let distance = normal.abs().dot(on_ray.abs() + point.abs() + on_plane.abs()) * gamma(8);
    (point, normal.abs() * distance + point.abs() * point.x.splat(2.0 * UNIT_ROUNDOFF))
}

/// Texture coordinates at a hit of a ray with this origin and direction, as of [`Plane`].
///
/// They are computed from origin and direction: the hit point is rounded to the grid of its largest coordinate, these are not.
#[inline(always)]
pub fn plane_uv<R: Real>(
    on_plane: Vector3<R>,
    normal: Vector3<R>,
    [origin, direction]: [Vector3<R>; 2],
    t: R,
) -> [R; 2] {
    let [x, y] = tangents(normal);
    let origin = origin - on_plane;
    [x.dot(origin) + t * x.dot(direction), y.dot(origin) + t * y.dot(direction)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A normal that is not quite as long as 1 leaves the projected point some 10⁻³⁶ off a floor at height 0. A bound that
    /// knows that height only lets shadow rays meet the floor again.
    #[test]
    fn a_floor_with_a_normal_rounded_short_does_not_shadow_itself() {
        for scale in [1e-3, 0.1, 0.3, 7.0, 1e3] {
            let shrink = rt_math::Transform::scale(DVec3::splat(scale)).expect("regular");
            let floor = Plane { point: DVec3::ZERO, normal: shrink.normal(DVec3::Y).normalize() };
            for short in [floor, Plane { normal: DVec3::Y * (1.0 - 2.0 * UNIT_ROUNDOFF), ..floor }] {
                for i in 0..1000 {
                    let aim = DVec3::new(f64::from(i) * 0.37, 0.0, f64::from(i % 7)) * scale;
                    let eye = DVec3::new(0.0, 7.5, 12.0) * scale;
                    let ray = Ray::new(eye, (aim - eye).normalize());
                    let hit = short.intersect(&ray, Interval::FORWARD).expect("a hit");
                    let shadow = short
                        .surface(&ray, &hit, InteractionFlags::ALL)
                        .spawn_shadow_ray_towards(DVec3::new(0.5, 1.0, 0.75), 0.0);
                    assert_eq!(short.intersect(&shadow, Interval::SPAWNED), None, "scale {scale}, ray {i}");
                }
            }
        }
    }

    fn plane(point: [f64; 3], normal: [f64; 3]) -> Plane {
        Plane::new(point.into(), normal.into()).expect("a plane")
    }

    fn hit(plane: Plane, origin: [f64; 3], direction: [f64; 3]) -> Option<(f64, SurfaceInteraction)> {
        let ray = Ray::new(origin.into(), direction.into());
        let hit = plane.intersect(&ray, Interval::FORWARD)?;
        Some((hit.t, plane.surface(&ray, &hit, InteractionFlags::ALL)))
    }

    #[test]
    fn grazing_rays_reach_the_horizon() {
        let (t, surface) = hit(plane([0.0; 3], [0.0, 0.0, 1.0]), [0.0, 0.0, 1.0], [1.0, 0.0, -1e-12]).expect("a hit");
        assert_eq!((t, surface.point, surface.uv), (1e12, DVec3::new(1e12, 0.0, 0.0), [1e12, 0.0]));
    }

    #[test]
    fn parallel_rays_miss() {
        let floor = plane([0.0; 3], [0.0, 1.0, 0.0]);
        for zero in [0.0, -0.0] {
            assert!(hit(floor, [0.0, 1.0, 0.0], [1.0, zero, 0.0]).is_none());
            assert!(hit(floor, [0.0, 0.0, 0.0], [1.0, zero, 0.0]).is_none(), "within the plane");
        }
        assert!(hit(floor, [0.0, 1.0, 0.0], [0.0, 1.0, 0.0]).is_none(), "behind");
        assert!(hit(floor, [0.0, -1.0, 0.0], [0.0, 1.0, 0.0]).is_some(), "from below");
    }

    #[test]
    fn a_floor_is_textured_by_x_and_minus_z() {
        let floor = plane([10.0, 2.0, 20.0], [0.0, 3.0, 0.0]);
        let (t, surface) = hit(floor, [13.0, 4.0, 15.0], [0.0, -1.0, 0.0]).expect("a hit");
        assert_eq!((t, surface.uv), (2.0, [3.0, 5.0]));
        assert_eq!(surface.point, DVec3::new(13.0, 2.0, 15.0));
        let wall = plane([0.0; 3], [0.0, 0.0, 1.0]);
        assert_eq!(hit(wall, [3.0, 4.0, 5.0], [0.0, 0.0, -1.0]).map(|(_, s)| s.uv), Some([3.0, 4.0]));
    }

    proptest! {
        #[test]
        fn hits_lie_on_the_plane(
            p in -10.0..10.0f64, n in -1.0..1.0f64, m in -1.0..1.0f64, o in -1e3..1e3f64, d in -1.0..1.0f64,
        ) {
            let plane = plane([p, -p, 1.0], [n, m, 0.5]);
            if let Some((_, surface)) = hit(plane, [o, 1.0, -o], [d, n, 1.0]) {
                let height = plane.normal().dot(surface.point - plane.point());
                let bound = plane.normal().abs().dot(surface.point_error);
                prop_assert!(height.abs() <= bound, "{height} above {bound}");
            }
        }
    }
}
