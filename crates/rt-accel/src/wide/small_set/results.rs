//! Results of eight rays on the entries of a small set.

use rt_geometry::{Hit, HitStream};
use rt_math::Interval;

use crate::wide::f64x8::{F64x8, PACKET};
use crate::wide::query::Output;
use crate::wide::ray_soa::PacketHit;
use crate::wide::simd::Simd;

/// Results of eight rays, of which some are traced. Bit `i` of a mask is for ray `i`.
pub(super) struct SetResults<S: Simd> {
    /// Rays whose result may still change.
    pub(super) active: u32,
    /// Rays of an any-hit query that these entries or earlier ones occlude.
    pub(super) hit: u32,
    /// Rays with a hit on these entries or on earlier ones.
    pub(super) found: u32,
    /// Parameters of the closest hits; infinite without one.
    pub(super) t: F64x8<S>,
    uv: [F64x8<S>; 2],
    /// Bits of their instances and primitives.
    ids: [S::F32x8; 2],
}

impl<S: Simd> SetResults<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, active: u32) -> Self {
        let zero = F64x8::splat(simd, 0.0);
        let ids = [simd.splat(0.0), simd.splat(f32::from_bits(HitStream::NONE))];
        Self { active, hit: 0, found: 0, t: F64x8::splat(simd, f64::INFINITY), uv: [zero; 2], ids }
    }

    /// Reads closest hits on earlier entries from a stream, from index `at` on.
    #[inline(always)]
    pub(super) fn read(simd: S, hits: &HitStream, at: usize, active: u32) -> Self {
        let [u, v] = &hits.uv;
        let (instances, primitives) = (hits.instance.vector(at), hits.primitive.vector(at));
        let (mut found, mut ids) = (0, [[0.0; PACKET]; 2]);
        for lane in 0..PACKET {
            found |= u32::from(primitives[lane] != HitStream::NONE) << lane;
            (ids[0][lane], ids[1][lane]) = (f32::from_bits(instances[lane]), f32::from_bits(primitives[lane]));
        }
        let t = F64x8::new(simd, *hits.t.vector(at));
        Self {
            active,
            hit: 0,
            found,
            t: t.select(simd, found, F64x8::splat(simd, f64::INFINITY)),
            uv: [F64x8::new(simd, *u.vector(at)), F64x8::new(simd, *v.vector(at))],
            ids: [simd.load(&ids[0]), simd.load(&ids[1])],
        }
    }

    /// Writes the closest hits to a stream, from index `at` on.
    #[inline(always)]
    pub(super) fn write(&self, simd: S, hits: &mut HitStream, at: usize) {
        let [instance, primitive] = self.ids;
        let [to_u, to_v] = &mut hits.uv;
        *hits.t.vector_mut(at) = self.t.to_array(simd);
        *hits.instance.vector_mut(at) = simd.to_array(instance).map(f32::to_bits);
        *hits.primitive.vector_mut(at) = simd.to_array(primitive).map(f32::to_bits);
        *to_u.vector_mut(at) = self.uv[0].to_array(simd);
        *to_v.vector_mut(at) = self.uv[1].to_array(simd);
    }

    /// Marks rays that are occluded, and returns their number.
    #[inline(always)]
    pub(super) fn accept_occluded(&mut self, hit: u32) -> u64 {
        self.hit |= hit;
        self.active &= !hit;
        u64::from(hit.count_ones())
    }

    /// Span in which another hit of a ray is closer.
    #[inline(always)]
    pub(super) fn remaining_span<O: Output>(&self, simd: S, lane: usize, span: Interval) -> Interval {
        let is_shorter = !O::ANY_HIT && self.found >> lane & 1 == 1;
        if is_shorter { Interval { max: self.t.to_array(simd)[lane & 7], ..span } } else { span }
    }

    /// Accepts the hit of one ray on an entry if it is closer than any before.
    #[inline(always)]
    pub(super) fn set<O: Output>(&mut self, simd: S, lane: usize, hit: &Hit) {
        let (ids, uv) = ([hit.instance, hit.primitive], [F64x8::splat(simd, hit.uv[0]), F64x8::splat(simd, hit.uv[1])]);
        let hit = PacketHit { hit: 1 << lane, uncertain: 0, t: F64x8::splat(simd, hit.t), uv };
        let _ = self.accept::<O>(simd, ids, 1 << lane, &hit);
    }

    /// Accepts the certain hits of some rays, with these ids, that are closer than any before. Returns the number of those that are not behind
    /// another. Entries are tested by rising index, so that ties keep the lower one.
    #[inline(always)]
    pub(super) fn accept<O: Output>(&mut self, simd: S, ids: [u32; 2], mask: u32, hits: &PacketHit<S>) -> u64 {
        let hit = mask & hits.hit;
        if O::ANY_HIT {
            return self.accept_occluded(hit);
        }
        let closer = hit & (hits.t.lt(simd, self.t) | !self.found);
        let not_behind = hit & (hits.t.le(simd, self.t) | !self.found);
        self.found |= closer;
        self.t = hits.t.select(simd, closer, self.t);
        self.uv = [hits.uv[0].select(simd, closer, self.uv[0]), hits.uv[1].select(simd, closer, self.uv[1])];
        let [instance, primitive] = ids.map(f32::from_bits);
        self.ids = [
            simd.select(closer, simd.splat(instance), self.ids[0]),
            simd.select(closer, simd.splat(primitive), self.ids[1]),
        ];
        u64::from(not_behind.count_ones())
    }
}
