//! Results of eight rays on the entries of a small set.

use rt_geometry::HitStream;
use rt_math::Interval;

use super::entry::SetEntry;
use crate::wide::f64x8::PACKET;
use crate::wide::query::Output;
use crate::wide::ray_soa::PacketHit;
use crate::wide::simd::{Simd, take_lane};

/// Results of eight rays, of which some are traced. Bit `i` of a mask is for ray `i`.
pub(super) struct SetResults {
    /// Rays whose result may still change.
    pub(super) active: u32,
    /// Rays with a hit on these entries.
    pub(super) hit: u32,
    /// Rays with a hit on these entries or on earlier ones.
    pub(super) found: u32,
    /// Parameters of the closest hits; infinite without one.
    pub(super) t: [f64; PACKET],
    pub(super) uv: [[f64; PACKET]; 2],
    /// Numbers of the hit entries.
    pub(super) entries: [u32; PACKET],
}

impl SetResults {
    #[inline(always)]
    pub(super) const fn new(active: u32) -> Self {
        Self { active, hit: 0, found: 0, t: [f64::INFINITY; PACKET], uv: [[0.0; PACKET]; 2], entries: [0; PACKET] }
    }

    /// Writes the closest hits to a stream, from index `at` on.
    #[inline(always)]
    pub(super) fn write(&self, entries: &[SetEntry], hits: &mut HitStream, at: usize) {
        let (mut instances, mut primitives) = ([0; PACKET], [HitStream::NONE; PACKET]);
        for (lane, entry) in self.entries.into_iter().enumerate() {
            if self.hit >> lane & 1 == 1
                && let Some(entry) = entries.get(entry as usize)
            {
                [instances[lane], primitives[lane]] = entry.hit_ids;
            }
        }
        let ([to_u, to_v], [u, v]) = (&mut hits.uv, &self.uv);
        *hits.t.vector_mut(at) = self.t;
        *hits.instance.vector_mut(at) = instances;
        *hits.primitive.vector_mut(at) = primitives;
        (*to_u.vector_mut(at), *to_v.vector_mut(at)) = (*u, *v);
    }

    /// Span in which another hit of a ray is closer.
    #[inline(always)]
    pub(super) fn remaining_span<O: Output>(&self, lane: usize, span: Interval) -> Interval {
        let is_shorter = !O::ANY_HIT && self.found >> lane & 1 == 1;
        if is_shorter { Interval { max: self.t[lane], ..span } } else { span }
    }

    /// Accepts a hit that is closer than any before. Entries are tested by rising index, so that ties keep the lower one.
    #[inline(always)]
    pub(super) fn set<O: Output>(&mut self, entry: usize, lane: usize, t: f64, uv: [f64; 2]) {
        if O::ANY_HIT || self.found >> lane & 1 == 0 || t < self.t[lane] {
            self.hit |= 1 << lane;
            self.found |= 1 << lane;
            (self.t[lane], self.entries[lane]) = (t, entry as u32);
            (self.uv[0][lane], self.uv[1][lane]) = (uv[0], uv[1]);
            if O::ANY_HIT {
                self.active &= !(1 << lane);
            }
        }
    }

    /// Accepts the certain hits of some rays on an entry. Returns the number of those that are not behind another.
    #[inline(always)]
    pub(super) fn accept<S: Simd, O: Output>(&mut self, simd: S, entry: usize, mask: u32, hits: &PacketHit<S>) -> u64 {
        let mut hit = mask & hits.hit;
        if O::ANY_HIT {
            self.hit |= hit;
            self.active &= !hit;
            return u64::from(hit.count_ones());
        }
        let [v, w] = hits.uv;
        let (t, v, w) = (hits.t.to_array(simd), v.to_array(simd), w.to_array(simd));
        let mut accepted = 0;
        while hit != 0 {
            let lane = take_lane(&mut hit);
            accepted += u64::from(self.found >> lane & 1 == 0 || t[lane] <= self.t[lane]);
            self.set::<O>(entry, lane, t[lane], [v[lane], w[lane]]);
        }
        accepted
    }
}
