//! Axis-aligned boxes as shapes.

use crate::error::{ShapeError, check_coordinates};
use crate::{InteractionFlags, ShapeHit, SurfaceInteraction};
use rt_math::float::gamma;
use rt_math::{Aabb, DVec3, Interval, Ray};

/// A closed solid box with faces along the axes; its normal points outwards. It may be flat.
///
/// Each face has texture coordinates from 0 to 1, upright and unmirrored from outside. `v` runs along +y on the four
/// sides, along −z on the top (+y) and along +z on the bottom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cuboid {
    bounds: Aabb,
}

/// One of the six faces, numbered as in the `uv[0]` of a hit: twice the axis, plus one for the greater side.
#[derive(Clone, Copy)]
struct CuboidFace {
    axis: usize,
    greater: bool,
}

impl CuboidFace {
    fn number(self) -> f64 {
        (2 * self.axis + usize::from(self.greater)) as f64
    }

    fn from_number(number: f64) -> Self {
        let number = number as usize;
        Self { axis: (number / 2).min(2), greater: number % 2 == 1 }
    }
}

impl Cuboid {
    /// The box from `min` to `max`.
    ///
    /// # Errors
    /// If `min` exceeds `max` on an axis or a number is not finite.
    pub fn new(min: DVec3, max: DVec3) -> Result<Self, ShapeError> {
        check_coordinates([min, max])?;
        match (0..3).find(|&axis| min[axis] > max[axis]) {
            Some(axis) => Err(ShapeError::InvertedBox { axis, min: min[axis], max: max[axis] }),
            None => Ok(Self { bounds: Aabb::new(min, max) }),
        }
    }

    /// The extent of the box.
    pub const fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Parameter at which the ray enters the box, or leaves it if the entry is before `span`. `None` on a miss, and for
    /// rays without a direction. At an edge the face of the lowest axis wins.
    ///
    /// The slab test (Williams et al. 2005) without any widening: two boxes that share a face compute the same `t` for
    /// it, so no ray slips between them.
    #[inline]
    pub fn intersect(&self, ray: &Ray, span: Interval) -> Option<ShapeHit> {
        let inverse = ray.direction.recip();
        let nowhere = CuboidFace { axis: 0, greater: false };
        let (mut enter, mut enter_face) = (f64::NEG_INFINITY, nowhere);
        let (mut leave, mut leave_face) = (f64::INFINITY, nowhere);
        for axis in 0..3 {
            let low = (self.bounds.min[axis] - ray.origin[axis]) * inverse[axis];
            let high = (self.bounds.max[axis] - ray.origin[axis]) * inverse[axis];
            let backwards = inverse[axis].is_sign_negative();
            let (near, far) = if backwards { (high, low) } else { (low, high) };
            // A ray in the plane of a face gives NaN, which fails both comparisons: the box is closed.
            if near > enter {
                (enter, enter_face) = (near, CuboidFace { axis, greater: backwards });
            }
            if far < leave {
                (leave, leave_face) = (far, CuboidFace { axis, greater: !backwards });
            }
        }
        if enter > leave {
            return None;
        }
        let t = span.first(enter, leave)?;
        // A NaN in the ray must miss, but in the loop it looks like a ray within a face.
        if !t.is_finite() || ray.origin.is_nan() || ray.direction.is_nan() {
            return None;
        }
        let face = if t == enter { enter_face } else { leave_face };
        Some(ShapeHit { t, uv: [face.number(), 0.0] })
    }

