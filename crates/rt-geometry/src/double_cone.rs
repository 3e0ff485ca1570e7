//! Infinite double cones.

use crate::error::{ShapeError, check_length};
use crate::quadric_side::{QuadricSide, azimuth};
use crate::{InteractionFlags, ShapeHit, SurfaceInteraction};
use rt_math::{Interval, Ray};

/// Two infinite cones around the y axis with a common apex at the origin. The normal points away from the axis, at the
/// apex against the incident ray. It has no bounds.
///
/// Texture coordinates: `u` runs once around +y as on a [`Sphere`](crate::Sphere), with +z at ½; `v` is y, a length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DoubleCone(QuadricSide);

impl DoubleCone {
    /// The cone x² + z² = slope²·y²: at height 1 it is `slope` wide from the axis.
    ///
    /// # Errors
    /// If the slope is not positive (at least 1e-60) or not finite.
    pub fn new(slope: f64) -> Result<Self, ShapeError> {
        check_length("slope", slope)?;
        Ok(Self(QuadricSide { height: 0.0, radius: 0.0, slope }))
    }

    /// The radius at height 1, positive.
    pub const fn slope(&self) -> f64 {
        self.0.slope
    }

    /// First intersection within `span`. `None` on a miss, for rays within the surface, and for rays without a
    /// direction.
    ///
    /// The crossings solve a·t² − 2b·t + c = 0, with the slope k and vectors across the axis. The coefficients are a =
    /// d·d − k²d_y², b = k²o_y·d_y − o·d and c = o·o − k²o_y². They keep their digits where the terms cancel. The
    /// discriminant is k²|o_y·d − d_y·o|² − (o × d)², factored. A ray along a generator has a = 0 and one crossing,
    /// c/2b.
    #[inline]
    pub fn intersect(&self, ray: &Ray, span: Interval) -> Option<ShapeHit> {
        let t = self.0.first_crossing(ray, span, |_| true)?;
        Some(ShapeHit { t, uv: [0.0; 2] })
    }

