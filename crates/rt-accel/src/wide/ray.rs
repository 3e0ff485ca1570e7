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

use rt_math::{DVec3, Interval, Ray};

use super::node::Node;
use super::simd::Simd;

/// By how much reciprocals are moved.
pub(super) const SLACK: f64 = 1.0 / (1 << 22) as f64;

/// Greatest reciprocal, relative to that of the greatest component.
pub(super) const STEEPEST: f64 = (1u64 << 60) as f64;

/// Farthest origin, in sizes of the tree.
pub(super) const FARTHEST: f64 = (1 << 19) as f64;

/// A ray prepared for boxes of `f32`: planes are passed at `plane·scale + shift`.
#[derive(Clone, Copy, Debug)]
pub(super) struct FilterRay {
    near_scale: [f32; 4],
    near_shift: [f32; 4],
    far_scale: [f32; 4],
    far_shift: [f32; 4],
    /// By axis: which row of a node, or number of a leaf, are the near planes; the far ones are its neighbour.
    pub(super) near_row: [usize; 3],
}

/// Least and greatest number of a tree or direction for which nothing over- or underflows.
pub(super) const RANGE: core::ops::RangeInclusive<f64> = 1.0 / (1 << 24) as f64..=(1 << 24) as f64;

/// A ray in `f64`, all axes side by side; the fourth lanes are 0, and 1 where they divide.
#[derive(Clone, Copy)]
pub(super) struct LaneRay<S: Simd> {
    pub(super) origin: S::Doubles,
    pub(super) direction: S::Doubles,
    /// As [`SlabRay`](rt_math::SlabRay) has it.
    pub(super) inverse: S::Doubles,
}

impl<S: Simd> LaneRay<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, ray: &Ray) -> Self {
        let Ray { origin: o, direction: d, .. } = *ray;
        let direction = simd.doubles([d.x, d.y, d.z, 1.0]);
        let inverse = simd.div_doubles(simd.doubles([1.0; 4]), direction);
        Self { origin: simd.doubles([o.x, o.y, o.z, 0.0]), direction, inverse }
    }
}

/// By what planes are multiplied, and what is added then: for the axes of one ray, or for one axis of four.
pub(super) struct Slabs<S: Simd> {
    pub(super) near_scale: S::Doubles,
    pub(super) near_shift: S::Doubles,
    pub(super) far_scale: S::Doubles,
    pub(super) far_shift: S::Doubles,
}

impl<S: Simd> Slabs<S> {
    /// Of the origin relative to the centre of a tree and the reciprocal of the direction, which is limited. What it
    /// holds is to be rounded to `f32`.
    #[inline(always)]
    pub(super) fn new(simd: S, q: S::Doubles, inverse: S::Doubles, steepest: S::Doubles, size: f64) -> Self {
        let pad_of = size / if S::FUSED { (1u64 << 40) as f64 } else { (1u64 << 22) as f64 };
        let gentlest = simd.sub_doubles(simd.doubles([0.0; 4]), steepest);
        let inverse = simd.max_doubles(simd.min_doubles(inverse, steepest), gentlest);
        let near_scale = simd.rounded(simd.mul_doubles(inverse, simd.doubles([1.0 - SLACK; 4])));
        let far_scale = simd.rounded(simd.mul_doubles(inverse, simd.doubles([1.0 + SLACK; 4])));
        let pad = simd.mul_doubles(simd.doubles([pad_of; 4]), simd.abs_doubles(inverse));
        let near_q = simd.mul_doubles(q, near_scale);
        let far_q = simd.mul_doubles(q, far_scale);
        let slack = simd.doubles([SLACK / 2.0; 4]);
        let near_slack = simd.add_doubles(simd.mul_doubles(simd.abs_doubles(near_q), slack), pad);
        let far_slack = simd.add_doubles(simd.mul_doubles(simd.abs_doubles(far_q), slack), pad);
        let near_shift = simd.sub_doubles(simd.sub_doubles(simd.doubles([0.0; 4]), near_q), near_slack);
        Self { near_scale, near_shift, far_scale, far_shift: simd.sub_doubles(far_slack, far_q) }
    }
}

/// True if the filters are proven for a ray: by the greatest component of its direction, how far its origin is from the
/// centre of a tree of that size, and a number that is 0 unless something is not finite.
#[inline(always)]
pub(super) fn is_proven(fastest: f64, farthest: f64, nothing: f64, span: Interval, size: f64) -> bool {
    RANGE.contains(&fastest)
        & RANGE.contains(&size)
        & (farthest <= FARTHEST * size)
        & (span.min >= 0.0)
        & (nothing == 0.0)
}

/// The greatest of the first three.
#[inline(always)]
pub(super) fn greatest<S: Simd>(simd: S, a: S::Doubles) -> f64 {
    let turned = simd.max_doubles(simd.turned_once(a), simd.turned_twice(a));
    let [greatest, ..] = simd.to_doubles(simd.max_doubles(a, turned));
    greatest
}

impl FilterRay {
    /// For a tree of this centre and size, its greatest coordinate relative to the centre. `None` where the proof does
    /// not hold.
    #[inline(always)]
    pub(super) fn new<S: Simd>(simd: S, ray: &LaneRay<S>, span: Interval, centre: DVec3, size: f64) -> Option<Self> {
        let q = simd.sub_doubles(ray.origin, simd.doubles([centre.x, centre.y, centre.z, 0.0]));
        let fastest = greatest(simd, simd.abs_doubles(ray.direction));
        let farthest = greatest(simd, simd.abs_doubles(q));
        // What is not finite makes a NaN of this.
        let nothing = simd.mul_doubles(simd.add_doubles(q, ray.direction), simd.doubles([0.0; 4]));
        let [x, y, z, _] = simd.to_doubles(nothing);
        if !is_proven(fastest, farthest, x + y + z, span, size) {
            return None;
        }
        let steepest = simd.doubles([STEEPEST / fastest; 4]);
        let slabs = Slabs::new(simd, q, ray.inverse, steepest, size);
        let signs = simd.signs(ray.inverse) as usize;
        Some(Self {
            near_scale: simd.narrowed(slabs.near_scale),
            near_shift: simd.narrowed(slabs.near_shift),
            far_scale: simd.narrowed(slabs.far_scale),
            far_shift: simd.narrowed(slabs.far_shift),
            near_row: [signs & 1, 2 | signs >> 1 & 1, 4 | signs >> 2 & 1],
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

    /// Where the boxes of a node are entered, at `min` or later, and left, at `max` or before. Those that are left
    /// before they are entered are not passed.
    #[inline(always)]
    pub(super) fn cross<S: Simd>(&self, simd: S, node: &Node, min: f32, max: f32) -> [S::Lanes; 2] {
        let [x, y, z] = self.near_row;
        let enter_x = self.near(simd, 0, node.row(simd, x));
        let enter_y = self.near(simd, 1, node.row(simd, y));
        let enter_z = self.near(simd, 2, node.row(simd, z));
        let leave_x = self.far(simd, 0, node.row(simd, x ^ 1));
        let leave_y = self.far(simd, 1, node.row(simd, y ^ 1));
        let leave_z = self.far(simd, 2, node.row(simd, z ^ 1));
        let enter = simd.max(simd.max(enter_x, enter_y), simd.max(enter_z, simd.splat(min)));
        let leave = simd.min(simd.min(leave_x, leave_y), simd.min(leave_z, simd.splat(max)));
        [enter, leave]
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
