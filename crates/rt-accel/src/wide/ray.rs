//! A ray as the filters see it: eight boxes at a time, in `f32`.
//!
//! # Why the culling is conservative
//!
//! Let `c` be the centre of the tree, `o` the origin of the ray, `v = fl(1/d)` on some axis, and `u = 2⁻⁵³`. An own box
//! is entered through the plane `b` at `fl(fl(b − o)·v)`, which is within 3.1u of the real number `τ = (b − o)/d`, and
//! left after at most `τ·(1 + 10u)` ([`Aabb::clip`](rt_math::Aabb::clip)). A node stores a plane `p`, an `f32`, of which
//! [`NodeBox`](crate::bvh::NodeBox) promises that it lies at or before `b − c` where it is the near one, and at or behind
//! it where it is the far one. Take `v > 0` and let `q = o − c`; for `v < 0` all signs turn around.
//!
//! The filter computes `fl32(p·n + s)` for near planes, with the `f32` numbers `n` = `v` made smaller by 2⁻²² and rounded,
//! and `s ≤ −q·n − pad`, where `pad` = 2⁻⁴⁰·(size of the tree)·`v`. So before the last rounding it is at most
//! `(p − q)·n − pad`.
//!
//! * If `p − q ≤ 0` it is at most 0, and spans begin at 0 or later.
//! * Otherwise it is at most `τ·(1 − 2⁻²² + 2⁻²⁴)`, and rounding adds 2⁻²⁴: at most `τ·(1 − 2⁻²³)`, less than what the own
//!   box computes.
//!
//! Far planes are the mirror image, with `v` made greater: what is in front of the ray is left no earlier, and what is
//! behind it was left by the own box as well. Rounding of `q`, of `s` and of small numbers is covered by `pad` and by the
//! 2⁻²³ of `|q·n|` that `s` is moved outward by. Without a fused multiply-add `p·n` is rounded by itself, and `pad` has
//! 2⁻²² in place of 2⁻⁴⁰.
//!
//! **Directions that are nearly zero on an axis.** `|v|` is limited to 2⁶⁰ over the greatest component `D` of the direction.
//! Entering later than the truth is impossible by that, as times in front of the ray become smaller. Leaving is: but
//! `pad` makes every time of leaving at least 2²⁰·size/D, and as `|q| ≤ 2¹⁹·size`, the own box is left on the axis of `D`
//! before that.
//!
//! **Range.** All this needs numbers that neither over- nor underflow. [`FilterRay::new`] refuses rays and trees out of
//! proportion, which are walked in `f64`.

use rt_math::{DVec3, Interval, SlabRay};

use super::four::Four;
use super::node::Node;
use super::simd::Simd;

/// By how much reciprocals are moved.
const SLACK: f64 = 1.0 / (1 << 22) as f64;

/// Greatest reciprocal, relative to that of the greatest component.
const STEEPEST: f64 = (1u64 << 60) as f64;

/// Farthest origin, in sizes of the tree.
const FARTHEST: f64 = (1 << 19) as f64;

/// A ray prepared for boxes of `f32`: planes are passed at `plane·scale + shift`.
#[derive(Clone, Copy, Debug)]
pub(super) struct FilterRay {
    near_scale: [f32; 4],
    near_shift: [f32; 4],
    far_scale: [f32; 4],
    far_shift: [f32; 4],
    /// By axis: 1 if the near plane is the upper one.
    pub(super) near_side: [usize; 3],
}

/// Least and greatest number of a tree or direction for which nothing over- or underflows.
const RANGE: core::ops::RangeInclusive<f64> = 1.0 / (1 << 24) as f64..=(1 << 24) as f64;

/// The greater of both, in one instruction; either where one is NaN.
#[inline(always)]
pub(super) fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