    /// The surface at a hit of [`intersect`](Self::intersect).
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit, needs: InteractionFlags) -> SurfaceInteraction {
        let mut surface = self.0.surface(ray, hit.t, [f64::NEG_INFINITY, f64::INFINITY]);
        if needs.uv {
            surface.uv = [azimuth(surface.point), surface.point.y];
        }
        surface
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rt_math::DVec3;

    fn cone(slope: f64) -> DoubleCone {
        DoubleCone::new(slope).expect("a cone")
    }

    fn hits(slope: f64, origin: [f64; 3], direction: [f64; 3]) -> Vec<f64> {
        let ray = Ray::new(origin.into(), direction.into());
        let mut found: Vec<f64> = Vec::new();
        let mut min = f64::NEG_INFINITY;
        while let Some(hit) = cone(slope).intersect(&ray, Interval::new(min, f64::INFINITY)) {
            found.push(hit.t);
            min = hit.t.next_up();
        }
        found
    }

    /// Exact roots from 80-digit arithmetic.
    #[test]
    fn stiff_cases_keep_their_digits() {
        let almost_one = 1.0 + 1.0 / f64::from(1 << 23);
        let cases = [
            // Nearly parallel to a generator.
            (1.0, [0.5, 1.0, -3.0], [0.0, almost_one, 1.0], [-33_554_432.031_25, 1.031_249_937_572_287_5]),
            // A needle.
            (1e-4, [0.0, 1.0, -1.0], [0.0, 0.0, 1.0], [0.9999, 1.0001]),
            (1.0, [0.25, 1.0, -1e6], [0.0, 0.0, 1.0], [999_999.031_754_163_4, 1_000_000.968_245_836_6]),
        ];
        for (slope, origin, direction, exact) in cases {
            let found = hits(slope, origin, direction);
            assert_eq!(found.len(), 2, "{origin:?}");
            for (t, exact) in found.into_iter().zip(exact) {
                assert!((t - exact).abs() <= 4.5e-16 * exact.abs(), "{origin:?}: {t} instead of {exact}");
            }
        }
    }

    #[test]
    fn a_ray_parallel_to_a_generator_crosses_once() {
        assert_eq!(hits(1.0, [0.5, 1.0, -3.0], [0.0, 1.0, 1.0]), [1.03125]);
        assert_eq!(hits(1.0, [0.0, 1.0, 1.0], [0.0, 1.0, 1.0]), [0.0; 0], "within the surface");
        assert_eq!(hits(1.0, [0.5, 1.0, 1.0], [0.0, 1.0, 1.0]), [0.0; 0], "beside the surface");
    }

    #[test]
    fn a_ray_along_the_axis_meets_the_apex_head_on() {
        let ray = Ray::new(DVec3::new(0.0, 3.0, 0.0), DVec3::new(0.0, -2.0, 0.0));
        let hit = cone(0.5).intersect(&ray, Interval::FORWARD).expect("the apex");
        let surface = cone(0.5).surface(&ray, &hit, InteractionFlags::ALL);
        assert_eq!((hit.t, surface.point, surface.geometric_normal), (1.5, DVec3::ZERO, DVec3::Y));
    }

    #[test]
    fn rays_through_the_apex_meet_it_once_with_a_finite_normal() {
        for direction in [[1.0, 2.0, 3.0], [3.0, 0.25, -1.0], [1.0, 0.0, 0.0], [0.6, 1.0, 0.8]] {
            let direction = DVec3::from(direction);
            let ray = Ray::new(direction * -2.0, direction);
            if let Some(hit) = cone(0.5).intersect(&ray, Interval::FORWARD) {
                assert!((hit.t - 2.0).abs() < 1e-7, "{direction}: {}", hit.t);
                let normal = cone(0.5).surface(&ray, &hit, InteractionFlags::ALL).geometric_normal;
                assert!((normal.length() - 1.0).abs() < 1e-15, "{direction}: {normal}");
            } else {
                // Outside the cone the ray may miss the apex by rounding, inside it cannot.
                assert!(DVec3::new(direction.x, 0.0, direction.z).length() > 0.5 * direction.y.abs(), "{direction}");
            }
        }
    }

    #[test]
    fn both_nappes_have_normals_away_from_the_axis() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        for (y, normal) in [(2.0, DVec3::new(half, -half, 0.0)), (-2.0, DVec3::new(half, half, 0.0))] {
            let ray = Ray::new(DVec3::new(5.0, y, 0.0), DVec3::NEG_X);
            let hit = cone(1.0).intersect(&ray, Interval::FORWARD).expect("a hit");
            let surface = cone(1.0).surface(&ray, &hit, InteractionFlags::ALL);
            assert_eq!((hit.t, surface.uv), (3.0, [0.75, y]));
            assert!((surface.geometric_normal - normal).length() < 1e-15);
        }
    }

    #[test]
    fn bad_slopes_are_refused() {
        assert_eq!(DoubleCone::new(0.0), Err(ShapeError::BadLength("slope", 0.0)));
        assert!(DoubleCone::new(f64::INFINITY).is_err());
    }

    fn vector(range: f64) -> impl Strategy<Value = DVec3> {
        let side = -range..range;
        (side.clone(), side.clone(), side).prop_map(DVec3::from)
    }

    proptest! {
        #[test]
        fn hits_lie_on_the_cone(slope in 1e-3..1e3f64, from in vector(100.0), to in vector(3.0)) {
            let ray = Ray::new(from, to - from);
            if let Some(hit) = cone(slope).intersect(&ray, Interval::FORWARD) {
                let surface = cone(slope).surface(&ray, &hit, InteractionFlags::ALL);
                let (p, normal) = (surface.point, surface.geometric_normal);
                let gap = (DVec3::new(p.x, 0.0, p.z).length() - slope * p.y.abs()) / (1.0 + slope * slope).sqrt();
                prop_assert!(gap.abs() <= normal.abs().dot(surface.point_error), "{gap}");
                prop_assert!((p - ray.at(hit.t)).length() < 1e-10 * (1.0 + ray.at(hit.t).length()));
                prop_assert!((normal.length() - 1.0).abs() < 1e-15);
                prop_assert!(normal.dot(p - DVec3::Y * p.y) >= 0.0);
            }
        }

        /// A steep ray crosses from one nappe to the other for any rounding.
        #[test]
        fn steep_rays_meet_both_nappes(from in vector(10.0), dx in -0.9..0.9f64) {
            let found = hits(1.0, from.into(), [dx * 0.7, 1.0, dx * 0.7]);
            prop_assert!((1..=2).contains(&found.len()), "{found:?}");
            let [low, high] = [found[0], found[found.len() - 1]].map(|t| from.y + t);
            prop_assert!(low <= 1e-6 && high >= -1e-6, "{low} {high}");
        }
    }
}