    /// The surface at a hit of [`intersect`](Self::intersect). The point lies exactly on its face.
    pub fn surface(&self, ray: &Ray, hit: &ShapeHit, needs: InteractionFlags) -> SurfaceInteraction {
        let Aabb { min, max } = self.bounds;
        let CuboidFace { axis, greater } = CuboidFace::from_number(hit.uv[0]);
        let mut point = ray.at(hit.t).max(min).min(max);
        point[axis] = if greater { max[axis] } else { min[axis] };
        let mut normal = DVec3::ZERO;
        normal[axis] = if greater { 1.0 } else { -1.0 };
        // The point is exact across its face. The bound is for a ray that leaves a face at coordinate 0, where
        // neighbouring numbers are too close to distinguish.
        let point_error = DVec3::splat(gamma(3) * self.bounds.max_abs());
        let uv = if needs.uv { self.face_uv(point, axis, greater) } else { [0.0; 2] };
        SurfaceInteraction::flat(point, point_error, normal, uv)
    }

    fn face_uv(&self, point: DVec3, axis: usize, greater: bool) -> [f64; 2] {
        let along = |axis: usize, forwards: bool| {
            let (min, max) = (self.bounds.min[axis], self.bounds.max[axis]);
            let fraction = if max > min { (point[axis] - min) / (max - min) } else { 0.0 };
            if forwards { fraction } else { 1.0 - fraction }
        };
        match axis {
            0 => [along(2, !greater), along(1, true)],
            1 => [along(0, true), along(2, !greater)],
            _ => [along(0, greater), along(1, true)],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strategies::vector;
    use proptest::prelude::*;

    fn unit() -> Cuboid {
        Cuboid::new(DVec3::ZERO, DVec3::ONE).expect("a box")
    }

    /// Parameter, normal and texture coordinates of the hit.
    fn hit(axis_box: Cuboid, origin: [f64; 3], direction: [f64; 3]) -> Option<(f64, DVec3, [f64; 2])> {
        let ray = Ray::new(origin.into(), direction.into());
        let hit = axis_box.intersect(&ray, Interval::FORWARD)?;
        let surface = axis_box.surface(&ray, &hit, InteractionFlags::ALL);
        Some((hit.t, surface.geometric_normal, surface.uv))
    }

    fn t_and_normal(axis_box: Cuboid, origin: [f64; 3], direction: [f64; 3]) -> Option<(f64, DVec3)> {
        hit(axis_box, origin, direction).map(|(t, normal, _)| (t, normal))
    }

    #[test]
    fn known_values() {
        assert_eq!(t_and_normal(unit(), [-1.0; 3], [1.0; 3]), Some((1.0, DVec3::NEG_X)), "three faces tie");
        assert_eq!(t_and_normal(unit(), [0.5; 3], [1.0; 3]), Some((0.5, DVec3::X)), "three faces tie on the way out");
        for zero in [0.0, -0.0] {
            let grazing = [1.0, zero, zero];
            assert_eq!(t_and_normal(unit(), [-1.0, 0.0, 0.5], grazing), Some((1.0, DVec3::NEG_X)), "closed");
            assert_eq!(t_and_normal(unit(), [-1.0, 1.0, 0.5], grazing), Some((1.0, DVec3::NEG_X)), "closed");
            assert_eq!(t_and_normal(unit(), [-1.0, 1.5, 0.5], grazing), None);
        }
        assert_eq!(t_and_normal(unit(), [0.0, 0.0, 0.5], [0.0, 1.0, 0.0]), Some((0.0, DVec3::NEG_Y)));
        assert_eq!(t_and_normal(unit(), [0.5; 3], [0.0, 0.0, -1.0]), Some((0.5, DVec3::NEG_Z)), "exit");
        assert_eq!(t_and_normal(unit(), [0.5, 0.5, 2.0], [0.0, 0.0, 1.0]), None, "behind");
    }

    #[test]
    fn spans_are_closed_and_choose_the_exit_after_the_entry() {
        let ray = Ray::new(DVec3::new(-1.0, 0.5, 0.5), DVec3::X);
        let within = |min, max| unit().intersect(&ray, Interval::new(min, max)).map(|hit| hit.t);
        assert_eq!(within(1.0, 1.0), Some(1.0));
        assert_eq!(within(1.5, 2.0), Some(2.0));
        assert_eq!(within(1.5, 1.9), None);
        assert_eq!(within(0.0, 0.9), None);
    }

    #[test]
    fn flat_boxes_are_hit_on_the_near_side() {
        for thickness in [0.0, 1e-300] {
            let flat = Cuboid::new(DVec3::ZERO, DVec3::new(1.0, 1.0, thickness)).expect("a box");
            assert_eq!(t_and_normal(flat, [0.5, 0.5, -1.0], [0.0, 0.0, 1.0]), Some((1.0, DVec3::NEG_Z)));
            assert_eq!(t_and_normal(flat, [0.5, 0.5, 1.0], [0.0, 0.0, -1.0]), Some((1.0, DVec3::Z)));
            assert_eq!(t_and_normal(flat, [-1.0, 0.5, 0.0], [1.0, 0.0, 0.0]), Some((1.0, DVec3::NEG_X)), "edge-on");
        }
    }

    #[test]
    fn textures_are_upright_from_outside() {
        let big = Cuboid::new(DVec3::ZERO, DVec3::splat(4.0)).expect("a box");
        // Rows: viewer, view direction, and the expected values at a quarter of the way right and up from the lower
        // left.
        let rows = [
            ([1.0, 1.0, 9.0], [0.0, 0.0, -1.0]),
            ([3.0, 1.0, -9.0], [0.0, 0.0, 1.0]),
            ([9.0, 1.0, 3.0], [-1.0, 0.0, 0.0]),
            ([-9.0, 1.0, 1.0], [1.0, 0.0, 0.0]),
            ([1.0, 9.0, 3.0], [0.0, -1.0, 0.0]),
            ([1.0, -9.0, 1.0], [0.0, 1.0, 0.0]),
        ];
        for (origin, direction) in rows {
            assert_eq!(hit(big, origin, direction).map(|(.., uv)| uv), Some([0.25, 0.25]), "from {origin:?}");
        }
        let flat = Cuboid::new(DVec3::ZERO, DVec3::new(1.0, 0.0, 1.0)).expect("a box");
        assert_eq!(hit(flat, [-1.0, 0.0, 0.5], [1.0, 0.0, 0.0]).map(|(.., uv)| uv), Some([0.5, 0.0]), "no height");
    }

    proptest! {
        #[test]
        fn hits_lie_on_their_face(a in vector(5.0), b in vector(5.0), from in vector(50.0), at in 0.0..1.0f64) {
            let solid = Cuboid::new(a.min(b), a.max(b)).expect("a box");
            let inside = a + (b - a) * at;
            let ray = Ray::new(from, inside - from);
            let hit = solid.intersect(&ray, Interval::FORWARD).expect("towards a point inside");
            let surface = solid.surface(&ray, &hit, InteractionFlags::ALL);
            let Aabb { min, max } = solid.bounds();
            let axis = surface.geometric_normal.abs().max_position();
            let face = if surface.geometric_normal[axis] > 0.0 { max[axis] } else { min[axis] };
            prop_assert_eq!(surface.point[axis], face);
            prop_assert!(solid.bounds().contains(surface.point));
            prop_assert!((surface.point - ray.at(hit.t)).length() < 1e-12);
            prop_assert!(surface.uv.iter().all(|x| (0.0..=1.0).contains(x)));
        }

        /// A ray at the common edge of two boxes hits one of them for any rounding.
        #[test]
        fn no_ray_slips_between_neighbours(from in vector(10.0), shared in -3.0..3.0f64, at in -0.9..0.9f64) {
            prop_assume!(from.z > 1.5);
            let left = Cuboid::new(DVec3::new(-4.0, -1.0, -1.0), DVec3::new(shared, 1.0, 1.0)).expect("a box");
            let right = Cuboid::new(DVec3::new(shared, -1.0, -1.0), DVec3::new(4.0, 1.0, 1.0)).expect("a box");
            let ray = Ray::new(from, DVec3::new(shared, at, 1.0) - from);
            prop_assert!([left, right].iter().any(|solid| solid.intersect(&ray, Interval::FORWARD).is_some()));
        }
    }
}
