//! A few primitives without a tree: spheres and triangles are intersected with eight rays at once, instances with whole
//! batches.

use rt_geometry::{BatchKernel, Hit, Primitives, Probe};
use rt_math::{Interval, Ray};

use super::f64x8::PACKET;
use super::packet::SWITCH_THRESHOLD;
use super::packet_spheres::SpherePacket;
use super::packet_triangles;
use super::query::{Output, PrimitiveTester, Tester, TraversalStats};
use super::ray_soa::{PacketHit, RaySoa8, pad_to_packet};
use super::simd::{DetectedSimd, Simd, SimdLevel, WithSimd, take_lane};

/// Rays that an instance is traced with at once. Bounds the memory for copies of rays.
const INSTANCE_BATCH: usize = 1024;

/// A few primitives of a set, as an accelerator: hits carry the indices of the set.
///
/// Tests all by ascending index, with the results and [`Counters`](crate::Counters) of
/// [`brute_force`](crate::brute_force), bit for bit. Batches intersect [`BatchKernel::Sphere`] and
/// [`BatchKernel::Triangle`] with eight rays at once. A [`BatchKernel::Instance`] traces many rays of the batch together,
/// and counts the work of a batch.
///
/// ```
/// use rt_accel::{Aabb, Boxes, DVec3, Interval, NoProbe, Ray, wide::SmallSet};
///
/// let boxes = [0.0, 2.0, 4.0].map(|x| Aabb::new(DVec3::splat(x), DVec3::splat(x + 1.0)));
/// let all_but_the_first = SmallSet::new([2, 1]).expect("within the capacity");
/// let ray = Ray::new(DVec3::splat(-1.0), DVec3::ONE);
/// let hit = all_but_the_first.closest(&Boxes(&boxes), &ray, Interval::FORWARD, &mut NoProbe);
/// assert_eq!(hit.map(|hit| hit.primitive), Some(1));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SmallSet {
    /// Rising.
    indices: [u32; Self::CAPACITY],
    len: usize,
    level: DetectedSimd,
}

impl SmallSet {
    /// Most primitives of a set.
    pub const CAPACITY: usize = 16;

    /// Primitives by their indices, in any order; duplicates are tested twice. `None` beyond the capacity.
    pub fn new(indices: impl IntoIterator<Item = u32>) -> Option<Self> {
        let mut this = Self { indices: [0; Self::CAPACITY], len: 0, level: DetectedSimd::default() };
        for index in indices {
            *this.indices.get_mut(this.len)? = index;
            this.len += 1;
        }
        this.indices.get_mut(..this.len)?.sort_unstable();
        Some(this)
    }

    /// Replaces the instruction set, for tests and comparisons. The portable level replaces one that the processor
    /// does not support.
    #[must_use]
    pub fn with_level(mut self, level: SimdLevel) -> Self {
        self.level = DetectedSimd::new(level);
        self
    }

    /// Indices of the primitives, rising.
    pub fn indices(&self) -> &[u32] {
        self.indices.get(..self.len).unwrap_or(&[])
    }

    /// Traces a batch.
    fn trace_batch<O: Output, P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        rays: &[(Ray, Interval)],
        outputs: &mut [O],
        probe: &mut S,
    ) where
        for<'a> Tester<'a, P, S>: PrimitiveTester<O>,
    {
        let n = rays.len().min(outputs.len());
        let (rays, outputs) = (rays.get(..n).unwrap_or(&[]), outputs.get_mut(..n).unwrap_or(&mut []));
        let mut entries = [SetEntry::NONE; Self::CAPACITY];
        for (entry, &index) in entries.iter_mut().zip(self.indices()) {
            *entry = SetEntry::new(primitives, index);
        }
        let entries = entries.get(..self.len).unwrap_or(&[]);
        if entries.is_empty() {
            outputs.fill(O::default());
        }
        let mut tester = Tester { primitives, probe };
        let stats = TraversalStats::default();
        let mut batch = Batch { entries, indices: &[], is_first: true, tester: &mut tester, stats };
        let mut indices = self.indices();
        for entries in entries.chunk_by(|a, b| !a.is_instance() && !b.is_instance()) {
            batch.entries = entries;
            (batch.indices, indices) = indices.split_at(entries.len());
            match entries {
                [entry] if entry.is_instance() => batch.trace_instance(entry.index, rays, outputs),
                _ => {
                    let is_traced = entries.iter().any(SetEntry::has_kernel)
                        && self.level.dispatch_packets(&mut batch, rays, &mut *outputs);
                    if !is_traced {
                        batch.trace_singly(rays, outputs);
                    }
                }
            }
            batch.is_first = false;
        }
        batch.stats.add_to(tester.probe);
    }
}

