//! A ray prepared for conservative box tests: eight boxes at a time, in `f32`.
//!
//! # Why the culling is conservative
//!
//! Let `c` be the centre of the tree, `o` the origin of the ray, `v = fl(1/d)` on some axis, and `u = 2⁻⁵³`. Padded
//! bounds are entered through the plane `b` at `fl(fl(b − o)·v)`, which is within 3.1u of the real number `τ = (b −
//! o)/d`. They are left after at most `τ·(1 + 10u)` ([`Aabb::clip`](rt_math::Aabb::clip)). A node stores a plane `p` in
//! `f32`. [`Aabb32`](crate::bvh::Aabb32) guarantees that a near plane lies at or before `b − c`, and a far plane at
//! or behind it. Take `v > 0` and let `q = o − c`; for `v < 0` all signs are mirrored.
//!
//! The filter computes `fl32(p·n + s)`, with the `f32` number `n` = `fl32(v)` for both planes, and for near planes
//! `s = fl32(−q·n − w)`, where `w` = 2⁻²²·(`|q|` + size of the tree)·`|n|`. As neither plane nor origin is farther from
//! the centre than these, `w` is four times the error of each of three roundings. These are that of `v`, multiplied by
//! `p − q`, that of `s`, and that of the result. So:
//!
//! * If `p − q ≤ 0` the result is at most 0, and spans begin at 0 or later.
//! * Otherwise it is at most `τ − w/4`, less than the entry into the padded bounds: 3.1u of `τ` are far less than
//!   `w/4`.
//!
//! Far planes are the mirror image, with `s = fl32(−q·n + w)`. Boxes in front of the ray are left no earlier, and boxes
//! behind it also have their padded bounds behind it. Rounding of `q` and of `w` is 2⁻²⁹ of `w`. Without a fused
//! multiply-add `p·n` is rounded separately, and `w` has 2⁻²¹ instead of 2⁻²².
//!
//! **Directions that are nearly zero on an axis.** `|v|` is limited to 2⁶⁰ times the minimum of the three, which is one
//! over the maximum component `D` of the direction. This lowers times in front of the ray, so an entry is never too
//! late. An exit may be too early. But the remaining half of `w` makes every exit at least 2³⁷·size/D. The padded
//! bounds are left on the axis of `D` before that, as `|q| ≤ 2¹⁹·size`.
//!
//! **Range.** All numbers must neither over- nor underflow. [`RayF32::new`] rejects rays and trees out of range, which
//! are traversed in `f64`.

use rt_math::{DVec3, Interval, Ray};

use super::node::{Row, WideNode};
use super::simd::Simd;

/// Relative outward rounding.
pub(super) const SLACK: f64 = 1.0 / (1 << 22) as f64;

/// Maximum reciprocal, relative to that of the maximum component.
pub(super) const STEEPEST: f64 = (1u64 << 60) as f64;

/// Maximum distance of an origin, in sizes of the tree.
pub(super) const FARTHEST: f64 = (1 << 19) as f64;

/// A ray prepared for boxes of `f32`: it crosses planes at `plane·scale + shift`.
#[derive(Clone, Copy, Debug)]
pub(super) struct RayF32 {
    scale: [f32; 4],
    near_shift: [f32; 4],
    far_shift: [f32; 4],
    /// By axis: row of the near planes in a node.
    near: [Row; 3],
}

/// Sizes of trees and directions without overflow or underflow.
pub(super) const RANGE: core::ops::RangeInclusive<f64> = 1.0 / (1 << 24) as f64..=(1 << 24) as f64;

/// A ray in `f64`, with all axes side by side. The fourth lane is 0, or 1 where it divides.
#[derive(Clone, Copy)]
pub(super) struct RayF64x4<S: Simd> {
    pub(super) origin: S::F64x4,
    pub(super) direction: S::F64x4,
    /// Equals [`SlabRay::inverse`](rt_math::SlabRay).
    pub(super) inverse: S::F64x4,
}

impl<S: Simd> RayF64x4<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, ray: &Ray) -> Self {
        let (o, d) = (&ray.origin, &ray.direction);
        let direction = simd.f64x4([alone(&d.x), alone(&d.y), alone(&d.z), 1.0]);
        let inverse = simd.div_f64(simd.f64x4([1.0; 4]), direction);
        Self { origin: simd.f64x4([alone(&o.x), alone(&o.y), alone(&o.z), 0.0]), direction, inverse }
    }
}

/// Loads a number by itself. Compilers would combine several loads into a wide one, which stalls on narrow stores just
/// before.
#[inline(always)]
fn alone(number: &f64) -> f64 {
    // SAFETY: a reference may be read.
    unsafe { core::ptr::from_ref(number).read_volatile() }
}

/// Factor of planes and the addends of near and far planes: three axes of one ray, or one axis of four rays.
pub(super) struct SlabCoeffs<S: Simd> {
    pub(super) scale: S::F64x4,
    pub(super) near_shift: S::F64x4,
    pub(super) far_shift: S::F64x4,
}

