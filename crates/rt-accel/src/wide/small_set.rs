//! A handful of primitives, without a tree: each is asked in turn, spheres and triangles for eight rays at a time, and what is
//! a structure itself for all rays of a batch.

use crate::{Accelerator, RayQuery};
use rt_geometry::{
    BatchKernel, Hit, Primitives, Probe, intersect_primitive_batch, intersect_primitive_uncounted,
    occludes_primitive_batch, occludes_primitive_uncounted,
};
use rt_math::{Interval, Ray};

use super::packet::FEW;
use super::packet_rays::{PACKET, PacketHit, RaySoa8, pad_to_packet};
use super::packet_spheres::SpherePacket;
use super::packet_triangles;
use super::query::take_lane;
use super::simd::{DetectedSimd, Simd, SimdLevel, WithSimd};
use super::single_ray::Work;
use crate::ray_query::{Any, Closest};

/// Rays that a structure is asked for at a time, so that what is copied of them does not grow with batches.
const AT_ONCE: usize = 1024;

/// A few primitives of a set, as a structure over the set: hits are those on these primitives, and named as in the set.
///
/// All are asked in turn, by rising index, with the answers and [`Counters`](crate::Counters) of
/// [`brute_force`](crate::brute_force), to the last bit and the last test. In batches, those that are
/// [`BatchKernel::Sphere`] or [`BatchKernel::Triangle`] are decided about for eight rays at a time, and [`BatchKernel::Instance`]s
/// are asked for many rays of the batch together, whose own work is then that of batches.
///
/// ```
/// use rt_accel::{Aabb, Accelerator, Boxes, DVec3, Interval, NoProbe, Ray, wide::SmallSet};
///
/// let boxes = [0.0, 2.0, 4.0].map(|x| Aabb::new(DVec3::splat(x), DVec3::splat(x + 1.0)));
/// let all_but_the_first = SmallSet::new([2, 1]).expect("no more than there is room for");
/// let ray = Ray::new(DVec3::splat(-1.0), DVec3::ONE);
/// let hit = all_but_the_first.closest(&Boxes(&boxes), &ray, Interval::FORWARD, &mut NoProbe);
/// assert_eq!(hit.map(|hit| hit.primitive), Some(1));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SmallSet {
    /// Rising.
    indices: [u32; Self::MOST],
    len: usize,
    level: DetectedSimd,
}

impl SmallSet {
    /// What there is room for.
    pub const MOST: usize = 16;

    /// The primitives of these indices, in any order; one that is named twice is asked twice. `None` if they are too many.
    pub fn new(indices: impl IntoIterator<Item = u32>) -> Option<Self> {
        let mut this = Self { indices: [0; Self::MOST], len: 0, level: DetectedSimd::default() };
        for index in indices {
            *this.indices.get_mut(this.len)? = index;
            this.len += 1;
        }
        this.indices.get_mut(..this.len)?.sort_unstable();
        Some(this)
    }

    /// The same primitives, asked by other instructions: for tests and comparisons, as the best that the processor has are
    /// chosen otherwise. What the processor does not have is replaced by the portable level.
    #[must_use]
    pub fn with_level(mut self, level: SimdLevel) -> Self {
        self.level = DetectedSimd::new(level);
        self
    }

    /// The indices of the primitives, rising.
    pub fn indices(&self) -> &[u32] {
        self.indices.get(..self.len).unwrap_or(&[])
    }

    /// Asks for all rays of a batch. Single rays are asked for by `decider`.
    fn ask<A: Answer, P: Primitives, D: Decider<A>>(
        &self,
        primitives: &P,
        rays: &[(Ray, Interval)],
        answers: &mut [A],
        decider: &mut D,
    ) -> Work {
        let n = rays.len().min(answers.len());
        let (rays, answers) = (rays.get(..n).unwrap_or(&[]), answers.get_mut(..n).unwrap_or(&mut []));
        let mut members = [Member::NONE; Self::MOST];
        for (member, &index) in members.iter_mut().zip(self.indices()) {
            *member = Member::of(primitives, index);
        }
        let members = members.get(..self.len).unwrap_or(&[]);
        if members.is_empty() {
            answers.fill(A::default());
        }
        let mut batch = Batch { members, indices: &[], is_first: true, decider, work: Work::default() };
        let mut indices = self.indices();
        for members in members.chunk_by(|a, b| !a.is_structure() && !b.is_structure()) {
            batch.members = members;
            (batch.indices, indices) = indices.split_at(members.len());
            match members {
                [member] if member.is_structure() => batch.ask_structure(member.index, rays, answers),
                _ if members.iter().any(Member::is_known) => self.level.dispatch(&mut batch, rays, answers),
                _ => batch.ask_alone(rays, answers),
            }
            batch.is_first = false;
        }
        batch.work
    }
}

