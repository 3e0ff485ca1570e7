//! A few primitives without a tree: spheres, triangles, planes and bounds are tested with eight rays at once, instances
//! with whole batches.

mod entry;
mod results;

use rt_geometry::{BatchKernel, Hit, HitStream, Primitives, Probe, RayStream};
use rt_math::{Aabb, Interval, Ray};

use self::entry::SetEntry;
use self::results::SetResults;
use super::f64x8::{F64x8, PACKET};
use super::packet::SWITCH_THRESHOLD;
use super::packet_spheres::SpherePacket;
use super::query::{Output, PrimitiveTester, Tester, TraversalStats};
use super::ray_soa::{RaySoa8, pad_to_packet};
use super::simd::{DetectedSimd, Simd, SimdLevel, WithSimd, take_lane};
use super::{packet_planes, packet_triangles};

/// Rays that an instance is traced with at once. Bounds the memory for copies of rays.
const INSTANCE_BATCH: usize = 1024;

/// A few primitives of a set, as an accelerator: hits carry the indices of the set.
///
/// Tests all by ascending index, with the results of [`brute_force`](crate::brute_force), bit for bit, and its
/// [`Counters`](crate::Counters) unless there are instances. Batches intersect [`BatchKernel::Sphere`],
/// [`BatchKernel::Triangle`] and [`BatchKernel::Plane`] with eight rays at once. Of other shapes, they test the padded
/// bounds with eight rays at once, and then single rays. A [`BatchKernel::Instance`] traces the rays that may pass its bounds
/// together, and counts the work of a batch.
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
    /// Maximum number of primitives.
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

    /// The primitives with what batches need of them, in a buffer.
    fn entries<'b, P: Primitives>(&self, primitives: &P, buffer: &'b mut [SetEntry; Self::CAPACITY]) -> &'b [SetEntry] {
        for (entry, &index) in buffer.iter_mut().zip(self.indices()) {
            *entry = SetEntry::new(primitives, index);
        }
        buffer.get(..self.len).unwrap_or(&[])
    }

    /// Traces a stream. Returns false, without any result, for a set with instances, and at levels without packets.
    fn trace_stream<O: SetQuery, P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        (rays, output): (&RayStream, StreamOutput<'_>),
        probe: &mut S,
    ) -> bool
    where
        for<'a> Tester<'a, P, S>: PrimitiveTester<O>,
    {
        let mut buffer = [SetEntry::NONE; Self::CAPACITY];
        let entries = self.entries(primitives, &mut buffer);
        if entries.iter().any(SetEntry::is_instance) {
            return false;
        }
        let mut tester = Tester { primitives, probe };
        let stats = TraversalStats::default();
        let mut batch = Batch { entries, indices: self.indices(), is_first: true, tester: &mut tester, stats };
        let is_traced = O::trace_stream(self.level, &mut batch, rays, output);
        batch.stats.add_to(tester.probe);
        is_traced
    }

    /// Version of [`closest_batch`](Self::closest_batch) for a stream. Returns false, without any result,
    /// for a set with instances, and at levels without packets.
    #[must_use]
    pub fn closest_stream<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        rays: &RayStream,
        hits: &mut HitStream,
        probe: &mut S,
    ) -> bool {
        self.trace_stream::<Option<Hit>, _, _>(primitives, (rays, StreamOutput::Closest(hits)), probe)
    }

    /// Version of [`occluded_batch`](Self::occluded_batch) for a stream. Returns false as
    /// [`closest_stream`](Self::closest_stream) does.
    #[must_use]
    pub fn occluded_stream<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        rays: &RayStream,
        occluded: &mut [bool],
        probe: &mut S,
    ) -> bool {
        self.trace_stream::<bool, _, _>(primitives, (rays, StreamOutput::Occluded(occluded)), probe)
    }

    /// Traces a batch.
    fn trace_batch<O: SetQuery, P: Primitives, S: Probe>(
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
        let mut buffer = [SetEntry::NONE; Self::CAPACITY];
        let entries = self.entries(primitives, &mut buffer);
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
                [entry] if entry.is_instance() => batch.trace_instance(self.level, entry, rays, outputs),
                _ => {
                    let is_traced = entries.iter().any(SetEntry::has_kernel)
                        && O::trace_batch(self.level, &mut batch, rays, outputs);
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

    /// Traces the rays that may pass the bounds of an instance through it, unless their result is final.
    fn trace_instance(&mut self, level: DetectedSimd, entry: &SetEntry, rays: &[(Ray, Interval)], outputs: &mut [O]) {
        if self.is_first {
            outputs.fill(O::default());
        }
        for (rays, outputs) in rays.chunks(INSTANCE_BATCH).zip(outputs.chunks_mut(INSTANCE_BATCH)) {
            let mut passing = [0xff; INSTANCE_BATCH / PACKET];
            if let Some(bounds) = &entry.bounds {
                // Without kernels at this level, all rays may pass.
                let _ = level.dispatch_lists(BoundsTest { bounds }, rays, passing.as_mut_slice());
            }
            let mut active = Vec::with_capacity(rays.len());
            let mut batch = Vec::with_capacity(rays.len());
            for (at, ((ray, span), output)) in rays.iter().zip(&*outputs).enumerate() {
                if output.is_final() {
                    continue;
                }
                self.stats.tests += 1;
                if passing[at / PACKET] >> (at % PACKET) & 1 == 1 {
                    active.push(at);
                    batch.push((*ray, Interval { max: output.t_max(span.max), ..*span }));
                }
            }
            let mut found = vec![O::default(); batch.len()];
            self.tester.test_batch(entry.index, &batch, &mut found);
            for (at, found) in active.into_iter().zip(found) {
                if let Some(output) = outputs.get_mut(at) {
                    output.merge(found);
                }
            }
        }
    }

    /// Traces as many of eight rays as there are outputs.
    #[inline(always)]
    fn trace_packet<S: Simd>(&mut self, simd: S, rays: &[(Ray, Interval); PACKET], outputs: &mut [O]) {
        let soa = RaySoa8::new(simd, rays);
        let in_range = soa.in_safe_range(simd) & ((1 << outputs.len().min(PACKET)) - 1);
        let mut results = SetResults::new(simd, in_range);
        if !self.is_first {
            let mut t = [f64::INFINITY; PACKET];
            for (lane, output) in outputs.iter().enumerate() {
                results.found |= u32::from(output.to_hit().is_some()) << lane;
                t[lane & 7] = output.t_max(f64::INFINITY);
                results.active &= !(u32::from(output.is_final()) << lane);
            }
            results.t = F64x8::new(simd, t);
        }
        self.test_entries(simd, &soa, |lane| rays[lane & 7], &mut results);
        let hits = results.hits(simd);
        for (lane, output) in outputs.iter_mut().enumerate().take(PACKET) {
            if in_range >> lane & 1 == 0 {
                let (ray, span) = &rays[lane];
                self.trace(ray, *span, output);
            } else if results.hit >> lane & 1 == 1 {
                *output = O::from_hit(Some(hits[lane]));
            } else if self.is_first {
                *output = O::default();
            }
        }
    }

    /// Intersects one ray, whose numbers are extreme, with the entries.
    #[inline(always)]
    fn trace_entries<S: Simd>(
        &mut self,
        simd: S,
        (ray, span): &(Ray, Interval),
        lane: usize,
        results: &mut SetResults<S>,
    ) {
        for entry in self.entries {
            self.stats.tests += 1;
            let span = results.remaining_span::<O>(simd, lane, *span);
            if let Some(hit) = self.tester.test(entry.index, ray, span).to_hit() {
                results.set::<O>(simd, entry, lane, &hit);
                if O::ANY_HIT {
                    return;
                }
            }
        }
    }

    /// Intersects eight rays with the entries; `ray` returns one of them.
    #[inline(always)]
    fn test_entries<S: Simd>(
        &mut self,
        simd: S,
        soa: &RaySoa8<S>,
        ray: impl Fn(usize) -> (Ray, Interval),
        results: &mut SetResults<S>,
    ) {
        let by_axis = soa.by_steepest_axis(simd);
        for entry in self.entries {
            let SetEntry { index, casts_shadow, kernel, bounds, .. } = entry;
            let active = results.active;
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
                    let mut possible = active & !spheres.miss_mask(simd, soa);
                    if O::ANY_HIT && possible != 0 {
                        let [hit, uncertain] = spheres.occlusion(simd, soa);
                        self.stats.hits += results.accept_occluded(possible & hit);
                        possible &= uncertain;
                    }
                    if possible == 0 {
                        continue;
                    }
                    let hits = spheres.intersect(simd, soa);
                    self.stats.hits += results.accept::<O>(simd, entry, possible, &hits);
                    possible & hits.uncertain
                }
                BatchKernel::Triangle(vertices) => {
                    let mut uncertain = 0;
                    for (axis, rays) in by_axis.iter().enumerate() {
                        let mask = active & rays;
                        if mask == 0 {
                            continue;
                        }
                        let Some(hits) = packet_triangles::intersect(simd, vertices, axis, soa, mask) else {
                            continue;
                        };
                        self.stats.hits += results.accept::<O>(simd, entry, mask, &hits);
                        uncertain |= hits.uncertain;
                    }
                    uncertain
                }
                BatchKernel::Plane(plane) => {
                    let hits = packet_planes::intersect(simd, plane, soa);
                    self.stats.hits += results.accept::<O>(simd, entry, active, &hits);
                    0
                }
                BatchKernel::Instance | BatchKernel::Single => {
                    bounds.as_ref().map_or(active, |bounds| active & soa.may_pass(simd, bounds, results.t))
                }
            };
            while uncertain != 0 {
                let lane = take_lane(&mut uncertain);
                let (ray, span) = ray(lane);
                let span = results.remaining_span::<O>(simd, lane, span);
                if let Some(hit) = self.tester.test(*index, &ray, span).to_hit() {
                    results.set::<O>(simd, entry, lane, &hit);
                }
            }
        }
    }
}

