//! Axis-aligned planes.
//!
//! # Why crossings are conservative
//!
//! On the axis of a plane at `s`, let `o` be the origin of a ray, `v = fl(1/d)`, and `fl` rounding to the nearest
//! `f64`. [`Aabb::clip`] enters padded bounds `[b₋, b₊]` no earlier than `fl(fl(b₋ − o)·v)` and leaves it no later than
//! `fl(fl(fl(b₊ − o)·v)·FAR_FACTOR)`, for `v > 0`. A crossing takes the same operations to the plane, at `ts = fl(fl(s −
//! o)·v)`, and each of them is monotone:
//!
//! * A box that lies above only, `s < b₋`, is entered at `E ≥ fl(fl(b₋ − o)·v) ≥ ts = far_min`.
//! * A box that lies below only, `b₊ < s`, is entered at `E ≤ fl(fl(fl(b₊ − o)·v)·FAR_FACTOR) ≤ fl(ts·FAR_FACTOR) ≤
//!   near_max`. That is the greater of this and `ts`, which differ where `ts < 0`, so that `far_min ≤ near_max`.
//!
//! For `v < 0` the sides and all signs are exchanged. `0 · ∞` gives NaN where a ray lies in the plane, and no
//! constraint. Where the ray lies in a face of a box off the plane, `ts` is infinite. Its sign is then the one that
//! does not constrain the side of the box. So the contract of [`SplitPlane::plane_hit`] holds for every finite
//! ray, **bit for bit**.

use glam::DVec3;
use rt_math::{Aabb, FAR_FACTOR, Interval, SlabRay};

use crate::axis::Axis;
use crate::space_partition::{PlaneHit, SplitPlane};

/// Plane of all points with one coordinate of a given value. Packed, so that a node has 16 bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(Rust, packed(4))]
pub(crate) struct AxisPlane {
    pub(crate) position: f64,
    pub(crate) axis: Axis,
}

impl SplitPlane for AxisPlane {
    type Ray = SlabRay;

    /// Accepts every finite ray.
    #[inline]
    fn prepare(ray: &SlabRay, _bounds: &Aabb, _inside: Interval) -> Option<SlabRay> {
        Some(*ray)
    }

    #[inline(always)]
    fn plane_hit(&self, ray: &SlabRay) -> PlaneHit {
        let axis = self.axis as usize;
        let inverse = ray.inverse[axis];
        let t = (self.position - ray.ray.origin[axis]) * inverse;
        let later = t * FAR_FACTOR;
        PlaneHit { from_above: inverse.is_sign_negative(), near_max: if later > t { later } else { t }, far_min: t }
    }

    #[inline(always)]
    fn is_above(&self, point: DVec3) -> bool {
        point[self.axis as usize] >= self.position
    }

    /// A box that touches the plane is on both sides.
    #[inline(always)]
    fn classify(&self, aabb: &Aabb) -> [bool; 2] {
        let axis = self.axis as usize;
        [aabb.min[axis] <= self.position, aabb.max[axis] >= self.position]
    }

    fn split_bounds(&self, cell: &Aabb) -> [Aabb; 2] {
        let mut parts = [*cell; 2];
        parts[0].max[self.axis as usize] = self.position;
        parts[1].min[self.axis as usize] = self.position;
        parts
    }

    fn is_tight(&self) -> bool {
        true
    }

    fn is_valid(&self) -> bool {
        let position = self.position;
        position.is_finite()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space_partition::PartitionNode;
    use rt_math::Ray;
    use rt_math::random::hash;

    #[test]
    fn a_node_has_sixteen_bytes() {
        assert_eq!(size_of::<PartitionNode<AxisPlane>>(), 16);
    }

    /// Checks the proof at the top of this file with numbers that round, cancel, overflow and give NaN, without
    /// tolerance.
    #[test]
    fn boxes_on_one_side_are_entered_within_the_interval_of_that_side() {
        let values =
            [0.0, -0.0, 1.0, -1.0, 0.3, -0.7, 1.0 + f64::EPSILON, 1e-300, 5e-324, -1e-310, 1e17, 1e300, -3e307];
        let mut n_sides = [0; 2];
        for i in 0..200_000 {
            let draw = |k: u64| {
                let bits = hash(&[i, k]);
                let value = values[(bits % values.len() as u64) as usize];
                [value, value.next_up(), value.next_down(), value * 1.1][(bits >> 32) as usize % 4]
            };
            let vector = |k: u64| DVec3::new(draw(k), draw(k + 1), draw(k + 2));
            let own = Aabb::from_points([vector(0), vector(3)]);
            let ray = Ray::new(vector(6), vector(9));
            let axis = Axis::ALL[(hash(&[i, 12]) % 3) as usize];
            // Anywhere, or one step off the box.
            let position = match hash(&[i, 13]) % 4 {
                0 => own.min[axis as usize].next_down(),
                1 => own.max[axis as usize].next_up(),
                _ => draw(14),
            };
            let plane = AxisPlane { position, axis };
            let ray = SlabRay::new(&ray);
            let PlaneHit { from_above, near_max, far_min } = plane.plane_hit(&ray);
            assert!(!(far_min > near_max), "case {i}: {plane:?} {ray:?}");
            let [below, above] = plane.classify(&own);
            for span in [Interval::FORWARD, Interval::new(-3.0, 2.0), Interval::new(f64::NEG_INFINITY, f64::INFINITY)] {
                let Some(inside) = own.clip(&ray, span).filter(|_| below != above) else { continue };
                if above == from_above {
                    assert!(!(inside.min > near_max), "case {i}: {plane:?} {own:?} {ray:?}");
                } else {
                    assert!(!(inside.min < far_min), "case {i}: {plane:?} {own:?} {ray:?}");
                }
                n_sides[usize::from(above == from_above)] += 1;
            }
        }
        assert!(n_sides.iter().all(|&n| n > 5_000), "{n_sides:?}");
    }

    #[test]
    fn rays_in_the_plane_see_both_sides() {
        let plane = AxisPlane { position: 2.0, axis: Axis::Y };
        for zero in [0.0, -0.0] {
            let crossing =
                |y| plane.plane_hit(&SlabRay::new(&Ray::new(DVec3::new(0.0, y, 0.0), DVec3::new(1.0, zero, 0.0))));
            let within = crossing(2.0);
            assert!(within.near_max.is_nan() && within.far_min.is_nan());
            let [above, below] = [crossing(2.5), crossing(1.5)];
            assert_eq!(above.far_min == f64::NEG_INFINITY, !above.from_above, "{above:?}");
            assert_eq!(below.far_min == f64::NEG_INFINITY, below.from_above, "{below:?}");
        }
    }
}