/// One of the handful.
#[derive(Clone, Copy)]
struct Member {
    index: u32,
    /// Instance and primitive of its hits.
    name: [u32; 2],
    blocks: bool,
    kernel: BatchKernel,
}

impl Member {
    const NONE: Self = Self { index: 0, name: [0; 2], blocks: false, kernel: BatchKernel::Single };

    fn of<P: Primitives>(primitives: &P, index: u32) -> Self {
        Self {
            index,
            name: primitives.hit_ids(index),
            blocks: primitives.blocks(index),
            kernel: primitives.batch_kernel(index),
        }
    }

    const fn is_structure(&self) -> bool {
        matches!(self.kernel, BatchKernel::Instance)
    }

    /// True if it is decided about in lanes.
    const fn is_known(&self) -> bool {
        matches!(self.kernel, BatchKernel::Sphere(_) | BatchKernel::Triangle(_))
    }
}

/// What has been found for a ray.
trait Answer: Copy + Default {
    /// True if what blocks no ray matters.
    const SEES_ALL: bool;

    /// True if nothing else matters.
    fn is_final(&self) -> bool;

    /// The end of what matters of a span.
    fn end(&self, max: f64) -> f64;

    /// Takes what one primitive has to say into account.
    fn consider(&mut self, found: Self);

    /// As [`consider`](Self::consider), of a hit within the whole span; true if it is within what matters.
    fn consider_hit(&mut self, hit: Hit) -> bool;
}

impl Answer for Option<Hit> {
    const SEES_ALL: bool = true;

    #[inline(always)]
    fn is_final(&self) -> bool {
        false
    }

    #[inline(always)]
    fn end(&self, max: f64) -> f64 {
        self.map_or(max, |hit| hit.t)
    }

    #[inline(always)]
    fn consider(&mut self, found: Self) {
        if let Some(hit) = found
            && self.is_none_or(|nearest| hit.precedes(&nearest))
        {
            *self = Some(hit);
        }
    }

    #[inline(always)]
    fn consider_hit(&mut self, hit: Hit) -> bool {
        let matters = self.is_none_or(|nearest| hit.t <= nearest.t);
        if matters {
            self.consider(Some(hit));
        }
        matters
    }
}

impl Answer for bool {
    const SEES_ALL: bool = false;

    #[inline(always)]
    fn is_final(&self) -> bool {
        *self
    }

    #[inline(always)]
    fn end(&self, max: f64) -> f64 {
        max
    }

    #[inline(always)]
    fn consider(&mut self, found: Self) {
        *self |= found;
    }

    #[inline(always)]
    fn consider_hit(&mut self, _: Hit) -> bool {
        *self = true;
        true
    }
}

/// Decides in the name of the primitives, and counts.
trait Decider<A> {
    /// About one of them, whose test has been counted.
    fn decide(&mut self, index: u32, ray: &Ray, span: Interval) -> A;

    /// About some of them, whose tests have not been counted.
    fn decide_all(&mut self, indices: &[u32], ray: &Ray, span: Interval) -> A;

    /// About one of them, for many rays whose tests have been counted: `answers[i]` is for `rays[i]`.
    fn decide_for_all(&mut self, index: u32, rays: &[(Ray, Interval)], answers: &mut [A]);
}

/// The primitives of a query.
struct Members<'a, P, S> {
    primitives: &'a P,
    probe: &'a mut S,
}

impl<P: Primitives, S: Probe> Decider<Option<Hit>> for Members<'_, P, S> {
    fn decide(&mut self, index: u32, ray: &Ray, span: Interval) -> Option<Hit> {
        intersect_primitive_uncounted(self.primitives, index, ray, span, self.probe)
    }

    fn decide_all(&mut self, indices: &[u32], ray: &Ray, span: Interval) -> Option<Hit> {
        let mut query = Closest::new(ray, span);
        let _ = query.offer_all(self.primitives, indices, self.probe);
        query.hit
    }

    fn decide_for_all(&mut self, index: u32, rays: &[(Ray, Interval)], hits: &mut [Option<Hit>]) {
        intersect_primitive_batch(self.primitives, index, rays, hits, self.probe);
    }
}

