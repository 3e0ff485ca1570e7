//! Frusta: cones without their tip.

use crate::error::{ShapeError, check_length, check_radius};
use crate::{InteractionFlags, ShapeHit, SurfaceInteraction, capped_quadric::CappedQuadric, quadric_side::QuadricSide};
use rt_math::{Aabb, DVec3, Interval, Ray};

/// Cone cut off at both ends that stands on the plane y = 0: a closed solid with caps, or open without. Its normal
/// points outwards, away from the axis on the side.
///
/// Texture coordinates are those of a [`Cylinder`](crate::Cylinder).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frustum(CappedQuadric);

impl Frustum {
    /// Solid from a disk at y = 0 to one at y = `height`; only its side without `caps`. Either disk may be the larger
    /// one; for a tip use [`Cone`](crate::Cone).
    ///
    /// # Errors
    /// If a radius or the height is not positive (at least 1e-60), or not finite.
    pub fn new(bottom_radius: f64, top_radius: f64, height: f64, caps: bool) -> Result<Self, ShapeError> {
        check_radius(bottom_radius)?;
        check_radius(top_radius)?;
        check_length("height", height)?;
        let slope = (top_radius - bottom_radius) / height;
        // Near the smaller end a rounding error matters most.
        let side = if bottom_radius < top_radius {
            QuadricSide { height: 0.0, radius: bottom_radius, slope }
        } else {
            QuadricSide { height, radius: top_radius, slope }
        };
        Ok(Self(CappedQuadric { side, bottom: 0.0, top: height, caps }))
    }

    /// Height of the upper end, positive.
    pub const fn height(&self) -> f64 {
        self.0.top
    }

    /// True for a closed solid, false for an open surface.
    pub const fn has_caps(&self) -> bool {
        self.0.caps
    }

    /// The smallest box around the frustum, rounded outwards.
    pub fn bounds(&self) -> Aabb {
        self.0.bounds()
    }

    /// Support function: the largest dot product of a direction with a point of the frustum.
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
    use crate::{Cone, Cylinder};
    use proptest::prelude::*;

    fn frustum(caps: bool) -> Frustum {
        Frustum::new(2.0, 1.0, 1.0, caps).expect("a frustum")
    }

    fn first(frustum: Frustum, origin: [f64; 3], direction: [f64; 3]) -> Option<(f64, DVec3)> {
        let ray = Ray::new(origin.into(), direction.into());
        let hit = frustum.intersect(&ray, Interval::FORWARD)?;
        Some((hit.t, frustum.surface(&ray, &hit, InteractionFlags::ALL).geometric_normal))
    }

    #[test]
    fn known_values() {
        let (t, normal) = first(frustum(true), [-5.0, 0.5, 0.0], [1.0, 0.0, 0.0]).expect("the side");
        assert_eq!(t, 3.5);
        assert!((normal - DVec3::new(-1.0, 1.0, 0.0).normalize()).length() < 1e-15);
        assert_eq!(first(frustum(true), [0.5, 3.0, 0.0], [0.0, -1.0, 0.0]), Some((2.0, DVec3::Y)));
        assert_eq!(first(frustum(true), [1.5, -3.0, 0.0], [0.0, 1.0, 0.0]), Some((3.0, DVec3::NEG_Y)));
        assert_eq!(first(frustum(false), [0.5, 3.0, 0.0], [0.0, -1.0, 0.0]), None, "through the open frustum");
        assert_eq!(
            first(frustum(true), [1.5, 3.0, 0.0], [0.0, -1.0, 0.0]).map(|(t, _)| t),
            Some(2.5),
            "beside the top"
        );
        let funnel = Frustum::new(1.0, 2.0, 1.0, true).expect("a frustum");
        assert_eq!(first(funnel, [1.5, -3.0, 0.0], [0.0, 1.0, 0.0]).map(|(t, _)| t), Some(3.5), "under the brim");
    }

    #[test]
    fn bad_frusta_are_refused() {
        assert_eq!(Frustum::new(0.0, 1.0, 1.0, true), Err(ShapeError::BadRadius(0.0)));
        assert_eq!(Frustum::new(1.0, -1.0, 1.0, true), Err(ShapeError::BadRadius(-1.0)));
        assert_eq!(Frustum::new(1.0, 1.0, 0.0, true), Err(ShapeError::BadLength("height", 0.0)));
        assert!(Frustum::new(1.0, f64::NAN, 1.0, true).is_err());
    }

    fn vector(range: f64) -> impl Strategy<Value = DVec3> {
        let side = -range..range;
        (side.clone(), side.clone(), side).prop_map(DVec3::from)
    }

    proptest! {
        #[test]
        fn hits_lie_on_the_frustum(
            bottom in 0.01..5.0f64, top in 0.01..5.0f64, height in 0.01..5.0f64, caps in any::<bool>(),
            from in vector(50.0), to in vector(2.0),
        ) {
            let frustum = Frustum::new(bottom, top, height, caps).expect("a frustum");
            let ray = Ray::new(from, to - from);
            if let Some(hit) = frustum.intersect(&ray, Interval::FORWARD) {
                let surface = frustum.surface(&ray, &hit, InteractionFlags::ALL);
                let (p, normal) = (surface.point, surface.geometric_normal);
                let from_axis = DVec3::new(p.x, 0.0, p.z).length();
                let radius = bottom + (top - bottom) * (p.y / height);
                let stretch = DVec3::new(height, top - bottom, 0.0).length() / height;
                let gap = match normal {
                    DVec3::Y => p.y - height,
                    DVec3::NEG_Y => p.y,
                    _ => (from_axis - radius) / stretch,
                };
                prop_assert!(gap.abs() <= normal.abs().dot(surface.point_error), "{gap}");
                prop_assert!((p - ray.at(hit.t)).length() < 1e-11);
                prop_assert!(frustum.bounds().contains(p));
                prop_assert!(surface.uv.iter().all(|x| (0.0..=1.0).contains(x)), "{:?}", surface.uv);
            }
        }

        /// With equal radii it is a cylinder, with a tiny tip a cone.
        #[test]
        fn its_limits_are_cylinders_and_cones(from in vector(5.0), to in vector(1.0), caps in any::<bool>()) {
            let ray = Ray::new(from, to - from);
            let t = |hit: Option<ShapeHit>| hit.map(|hit| hit.t);
            let straight = Frustum::new(1.0, 1.0, 2.0, caps).expect("a frustum").intersect(&ray, Interval::FORWARD);
            let cylinder = Cylinder::new(1.0, 0.0, 2.0, caps).expect("a cylinder").intersect(&ray, Interval::FORWARD);
            prop_assert_eq!(t(straight), t(cylinder));
            let pointed = Frustum::new(1.0, 1e-30, 2.0, caps).expect("a frustum").intersect(&ray, Interval::FORWARD);
            let cone = Cone::new(1.0, 2.0, caps).expect("a cone").intersect(&ray, Interval::FORWARD);
            prop_assert_eq!(t(pointed), t(cone));
        }
    }
}
