//! Infinite cylinders and double cones.

use crate::error::{ShapeError, check_length, check_radius};
use crate::quadric_side::{QuadricSide, azimuth};
use crate::{InteractionFlags, ShapeHit, SurfaceInteraction};
use rt_math::{Interval, Ray};

/// Infinite cylinder or double cone around the y axis. The normal points away from the axis, at an apex against the
/// incident ray. It has no bounds.
///
/// Texture coordinates: `u` runs once around +y as on a [`Sphere`](crate::Sphere), with +z at ½; `v` is y, a length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InfiniteQuadric(QuadricSide);

impl InfiniteQuadric {
    /// The cylinder x² + z² = radius².
    ///
    /// # Errors
    /// If the radius is not positive (at least 1e-60) or not finite.
    pub fn cylinder(radius: f64) -> Result<Self, ShapeError> {
        check_radius(radius)?;
        Ok(Self(QuadricSide { height: 0.0, radius, slope: 0.0 }))
    }

    /// The double cone x² + z² = slope²·y²: two cones with a common apex at the origin. At height 1 it is `slope` wide
    /// from the axis.
    ///
    /// # Errors
    /// If the slope is not positive (at least 1e-60) or not finite.
    pub fn double_cone(slope: f64) -> Result<Self, ShapeError> {
        check_length("slope", slope)?;
        Ok(Self(QuadricSide { height: 0.0, radius: 0.0, slope }))
    }

    /// First intersection within `span`. `None` on a miss, for rays within the surface or along the axis of a cylinder,
    /// and for rays without a direction.
    ///
    /// A cylinder is intersected as a circle in the plane across the axis. The discriminant is (r − L)(r + L), where L
    /// is the distance of the ray from the axis.
    ///
    /// The crossings with a cone solve a·t² − 2b·t + c = 0, with the slope k and vectors across the axis. The
    /// coefficients are a = d·d − k²d_y², b = k²o_y·d_y − o·d and c = o·o − k²o_y². They keep their digits where the
    /// terms cancel. The discriminant is k²|o_y·d − d_y·o|² − (o × d)², factored. A ray along a generator has a = 0 and
    /// one crossing, c/2b.
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
    use crate::strategies::vector;
    use proptest::prelude::*;
    use rt_math::DVec3;

    fn cylinder(radius: f64) -> InfiniteQuadric {
        InfiniteQuadric::cylinder(radius).expect("a cylinder")
    }

    fn cone(slope: f64) -> InfiniteQuadric {
        InfiniteQuadric::double_cone(slope).expect("a cone")
    }

    fn hits(quadric: InfiniteQuadric, origin: [f64; 3], direction: [f64; 3]) -> Vec<f64> {
        let ray = Ray::new(origin.into(), direction.into());
        let mut found: Vec<f64> = Vec::new();
        let mut min = f64::NEG_INFINITY;
        while let Some(hit) = quadric.intersect(&ray, Interval::new(min, f64::INFINITY)) {
            found.push(hit.t);
            min = hit.t.next_up();
        }
        found
    }

