//! Leaves of boxes, for primitives of any kind: the filter is that of nodes.

use super::{Block, ExactRay, Filter, FilterSpan, Lane, LeafView, Verdict};
use crate::wide::across::{Across, AcrossBoxes};
use crate::{bvh::NodeBox, wide::WideBvh, wide::node::Row, wide::ray::FilterRay, wide::simd::Simd};

/// Lower and upper plane of each axis.
pub(super) const NUMBERS: usize = 6;

pub(super) fn fill(block: &mut Block<'_>, indices: &[u32], own: impl Fn(u32) -> NodeBox) {
    for (lane, &index) in indices.iter().enumerate() {
        let own = own(index);
        for axis in 0..3 {
            block.set(2 * axis, lane, own.min[axis]);
            block.set(2 * axis + 1, lane, own.max[axis]);
        }
    }
}

/// Rules out whose box is missed; says of nothing that it is hit.
#[derive(Clone, Copy)]
pub(in crate::wide) struct BoxFilter {
    ray: FilterRay,
    min: f32,
}

impl Filter for BoxFilter {
    #[inline(always)]
    fn new<S: Simd>(_: S, _: &ExactRay<'_, S>, boxes: &FilterRay, span: FilterSpan, _: &WideBvh) -> Self {
        Self { ray: *boxes, min: span.min() }
    }

    #[inline(always)]
    fn judge<S: Simd>(&self, simd: S, leaf: LeafView<'_>, limit: f32) -> Verdict<S> {
        let (mut enter, mut leave) = (simd.splat(self.min), simd.splat(limit));
        for axis in 0..3 {
            let row = self.ray.near_row(axis);
            // SAFETY: both rows are less than `NUMBERS`.
            let [near, far] = unsafe {
                [leaf.lanes(simd, row.index() * leaf.count), leaf.lanes(simd, row.opposite().index() * leaf.count)]
            };
            enter = simd.max(self.ray.near(simd, axis, near), enter);
            leave = simd.min(self.ray.far(simd, axis, far), leave);
        }
        Verdict { maybe: simd.le(enter, leave) & leaf.mask(), sure: 0, near: enter, far: leave }
    }

    type Across<S: Simd> = AcrossBoxes<S>;

    #[inline(always)]
    fn across<S: Simd>(_: S, rays: &Across<S>, _: &WideBvh) -> AcrossBoxes<S> {
        rays.boxes
    }

    #[inline(always)]
    fn judge_across<S: Simd>(
        simd: S,
        rays: &AcrossBoxes<S>,
        leaf: LeafView<'_>,
        lane: Lane,
        limits: S::Lanes,
    ) -> Verdict<S> {
        // SAFETY: the row is less than `NUMBERS`, and the lane less than 8.
        let plane = |row: Row| simd.splat(unsafe { leaf.number(row.index() * leaf.count + lane.index()) });
        let [enter, leave] = rays.cross::<false>(simd, plane, limits);
        Verdict { maybe: simd.le(enter, leave), sure: 0, near: enter, far: leave }
    }

    #[inline(always)]
    fn index(leaf: LeafView<'_>, lane: Lane) -> u32 {
        // SAFETY: indices follow the numbers, and the lane is less than 8.
        unsafe { leaf.word(NUMBERS * leaf.count + lane.index()) }
    }
}
