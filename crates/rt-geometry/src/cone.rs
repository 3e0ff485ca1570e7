//! Finite cones.

use crate::error::{ShapeError, check_length, check_radius};
use crate::{InteractionFlags, ShapeHit, SurfaceInteraction, capped_quadric::CappedQuadric, quadric_side::QuadricSide};
use rt_math::{Aabb, DVec3, Interval, Ray};

/// Cone that stands on the plane y = 0 with its apex above: a closed solid with a cap below, or open without. Its
/// normal points outwards, away from the axis on the side; at the apex it is opposite to the incident ray.
///
/// Texture coordinates are those of a [`Cylinder`](crate::Cylinder).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone(CappedQuadric);

impl Cone {
    /// The cone with its base of this radius at y = 0 and its apex at y = `height`; only its side if it has no `caps`.
    ///
    /// # Errors
    /// If the radius or the height is not positive (at least 1e-60), or not finite.
    pub fn new(radius: f64, height: f64, caps: bool) -> Result<Self, ShapeError> {
        check_radius(radius)?;
        check_length("height", height)?;
        let side = QuadricSide { height, radius: 0.0, slope: -radius / height };
        Ok(Self(CappedQuadric { side, bottom: 0.0, top: height, caps }))
    }

    /// Height of the apex, positive.
    pub const fn height(&self) -> f64 {
        self.0.top
    }

    /// True for a closed solid, false for an open cone.
    pub const fn has_caps(&self) -> bool {
        self.0.caps
    }

    /// The smallest box around the cone, rounded outwards.
    pub fn bounds(&self) -> Aabb {
        self.0.bounds()
    }

    /// Support function: the largest dot product of a direction with a point of the cone.
    pub(crate) fn support(&self, direction: DVec3) -> f64 {
        self.0.support(direction)
    }

    /// First intersection within `span`. `None` on a miss, and for rays without a direction. See
    /// [`DoubleCone`](crate::DoubleCone) for the arithmetic.
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

    fn cone(caps: bool) -> Cone {
        Cone::new(1.0, 2.0, caps).expect("a cone")
    }

    fn first(caps: bool, origin: [f64; 3], direction: [f64; 3]) -> Option<(f64, DVec3)> {
        let ray = Ray::new(origin.into(), direction.into());
        let hit = cone(caps).intersect(&ray, Interval::FORWARD)?;
        Some((hit.t, cone(caps).surface(&ray, &hit, InteractionFlags::ALL).geometric_normal))
    }

    #[test]
    fn the_side_slopes_to_the_apex_and_the_base_faces_down() {
        let (t, normal) = first(true, [-3.0, 1.0, 0.0], [1.0, 0.0, 0.0]).expect("half way up");
        assert_eq!(t, 2.5);
        assert!((normal - DVec3::new(-2.0, 1.0, 0.0).normalize()).length() < 1e-15);
        assert_eq!(first(true, [0.5, -3.0, 0.0], [0.0, 1.0, 0.0]), Some((3.0, DVec3::NEG_Y)));
        assert_eq!(first(false, [0.5, -3.0, 0.0], [0.0, 1.0, 0.0]).map(|(t, _)| t), Some(4.0), "from inside");
        assert_eq!(first(true, [-3.0, 3.0, 0.0], [1.0, 0.0, 0.0]), None, "the other nappe is not there");
        assert_eq!(first(true, [-3.0, -0.5, 0.0], [1.0, 0.0, 0.0]), None, "nor what is below the base");
        assert_eq!(first(true, [0.25, 5.0, 0.0], [0.0, -1.0, 0.0]).map(|(t, _)| t), Some(3.5), "past the other nappe");
    }

    #[test]
    fn the_apex_faces_whoever_looks_at_it() {
        for caps in [true, false] {
            assert_eq!(first(caps, [0.0, 5.0, 0.0], [0.0, -1.0, 0.0]), Some((3.0, DVec3::Y)));
        }
        assert_eq!(first(true, [0.0, 1.0, 0.0], [0.0, 2.0, 0.0]), Some((0.5, DVec3::NEG_Y)), "from inside");
    }

    #[test]
    fn rays_along_a_generator_cross_once() {
        let parallel = [-0.5, 1.0, 0.0];
        assert_eq!(first(true, [2.0, -1.0, 0.0], parallel), None, "outside");
        assert_eq!(first(true, [1.0, -1.0, 0.0], parallel), Some((1.0, DVec3::NEG_Y)), "in at the base");
        assert_eq!(first(false, [1.0, -1.0, 0.0], parallel).map(|(t, _)| t), Some(2.5), "out at the side");
    }

    #[test]
    fn bad_cones_are_refused() {
        assert_eq!(Cone::new(0.0, 1.0, true), Err(ShapeError::BadRadius(0.0)));
        assert_eq!(Cone::new(1.0, -1.0, true), Err(ShapeError::BadLength("height", -1.0)));
        assert!(matches!(Cone::new(1.0, f64::NAN, true), Err(ShapeError::BadCoordinate(_))));
    }

    fn vector(range: f64) -> impl Strategy<Value = DVec3> {
        let side = -range..range;
        (side.clone(), side.clone(), side).prop_map(DVec3::from)
    }

    proptest! {
        #[test]
        fn hits_lie_on_the_cone(
            radius in 0.01..50.0f64, height in 0.01..50.0f64, caps in any::<bool>(), from in vector(100.0), to in vector(3.0),
        ) {
            let cone = Cone::new(radius, height, caps).expect("a cone");
            let ray = Ray::new(from, to - from);
            if let Some(hit) = cone.intersect(&ray, Interval::FORWARD) {
                let surface = cone.surface(&ray, &hit, InteractionFlags::ALL);
                let (p, normal) = (surface.point, surface.geometric_normal);
                let from_axis = DVec3::new(p.x, 0.0, p.z).length();
                let steepness = DVec3::new(radius, height, 0.0).length();
                let gap = if normal == DVec3::NEG_Y { p.y } else { (from_axis * height - radius * (height - p.y)) / steepness };
                prop_assert!(gap.abs() <= normal.abs().dot(surface.point_error), "{gap}");
                prop_assert!((p - ray.at(hit.t)).length() < 1e-11);
                prop_assert!((normal.length() - 1.0).abs() < 1e-15);
                prop_assert!(cone.bounds().contains(p));
                prop_assert!(surface.uv.iter().all(|x| (0.0..=1.0).contains(x)), "{:?}", surface.uv);
            }
        }

        /// A ray towards a point inside enters the solid and leaves it again.
        #[test]
        fn a_solid_is_entered_and_left(from in vector(20.0), x in -0.4..0.4f64, y in 0.01..1.0f64, z in -0.2..0.2f64) {
            let ray = Ray::new(from, DVec3::new(x, y, z) - from);
            let within = |min, max| cone(true).intersect(&ray, Interval::new(min, max)).map(|hit| hit.t);
            let enter = within(f64::NEG_INFINITY, f64::INFINITY).expect("towards a point inside");
            let leave = within(1.0, f64::INFINITY).expect("from a point inside");
            prop_assert!(enter < 1.0 && leave > 1.0);
            prop_assert_eq!(within(leave.next_up(), f64::INFINITY), None);
        }
    }
}
