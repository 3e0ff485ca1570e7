//! Infinite cylinders.

use crate::error::{ShapeError, check_radius};
use crate::quadric_side::{QuadricSide, azimuth};
use crate::{InteractionFlags, ShapeHit, SurfaceInteraction};
use rt_math::{Interval, Ray};

/// Infinite cylinder around the y axis; its normal points outwards. It has no bounds.
///
/// Texture coordinates: `u` runs once around +y as on a [`Sphere`](crate::Sphere), with +z at ½; `v` is y, a length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InfiniteCylinder(QuadricSide);

impl InfiniteCylinder {
    /// The cylinder x² + z² = radius².
    ///
    /// # Errors
    /// If the radius is not positive (at least 1e-60) or not finite.
    pub fn new(radius: f64) -> Result<Self, ShapeError> {
        check_radius(radius)?;
        Ok(Self(QuadricSide { height: 0.0, radius, slope: 0.0 }))
    }

    /// The radius, positive.
    pub const fn radius(&self) -> f64 {
        self.0.radius
    }

    /// First intersection within `span`. `None` on a miss, for rays along the axis, also within the surface, and for
    /// rays without a direction. See [`Cylinder`](crate::Cylinder) for the arithmetic.
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

    fn hits(radius: f64, origin: [f64; 3], direction: [f64; 3]) -> Vec<f64> {
        let cylinder = InfiniteCylinder::new(radius).expect("a cylinder");
        let ray = Ray::new(origin.into(), direction.into());
        let mut found: Vec<f64> = Vec::new();
        let mut min = f64::NEG_INFINITY;
        while let Some(hit) = cylinder.intersect(&ray, Interval::new(min, f64::INFINITY)) {
            found.push(hit.t);
            min = hit.t.next_up();
        }
        found
    }

    /// Exact roots from 80-digit arithmetic.
    #[test]
    fn stiff_cases_keep_their_digits() {
        let cases = [
            // Far and oblique: the distance of the ray from the axis is small compared with its coordinates.
            (1.0, [-8e5 - 0.3, 0.0, -6e5 + 0.4], [0.8, 0.0, 0.6], [999_999.133_974_596_2, 1_000_000.866_025_403_8]),
            (1e-3, [5e-4, 0.0, 100.0], [0.0, 0.0, -1.0], [99.999_133_974_596_22, 100.000_866_025_403_8]),
            // Nearly along the axis.
            (1.0, [0.0, -10.0, 0.5], [0.0, 1.0, 1e-8], [-150_000_000.0, 50_000_000.0]),
        ];
        for (radius, origin, direction, exact) in cases {
            let found = hits(radius, origin, direction);
            assert_eq!(found.len(), 2, "{origin:?}");
            for (t, exact) in found.into_iter().zip(exact) {
                assert!((t - exact).abs() <= 4.5e-16 * exact.abs(), "{origin:?}: {t} instead of {exact}");
            }
        }
    }

    #[test]
    fn rays_along_the_axis_miss_everywhere() {
        for x in [0.0, 0.5, 1.0, 2.0] {
            assert!(hits(1.0, [x, 0.0, 0.0], [0.0, 1.0, 0.0]).is_empty(), "{x}");
        }
    }

    #[test]
    fn the_side_is_textured_by_its_length() {
        let cylinder = InfiniteCylinder::new(2.0).expect("a cylinder");
        let ray = Ray::new(DVec3::new(-5.0, 1e9, 0.0), DVec3::X);
        let hit = cylinder.intersect(&ray, Interval::FORWARD).expect("a hit");
        let surface = cylinder.surface(&ray, &hit, InteractionFlags::ALL);
        assert_eq!((hit.t, surface.geometric_normal, surface.uv), (3.0, DVec3::NEG_X, [0.25, 1e9]));
    }

    #[test]
    fn bad_radii_are_refused() {
        assert_eq!(InfiniteCylinder::new(-2.0), Err(ShapeError::BadRadius(-2.0)));
        assert!(InfiniteCylinder::new(f64::NAN).is_err());
    }

    proptest! {
        /// Intersections are those of the circle in the plane across the axis, at any height.
        #[test]
        fn height_does_not_matter(
            x in -5.0..5.0f64, z in -5.0..5.0f64, dx in -1.0..1.0f64, dz in -1.0..1.0f64, y in -1e9..1e9f64, dy in -9.0..9.0f64,
        ) {
            prop_assert_eq!(hits(1.5, [x, y, z], [dx, dy, dz]), hits(1.5, [x, 0.0, z], [dx, 0.0, dz]));
        }

        #[test]
        fn t_scales_exactly_with_the_direction(x in -5.0..5.0f64, z in -5.0..5.0f64, dx in -1.0..1.0f64, k in -100i32..100) {
            let scale = rt_math::transcendental::exp2(f64::from(k));
            let plain = hits(1.5, [x, 0.0, z], [dx, 0.5, 1.0]);
            let scaled = hits(1.5, [x, 0.0, z], [dx * scale, 0.5 * scale, scale]);
            prop_assert_eq!(plain, scaled.into_iter().map(|t| t * scale).collect::<Vec<_>>());
        }
    }
}
