//! Frustum culling of a bundle of rays: finds the few subtrees that any of them can hit.
//!
//! # Why the culling is conservative
//!
//! Let `q` be the origin of a ray relative to the centre of the tree, and `v = 1/d` on some axis. Take `v > 0`, as for
//! `v < 0` all signs turn around. The frustum computes `fl((p − Q)·n)` for near planes `p`. `Q` is at least 2⁻²² sizes
//! of the tree beyond all `q`. `n` is at most the minimum of all `v`, made smaller by 2⁻²².
//!
//! * If `p − q > 0`, the result is no more than `τ·(1 − 2⁻²²)·(1 + 2⁻²⁴)³`. That is less than what the padded bounds
//!   compute ([`ray`](super::ray)).
//! * Otherwise the product is negative, and spans begin at 0 or later.
//!
//! Far planes are the mirror image. Directions that are nearly zero are limited as those of single rays are, and times
//! of leaving are long enough for the same reason.
//!
//! Entry points and culling by intervals are those of Reshetov, Soupikov and Hurley, "Multi-Level Ray Tracing
//! Algorithm", 2005. See also Wald, Boulos and Shirley, "Ray Tracing Deformable Scenes using Dynamic Bounding Volume
//! Hierarchies", 2007.

use rt_math::{Aabb, DVec3};

use super::WideBvh;
use super::coherence::{are_in_octant, first_octant};
use super::f64x8::{F64x8, PACKET};
use super::node::Row;
use super::ray::{FARTHEST, RANGE, SLACK, STEEPEST, round_down, round_up};
use super::simd::Simd;
use super::stream_rays::StreamRays;
use crate::bvh::Aabb32;

/// Most rays that are culled with one frustum.
const BUNDLE_SIZE: usize = 64;

/// Padding of primitives is less than this part of the distance of the tree's centre from the origin.
const OF_OFFSET: f32 = 1.0 / (1u64 << 38) as f32;

/// Encloses all rays of a bundle in one octant.
pub(super) struct BundleFrustum<S: Simd> {
    near_origin: [S::F32x8; 3],
    near_scale: [S::F32x8; 3],
    far_origin: [S::F32x8; 3],
    far_scale: [S::F32x8; 3],
    near_row: [Row; 3],
    min: S::F32x8,
    max: S::F32x8,
    /// Greatest coordinate of the centre of the tree, or more.
    offset: f32,
}

/// Range of a number of some rays.
struct NumberRange {
    low: f64,
    high: f64,
    /// Sum over the rays; not finite if any number is not.
    sum: f64,
}

/// Range of the numbers of `n` rays, a multiple of eight.
#[inline(always)]
fn range<S: Simd>(simd: S, n: usize, numbers: impl Fn(usize) -> F64x8<S>) -> NumberRange {
    let (mut low, mut high) = (F64x8::splat(simd, f64::INFINITY), F64x8::splat(simd, f64::NEG_INFINITY));
    let mut sum = F64x8::splat(simd, 0.0);
    for at in (0..n).step_by(PACKET) {
        let numbers = numbers(at);
        // A comparison with NaN keeps the earlier number.
        (low, high) = (numbers.min(simd, low), numbers.max(simd, high));
        sum = sum.add(simd, numbers);
    }
    NumberRange { low: low.reduce_min(simd), high: high.reduce_max(simd), sum: sum.reduce_sum(simd) }
}