/// A primitive of the set.
#[derive(Clone, Copy)]
struct SetEntry {
    index: u32,
    /// Instance and primitive of its hits.
    hit_ids: [u32; 2],
    casts_shadow: bool,
    kernel: BatchKernel,
}

impl SetEntry {
    const NONE: Self = Self { index: 0, hit_ids: [0; 2], casts_shadow: false, kernel: BatchKernel::Single };

    fn new<P: Primitives>(primitives: &P, index: u32) -> Self {
        Self {
            index,
            hit_ids: primitives.hit_ids(index),
            casts_shadow: primitives.blocks(index),
            kernel: primitives.batch_kernel(index),
        }
    }

    const fn is_instance(&self) -> bool {
        matches!(self.kernel, BatchKernel::Instance)
    }

    /// True if it is intersected with eight rays at once.
    const fn has_kernel(&self) -> bool {
        matches!(self.kernel, BatchKernel::Sphere(_) | BatchKernel::Triangle(_))
    }
}

/// Traces a batch through consecutive entries.
struct Batch<'a, O> {
    entries: &'a [SetEntry],
    indices: &'a [u32],
    /// True if no entries were tested before.
    is_first: bool,
    tester: &'a mut dyn PrimitiveTester<O>,
    /// Work that the tester has not counted.
    stats: TraversalStats,
}

impl<O: Output> WithSimd<&[(Ray, Interval)], &mut [O]> for &mut Batch<'_, O> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S, rays: &[(Ray, Interval)], outputs: &mut [O]) {
        for (rays, outputs) in rays.chunks(PACKET).zip(outputs.chunks_mut(PACKET)) {
            let padded;
            let packet = if let Ok(packet) = rays.try_into() {
                packet
            } else if rays.len() <= SWITCH_THRESHOLD as usize {
                self.trace_singly(rays, outputs);
                continue;
            } else {
                padded = pad_to_packet(rays);
                &padded
            };
            self.trace_packet(simd, packet, outputs);
        }
    }
}

