//! Leaves of boxes, for primitives of any kind: the filter is that of nodes.

use super::{FilterTRange, HitBounds, Lane, LeafMut, LeafTest, LeafView, RayF64};
use crate::wide::packet_rays::{PacketSlabs, RayPacket};
use crate::{bvh::NodeBox, wide::WideBvh, wide::node::Row, wide::ray::RayF32, wide::simd::Simd};

/// Lower and upper plane of each axis.
pub(super) const NUMBERS: usize = 6;

pub(super) fn fill(block: &mut LeafMut<'_>, indices: &[u32], own: impl Fn(u32) -> NodeBox) {
    for (lane, &index) in indices.iter().enumerate() {
        let own = own(index);
        for axis in 0..3 {
            block.set(2 * axis, lane, own.min[axis]);
            block.set(2 * axis + 1, lane, own.max[axis]);
        }
    }
}

/// BuildConfig out whose box is missed; says of nothing that it is hit.
#[derive(Clone, Copy)]
pub(in crate::wide) struct BoxTest {
    ray: RayF32,
    min: f32,
}

impl LeafTest for BoxTest {
    #[inline(always)]
    fn new<S: Simd>(_: S, _: &RayF64<'_, S>, boxes: &RayF32, span: FilterTRange, _: &WideBvh) -> Self {
        Self { ray: *boxes, min: span.min() }
    }

    #[inline(always)]
    fn test<S: Simd>(&self, simd: S, leaf: LeafView<'_>, t_max: f32) -> HitBounds<S> {
        let (mut enter, mut leave) = (simd.splat(self.min), simd.splat(t_max));
        for axis in 0..3 {
            let row = self.ray.near_row(axis);
            // SAFETY: both rows are less than `NUMBERS`.
            let [near, far] = unsafe {
                [leaf.lanes(simd, row.index() * leaf.count), leaf.lanes(simd, row.opposite().index() * leaf.count)]
            };
            enter = simd.max(self.ray.near(simd, axis, near), enter);
            leave = simd.min(self.ray.far(simd, axis, far), leave);
        }
        HitBounds { possible: simd.le(enter, leave) & leaf.mask(), certain: 0, t_min: enter, t_max: leave }
    }

    type Packet<S: Simd> = PacketSlabs<S>;

    #[inline(always)]
    fn packet<S: Simd>(_: S, rays: &RayPacket<S>, _: &WideBvh) -> PacketSlabs<S> {
        rays.boxes
    }

    #[inline(always)]
    fn test_packet<S: Simd>(
        simd: S,
        rays: &PacketSlabs<S>,
        leaf: LeafView<'_>,
        lane: Lane,
        t_max: S::F32x8,
    ) -> HitBounds<S> {
        // SAFETY: the row is less than `NUMBERS`, and the lane less than 8.
        let plane = |row: Row| simd.splat(unsafe { leaf.number(row.index() * leaf.count + lane.index()) });
        let [enter, leave] = rays.cross::<false>(simd, plane, t_max);
        HitBounds { possible: simd.le(enter, leave), certain: 0, t_min: enter, t_max: leave }
    }

    #[inline(always)]
    fn index(leaf: LeafView<'_>, lane: Lane) -> u32 {
        // SAFETY: indices follow the numbers, and the lane is less than 8.
        unsafe { leaf.word(NUMBERS * leaf.count + lane.index()) }
    }
}