impl FilterRay {
    /// For a tree of this centre and size, its greatest coordinate relative to the centre. `None` where the proof does
    /// not hold.
    #[inline(always)]
    pub(super) fn new<S: Simd>(_simd: S, ray: &SlabRay, span: Interval, centre: DVec3, size: f64) -> Option<Self> {
        let direction = ray.ray.direction.abs();
        let greatest = greater(greater(direction.x, direction.y), direction.z);
        let q = ray.ray.origin - centre;
        let distance = q.abs();
        let farthest = greater(greater(distance.x, distance.y), distance.z);
        // A NaN is in no range, and not finite.
        let is_proven = RANGE.contains(&greatest)
            & RANGE.contains(&size)
            & (farthest <= FARTHEST * size)
            & (span.min >= 0.0)
            & (direction.x + direction.y + direction.z + q.x + q.y + q.z).is_finite();
        if !is_proven {
            return None;
        }
        let pad_of = size / if S::FUSED { (1u64 << 40) as f64 } else { (1u64 << 22) as f64 };
        let inverse = Four::new(ray.inverse, 1.0).limited(STEEPEST / greatest);
        let q = Four::new(q, 0.0);
        let near_scale = (inverse * Four::splat(1.0 - SLACK)).to_f32();
        let far_scale = (inverse * Four::splat(1.0 + SLACK)).to_f32();
        let pad = Four::splat(pad_of) * inverse.abs();
        let (near_q, far_q) = (q * Four::from_f32(near_scale), q * Four::from_f32(far_scale));
        let slack = Four::splat(SLACK / 2.0);
        let near_shift = (Four::splat(0.0) - near_q) - (near_q.abs() * slack + pad);
        let far_shift = (far_q.abs() * slack + pad) - far_q;
        let is_negative = |axis: usize| usize::from(inverse.0[axis].is_sign_negative());
        Some(Self {
            near_scale,
            near_shift: near_shift.to_f32(),
            far_scale,
            far_shift: far_shift.to_f32(),
            near_side: [is_negative(0), is_negative(1), is_negative(2)],
        })
    }

    /// Where near planes are passed, or before.
    #[inline(always)]
    pub(super) fn near<S: Simd>(&self, simd: S, axis: usize, planes: S::Lanes) -> S::Lanes {
        simd.mul_add(planes, simd.splat(self.near_scale[axis]), simd.splat(self.near_shift[axis]))
    }

    /// Where far planes are passed, or after.
    #[inline(always)]
    pub(super) fn far<S: Simd>(&self, simd: S, axis: usize, planes: S::Lanes) -> S::Lanes {
        simd.mul_add(planes, simd.splat(self.far_scale[axis]), simd.splat(self.far_shift[axis]))
    }

    /// Where the boxes of a node are entered, at `min` or later, and which of them are passed between `min` and `max`.
    #[inline(always)]
    pub(super) fn cross<S: Simd>(&self, simd: S, node: &Node, min: f32, max: f32) -> (S::Lanes, u32) {
        let [x, y, z] = [self.near_side[0] & 1, 2 | self.near_side[1] & 1, 4 | self.near_side[2] & 1];
        let planes = &node.planes;
        let enter_x = self.near(simd, 0, simd.load(&planes[x]));
        let enter_y = self.near(simd, 1, simd.load(&planes[y]));
        let enter_z = self.near(simd, 2, simd.load(&planes[z]));
        let leave_x = self.far(simd, 0, simd.load(&planes[x ^ 1]));
        let leave_y = self.far(simd, 1, simd.load(&planes[y ^ 1]));
        let leave_z = self.far(simd, 2, simd.load(&planes[z ^ 1]));
        let enter = simd.max(simd.max(enter_x, enter_y), simd.max(enter_z, simd.splat(min)));
        let leave = simd.min(simd.min(leave_x, leave_y), simd.min(leave_z, simd.splat(max)));
        (enter, simd.le(enter, leave))
    }
}

/// An `f32` that is not above `t`, which is not negative.
#[inline(always)]
pub(super) fn at_most(t: f64) -> f32 {
    let below = (t * (1.0 - SLACK)) as f32;
    if below < f32::MIN_POSITIVE { 0.0 } else { below }
}

/// An `f32` that is not below `t`, which is not negative.
#[inline(always)]
pub(super) fn at_least(t: f64) -> f32 {
    ((t * (1.0 + SLACK)) as f32).max(f32::MIN_POSITIVE)
}