impl<P: Primitives, S: Probe> Decider<bool> for Members<'_, P, S> {
    fn decide(&mut self, index: u32, ray: &Ray, span: Interval) -> bool {
        occludes_primitive_uncounted(self.primitives, index, ray, span, self.probe)
    }

    fn decide_all(&mut self, indices: &[u32], ray: &Ray, span: Interval) -> bool {
        Any::new(ray, span).offer_all(self.primitives, indices, self.probe).is_break()
    }

    fn decide_for_all(&mut self, index: u32, rays: &[(Ray, Interval)], blocked: &mut [bool]) {
        occludes_primitive_batch(self.primitives, index, rays, blocked, self.probe);
    }
}

/// A batch that is asked for.
struct Batch<'a, A> {
    /// Those who are asked now.
    members: &'a [Member],
    indices: &'a [u32],
    /// True if nobody has been asked before them.
    is_first: bool,
    decider: &'a mut dyn Decider<A>,
    /// Beside what the decider has counted.
    work: Work,
}

impl<A: Answer> WithSimd<&[(Ray, Interval)], &mut [A]> for &mut Batch<'_, A> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S, rays: &[(Ray, Interval)], answers: &mut [A]) {
        for (rays, answers) in rays.chunks(PACKET).zip(answers.chunks_mut(PACKET)) {
            if let Ok(rays) = rays.try_into() {
                self.ask_eight(simd, rays, answers);
            } else if rays.len() <= FEW as usize {
                self.ask_alone(rays, answers);
            } else {
                self.ask_eight(simd, &pad_to_packet(rays), answers);
            }
        }
    }
}

