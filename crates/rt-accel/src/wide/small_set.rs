//! A few primitives without a tree: spheres, triangles, quadrilaterals, planes and bounds are tested with eight rays at once,
//! instances with whole streams.

mod entry;
mod results;

use rt_geometry::{Hit, HitStream, PacketKernel, Primitives, Probe, RayStream, STREAM_CAPACITY, with_stream_buffers};
use rt_math::{Aabb, Interval, Ray};

use self::entry::SetEntry;
use self::results::SetResults;
use super::f64x8::{F64x8, PACKET};
use super::packet_spheres::SpherePacket;
use super::query::{Output, PrimitiveTester, Tester, TraversalStats};
use super::ray_soa::RaySoa8;
use super::simd::{DetectedSimd, Simd, SimdLevel, WithSimd, take_lane};
use super::stream_rays::N_PACKETS;
use super::{packet_planes, packet_quadrilaterals, packet_triangles};

/// A few primitives of a set, as an accelerator: hits carry the indices of the set.
///
/// Tests all by ascending index, with the results of [`brute_force`](crate::brute_force), bit for bit, and its
/// [`Counters`](crate::Counters) unless there are instances. Streams intersect [`PacketKernel::Sphere`], [`PacketKernel::Triangle`],
/// [`PacketKernel::Quadrilateral`] and [`PacketKernel::Plane`] with eight rays at once. Of other shapes, they test the padded bounds with
/// eight rays at once, and then single rays. A [`PacketKernel::Instance`] traces the rays that may pass its bounds together, and counts
/// their work once.
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

    /// The primitives with what streams need of them, in a buffer.
    fn entries<'b, P: Primitives>(&self, primitives: &P, buffer: &'b mut [SetEntry; Self::CAPACITY]) -> &'b [SetEntry] {
        for (entry, &index) in buffer.iter_mut().zip(self.indices()) {
            *entry = SetEntry::new(primitives, index);
        }
        buffer.get(..self.len).unwrap_or(&[])
    }

    /// Traces a stream.
    fn trace_stream<O: SetQuery, P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        rays: &RayStream,
        outputs: &mut O::OfStream,
        probe: &mut S,
    ) where
        for<'a> Tester<'a, P, S>: PrimitiveTester<O>,
    {
        let mut buffer = [SetEntry::NONE; Self::CAPACITY];
        let entries = self.entries(primitives, &mut buffer);
        let mut tester = Tester { primitives, probe };
        let stats = TraversalStats::default();
        let mut tracer = EntryTracer { entries, indices: &[], is_first: true, tester: &mut tester, stats };
        let mut indices = self.indices();
        for entries in entries.chunk_by(|a, b| !a.is_instance() && !b.is_instance()) {
            tracer.entries = entries;
            (tracer.indices, indices) = indices.split_at(entries.len());
            match entries {
                [entry] if entry.is_instance() => tracer.trace_instance(self.level, entry, rays, outputs),
                _ => {
                    let is_traced =
                        entries.iter().any(SetEntry::has_kernel) && O::trace(self.level, &mut tracer, rays, outputs);
                    if !is_traced {
                        tracer.trace_singly(rays, outputs);
                    }
                }
            }
            tracer.is_first = false;
        }
        if tracer.is_first {
            (0..rays.len()).for_each(|at| O::default().write(outputs, at));
        }
        tracer.stats.add_to(tester.probe);
    }
}

/// Traces a stream through consecutive entries.
struct EntryTracer<'a, O> {
    entries: &'a [SetEntry],
    indices: &'a [u32],
    /// True if no entries were tested before.
    is_first: bool,
    tester: &'a mut dyn PrimitiveTester<O>,
    /// Work that the tester has not counted.
    stats: TraversalStats,
}