impl<O: Output> Batch<'_, O> {
    /// Traces each ray by itself.
    fn trace_singly(&mut self, rays: &[(Ray, Interval)], outputs: &mut [O]) {
        for ((ray, span), output) in rays.iter().zip(outputs) {
            self.trace(ray, *span, output);
        }
    }

    /// Traces one ray.
    fn trace(&mut self, ray: &Ray, span: Interval, output: &mut O) {
        if self.is_first {
            *output = self.tester.test_all(self.indices, ray, span);
            return;
        }
        for entry in self.entries {
            if output.is_final() {
                return;
            }
            self.stats.tests += 1;
            let span = Interval { max: output.t_max(span.max), ..span };
            output.merge(self.tester.test(entry.index, ray, span));
        }
    }

    /// Traces all rays through an instance, unless their result is final.
    fn trace_instance(&mut self, index: u32, rays: &[(Ray, Interval)], outputs: &mut [O]) {
        for (rays, outputs) in rays.chunks(INSTANCE_BATCH).zip(outputs.chunks_mut(INSTANCE_BATCH)) {
            if self.is_first {
                outputs.fill(O::default());
                self.stats.tests += rays.len() as u64;
                self.tester.test_batch(index, rays, outputs);
                continue;
            }
            let mut active = Vec::with_capacity(rays.len());
            let mut batch = Vec::with_capacity(rays.len());
            for (at, ((ray, span), output)) in rays.iter().zip(&*outputs).enumerate() {
                if !output.is_final() {
                    active.push(at);
                    batch.push((*ray, Interval { max: output.t_max(span.max), ..*span }));
                }
            }
            self.stats.tests += batch.len() as u64;
            let mut found = vec![O::default(); batch.len()];
            self.tester.test_batch(index, &batch, &mut found);
            for (at, found) in active.into_iter().zip(found) {
                if let Some(output) = outputs.get_mut(at) {
                    output.merge(found);
                }
            }
        }
    }

    /// Merges the certain hits of some rays on an entry.
    #[inline(always)]
    fn accept_hits<S: Simd>(
        &mut self,
        simd: S,
        [instance, primitive]: [u32; 2],
        mask: u32,
        hits: &PacketHit<S>,
        results: &mut [O; PACKET],
    ) {
        let [v, w] = hits.uv;
        let (t, v, w) = (hits.t.to_array(simd), v.to_array(simd), w.to_array(simd));
        let mut hit = mask & hits.hit;
        while hit != 0 {
            let lane = take_lane(&mut hit);
            let hit = Hit { t: t[lane], instance, primitive, uv: [v[lane], w[lane]] };
            if hit.t <= results[lane].t_max(f64::INFINITY) {
                results[lane].merge(O::from_hit(Some(hit)));
                self.stats.hits += 1;
            }
        }
    }

    /// Traces as many of eight rays as there are outputs.
    #[inline(always)]
    fn trace_packet<S: Simd>(&mut self, simd: S, rays: &[(Ray, Interval); PACKET], outputs: &mut [O]) {
        let soa = RaySoa8::new(simd, rays);
        let all = (1 << outputs.len().min(PACKET)) - 1;
        let in_range = soa.in_safe_range(simd) & all;
        let mut active = in_range;
        let by_axis = soa.by_steepest_axis(simd);
        let mut results = [O::default(); PACKET];
        if !self.is_first {
            for (lane, (result, output)) in results.iter_mut().zip(&*outputs).enumerate() {
                *result = *output;
                active &= !(u32::from(result.is_final()) << lane);
            }
        }
        for SetEntry { index, hit_ids, casts_shadow, kernel } in self.entries {
            if active == 0 {
                break;
            }
            self.stats.tests += u64::from(active.count_ones());
            if O::ANY_HIT && !*casts_shadow {
                continue;
            }
            let mut uncertain = match kernel {
                BatchKernel::Sphere(sphere) => {
                    let spheres = SpherePacket::all(simd, sphere);
                    let possible = active & !spheres.miss_mask(simd, &soa);
                    if possible == 0 {
                        continue;
                    }
                    let hits = spheres.intersect(simd, &soa);
                    self.accept_hits(simd, *hit_ids, possible, &hits, &mut results);
                    possible & hits.uncertain
                }
                BatchKernel::Triangle(vertices) => {
                    let mut uncertain = 0;
                    for (axis, rays) in by_axis.iter().enumerate() {
                        let mask = active & rays;
                        if mask == 0 {
                            continue;
                        }
                        let Some(hits) = packet_triangles::intersect(simd, vertices, axis, &soa, mask) else {
                            continue;
                        };
                        self.accept_hits(simd, *hit_ids, mask, &hits, &mut results);
                        uncertain |= hits.uncertain;
                    }
                    uncertain
                }
                BatchKernel::Instance | BatchKernel::Single => active,
            };
            while uncertain != 0 {
                let lane = take_lane(&mut uncertain);
                let (ray, span) = &rays[lane];
                let span = Interval { max: results[lane].t_max(span.max), ..*span };
                results[lane].merge(self.tester.test(*index, ray, span));
            }
            for (lane, result) in results.iter().enumerate() {
                active &= !(u32::from(result.is_final()) << lane);
            }
        }
        for (lane, output) in outputs.iter_mut().enumerate().take(PACKET) {
            if in_range >> lane & 1 != 0 {
                *output = results[lane];
            } else {
                let (ray, span) = &rays[lane];
                self.trace(ray, *span, output);
            }
        }
    }
}

impl SmallSet {
    /// Closest hit of the members within `span`.
    pub fn closest<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        ray: &Ray,
        span: Interval,
        probe: &mut S,
    ) -> Option<Hit> {
        Tester { primitives, probe }.test_all(self.indices(), ray, span)
    }

    /// True if any member occludes the ray within `span`.
    pub fn occluded<P: Primitives, S: Probe>(&self, primitives: &P, ray: &Ray, span: Interval, probe: &mut S) -> bool {
        Tester { primitives, probe }.test_all(self.indices(), ray, span)
    }

    /// [`closest`](Self::closest) for many rays, with identical results.
    pub fn closest_batch<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        rays: &[(Ray, Interval)],
        hits: &mut [Option<Hit>],
        probe: &mut S,
    ) {
        self.trace_batch(primitives, rays, hits, probe);
    }

    /// [`occluded`](Self::occluded) for many rays, with identical results.
    pub fn occluded_batch<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        rays: &[(Ray, Interval)],
        occluded: &mut [bool],
        probe: &mut S,
    ) {
        self.trace_batch(primitives, rays, occluded, probe);
    }
}
