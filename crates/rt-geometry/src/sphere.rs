//! Spheres.

use crate::error::{ShapeError, check_coordinates, check_radius};
use crate::{InteractionFlags, ShapeHit, SphereKernel, SurfaceInteraction};
use rt_math::float::{UNIT_ROUNDOFF, gamma};
use rt_math::transcendental::{atan2, hypot};
use rt_math::{Aabb, DVec3, Interval, Ray, Real, Vector3};
use std::f64::consts::{PI, TAU};

/// A sphere; its normal points outwards.
///
/// The texture coordinate `u` runs once around +y, from −z over −x, +z (where it is ½) and +x. An image appears upright
/// and unmirrored from outside. `v` runs with the latitude from 0 at the south pole (−y) to 1 at the north.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere(SphereKernel);

impl Sphere {
    /// A sphere around `centre`.
    ///
    /// # Errors
    /// If the radius is not positive (at least 1e-60) or a number is not finite.
    pub fn new(centre: DVec3, radius: f64) -> Result<Self, ShapeError> {
        check_coordinates([centre])?;
        check_radius(radius)?;
        Ok(Self(SphereKernel { centre, radius }))
    }

    /// The centre.
    pub const fn centre(&self) -> DVec3 {
        self.0.centre
    }

    /// The radius, positive.
    pub const fn radius(&self) -> f64 {
        self.0.radius
    }

    /// The smallest box around the sphere, rounded outwards.
    #[inline]
    pub fn bounds(&self) -> Aabb {
        let (min, max) = (self.0.centre - self.0.radius, self.0.centre + self.0.radius);
        Aabb::new(min.map(f64::next_down), max.map(f64::next_up))
    }

    /// Intersection kernel.
    #[inline(always)]
    pub const fn kernel(&self) -> SphereKernel {
        self.0
    }

    /// First of the two intersections within `span`, by [`SphereKernel`]. `None` on a miss, and for rays without a
    /// direction.
    #[inline(always)]
    pub fn intersect(&self, ray: &Ray, span: Interval) -> Option<ShapeHit> {
        let t = self.0.intersect(ray, span)?;
        Some(ShapeHit { t, uv: [0.0; 2] })
    }

    /// The surface at a hit of [`intersect`](Self::intersect).
    #[inline(always)]
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit, needs: InteractionFlags) -> SurfaceInteraction {
        let offset = (ray.origin - self.0.centre) + ray.direction * hit.t;
        // If rounding puts a faraway hit on the centre, use the side of the viewer.
        let normal = offset.try_normalize().unwrap_or_else(|| -ray.direction.normalize_or(DVec3::Y));
        let (point, point_error) = sphere_point(self.0.centre.into(), self.0.radius, normal.into());
        let uv = if needs.uv { spherical_uv(normal) } else { [0.0; 2] };
        SurfaceInteraction::flat(point.into(), point_error.into(), normal, uv)
    }
}

/// Point of a sphere with this unit normal, and its error bound, as in [`SurfaceInteraction`].
#[inline(always)]
pub fn sphere_point<R: Real>(centre: Vector3<R>, radius: R, normal: Vector3<R>) -> (Vector3<R>, Vector3<R>) {
    let point = centre + normal * radius;
    (point, normal.abs() * (radius * gamma(10)) + point.abs() * point.x.splat(2.0 * UNIT_ROUNDOFF))
}

