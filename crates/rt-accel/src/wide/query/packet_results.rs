//! Results of the eight rays of a packet, side by side.

use core::marker::PhantomData;

use rt_geometry::{Hit, SphereKernel};
use rt_math::DVec3;

use super::{Output, PrimSlot, PrimitiveTester};
use crate::wide::WideBvh;
use crate::wide::f64x8::PACKET;
use crate::wide::filter::LeafTest;
use crate::wide::leaf::Lane;
use crate::wide::node::Child;
use crate::wide::packet_spheres::SpherePacket;
use crate::wide::ray_f64::RayF64;
use crate::wide::ray_packet::RayPacket;
use crate::wide::simd::{Simd, take_lane};
use crate::wide::stream_rays::PacketRays;

/// One certain hit for each of eight rays.
pub(in crate::wide) struct PacketResults<S: Simd, O> {
    /// A bit for each ray with a hit.
    hit: u32,
    t_near: S::F32x8,
    /// Bits of the leaf and the lane that are hit. They may be NaNs, so they are only moved and compared as bits.
    leaf: S::F32x8,
    lane: S::F32x8,
    /// Last occluder of an any-hit query.
    occluder: Option<PrimSlot>,
    output: PhantomData<O>,
}

impl<S: Simd, O: Output> PacketResults<S, O> {
    #[inline(always)]
    pub(in crate::wide) fn empty(simd: S) -> Self {
        let zero = simd.splat(0.0);
        let t_near = simd.splat(f32::INFINITY);
        Self { hit: 0, t_near, leaf: zero, lane: zero, occluder: None, output: PhantomData }
    }

    /// Records certain hits of some rays between two bounds, and lowers their `t_max`. Returns the rays that are not
    /// certain to be hit closest here.
    #[inline(always)]
    pub(in crate::wide) fn record_certain(
        &mut self,
        simd: S,
        slot: PrimSlot,
        certain: u32,
        [t_near, t_far]: [S::F32x8; 2],
        t_max: &mut S::F32x8,
    ) -> u32 {
        if O::ANY_HIT {
            self.hit |= certain;
            self.occluder = Some(slot);
            *t_max = simd.select(certain, simd.splat(-1.0), *t_max);
            return 0;
        }
        // The usual case: certainly closer than the hit before.
        let is_closest = certain & simd.lt(t_far, self.t_near);
        self.hit |= is_closest;
        self.t_near = simd.select(is_closest, t_near, self.t_near);
        self.leaf = simd.select(is_closest, simd.splat(f32::from_bits(slot.leaf().to_bits())), self.leaf);
        self.lane = simd.select(is_closest, simd.splat(f32::from_bits(slot.lane().index() as u32)), self.lane);
        *t_max = simd.select(certain, simd.min(*t_max, t_far), *t_max);
        certain & !is_closest
    }

    /// Drops hits that lie beyond `t_max`.
    #[inline(always)]
    pub(in crate::wide) fn drop_beyond(&mut self, simd: S, t_max: S::F32x8) {
        if !O::ANY_HIT {
            self.hit &= simd.le(self.t_near, t_max);
        }
    }

    /// Last occluder of an any-hit query.
    #[inline(always)]
    pub(in crate::wide) const fn last_occluder(&self) -> Option<PrimSlot> {
        self.occluder
    }

    /// Leaf and lane by ray; meaningful for rays with a hit.
    #[inline(always)]
    fn slots(&self, simd: S) -> [(Child, Lane); PACKET] {
        let (leaf, lane) = (simd.to_array(self.leaf), simd.to_array(self.lane));
        let mut slots = [(Child::NONE, Lane::new(0)); PACKET];
        for (i, slot) in slots.iter_mut().enumerate() {
            *slot = (Child::from_bits(leaf[i].to_bits()), Lane::new(lane[i].to_bits() as usize));
        }
        slots
    }

    /// Rays that hit this slot.
    #[inline(always)]
    fn rays_at(&self, simd: S, (leaf, lane): (Child, Lane)) -> u32 {
        simd.eq_bits(self.leaf, simd.splat(f32::from_bits(leaf.to_bits())))
            & simd.eq_bits(self.lane, simd.splat(f32::from_bits(lane.index() as u32)))
    }

