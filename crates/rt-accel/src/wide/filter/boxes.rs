//! Leaves of boxes, for primitives of any kind: the test is that of nodes.

use super::leaf_test::{HitBounds, LeafTest};
use crate::wide::WideBvh;
use crate::wide::leaf::{BOX_NUMBERS, Lane, LeafView};
use crate::wide::node::Row;
use crate::wide::packet_slabs::PacketSlabs;
use crate::wide::ray::RayF32;
use crate::wide::ray_f64::RayF64;
use crate::wide::ray_packet::RayPacket;
use crate::wide::simd::Simd;
use crate::wide::t_range::FilterTRange;

/// Rejects primitives whose box is missed; no hit is certain.
#[derive(Clone, Copy)]
pub(in crate::wide) struct BoxTest {
    ray: RayF32,
    min: f32,
}

impl LeafTest for BoxTest {
    const HEADER: usize = 0;
    const NUMBERS: usize = BOX_NUMBERS;

    #[inline(always)]
    fn new<S: Simd>(_: S, _: &RayF64<'_, S>, boxes: &RayF32, span: FilterTRange, _: &WideBvh) -> Self {
        Self { ray: *boxes, min: span.min() }
    }

    #[inline(always)]
    fn test<S: Simd>(&self, simd: S, leaf: LeafView<'_>, t_max: f32) -> HitBounds<S> {
        let (mut enter, mut leave) = (simd.splat(self.min), simd.splat(t_max));
        for axis in 0..3 {
            let row = self.ray.near_row(axis);
            // SAFETY: both rows are less than `BOX_NUMBERS`.
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
        // SAFETY: the row is less than `BOX_NUMBERS`, and the lane less than 8.
        let plane = |row: Row| simd.splat(unsafe { leaf.number(row.index() * leaf.count + lane.index()) });
        let [enter, leave] = rays.cross::<false>(simd, plane, t_max);
        HitBounds { possible: simd.le(enter, leave), certain: 0, t_min: enter, t_max: leave }
    }
}
