//! Finite cylinders.

use crate::error::{ShapeError, check_coordinates, check_radius};
use crate::{InteractionFlags, ShapeHit, SurfaceInteraction, capped_quadric::CappedQuadric, quadric_side::QuadricSide};
use rt_math::{Aabb, DVec3, Interval, Ray};

/// Cylinder around the y axis, from a bottom to a top: a closed solid with caps, or an open surface without. Its normal
/// points outwards, away from the axis on the side.
///
/// On the side, the texture coordinate `u` runs once around +y as on a [`Sphere`](crate::Sphere), with +z at ½. `v`
/// runs from 0 at the bottom to 1 at the top. On the caps they run from 0 to 1 over the square around the disk, upright
/// and unmirrored from outside. `v` runs along −z on the top and along +z on the bottom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder(CappedQuadric);

impl Cylinder {
    /// The cylinder x² + z² ≤ radius² with `bottom` ≤ y ≤ `top`; only its side if it has no `caps`.
    ///
    /// # Errors
    /// If the radius is not positive (at least 1e-60), the top is not above the bottom, or a number is not finite.
    pub fn new(radius: f64, bottom: f64, top: f64, caps: bool) -> Result<Self, ShapeError> {
        check_coordinates([DVec3::new(bottom, top, 0.0)])?;
        check_radius(radius)?;
        if bottom >= top {
            return Err(ShapeError::NoHeight { bottom, top });
        }
        Ok(Self(CappedQuadric { side: QuadricSide { height: bottom, radius, slope: 0.0 }, bottom, top, caps }))
    }

    /// The radius, positive.
    pub const fn radius(&self) -> f64 {
        self.0.side.radius
    }

    /// Heights of the bottom and of the top.
    pub const fn heights(&self) -> [f64; 2] {
        [self.0.bottom, self.0.top]
    }

    /// True for a closed solid, false for an open surface.
    pub const fn has_caps(&self) -> bool {
        self.0.caps
    }

    /// The smallest box around the cylinder, rounded outwards.
    pub fn bounds(&self) -> Aabb {
        self.0.bounds()
    }

    /// Support function: the largest dot product of a direction with a point of the cylinder.
    pub(crate) fn support(&self, direction: DVec3) -> f64 {
        self.0.support(direction)
    }

    /// First intersection within `span`. `None` on a miss, and for rays without a direction.
    ///
    /// The side is intersected as a circle in the plane across the axis. The discriminant is (r − L)(r + L), where L is
    /// the distance of the ray from the axis. A ray along the axis hits the caps alone, rims included.
    #[inline]
    pub fn intersect(&self, ray: &Ray, span: Interval) -> Option<ShapeHit> {
        self.0.intersect(ray, span)
    }