impl<S: Simd> SlabCoeffs<S> {
    /// Coefficients from an origin relative to the centre of a tree of this size, and the reciprocal of a direction,
    /// limited to `steepest`. The caller rounds them to `f32`.
    #[inline(always)]
    pub(super) fn new(simd: S, q: S::F64x4, inverse: S::F64x4, steepest: S::F64x4, size: f64) -> Self {
        let slack = if S::FUSED { SLACK } else { 2.0 * SLACK };
        let zero = simd.f64x4([0.0; 4]);
        let limited = simd.min_f64(inverse, steepest);
        let scale = simd.round_to_f32(simd.max_f64(limited, simd.sub_f64(zero, steepest)));
        let farthest = simd.add_f64(simd.abs_f64(q), simd.f64x4([size; 4]));
        let widening = simd.mul_f64(simd.mul_f64(farthest, simd.f64x4([slack; 4])), simd.abs_f64(scale));
        let shift = simd.mul_f64(q, scale);
        Self {
            scale,
            near_shift: simd.sub_f64(zero, simd.add_f64(shift, widening)),
            far_shift: simd.sub_f64(widening, shift),
        }
    }
}

/// Minimum of the first three, none of which is NaN.
#[inline(always)]
fn min_lane<S: Simd>(simd: S, a: S::F64x4) -> f64 {
    let turned = simd.min_f64(simd.yzx(a), simd.zxy(a));
    let [min, ..] = simd.to_f64_array(simd.min_f64(a, turned));
    min
}

/// Maximum of the first three.
#[inline(always)]
pub(super) fn max_lane<S: Simd>(simd: S, a: S::F64x4) -> f64 {
    let turned = simd.max_f64(simd.yzx(a), simd.zxy(a));
    let [max, ..] = simd.to_f64_array(simd.max_f64(a, turned));
    max
}

impl RayF32 {
    /// Prepares a ray for a tree of this centre and size (its maximum coordinate relative to the centre). `None` where
    /// the proof does not apply.
    #[inline(always)]
    pub(super) fn new<S: Simd>(simd: S, ray: &RayF64x4<S>, span: Interval, centre: DVec3, size: f64) -> Option<Self> {
        let q = simd.sub_f64(ray.origin, simd.f64x4([centre.x, centre.y, centre.z, 0.0]));
        // False for NaN.
        let is_slow = simd.le_f64(simd.abs_f64(ray.direction), simd.f64x4([*RANGE.end(); 4]));
        let is_near = simd.le_f64(simd.abs_f64(q), simd.f64x4([FARTHEST * size; 4]));
        let min = min_lane(simd, simd.abs_f64(ray.inverse));
        let filter_applies = (is_slow & is_near == 0b1111)
            & (min <= *RANGE.end())
            & (size >= *RANGE.start())
            & (size <= *RANGE.end())
            & (span.min >= 0.0);
        if !filter_applies {
            return None;
        }
        let slabs = SlabCoeffs::new(simd, q, ray.inverse, simd.f64x4([STEEPEST * min; 4]), size);
        let signs = simd.signs(ray.inverse) as usize;
        Some(Self {
            scale: simd.to_f32(slabs.scale),
            near_shift: simd.to_f32(slabs.near_shift),
            far_shift: simd.to_f32(slabs.far_shift),
            near: Row::near([signs, signs >> 1, signs >> 2]),
        })
    }

    /// Lower bound of the `t` at near planes.
    #[inline(always)]
    pub(super) fn near<S: Simd>(&self, simd: S, axis: usize, planes: S::F32x8) -> S::F32x8 {
        simd.mul_add(planes, simd.splat(self.scale[axis]), simd.splat(self.near_shift[axis]))
    }

    /// Upper bound of the `t` at far planes.
    #[inline(always)]
    pub(super) fn far<S: Simd>(&self, simd: S, axis: usize, planes: S::F32x8) -> S::F32x8 {
        simd.mul_add(planes, simd.splat(self.scale[axis]), simd.splat(self.far_shift[axis]))
    }

    /// Row of the near planes of an axis.
    #[inline(always)]
    pub(super) const fn near_row(&self, axis: usize) -> Row {
        self.near[axis]
    }

    /// Entry into the boxes of a node, at `min` or later, and exit, at `max` or before. A box with its exit before its
    /// entry is missed.
    #[inline(always)]
    pub(super) fn cross<S: Simd>(&self, simd: S, node: &WideNode, min: f32, max: f32) -> [S::F32x8; 2] {
        let [x, y, z] = self.near;
        let enter_x = self.near(simd, 0, node.row(simd, x));
        let enter_y = self.near(simd, 1, node.row(simd, y));
        let enter_z = self.near(simd, 2, node.row(simd, z));
        let leave_x = self.far(simd, 0, node.row(simd, x.opposite()));
        let leave_y = self.far(simd, 1, node.row(simd, y.opposite()));
        let leave_z = self.far(simd, 2, node.row(simd, z.opposite()));
        let enter = simd.max(simd.max(enter_x, enter_y), simd.max(enter_z, simd.splat(min)));
        let leave = simd.min(simd.min(leave_x, leave_y), simd.min(leave_z, simd.splat(max)));
        [enter, leave]
    }
}