impl<O: Output> EntryTracer<'_, O> {
    /// Traces each ray by itself.
    fn trace_singly(&mut self, rays: &RayStream, outputs: &mut O::OfStream) {
        for at in 0..rays.len() {
            let (ray, span) = rays.get(at);
            let output = if self.is_first {
                self.tester.test_all(self.indices, &ray, span)
            } else {
                self.trace_further(&ray, span, O::read(outputs, at))
            };
            output.write(outputs, at);
        }
    }

    /// Traces one ray whose result for earlier entries is given.
    fn trace_further(&mut self, ray: &Ray, span: Interval, mut output: O) -> O {
        for entry in self.entries {
            if output.is_final() {
                break;
            }
            self.stats.tests += 1;
            let span = Interval { max: output.t_max(span.max), ..span };
            output.merge(self.tester.test(entry.index, ray, span));
        }
        output
    }

    /// Traces the rays that may pass the bounds of an instance through it, unless their result is final.
    fn trace_instance(&mut self, level: DetectedSimd, entry: &SetEntry, rays: &RayStream, outputs: &mut O::OfStream) {
        let mut passing = [0xff; N_PACKETS];
        if let Some(bounds) = &entry.bounds {
            // Without kernels at this level, all rays may pass.
            let _ = level.dispatch_lists(BoundsTest { bounds }, rays, &mut passing);
        }
        let (mut active, mut n) = ([0; STREAM_CAPACITY], 0);
        for at in 0..rays.len() {
            if self.is_first {
                O::default().write(outputs, at);
            } else if O::read(outputs, at).is_final() {
                continue;
            }
            self.stats.tests += 1;
            if passing[at / PACKET] >> (at % PACKET) & 1 == 1 {
                active[n] = at as u8;
                n += 1;
            }
        }
        let active = &active[..n];
        with_stream_buffers(&mut |buffers| {
            buffers.rays.set_gathered(rays, active);
            if !self.is_first {
                for (i, &at) in active.iter().enumerate() {
                    buffers.rays.max.set(i, O::read(outputs, at.into()).t_max(buffers.rays.max.get(i)));
                }
            }
            let (rays, found) = O::of_buffers(buffers);
            self.tester.test_stream(entry.index, rays, found);
            for (i, &at) in active.iter().enumerate() {
                let mut output = O::read(outputs, at.into());
                output.merge(O::read(found, i));
                output.write(outputs, at.into());
            }
        });
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
                results.set::<O>(simd, lane, &hit);
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
            let SetEntry { index, hit_ids, casts_shadow, kernel, bounds } = entry;
            let active = results.active;
            if active == 0 {
                break;
            }
            self.stats.tests += u64::from(active.count_ones());
            if O::ANY_HIT && !*casts_shadow {
                continue;
            }
            let mut uncertain = match kernel {
                PacketKernel::Sphere(sphere) => {
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
                    self.stats.hits += results.accept::<O>(simd, *hit_ids, possible, &hits);
                    possible & hits.uncertain
                }
                PacketKernel::Triangle(vertices) => {
                    let mut uncertain = 0;
                    for (axis, rays) in by_axis.iter().enumerate() {
                        let mask = active & rays;
                        if mask == 0 {
                            continue;
                        }
                        let Some(hits) = packet_triangles::intersect(simd, vertices, axis, soa, mask) else {
                            continue;
                        };
                        self.stats.hits += results.accept::<O>(simd, *hit_ids, mask, &hits);
                        uncertain |= hits.uncertain;
                    }
                    uncertain
                }
                PacketKernel::Plane(plane) => {
                    let hits = packet_planes::intersect(simd, plane, soa);
                    self.stats.hits += results.accept::<O>(simd, *hit_ids, active, &hits);
                    0
                }
                PacketKernel::Quadrilateral(plane, corners) => {
                    let passing =
                        bounds.as_ref().map_or(active, |bounds| active & soa.may_pass(simd, bounds, results.t));
                    if passing == 0 {
                        continue;
                    }
                    let shape = (plane, corners);
                    let hits = packet_quadrilaterals::intersect(simd, shape, soa, by_axis, passing);
                    self.stats.hits += results.accept::<O>(simd, *hit_ids, passing, &hits);
                    hits.uncertain
                }
                PacketKernel::Instance | PacketKernel::Single => {
                    bounds.as_ref().map_or(active, |bounds| active & soa.may_pass(simd, bounds, results.t))
                }
            };
            while uncertain != 0 {
                let lane = take_lane(&mut uncertain);
                let (ray, span) = ray(lane);
                let span = results.remaining_span::<O>(simd, lane, span);
                if let Some(hit) = self.tester.test(*index, &ray, span).to_hit() {
                    results.set::<O>(simd, lane, &hit);
                }
            }
        }
    }
}

/// Tests which rays may pass bounds within their spans: a bit for each, eight rays at a time.
struct BoundsTest<'b> {
    bounds: &'b Aabb,
}

impl WithSimd<&RayStream, &mut [u8; N_PACKETS]> for BoundsTest<'_> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S, rays: &RayStream, passing: &mut [u8; N_PACKETS]) {
        for (at, passing) in (0..rays.len()).step_by(PACKET).zip(passing) {
            let soa = RaySoa8::load(simd, rays, at, true);
            let may_pass = soa.may_pass(simd, self.bounds, F64x8::splat(simd, f64::INFINITY));
            *passing = (may_pass | !soa.in_safe_range(simd)) as u8;
        }
    }
}