    /// The surface at a hit of [`intersect`](Self::intersect).
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit, needs: InteractionFlags) -> SurfaceInteraction {
        self.0.surface(ray, hit, needs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rt_math::random;
    use rt_math::transcendental::sincos;
    use std::f64::consts::TAU;

    const CLOSED: bool = true;
    const OPEN: bool = false;

    fn cylinder(caps: bool) -> Cylinder {
        Cylinder::new(1.0, -1.0, 2.0, caps).expect("a cylinder")
    }

    fn hit(cylinder: Cylinder, origin: [f64; 3], direction: [f64; 3], span: Interval) -> Option<(f64, DVec3)> {
        let ray = Ray::new(origin.into(), direction.into());
        let hit = cylinder.intersect(&ray, span)?;
        Some((hit.t, cylinder.surface(&ray, &hit, InteractionFlags::ALL).geometric_normal))
    }

    fn first(caps: bool, origin: [f64; 3], direction: [f64; 3]) -> Option<(f64, DVec3)> {
        hit(cylinder(caps), origin, direction, Interval::FORWARD)
    }

    #[test]
    fn the_side_and_the_caps_are_hit_from_outside_and_inside() {
        assert_eq!(first(CLOSED, [-3.0, 0.5, 0.0], [1.0, 0.0, 0.0]), Some((2.0, DVec3::NEG_X)));
        assert_eq!(first(CLOSED, [0.5, 0.5, 0.0], [1.0, 0.0, 0.0]), Some((0.5, DVec3::X)), "from inside");
        assert_eq!(first(CLOSED, [0.5, 5.0, 0.5], [0.0, -1.0, 0.0]), Some((3.0, DVec3::Y)));
        assert_eq!(first(CLOSED, [0.5, 0.0, 0.5], [0.0, -1.0, 0.0]), Some((1.0, DVec3::NEG_Y)), "from inside");
        assert_eq!(first(CLOSED, [-3.0, 2.5, 0.0], [1.0, 0.0, 0.0]), None, "above");
        assert_eq!(
            first(CLOSED, [-3.0, 2.0, 0.0], [1.0, 0.0, 0.0]),
            Some((2.0, DVec3::NEG_X)),
            "in the plane of a cap"
        );
        // In through the top, out through the side.
        let slanted = |span| hit(cylinder(CLOSED), [-2.0, 4.0, 0.0], [1.0, -1.0, 0.0], span).map(|(t, _)| t);
        assert_eq!(slanted(Interval::FORWARD), Some(2.0));
        assert_eq!(slanted(Interval::new(2.5, 3.0)), Some(3.0));
        assert_eq!(slanted(Interval::new(2.5, 2.9)), None);
    }

    #[test]
    fn an_open_tube_is_looked_through() {
        assert_eq!(first(OPEN, [0.5, 5.0, 0.5], [0.0, -1.0, 0.0]), None, "through the tube");
        // Over the near rim to the far wall.
        assert_eq!(first(OPEN, [-3.0, 4.5, 0.0], [1.0, -1.0, 0.0]), Some((4.0, DVec3::X)));
        assert_eq!(first(CLOSED, [-3.0, 4.5, 0.0], [1.0, -1.0, 0.0]), Some((2.5, DVec3::Y)));
        assert_eq!(first(OPEN, [-3.0, 4.0, 0.0], [1.0, -1.0, 0.0]), Some((2.0, DVec3::NEG_X)), "the rim is closed");
        assert_eq!(first(CLOSED, [-3.0, 4.0, 0.0], [1.0, -1.0, 0.0]), Some((2.0, DVec3::NEG_X)), "the rim: side first");
        assert_eq!(first(OPEN, [-3.0, 1.0, 0.0], [1.0, 0.0, 0.0]), Some((2.0, DVec3::NEG_X)));
    }

    #[test]
    fn rays_along_the_axis_meet_the_caps_up_to_the_rim() {
        for x in [0.5, 1.0] {
            assert_eq!(first(CLOSED, [x, 5.0, 0.0], [0.0, -1.0, 0.0]), Some((3.0, DVec3::Y)));
            assert_eq!(first(OPEN, [x, 5.0, 0.0], [0.0, -1.0, 0.0]), None);
        }
        assert_eq!(first(CLOSED, [1.0f64.next_up(), 5.0, 0.0], [0.0, -1.0, 0.0]), None);
    }

    #[test]
    fn tangents_count_up_to_the_last_number() {
        for x in [1.0f64.next_down(), 1.0] {
            assert!(first(CLOSED, [x, 0.0, -5.0], [0.0, 0.0, 1.0]).is_some_and(|(t, _)| (t - 5.0).abs() < 1e-7));
        }
        assert_eq!(first(CLOSED, [1.0f64.next_up(), 0.0, -5.0], [0.0, 0.0, 1.0]), None);
    }

    #[test]
    fn texture_coordinates_run_around_the_side_and_over_the_caps() {
        let uv = |origin: [f64; 3], direction: [f64; 3]| {
            let ray = Ray::new(origin.into(), direction.into());
            let hit = cylinder(CLOSED).intersect(&ray, Interval::FORWARD).expect("a hit");
            cylinder(CLOSED).surface(&ray, &hit, InteractionFlags::ALL).uv
        };
        assert_eq!(uv([0.0, 0.5, 3.0], [0.0, 0.0, -1.0]), [0.5, 0.5]);
        assert_eq!(uv([3.0, 1.25, 0.0], [-1.0, 0.0, 0.0]), [0.75, 0.75]);
        assert_eq!(uv([0.5, 5.0, -0.5], [0.0, -1.0, 0.0]), [0.75, 0.75]);
        assert_eq!(uv([0.5, -5.0, -0.5], [0.0, 1.0, 0.0]), [0.75, 0.25]);
    }

    #[test]
    fn bad_cylinders_are_refused() {
        let error = |radius, bottom, top| Cylinder::new(radius, bottom, top, CLOSED).expect_err("bad");
        assert_eq!(error(0.0, 0.0, 1.0), ShapeError::BadRadius(0.0));
        assert_eq!(error(1.0, 1.0, 1.0), ShapeError::NoHeight { bottom: 1.0, top: 1.0 });
        assert!(matches!(error(f64::NAN, 0.0, 1.0), ShapeError::BadCoordinate(_)));
        assert!(matches!(error(1.0, f64::NAN, 1.0), ShapeError::BadCoordinate(_)));
        assert_eq!(error(1.0, 0.0, f64::INFINITY), ShapeError::BadCoordinate(f64::INFINITY));
    }

    /// Rays through the rim into the solid, and rays from inside to the rim. Rounding must not let them pass between
    /// the side and a cap.
    #[test]
    fn no_ray_slips_through_the_rim() {
        let solid = Cylinder::new(0.7, -0.3, 1.1, CLOSED).expect("a cylinder");
        let (mut leaks, mut surplus) = (0, 0);
        for ray in 0..1_000_000u64 {
            let draw = |k: u64| random::unit(random::hash(&[ray, k]));
            let (sin, cos) = sincos(TAU * draw(0));
            let y = if draw(1) < 0.5 { -0.3 } else { 1.1 };
            let rim = DVec3::new(0.7 * sin, y, 0.7 * cos);
            let (sin, cos) = sincos(TAU * draw(2));
            let inside = DVec3::new(0.69 * draw(3) * sin, 1.38 * draw(4) - 0.29, 0.69 * draw(3) * cos);
            let back = 1e4 * draw(5) * draw(5) * draw(5);
            let arriving = Ray::new(rim + (rim - inside) * back, inside - rim);
            let leaving = Ray::new(inside, rim - inside);
            let hits = |ray: &Ray, min: f64| solid.intersect(ray, Interval::new(min, f64::INFINITY)).map(|hit| hit.t);
            leaks += usize::from(hits(&arriving, 0.0).is_none()) + usize::from(hits(&leaving, 0.0).is_none());
            let out = hits(&leaving, 0.0).unwrap_or(0.0);
            surplus += usize::from(hits(&leaving, out.next_up()).is_some());
        }
        assert_eq!((leaks, surplus), (0, 0));
    }

    fn vector(range: f64) -> impl Strategy<Value = DVec3> {
        let side = -range..range;
        (side.clone(), side.clone(), side).prop_map(DVec3::from)
    }

    proptest! {
        #[test]
        fn hits_lie_on_the_cylinder(
            radius in 0.1..5.0f64, bottom in -5.0..5.0f64, height in 0.1..5.0f64, caps in any::<bool>(),
            from in vector(100.0), to in vector(3.0),
        ) {
            let cylinder = Cylinder::new(radius, bottom, bottom + height, caps).expect("a cylinder");
            let ray = Ray::new(from, to - from);
            if let Some(hit) = cylinder.intersect(&ray, Interval::FORWARD) {
                let surface = cylinder.surface(&ray, &hit, InteractionFlags::ALL);
                let p = surface.point;
                let (from_axis, normal) = (DVec3::new(p.x, 0.0, p.z).length(), surface.geometric_normal);
                let off = if normal.y == 0.0 {
                    from_axis - radius
                } else {
                    p.y - if normal.y > 0.0 { bottom + height } else { bottom }
                };
                prop_assert!(off.abs() <= normal.abs().dot(surface.point_error), "{off}");
                prop_assert!(from_axis <= radius * (1.0 + 1e-15) && (bottom..=bottom + height).contains(&p.y));
                prop_assert!((p - ray.at(hit.t)).length() < 1e-12);
                prop_assert!((normal.length() - 1.0).abs() < 1e-15);
                prop_assert!(normal.y != 0.0 || normal.dot(p - DVec3::Y * p.y) > 0.0);
                prop_assert!(surface.uv.iter().all(|x| (0.0..=1.0).contains(x)), "{:?}", surface.uv);
                prop_assert!(cylinder.bounds().contains(p));
            }
        }

        /// An open cylinder differs from a solid only where the caps hide its inside.
        #[test]
        fn caps_only_add_hits(from in vector(4.0), to in vector(2.0)) {
            let ray = Ray::new(from, to - from);
            let [solid, open] =
                [CLOSED, OPEN].map(|caps| cylinder(caps).intersect(&ray, Interval::FORWARD).map(|hit| hit.t));
            prop_assert!(open.is_none_or(|open| solid.is_some_and(|solid| solid <= open)), "{solid:?} {open:?}");
        }
    }
}