/// Rounds a non-negative `t` down to `f32`; infinite beyond the range of `f32`, where the proofs allow no hits.
#[inline(always)]
pub(super) fn round_down(t: f64) -> f32 {
    // Without a branch: the subtraction exceeds the rounding error of subnormal numbers.
    ((t * (1.0 - SLACK) - f64::from(f32::MIN_POSITIVE)) as f32).max(0.0)
}

/// Rounds a non-negative `t` up to `f32`.
#[inline(always)]
pub(super) fn round_up(t: f64) -> f32 {
    ((t * (1.0 + SLACK)) as f32).max(f32::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use rt_math::random::{hash, unit};
    use rt_math::{Aabb, SlabRay};

    use super::super::node::Child;
    use super::super::simd::{DetectedSimd, SimdLevel, WithSimd};
    use super::*;
    use crate::bvh::Aabb32;

    /// 2ⁿ, for n from −1022 to 1023.
    fn power_of_two(n: i32) -> f64 {
        f64::from_bits(((1023 + n) as u64) << 52)
    }

    /// Random numbers in [−1, 1).
    struct Draw {
        seed: u64,
        count: u64,
    }

    impl Draw {
        fn next(&mut self) -> f64 {
            self.count += 1;
            2.0 * unit(hash(&[self.seed, self.count])) - 1.0
        }

        /// A number of widely varying magnitude, or 0.
        fn stiff(&mut self) -> f64 {
            match (self.next() * 8.0) as i32 {
                -7 => 0.0,
                -6 => -0.0,
                power => self.next() * power_of_two(-9 * power.abs()),
            }
        }

        fn vector(&mut self, mut number: impl FnMut(&mut Self) -> f64) -> DVec3 {
            DVec3::new(number(self), number(self), number(self))
        }
    }

    /// Entry and exit for the first lane of a node; `None` where the proof does not apply.
    struct Cross<'a> {
        node: &'a WideNode,
        centre: DVec3,
        size: f64,
        result: &'a mut Option<[f32; 2]>,
    }

    impl WithSimd<&Ray, Interval> for Cross<'_> {
        #[inline(always)]
        fn run<S: Simd>(self, simd: S, ray: &Ray, span: Interval) {
            if let Some(filter) = RayF32::new(simd, &RayF64x4::new(simd, ray), span, self.centre, self.size) {
                let [enter, leave] = filter.cross(simd, self.node, round_down(span.min), round_up(span.max));
                *self.result = Some([simd.to_array(enter)[0], simd.to_array(leave)[0]]);
            }
        }
    }

    #[test]
    fn boxes_are_entered_no_later_and_left_no_earlier_than_padded_bounds() {
        const SEED: u64 = 7;
        let mut draw = Draw { seed: SEED, count: 0 };
        for &level in SimdLevel::ALL {
            let level = DetectedSimd::new(level);
            let (mut n_passed, mut n_proven) = (0, 0);
            for case in 0..20_000 {
                let centre = draw.vector(Draw::next) * power_of_two((draw.next() * 40.0) as i32);
                let size = power_of_two((draw.next() * 20.0) as i32);
                let corners = [0, 1].map(|_| centre + draw.vector(Draw::next) * size * 0.5);
                let own = Aabb::from_points(corners).padded();
                let inner = Aabb32::enclosing(&own, centre);
                let size = size.max(inner.max_abs());
                let mut node = WideNode::EMPTY;
                node.set(0, &inner, Child::node(0));
                let origin = centre + draw.vector(Draw::stiff) * size * power_of_two((draw.next() * 19.0) as i32);
                let direction = if case % 2 == 0 {
                    draw.vector(Draw::stiff)
                } else {
                    // Toward the box, where culling is close.
                    own.centre() + own.extent() * draw.vector(Draw::next) * 0.5 - origin
                };
                let ray = Ray::new(origin, direction);
                let mut result = None;
                level.dispatch(Cross { node: &node, centre, size, result: &mut result }, &ray, Interval::FORWARD);
                let Some([enter, leave]) = result else { continue };
                n_proven += 1;
                if let Some(clipped) = own.clip(&SlabRay::new(&ray), Interval::FORWARD) {
                    n_passed += 1;
                    assert!(enter <= leave, "seed {SEED}, case {case}: {ray:?} passes {own:?} but not the filter");
                    assert!(f64::from(enter) <= clipped.min, "seed {SEED}, case {case}: {enter} after {}", clipped.min);
                    assert!(
                        f64::from(leave) >= clipped.max,
                        "seed {SEED}, case {case}: {leave} before {}",
                        clipped.max
                    );
                }
            }
            assert!(n_passed > 5_000 && n_proven > 15_000, "{n_passed} of {n_proven}");
        }
    }
}