/// Tests which rays may pass bounds within their spans: a bit for each, eight rays at a time.
struct BoundsTest<'b> {
    bounds: &'b Aabb,
}

impl WithSimd<&[(Ray, Interval)], &mut [u8]> for BoundsTest<'_> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S, rays: &[(Ray, Interval)], passing: &mut [u8]) {
        for (rays, passing) in rays.chunks(PACKET).zip(passing) {
            let soa = match rays.try_into() {
                Ok(packet) => RaySoa8::new(simd, packet),
                Err(_) => RaySoa8::new(simd, &pad_to_packet(rays)),
            };
            let may_pass = soa.may_pass(simd, self.bounds, F64x8::splat(simd, f64::INFINITY));
            *passing = (may_pass | !soa.in_safe_range(simd)) as u8;
        }
    }
}

/// Traces a stream of rays through the entries of a batch.
struct StreamTraversal<'b, 'a, O> {
    batch: &'b mut Batch<'a, O>,
}

/// Destination of the results of a stream.
enum StreamOutput<'h> {
    Closest(&'h mut HitStream),
    Occluded(&'h mut [bool]),
}

impl<O: Output> WithSimd<&RayStream, StreamOutput<'_>> for StreamTraversal<'_, '_, O> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S, rays: &RayStream, mut output: StreamOutput<'_>) {
        let batch = self.batch;
        let has_inverse = batch.entries.iter().any(SetEntry::needs_inverse);
        for at in (0..rays.len()).step_by(PACKET) {
            let used = (rays.len() - at).min(PACKET);
            let soa = RaySoa8::load(simd, rays, at, has_inverse);
            let all = (1 << used) - 1;
            let in_range = soa.in_safe_range(simd) & all;
            let mut results = SetResults::new(simd, in_range);
            batch.test_entries(simd, &soa, |lane| rays.get(at + lane), &mut results);
            let mut out_of_range = all & !in_range;
            while out_of_range != 0 {
                let lane = take_lane(&mut out_of_range);
                batch.trace_entries(simd, &rays.get(at + lane), lane, &mut results);
            }
            match &mut output {
                StreamOutput::Closest(hits) => results.write(simd, hits, at),
                StreamOutput::Occluded(occluded) => {
                    for (lane, occluded) in occluded.iter_mut().skip(at).take(used).enumerate() {
                        *occluded = results.hit >> lane & 1 == 1;
                    }
                }
            }
        }
    }
}