    /// Intersects the recorded primitives exactly and writes all results. Returns the hits that no
    /// [`PrimitiveTester`] has counted.
    #[inline(always)]
    pub(in crate::wide) fn resolve<F: LeafTest>(
        &self,
        simd: S,
        tree: &WideBvh,
        tester: &mut dyn PrimitiveTester<O>,
        packet: &RayPacket<S>,
        rays: PacketRays<'_>,
        outputs: &mut [O; PACKET],
    ) -> u64 {
        if O::ANY_HIT {
            for (lane, output) in outputs.iter_mut().enumerate() {
                *output = if self.hit >> lane & 1 != 0 { O::HIT } else { O::default() };
            }
            return u64::from(self.hit.count_ones());
        }
        for output in outputs.iter_mut() {
            *output = O::default();
        }
        if self.hit == 0 {
            return 0;
        }
        let slots = self.slots(simd);
        let mut left = self.hit;
        let mut uncounted_hits = 0;
        if F::IS_SPHERE {
            // SAFETY: these rays have hits in the tree.
            let resolved = unsafe { resolve_spheres::<S, F, O>(simd, tree, tester, packet, &slots, left, outputs) };
            uncounted_hits += u64::from(resolved.count_ones());
            left &= !resolved;
        }
        while left != 0 {
            let first = left.trailing_zeros() as usize & 7;
            let slot = slots[first];
            let mut same = left & self.rays_at(simd, slot);
            left &= !same;
            // SAFETY: this ray has a hit in the tree.
            let (leaf, of_leaf) = (unsafe { tree.leaves.view(slot.0) }, slot.1);
            if !F::is_exact(leaf, of_leaf) {
                while same != 0 {
                    let lane = take_lane(&mut same);
                    let (ray, span) = rays.get(lane);
                    outputs[lane] = tester.test(F::index(leaf, of_leaf), ray, *span);
                }
                continue;
            }
            uncounted_hits += u64::from(same.count_ones());
            let mut together = same & packet.same_axis_mask;
            if together.count_ones() < 2 {
                together = 0;
            }
            let mut single = same & !together;
            while single != 0 {
                let lane = take_lane(&mut single);
                let (ray, span) = rays.get(lane);
                let ray = RayF64::new(simd, ray);
                outputs[lane] = O::from_hit(F::exact_hit::<S, true>(simd, leaf, of_leaf, &ray, *span));
            }
            if together == 0 {
                continue;
            }
            let [t, v, w] = F::exact_packet_hits(simd, leaf, of_leaf, packet);
            let (t, v, w) = (t.to_array(simd), v.to_array(simd), w.to_array(simd));
            let primitive = F::index(leaf, of_leaf);
            while together != 0 {
                let lane = take_lane(&mut together);
                let hit = Hit { t: t[lane], instance: 0, primitive, uv: [v[lane], w[lane]] };
                outputs[lane] = O::from_hit(Some(hit));
            }
        }
        uncounted_hits
    }
}

/// Intersects a sphere for each of some rays at once; returns the rays whose result is written.
///
/// # Safety
///
/// The slots of the rays in `mask` must be those of the tree, and the test that of their kind.
#[inline(always)]
unsafe fn resolve_spheres<S: Simd, F: LeafTest, O: Output>(
    simd: S,
    tree: &WideBvh,
    tester: &mut dyn PrimitiveTester<O>,
    packet: &RayPacket<S>,
    slots: &[(Child, Lane); PACKET],
    mask: u32,
    outputs: &mut [O; PACKET],
) -> u32 {
    let mut spheres = [SphereKernel { centre: DVec3::ZERO, radius: 1.0 }; PACKET];
    let mut indices = [0; PACKET];
    let (mut left, mut resolved) = (mask, 0);
    while left != 0 {
        let lane = take_lane(&mut left);
        let (leaf, of_leaf) = slots[lane];
        // SAFETY: as the caller promises.
        let index = F::index(unsafe { tree.leaves.view(leaf) }, of_leaf);
        if let Some(sphere) = tester.exact_sphere(index) {
            (spheres[lane], indices[lane]) = (sphere, index);
            resolved |= 1 << lane;
        }
    }
    if resolved == 0 {
        return 0;
    }
    let hits = SpherePacket::new(simd, &spheres).intersect(simd, &packet.soa);
    resolved &= hits.hit;
    let t = hits.t.to_array(simd);
    for (lane, output) in outputs.iter_mut().enumerate() {
        if resolved >> lane & 1 != 0 {
            *output = O::from_hit(Some(Hit { t: t[lane], instance: 0, primitive: indices[lane], uv: [0.0; 2] }));
        }
    }
    resolved
}