    /// Exact roots from 80-digit arithmetic.
    #[test]
    fn stiff_cases_keep_their_digits() {
        let almost_one = 1.0 + 1.0 / f64::from(1 << 23);
        let thin = cylinder(1e-3);
        let cases = [
            // Nearly parallel to a generator.
            (cone(1.0), [0.5, 1.0, -3.0], [0.0, almost_one, 1.0], [-33_554_432.031_25, 1.031_249_937_572_287_5]),
            // A needle.
            (cone(1e-4), [0.0, 1.0, -1.0], [0.0, 0.0, 1.0], [0.9999, 1.0001]),
            (cone(1.0), [0.25, 1.0, -1e6], [0.0, 0.0, 1.0], [999_999.031_754_163_4, 1_000_000.968_245_836_6]),
            // Far and oblique: the distance of the ray from the axis is small compared with its coordinates.
            (
                cylinder(1.0),
                [-8e5 - 0.3, 0.0, -6e5 + 0.4],
                [0.8, 0.0, 0.6],
                [999_999.133_974_596_2, 1_000_000.866_025_403_8],
            ),
            (thin, [5e-4, 0.0, 100.0], [0.0, 0.0, -1.0], [99.999_133_974_596_22, 100.000_866_025_403_8]),
            // Nearly along the axis.
            (cylinder(1.0), [0.0, -10.0, 0.5], [0.0, 1.0, 1e-8], [-150_000_000.0, 50_000_000.0]),
        ];
        for (quadric, origin, direction, exact) in cases {
            let found = hits(quadric, origin, direction);
            assert_eq!(found.len(), 2, "{origin:?}");
            for (t, exact) in found.into_iter().zip(exact) {
                assert!((t - exact).abs() <= 4.5e-16 * exact.abs(), "{origin:?}: {t} instead of {exact}");
            }
        }
    }

    #[test]
    fn rays_along_the_axis_of_a_cylinder_miss_everywhere() {
        for x in [0.0, 0.5, 1.0, 2.0] {
            assert!(hits(cylinder(1.0), [x, 0.0, 0.0], [0.0, 1.0, 0.0]).is_empty(), "{x}");
        }
    }

    #[test]
    fn a_ray_parallel_to_a_generator_crosses_once() {
        assert_eq!(hits(cone(1.0), [0.5, 1.0, -3.0], [0.0, 1.0, 1.0]), [1.03125]);
        assert_eq!(hits(cone(1.0), [0.0, 1.0, 1.0], [0.0, 1.0, 1.0]), [0.0; 0], "within the surface");
        assert_eq!(hits(cone(1.0), [0.5, 1.0, 1.0], [0.0, 1.0, 1.0]), [0.0; 0], "beside the surface");
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
    fn the_side_of_a_cylinder_is_textured_by_its_length() {
        let ray = Ray::new(DVec3::new(-5.0, 1e9, 0.0), DVec3::X);
        let hit = cylinder(2.0).intersect(&ray, Interval::FORWARD).expect("a hit");
        let surface = cylinder(2.0).surface(&ray, &hit, InteractionFlags::ALL);
        assert_eq!((hit.t, surface.geometric_normal, surface.uv), (3.0, DVec3::NEG_X, [0.25, 1e9]));
    }

    proptest! {
        /// Intersections are those of the circle in the plane across the axis, at any height.
        #[test]
        fn height_does_not_matter_to_a_cylinder(
            x in -5.0..5.0f64, z in -5.0..5.0f64, dx in -1.0..1.0f64, dz in -1.0..1.0f64, y in -1e9..1e9f64, dy in -9.0..9.0f64,
        ) {
            let hits = |y, dy| hits(cylinder(1.5), [x, y, z], [dx, dy, dz]);
            prop_assert_eq!(hits(y, dy), hits(0.0, 0.0));
        }

        #[test]
        fn t_scales_exactly_with_the_direction(x in -5.0..5.0f64, z in -5.0..5.0f64, dx in -1.0..1.0f64, k in -100i32..100) {
            let scale = rt_math::transcendental::exp2(f64::from(k));
            let plain = hits(cylinder(1.5), [x, 0.0, z], [dx, 0.5, 1.0]);
            let scaled = hits(cylinder(1.5), [x, 0.0, z], [dx * scale, 0.5 * scale, scale]);
            prop_assert_eq!(plain, scaled.into_iter().map(|t| t * scale).collect::<Vec<_>>());
        }

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
            let found = hits(cone(1.0), from.into(), [dx * 0.7, 1.0, dx * 0.7]);
            prop_assert!((1..=2).contains(&found.len()), "{found:?}");
            let [low, high] = [found[0], found[found.len() - 1]].map(|t| from.y + t);
            prop_assert!(low <= 1e-6 && high >= -1e-6, "{low} {high}");
        }
    }
}