/// Queries of a set. Compiled once here, and not in every crate that traces rays. False if kernels for lists are not compiled for
/// this level.
trait SetQuery: Output {
    fn trace_batch(
        level: DetectedSimd,
        batch: &mut Batch<'_, Self>,
        rays: &[(Ray, Interval)],
        outputs: &mut [Self],
    ) -> bool;

    fn trace_stream(
        level: DetectedSimd,
        batch: &mut Batch<'_, Self>,
        rays: &RayStream,
        output: StreamOutput<'_>,
    ) -> bool;
}

/// Entry points of a query, compiled for a concrete output.
macro_rules! entry_points {
    () => {
        #[inline(never)]
        fn trace_batch(
            level: DetectedSimd,
            batch: &mut Batch<'_, Self>,
            rays: &[(Ray, Interval)],
            outputs: &mut [Self],
        ) -> bool {
            level.dispatch_lists(batch, rays, outputs)
        }

        #[inline(never)]
        fn trace_stream(
            level: DetectedSimd,
            batch: &mut Batch<'_, Self>,
            rays: &RayStream,
            output: StreamOutput<'_>,
        ) -> bool {
            level.dispatch_lists(StreamTraversal { batch }, rays, output)
        }
    };
}

impl SetQuery for Option<Hit> {
    entry_points!();
}

impl SetQuery for bool {
    entry_points!();
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