impl<S: Simd> BundleFrustum<S> {
    /// Encloses the packets of a stream from one on, as far as their rays are in its octant. Returns the number of rays as well. `None` for
    /// fewer than two packets, or where the proof does not apply.
    #[inline(always)]
    pub(super) fn enclosing(simd: S, tree: &WideBvh, rays: StreamRays<'_>, first: usize) -> Option<(Self, usize)> {
        let octant = first_octant(simd, rays.directions(simd, first));
        let mut n = 0;
        while n + PACKET <= BUNDLE_SIZE
            && first + n + PACKET <= rays.len()
            && are_in_octant(simd, rays.directions(simd, first + n), octant)
        {
            n += PACKET;
        }
        if n < 2 * PACKET {
            return None;
        }
        macro_rules! range {
            ($numbers:ident[$axis:literal]) => {
                range(
                    simd,
                    n,
                    #[inline(always)]
                    |at| rays.numbers(simd, first + at, |rays| &rays.$numbers[$axis]),
                )
            };
            ($end:ident) => {
                range(
                    simd,
                    n,
                    #[inline(always)]
                    |at| rays.numbers(simd, first + at, |rays| &rays.$end),
                )
            };
        }
        let [x, y, z] = [range!(origin[0]), range!(origin[1]), range!(origin[2])];
        let [u, v, w] = [range!(direction[0]), range!(direction[1]), range!(direction[2])];
        let is_finite = (x.sum + y.sum + z.sum + u.sum + v.sum + w.sum) * 0.0 == 0.0;
        let (low, high) = (DVec3::new(x.low, y.low, z.low), DVec3::new(x.high, y.high, z.high));
        let (slow, fast) = (DVec3::new(u.low, v.low, w.low), DVec3::new(u.high, v.high, w.high));
        let (begin, end) = (range!(min).low, range!(max).high.max(0.0));
        // The directions have equal signs.
        let (slowest, fastest) = (slow.abs().min(fast.abs()), slow.abs().max(fast.abs()));
        let (low, high) = (low - tree.centre, high - tree.centre);
        let filter_applies = RANGE.contains(&fastest.max_element())
            & RANGE.contains(&slowest.max_element())
            & RANGE.contains(&tree.size)
            & (low.abs().max(high.abs()).max_element() <= FARTHEST * tree.size)
            & (begin >= 0.0)
            & is_finite;
        if !filter_applies {
            return None;
        }
        let pad = DVec3::splat(tree.size * SLACK);
        let outline = Aabb32::enclosing(&Aabb::new(low - pad, high + pad), DVec3::ZERO);
        let min_scale = fastest.max(DVec3::splat(fastest.max_element() / STEEPEST)).recip() * (1.0 - SLACK);
        let max_scale = slowest.max(DVec3::splat(slowest.max_element() / STEEPEST)).recip() * (1.0 + SLACK);
        let mut this = Self {
            near_origin: [simd.splat(0.0); 3],
            near_scale: [simd.splat(0.0); 3],
            far_origin: [simd.splat(0.0); 3],
            far_scale: [simd.splat(0.0); 3],
            near_row: Row::near(octant.map(usize::from)),
            min: simd.splat(round_down(begin)),
            max: simd.splat(round_up(end)),
            offset: round_up(tree.centre.abs().max_element()),
        };
        for axis in 0..3 {
            let (low, high) = (outline.min[axis], outline.max[axis]);
            let (near, far, sign) = if octant[axis] { (low, high, -1.0) } else { (high, low, 1.0) };
            this.near_origin[axis] = simd.splat(near);
            this.far_origin[axis] = simd.splat(far);
            this.near_scale[axis] = simd.splat((sign * min_scale[axis]) as f32);
            this.far_scale[axis] = simd.splat((sign * max_scale[axis]) as f32);
        }
        Some((this, n))
    }

    /// Widening of boxes made of a leaf's numbers, so that they contain the padded bounds. `max` is the largest of these
    /// numbers.
    #[inline(always)]
    pub(super) fn margin(&self, max: f32) -> f32 {
        max * SLACK as f32 + self.offset * OF_OFFSET
    }

    #[inline(always)]
    fn near(&self, simd: S, axis: usize, planes: S::F32x8) -> S::F32x8 {
        simd.mul(simd.sub(planes, self.near_origin[axis]), self.near_scale[axis])
    }

    #[inline(always)]
    fn far(&self, simd: S, axis: usize, planes: S::F32x8) -> S::F32x8 {
        simd.mul(simd.sub(planes, self.far_origin[axis]), self.far_scale[axis])
    }

    /// Boxes that rays may hit, a bit for each, and their earliest entry; `planes` returns a row.
    #[inline(always)]
    pub(super) fn intersect_boxes(&self, simd: S, planes: impl Fn(Row) -> S::F32x8) -> (u32, S::F32x8) {
        let [x, y, z] = self.near_row;
        let (enter_x, leave_x) = (self.near(simd, 0, planes(x)), self.far(simd, 0, planes(x.opposite())));
        let (enter_y, leave_y) = (self.near(simd, 1, planes(y)), self.far(simd, 1, planes(y.opposite())));
        let (enter_z, leave_z) = (self.near(simd, 2, planes(z)), self.far(simd, 2, planes(z.opposite())));
        let enter = simd.max(simd.max(enter_x, enter_y), simd.max(enter_z, self.min));
        let leave = simd.min(simd.min(leave_x, leave_y), simd.min(leave_z, self.max));
        (simd.le(enter, leave), enter)
    }
}