impl<A: Answer> Batch<'_, A> {
    /// Asks for each ray by itself.
    fn ask_alone(&mut self, rays: &[(Ray, Interval)], answers: &mut [A]) {
        for ((ray, span), answer) in rays.iter().zip(answers) {
            self.ask_for(ray, *span, answer);
        }
    }

    /// Asks for one ray.
    fn ask_for(&mut self, ray: &Ray, span: Interval, answer: &mut A) {
        if self.is_first {
            *answer = self.decider.decide_all(self.indices, ray, span);
            return;
        }
        for member in self.members {
            if answer.is_final() {
                return;
            }
            self.work.tests += 1;
            let span = Interval { max: answer.end(span.max), ..span };
            answer.consider(self.decider.decide(member.index, ray, span));
        }
    }

    /// Asks a structure for all rays for which something else may still matter.
    fn ask_structure(&mut self, index: u32, rays: &[(Ray, Interval)], answers: &mut [A]) {
        for (rays, answers) in rays.chunks(AT_ONCE).zip(answers.chunks_mut(AT_ONCE)) {
            if self.is_first {
                answers.fill(A::default());
                self.work.tests += rays.len() as u64;
                self.decider.decide_for_all(index, rays, answers);
            } else {
                self.ask_structure_on(index, rays, answers);
            }
        }
    }

    /// As [`ask_structure`](Self::ask_structure), where others have been asked before.
    fn ask_structure_on(&mut self, index: u32, rays: &[(Ray, Interval)], answers: &mut [A]) {
        // Memory for some hundred rays together, and not for each.
        let mut who = Vec::with_capacity(rays.len());
        let mut asking = Vec::with_capacity(rays.len());
        for (at, ((ray, span), answer)) in rays.iter().zip(&*answers).enumerate() {
            if !answer.is_final() {
                who.push(at);
                asking.push((*ray, Interval { max: answer.end(span.max), ..*span }));
            }
        }
        self.work.tests += asking.len() as u64;
        let mut found = vec![A::default(); asking.len()];
        self.decider.decide_for_all(index, &asking, &mut found);
        for (at, found) in who.into_iter().zip(found) {
            if let Some(answer) = answers.get_mut(at) {
                answer.consider(found);
            }
        }
    }

    /// Takes the certain hits of some rays on a member into account.
    #[inline(always)]
    fn take_hits<S: Simd>(
        &mut self,
        simd: S,
        [instance, primitive]: [u32; 2],
        asked: u32,
        meetings: &PacketHit<S>,
        found: &mut [A; PACKET],
    ) {
        let [v, w] = meetings.uv;
        let (t, v, w) = (meetings.t.to_array(simd), v.to_array(simd), w.to_array(simd));
        let mut hit = asked & meetings.hit;
        while hit != 0 {
            let lane = take_lane(&mut hit);
            let hit = Hit { t: t[lane], instance, primitive, uv: [v[lane], w[lane]] };
            self.work.hits += u64::from(found[lane].consider_hit(hit));
        }
    }

    /// Asks for as many of eight rays as there are answers.
    #[inline(always)]
    fn ask_eight<S: Simd>(&mut self, simd: S, rays: &[(Ray, Interval); PACKET], answers: &mut [A]) {
        let lanes = RaySoa8::new(simd, rays);
        let all = (1 << answers.len().min(PACKET)) - 1;
        let plain = lanes.plain(simd) & all;
        let mut asking = plain;
        let by_axis = lanes.by_steepest_axis(simd);
        let mut found = [A::default(); PACKET];
        if !self.is_first {
            for (lane, (found, answer)) in found.iter_mut().zip(&*answers).enumerate() {
                *found = *answer;
                asking &= !(u32::from(found.is_final()) << lane);
            }
        }
        for Member { index, name, blocks, kernel } in self.members {
            if asking == 0 {
                break;
            }
            self.work.tests += u64::from(asking.count_ones());
            if !(A::SEES_ALL || *blocks) {
                continue;
            }
            let unsure = match kernel {
                BatchKernel::Sphere(sphere) => {
                    let spheres = SpherePacket::all(simd, sphere);
                    let maybe = asking & !spheres.miss_mask(simd, &lanes);
                    if maybe == 0 {
                        continue;
                    }
                    let meetings = spheres.meet(simd, &lanes);
                    self.take_hits(simd, *name, maybe, &meetings, &mut found);
                    maybe & meetings.unsure
                }
                BatchKernel::Triangle([a, b, c]) => {
                    let vertices = [a.as_dvec3(), b.as_dvec3(), c.as_dvec3()];
                    let mut unsure = 0;
                    for (axis, rays) in by_axis.iter().enumerate() {
                        let asked = asking & rays;
                        if asked == 0 {
                            continue;
                        }
                        let Some(meetings) = packet_triangles::meet(simd, &vertices, axis, &lanes, asked) else {
                            continue;
                        };
                        self.take_hits(simd, *name, asked, &meetings, &mut found);
                        unsure |= meetings.unsure;
                    }
                    unsure
                }
                BatchKernel::Instance | BatchKernel::Single => asking,
            };
            let mut left = unsure;
            while left != 0 {
                let lane = take_lane(&mut left);
                let (ray, span) = &rays[lane];
                let span = Interval { max: found[lane].end(span.max), ..*span };
                found[lane].consider(self.decider.decide(*index, ray, span));
            }
            for (lane, found) in found.iter().enumerate() {
                asking &= !(u32::from(found.is_final()) << lane);
            }
        }
        for (lane, answer) in answers.iter_mut().enumerate().take(PACKET) {
            if plain >> lane & 1 != 0 {
                *answer = found[lane];
            } else {
                let (ray, span) = &rays[lane];
                self.ask_for(ray, *span, answer);
            }
        }
    }
}

impl Accelerator for SmallSet {
    fn closest<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        ray: &Ray,
        span: Interval,
        probe: &mut S,
    ) -> Option<Hit> {
        Members { primitives, probe }.decide_all(self.indices(), ray, span)
    }

    fn occluded<P: Primitives, S: Probe>(&self, primitives: &P, ray: &Ray, span: Interval, probe: &mut S) -> bool {
        Members { primitives, probe }.decide_all(self.indices(), ray, span)
    }

    fn closest_batch<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        rays: &[(Ray, Interval)],
        hits: &mut [Option<Hit>],
        probe: &mut S,
    ) {
        let Work { nodes, tests, hits } = self.ask(primitives, rays, hits, &mut Members { primitives, probe });
        probe.work(nodes, tests, hits);
    }

    fn occluded_batch<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        rays: &[(Ray, Interval)],
        blocked: &mut [bool],
        probe: &mut S,
    ) {
        let Work { nodes, tests, hits } = self.ask(primitives, rays, blocked, &mut Members { primitives, probe });
        probe.work(nodes, tests, hits);
    }
}