/// Traces a stream of rays through the entries of a tracer.
struct SetTraversal<'b, 'a, O> {
    tracer: &'b mut EntryTracer<'a, O>,
}

impl<O: SetQuery> WithSimd<&RayStream, &mut O::OfStream> for SetTraversal<'_, '_, O> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S, rays: &RayStream, outputs: &mut O::OfStream) {
        let tracer = self.tracer;
        let has_inverse = tracer.entries.iter().any(SetEntry::needs_inverse);
        for at in (0..rays.len()).step_by(PACKET) {
            let used = (rays.len() - at).min(PACKET);
            let soa = RaySoa8::load(simd, rays, at, has_inverse);
            let all = (1 << used) - 1;
            let in_range = soa.in_safe_range(simd) & all;
            let mut results = if tracer.is_first {
                SetResults::new(simd, in_range)
            } else {
                O::read_packet(simd, outputs, at, in_range)
            };
            tracer.test_entries(simd, &soa, |lane| rays.get(at + lane), &mut results);
            // Rays that earlier entries occlude are not tested.
            let mut out_of_range = all & !in_range & if O::ANY_HIT { !results.hit } else { !0 };
            while out_of_range != 0 {
                let lane = take_lane(&mut out_of_range);
                tracer.trace_entries(simd, &rays.get(at + lane), lane, &mut results);
            }
            O::write_packet(simd, &results, outputs, (at, used));
        }
    }
}

/// Queries of a set. Compiled once here, and not in every crate that traces rays.
trait SetQuery: Output {
    /// Traces a stream. False if kernels for lists are not compiled for this level.
    fn trace(
        level: DetectedSimd,
        tracer: &mut EntryTracer<'_, Self>,
        rays: &RayStream,
        outputs: &mut Self::OfStream,
    ) -> bool;

    /// Reads the results of eight rays from index `at` on, of which those of a mask are traced further.
    fn read_packet<S: Simd>(simd: S, outputs: &Self::OfStream, at: usize, mask: u32) -> SetResults<S>;

    /// Writes the results of a number of rays from index `at` on.
    fn write_packet<S: Simd>(simd: S, results: &SetResults<S>, outputs: &mut Self::OfStream, rays: (usize, usize));
}

impl SetQuery for Option<Hit> {
    #[inline(never)]
    fn trace(level: DetectedSimd, tracer: &mut EntryTracer<'_, Self>, rays: &RayStream, hits: &mut HitStream) -> bool {
        level.dispatch_lists(SetTraversal { tracer }, rays, hits)
    }

    #[inline(always)]
    fn read_packet<S: Simd>(simd: S, hits: &HitStream, at: usize, mask: u32) -> SetResults<S> {
        SetResults::read(simd, hits, at, mask)
    }

    #[inline(always)]
    fn write_packet<S: Simd>(simd: S, results: &SetResults<S>, hits: &mut HitStream, (at, _): (usize, usize)) {
        results.write(simd, hits, at);
    }
}

impl SetQuery for bool {
    #[inline(never)]
    fn trace(level: DetectedSimd, tracer: &mut EntryTracer<'_, Self>, rays: &RayStream, occluded: &mut [bool]) -> bool {
        level.dispatch_lists(SetTraversal { tracer }, rays, occluded)
    }

    #[inline(always)]
    fn read_packet<S: Simd>(simd: S, occluded: &[bool], at: usize, mask: u32) -> SetResults<S> {
        let mut results = SetResults::new(simd, mask);
        for (lane, occluded) in occluded.iter().skip(at).take(PACKET).enumerate() {
            results.hit |= u32::from(*occluded) << lane;
        }
        results.active &= !results.hit;
        results
    }

    #[inline(always)]
    fn write_packet<S: Simd>(_: S, results: &SetResults<S>, occluded: &mut [bool], (at, n): (usize, usize)) {
        for (lane, occluded) in occluded.iter_mut().skip(at).take(n).enumerate() {
            *occluded = results.hit >> lane & 1 == 1;
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

    /// [`closest`](Self::closest) for the rays of a stream, with identical results.
    pub fn closest_stream<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        rays: &RayStream,
        hits: &mut HitStream,
        probe: &mut S,
    ) {
        self.trace_stream::<Option<Hit>, _, _>(primitives, rays, hits, probe);
    }

    /// [`occluded`](Self::occluded) for the rays of a stream, with identical results.
    pub fn occluded_stream<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        rays: &RayStream,
        occluded: &mut [bool],
        probe: &mut S,
    ) {
        self.trace_stream::<bool, _, _>(primitives, rays, occluded, probe);
    }
}