/// Longitude and latitude of a direction as texture coordinates.
fn spherical_uv(n: DVec3) -> [f64; 2] {
    [0.5 + atan2(n.x, n.z) / TAU, 0.5 + atan2(n.y, hypot(n.x, n.z)) / PI]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rt_math::transcendental::exp2;

    fn sphere(radius: f64) -> Sphere {
        Sphere::new(DVec3::ZERO, radius).expect("a sphere")
    }

    fn hit(radius: f64, origin: [f64; 3], direction: [f64; 3], span: Interval) -> Option<f64> {
        sphere(radius).intersect(&Ray::new(origin.into(), direction.into()), span).map(|hit| hit.t)
    }

    /// Exact roots from 200-bit arithmetic.
    #[test]
    fn stiff_cases_keep_their_digits() {
        let cases = [
            (1.0, [0.5, 0.0, -1e4], [0.0, 0.0, 1.0], 9999.133974596216, 4e-16),
            (1.0, [0.5, 0.0, -1e8], [0.0, 0.0, 1.0], 99_999_999.133_974_6, 4e-16),
            (1e-6, [5e-7, 0.0, -10.0], [0.0, 0.0, 1.0], 9.999_999_133_974_596, 4e-16),
            (1e6, [0.0, 0.0, -1000001.0], [0.6, 0.0, 0.8], 1.2500003515626977, 1e-9),
            (1e8, [0.0, 0.0, -1e8 - 8.0], [0.0, 0.0, 1.0], 8.0, 1e-8),
            (1e12, [0.0, 0.0, -1e12 - 8.0], [0.0, 0.0, 1.0], 8.0, 1e-15),
        ];
        for (radius, origin, direction, exact, tolerance) in cases {
            let t = hit(radius, origin, direction, Interval::FORWARD).expect("a hit");
            assert!((t - exact).abs() <= tolerance * exact, "{origin:?}: {t} instead of {exact}");
        }
    }

    #[test]
    fn the_first_crossing_within_the_closed_span_counts() {
        let (origin, direction) = ([0.0, 0.0, -3.0], [0.0, 0.0, 1.0]);
        let within = |min, max| hit(1.0, origin, direction, Interval::new(min, max));
        assert_eq!(within(0.0, f64::INFINITY), Some(2.0));
        assert_eq!(within(2.0, 2.0), Some(2.0));
        assert_eq!(within(2.5, 4.0), Some(4.0));
        assert_eq!(within(0.0, 1.9), None);
        assert_eq!(within(2.5, 3.9), None);
        assert_eq!(hit(1.0, [0.0; 3], direction, Interval::FORWARD), Some(1.0), "from inside");
        assert_eq!(hit(1.0, [0.0, 0.0, 3.0], direction, Interval::FORWARD), None, "behind");
        let all = Interval::new(f64::NEG_INFINITY, f64::INFINITY);
        assert_eq!(hit(1.0, [0.0, 0.0, 3.0], direction, all), Some(-4.0));
    }

    #[test]
    fn tangents_are_decided_by_their_closest_approach() {
        let at = |x: f64| hit(1.0, [x, 0.0, -5.0], [0.0, 0.0, 1.0], Interval::FORWARD);
        assert!(at(1.0).is_some() && at(1.0f64.next_down()).is_some());
        assert_eq!(at(1.0f64.next_up()), None);
        assert_eq!(hit(1.0, [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], Interval::FORWARD), Some(0.0), "tangent at its origin");
    }

    #[test]
    fn infinite_and_extreme_rays_miss() {
        for bad in [f64::INFINITY, 1e200] {
            for k in 0..3 {
                let mut broken = [0.25; 3];
                broken[k] = bad;
                assert_eq!(hit(1.0, broken, [0.0, 0.0, 1.0], Interval::FORWARD), None);
                if bad == f64::INFINITY {
                    assert_eq!(hit(1.0, [0.0; 3], broken, Interval::FORWARD), None);
                    assert_eq!(hit(1.0, [0.0, 0.0, 3.0], broken, Interval::FORWARD), None);
                }
            }
        }
    }

    #[test]
    fn directions_of_any_length_are_met() {
        for k in [-900, -520, -510, 510, 520, 900] {
            let scale = exp2(f64::from(k));
            let t = hit(1.0, [0.25, 0.0, -3.0], [0.0, 0.0, scale], Interval::FORWARD);
            let expected = hit(1.0, [0.25, 0.0, -3.0], [0.0, 0.0, 1.0], Interval::FORWARD);
            assert_eq!(t, expected.map(|t| t / scale), "2^{k}");
            assert_eq!(hit(1.0, [1.25, 0.0, -3.0], [0.0, 0.0, scale], Interval::FORWARD), None, "2^{k}");
        }
    }

    #[test]
    fn texture_coordinates_follow_longitude_and_latitude() {
        let uv_at = |direction: DVec3| {
            let ray = Ray::new(direction * 3.0, -direction);
            let hit = sphere(2.0).intersect(&ray, Interval::FORWARD).expect("a hit");
            sphere(2.0).surface(&ray, &hit, InteractionFlags::ALL).uv
        };
        assert_eq!(uv_at(DVec3::Z), [0.5, 0.5]);
        assert_eq!(uv_at(DVec3::X), [0.75, 0.5]);
        assert_eq!(uv_at(DVec3::NEG_X), [0.25, 0.5]);
        assert_eq!(uv_at(DVec3::Y)[1], 1.0);
        assert_eq!(uv_at(DVec3::NEG_Y)[1], 0.0);
        assert_eq!(uv_at(DVec3::new(0.0, 1.0, 1.0).normalize())[1], 0.75);
    }

    /// A unit vector, from cylinder coordinates.
    fn direction() -> impl Strategy<Value = DVec3> {
        (-1.0..1.0f64, 0.0..TAU).prop_map(|(z, angle)| {
            let (sin, cos) = rt_math::transcendental::sincos(angle);
            let rho = ((1.0 - z) * (1.0 + z)).sqrt();
            DVec3::new(rho * cos, rho * sin, z)
        })
    }

    proptest! {
        /// Rays at a given distance hit if that is below the radius, by more than the rounding of the ray itself, and
        /// miss above.
        #[test]
        fn the_distance_of_the_ray_decides(
            towards in direction(), other in direction(), log_radius in -6.0..6.0f64, log_back in -2.0..7.0f64,
            log_gap in -12.0..0.0f64, centre in direction(), moved in 0.0..100.0f64,
        ) {
            let side = towards.cross(other);
            prop_assume!(side.length() > 0.1);
            let side = side.normalize();
            let ten_to = |x: f64| rt_math::transcendental::pow(10.0, x);
            let radius = ten_to(log_radius);
            let (back, centre) = (radius * ten_to(log_back), centre * (moved * radius));
            let gap = ten_to(log_gap) * radius + 1e-14 * (back + 100.0 * radius);
            let sphere = Sphere::new(centre, radius).expect("a sphere");
            let aimed = |distance: f64| {
                let ray = Ray::new(centre + side * distance - towards * back, towards);
                sphere.intersect(&ray, Interval::new(f64::NEG_INFINITY, f64::INFINITY)).is_some()
            };
            prop_assert!(gap > radius || aimed(radius - gap));
            prop_assert!(!aimed(radius + gap));
        }

        #[test]
        fn hits_lie_on_the_sphere_with_outward_normals(
            centre in direction(), from in direction(), to in direction(), radius in 0.1..10.0f64, far in 0.0..1e3f64,
        ) {
            let sphere = Sphere::new(centre * 100.0, radius).expect("a sphere");
            let inside = sphere.centre() + to * (0.99 * radius);
            let origin = inside + from * far;
            let ray = Ray::new(origin, (inside - origin) + from * -0.5);
            let hit = sphere.intersect(&ray, Interval::FORWARD).expect("towards a point inside");
            let surface = sphere.surface(&ray, &hit, InteractionFlags::ALL);
            let arm = surface.point - sphere.centre();
            let slack = surface.point_error.length();
            prop_assert!((arm.length() - radius).abs() <= slack && slack < 1e-12);
            prop_assert!((surface.point - ray.at(hit.t)).length() <= 1e-12 * (1.0 + far));
            prop_assert!((surface.geometric_normal.length() - 1.0).abs() < 1e-15);
            prop_assert!(surface.geometric_normal.dot(arm) > 0.0);
            prop_assert!(surface.uv.iter().all(|x| (0.0..=1.0).contains(x)));
            prop_assert!(sphere.bounds().padded().contains(surface.point));
        }

        #[test]
        fn t_scales_exactly_with_the_direction(origin in direction(), towards in direction(), k in -60i32..60) {
            let scale = exp2(f64::from(k));
            let ray = Ray::new(origin * 3.0, towards - origin * 3.0);
            let scaled = Ray::new(ray.origin, ray.direction * scale);
            let t = |ray| sphere(1.5).intersect(ray, Interval::FORWARD).map(|hit| hit.t);
            prop_assert_eq!(t(&ray).map(|t| t / scale), t(&scaled));
        }

        /// A chord at angle θ to the normal is 2·cos θ long. The ray starts off the surface by some roundings, which the
        /// chord magnifies by 1 / cos θ.
        #[test]
        fn chords_from_the_surface(start in direction(), towards in direction()) {
            let along = start.dot(towards);
            prop_assume!(along.abs() > 1e-3);
            let surface = SurfaceInteraction::flat(start, start.abs() * gamma(10), start, [0.0; 2]);
            let t = sphere(1.0).intersect(&surface.spawn_ray(towards, 0.0), Interval::FORWARD).map(|hit| hit.t);
            if along > 0.0 {
                prop_assert_eq!(t, None);
            } else {
                prop_assert!((t.expect("the far side") + 2.0 * along).abs() < 1e-14 / along.abs());
            }
        }
    }
}
