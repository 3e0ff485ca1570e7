//! What a ray is sent for: its first hit, or any.

use core::marker::PhantomData;
use core::mem::MaybeUninit;
use core::ops::ControlFlow;

use rt_math::{DVec3, Hit, Interval, Ray, RoundSphere};

use super::WideBvh;
use super::across::{Across, PACKET};
use super::flight::{Flight, Ground};
use super::leaf::{ExactRay, Filter, FilterSpan, LeafView};
use super::node::Child;
use super::ray::{FilterRay, at_least};
use super::round::RoundSpheres;
use super::simd::Simd;
use super::walk::{Query, Walk};

/// Decides about what the filters leave: the caller's primitives, behind one call.
pub(super) trait Judge {
    /// The hit on a primitive within the span.
    fn closest(&mut self, index: u32, ray: &Ray, span: Interval) -> Option<Hit>;
    /// True if the primitive blocks the ray within the span.
    fn occluded(&mut self, index: u32, ray: &Ray, span: Interval) -> bool;
    /// The primitive's numbers, if it is one about which a structure may decide by them.
    fn round(&mut self, index: u32) -> Option<RoundSphere>;
    /// True if the primitive is a structure, which answers several rays faster together.
    fn is_structure(&mut self, index: u32) -> bool;
    /// As [`closest`](Self::closest), for several rays: `hits[i]` answers `rays[i]`.
    fn closest_together(&mut self, index: u32, rays: &[(Ray, Interval)], hits: &mut [Option<Hit>]);
    /// As [`occluded`](Self::occluded), for several rays: `blocked[i]` answers `rays[i]`.
    fn occluded_together(&mut self, index: u32, rays: &[(Ray, Interval)], blocked: &mut [bool]);
    /// The first hit on primitives without bounds.
    fn closest_unbounded(&mut self, ray: &Ray, span: Interval) -> Option<Hit>;
    /// True if a primitive without bounds blocks the ray.
    fn occluded_unbounded(&mut self, ray: &Ray, span: Interval) -> bool;
    /// The first hit on bounded primitives, by a walk that needs no filters.
    fn closest_unfiltered(&mut self, ray: &Ray, span: Interval) -> Option<Hit>;
    /// True if bounded primitives block the ray, by a walk that needs no filters.
    fn occluded_unfiltered(&mut self, ray: &Ray, span: Interval) -> bool;
}

/// A ray on its way, prepared for boxes and for the primitives of leaves.
pub(super) struct Prepared<'r, S: Simd, F> {
    pub(super) ray: ExactRay<'r, S>,
    pub(super) boxes: FilterRay,
    pub(super) min: f32,
    pub(super) filter: F,
}

impl<'r, S: Simd, F: Filter> Prepared<'r, S, F> {
    /// `None` where the filters are not proven.
    #[inline(always)]
    pub(super) fn new(simd: S, tree: &WideBvh, ray: &'r Ray, span: Interval) -> Option<Self> {
        let ray = ExactRay::new(simd, ray);
        let boxes = FilterRay::new(simd, &ray.lanes, span, tree.centre, tree.size)?;
        let span = FilterSpan::new(simd, span);
        Some(Self { min: span.min(), filter: F::new(simd, &ray, &boxes, span, tree), ray, boxes })
    }
}

/// The lowest lane of a mask that is not 0, which loses it.
#[inline(always)]
pub(super) fn take_lane(mask: &mut u32) -> usize {
    let lane = mask.trailing_zeros() as usize;
    *mask &= *mask - 1;
    lane & 7
}

/// What a ray is sent for, and what it has found of it.
pub(super) trait Goal: Sized {
    /// True if what is nearer should be visited first.
    const ORDERED: bool;
    /// What is found in the end.
    type Answer: Copy + Default;

    /// Sends one ray. Not generic where it is implemented, so that it is compiled once and not by all who ask.
    fn walk(tree: &WideBvh, query: &mut Query<'_, Self::Answer>, ray: &Ray, span: Interval);

    /// Sends many rays, as [`walk`](Self::walk) sends one.
    fn fly(tree: &WideBvh, ground: &mut Ground<'_>, rays: &[(Ray, Interval)], answers: &mut [Self::Answer]);

    /// Nothing has been found yet.
    fn new(span: Interval) -> Self;

    /// Asks the primitives without bounds; breaks if nothing else matters.
    fn visit_unbounded(&mut self, judge: &mut dyn Judge, ray: &Ray) -> ControlFlow<()>;

    /// Walks without filters.
    fn visit_unfiltered(&mut self, judge: &mut dyn Judge, ray: &Ray);

    /// What is entered after this does not matter; negative if nothing matters.
    fn limit(&self) -> f32;

    /// Visits a leaf; breaks if nothing else matters.
    fn visit<S: Simd, F: Filter>(
        &mut self,
        simd: S,
        tree: &WideBvh,
        judge: &mut dyn Judge,
        prepared: &Prepared<'_, S, F>,
        leaf: Child,
    ) -> ControlFlow<()>;

    /// Considers one primitive that the filter has not ruled out, and between what it is hit if that is sure.
    #[expect(clippy::too_many_arguments, reason = "as `visit`, for one primitive")]
    fn consider<S: Simd, F: Filter>(
        &mut self,
        simd: S,
        tree: &WideBvh,
        judge: &mut dyn Judge,
        ray: &Ray,
        leaf: Child,
        lane: usize,
        sure: Option<[f32; 2]>,
    );

    /// The span within which something may still matter.
    fn span(&self) -> Interval;

    /// Asks a structure for several rays.
    fn ask_together(judge: &mut dyn Judge, index: u32, rays: &[(Ray, Interval)], answers: &mut [Self::Answer]);

    /// Considers what somebody else has found within the span.
    fn take(&mut self, found: Self::Answer);

    /// Decides about what has been put off, and writes what has been found where it is wanted: an answer that is moved on as a
    /// whole would wait until all its numbers are in memory.
    fn finish<S: Simd, F: Filter>(
        &mut self,
        simd: S,
        tree: &WideBvh,
        judge: &mut dyn Judge,
        ray: &ExactRay<'_, S>,
        answer: &mut Self::Answer,
    );

    /// As [`finish`](Self::finish), for those of eight rays for which it takes no more than a sphere each: a bit for each
    /// that is answered.
    #[inline(always)]
    fn finish_round<S: Simd, F: Filter>(
        _: S,
        _: &WideBvh,
        _: &mut dyn Judge,
        _: &Across<S>,
        _: &[Self; PACKET],
        _: &mut [Self::Answer; PACKET],
    ) -> u32 {
        0
    }

    /// Hits that no judge has counted.
    fn uncounted_hits(&self) -> u64;

    /// What blocks the ray, if that is all that it was sent to find out, and it was found in a leaf.
    #[inline(always)]
    fn blocker(&self) -> Option<Place> {
        None
    }

    /// What has been found so far.
    fn answer(&self) -> Self::Answer;
}

/// A primitive, by where it is in a tree.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub(super) leaf: Child,
    pub(super) lane: usize,
}

/// A primitive that is hit for sure, to be decided about at the end.
#[derive(Clone, Copy)]
struct Candidate {
    near: f32,
    leaf: Child,
    lane: usize,
}

/// Candidates that may be undecided at a time.
const MAX_CANDIDATES: usize = 8;

const NO_HIT: Hit = Hit { t: f64::INFINITY, instance: 0, primitive: 0, uv: [0.0; 2] };

/// The nearest hit so far, and who may still be nearer.
pub(super) struct FirstHit {
    uncounted_hits: u64,
    /// Ends at the nearest hit.
    span: Interval,
    is_hit: bool,
    /// The nearest hit, if there is one.
    best: Hit,
    /// What is entered or hit after this cannot be first.
    limit: f32,
    candidates: [MaybeUninit<Candidate>; MAX_CANDIDATES],
    n_candidates: usize,
    /// Of all candidates.
    least_near: f32,
}

impl FirstHit {
    /// A hit that precedes all before it.
    #[inline(always)]
    fn accept(&mut self, hit: &Hit) {
        self.span.max = hit.t;
        self.limit = self.limit.min(at_least(hit.t));
        self.is_hit = true;
        // One number after the other: all at once would have to wait until they are in memory.
        self.best.t = hit.t;
        self.best.instance = hit.instance;
        self.best.primitive = hit.primitive;
        self.best.uv[0] = hit.uv[0];
        self.best.uv[1] = hit.uv[1];
    }

    /// The usual case: one hit that is certain, before all others.
    #[inline(always)]
    fn only_candidate(&self) -> Option<Candidate> {
        // SAFETY: the first has been written where there is one.
        (self.n_candidates == 1 && !self.is_hit).then(|| unsafe { self.candidates[0].assume_init() })
    }

    #[inline(always)]
    fn decide<S: Simd, F: Filter>(
        &mut self,
        simd: S,
        judge: &mut dyn Judge,
        ray: &ExactRay<'_, S>,
        leaf: LeafView<'_>,
        lane: usize,
    ) {
        let hit = F::hit(simd, leaf, lane, ray, self.span, judge);
        self.uncounted_hits += u64::from(hit.is_some() && F::decides(leaf, lane));
        self.take(hit);
    }

    /// A hit is certain: nothing behind its far bound can be first. False if there is no room to remember it.
    #[inline(always)]
    fn remember(&mut self, leaf: Child, lane: usize, [near, far]: [f32; 2]) -> bool {
        if near > self.limit {
            return true;
        }
        if far < self.least_near {
            // The usual case: nearer than all others for sure.
            self.n_candidates = 0;
            self.least_near = near;
        } else {
            self.least_near = self.least_near.min(near);
        }
        self.limit = self.limit.min(far);
        let has_room = self.n_candidates < MAX_CANDIDATES;
        if has_room {
            self.candidates[self.n_candidates % MAX_CANDIDATES].write(Candidate { near, leaf, lane });
            self.n_candidates += 1;
        }
        has_room
    }
}

impl Goal for FirstHit {
    const ORDERED: bool = true;
    type Answer = Option<Hit>;

    #[inline(never)]
    fn walk(tree: &WideBvh, query: &mut Query<'_, Self::Answer>, ray: &Ray, span: Interval) {
        tree.level.dispatch(Walk::<Self> { tree, query, goal: PhantomData }, ray, span);
    }

    #[inline(never)]
    fn fly(tree: &WideBvh, ground: &mut Ground<'_>, rays: &[(Ray, Interval)], answers: &mut [Self::Answer]) {
        tree.level.dispatch(Flight::<Self> { tree, ground, goal: PhantomData }, rays, answers);
    }

    #[inline(always)]
    fn new(span: Interval) -> Self {
        Self {
            uncounted_hits: 0,
            span,
            is_hit: false,
            best: NO_HIT,
            limit: at_least(span.max),
            candidates: [const { MaybeUninit::uninit() }; MAX_CANDIDATES],
            n_candidates: 0,
            least_near: f32::INFINITY,
        }
    }

    fn visit_unbounded(&mut self, judge: &mut dyn Judge, ray: &Ray) -> ControlFlow<()> {
        // What is equally near, but of lower index, must still be found.
        if let Some(hit) = judge.closest_unbounded(ray, self.span) {
            self.accept(&hit);
        }
        ControlFlow::Continue(())
    }

    fn visit_unfiltered(&mut self, judge: &mut dyn Judge, ray: &Ray) {
        let found = judge.closest_unfiltered(ray, self.span);
        self.take(found);
    }

    #[inline(always)]
    fn limit(&self) -> f32 {
        self.limit
    }

    #[inline(always)]
    fn visit<S: Simd, F: Filter>(
        &mut self,
        simd: S,
        tree: &WideBvh,
        judge: &mut dyn Judge,
        prepared: &Prepared<'_, S, F>,
        leaf: Child,
    ) -> ControlFlow<()> {
        let view = tree.leaves.view(leaf);
        let verdict = prepared.filter.judge(simd, view, self.limit);
        if verdict.maybe == 0 {
            return ControlFlow::Continue(());
        }
        let (mut sure, mut unsure) = (verdict.sure, verdict.maybe & !verdict.sure);
        if sure != 0 {
            let (near, far) = (simd.to_array(verdict.near), simd.to_array(verdict.far));
            while sure != 0 {
                let lane = take_lane(&mut sure);
                if !self.remember(leaf, lane, [near[lane], far[lane]]) {
                    unsure |= 1 << lane;
                }
            }
        }
        while unsure != 0 {
            let lane = take_lane(&mut unsure);
            self.decide::<S, F>(simd, judge, &prepared.ray, view, lane);
        }
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn consider<S: Simd, F: Filter>(
        &mut self,
        simd: S,
        tree: &WideBvh,
        judge: &mut dyn Judge,
        ray: &Ray,
        leaf: Child,
        lane: usize,
        sure: Option<[f32; 2]>,
    ) {
        if sure.is_none_or(|bounds| !self.remember(leaf, lane, bounds)) {
            self.decide::<S, F>(simd, judge, &ExactRay::new(simd, ray), tree.leaves.view(leaf), lane);
        }
    }

    #[inline(always)]
    fn span(&self) -> Interval {
        self.span
    }

    fn ask_together(judge: &mut dyn Judge, index: u32, rays: &[(Ray, Interval)], answers: &mut [Self::Answer]) {
        judge.closest_together(index, rays, answers);
    }

    #[inline(always)]
    fn take(&mut self, found: Option<Hit>) {
        if let Some(hit) = found
            && (!self.is_hit | hit.precedes(&self.best))
        {
            self.accept(&hit);
        }
    }

    #[inline(always)]
    fn finish<S: Simd, F: Filter>(
        &mut self,
        simd: S,
        tree: &WideBvh,
        judge: &mut dyn Judge,
        ray: &ExactRay<'_, S>,
        answer: &mut Option<Hit>,
    ) {
        if let Some(Candidate { leaf, lane, .. }) = self.only_candidate() {
            // Where leaves decide, nothing is asked, so that the next ray need not wait.
            let leaf = tree.leaves.view(leaf);
            if F::decides(leaf, lane) {
                *answer = F::copied_hit::<S, true>(simd, leaf, lane, ray, self.span);
                self.uncounted_hits += u64::from(answer.is_some());
            } else {
                *answer = judge.closest(F::index(leaf, lane), ray.ray, self.span);
            }
            return;
        }
        for i in 0..self.n_candidates {
            // SAFETY: the first `n_candidates` have been written.
            let Candidate { near, leaf, lane } = unsafe { self.candidates[i % MAX_CANDIDATES].assume_init() };
            if near <= self.limit {
                self.decide::<S, F>(simd, judge, ray, tree.leaves.view(leaf), lane);
            }
        }
        *answer = self.answer();
    }

    #[inline(always)]
    fn finish_round<S: Simd, F: Filter>(
        simd: S,
        tree: &WideBvh,
        judge: &mut dyn Judge,
        rays: &Across<S>,
        goals: &[Self; PACKET],
        answers: &mut [Option<Hit>; PACKET],
    ) -> u32 {
        let mut spheres = [RoundSphere { centre: DVec3::ZERO, radius: 1.0 }; PACKET];
        let mut indices = [0; PACKET];
        let mut who = 0;
        for (lane, goal) in goals.iter().enumerate() {
            let Some(candidate) = goal.only_candidate() else { continue };
            let index = F::index(tree.leaves.view(candidate.leaf), candidate.lane);
            if let Some(sphere) = judge.round(index) {
                (spheres[lane], indices[lane]) = (sphere, index);
                who |= 1 << lane;
            }
        }
        if who == 0 {
            return 0;
        }
        let meetings = RoundSpheres::new(simd, &spheres).meet(simd, &rays.lanes);
        who &= meetings.hit;
        let t = meetings.t.to_array(simd);
        for (lane, answer) in answers.iter_mut().enumerate() {
            if who >> lane & 1 != 0 {
                *answer = Some(Hit { t: t[lane], instance: 0, primitive: indices[lane], uv: [0.0; 2] });
            }
        }
        who
    }

    #[inline(always)]
    fn uncounted_hits(&self) -> u64 {
        self.uncounted_hits
    }

    #[inline(always)]
    fn answer(&self) -> Option<Hit> {
        self.is_hit.then_some(self.best)
    }
}

/// Whether anything blocks the ray.
pub(super) struct AnyHit {
    span: Interval,
    uncounted_hits: u64,
    is_blocked: bool,
    blocker: Option<Place>,
    limit: f32,
}

impl AnyHit {
    /// Something blocks the ray: nothing else matters.
    #[inline(always)]
    fn block(&mut self) {
        self.is_blocked = true;
        self.limit = -1.0;
    }

    /// A primitive in a leaf blocks the ray.
    #[inline(always)]
    fn block_by(&mut self, leaf: Child, lane: usize) {
        self.block();
        self.blocker = Some(Place { leaf, lane });
    }
}

impl Goal for AnyHit {
    const ORDERED: bool = false;
    type Answer = bool;

    #[inline(never)]
    fn walk(tree: &WideBvh, query: &mut Query<'_, Self::Answer>, ray: &Ray, span: Interval) {
        tree.level.dispatch(Walk::<Self> { tree, query, goal: PhantomData }, ray, span);
    }

    #[inline(never)]
    fn fly(tree: &WideBvh, ground: &mut Ground<'_>, rays: &[(Ray, Interval)], answers: &mut [Self::Answer]) {
        tree.level.dispatch(Flight::<Self> { tree, ground, goal: PhantomData }, rays, answers);
    }

    #[inline(always)]
    fn new(span: Interval) -> Self {
        Self { span, uncounted_hits: 0, is_blocked: false, blocker: None, limit: at_least(span.max) }
    }

    fn visit_unbounded(&mut self, judge: &mut dyn Judge, ray: &Ray) -> ControlFlow<()> {
        if judge.occluded_unbounded(ray, self.span) {
            self.block();
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }

    fn visit_unfiltered(&mut self, judge: &mut dyn Judge, ray: &Ray) {
        self.is_blocked = judge.occluded_unfiltered(ray, self.span);
    }

    #[inline(always)]
    fn limit(&self) -> f32 {
        self.limit
    }

    #[inline(always)]
    fn visit<S: Simd, F: Filter>(
        &mut self,
        simd: S,
        tree: &WideBvh,
        judge: &mut dyn Judge,
        prepared: &Prepared<'_, S, F>,
        leaf: Child,
    ) -> ControlFlow<()> {
        let view = tree.leaves.view(leaf);
        let verdict = prepared.filter.judge(simd, view, self.limit);
        if verdict.sure != 0 {
            self.uncounted_hits += 1;
            self.block_by(leaf, verdict.sure.trailing_zeros() as usize);
            return ControlFlow::Break(());
        }
        let mut unsure = verdict.maybe;
        while unsure != 0 {
            let lane = take_lane(&mut unsure);
            if F::blocks(simd, view, lane, &prepared.ray, self.span, judge) {
                self.uncounted_hits += u64::from(F::decides(view, lane));
                self.block_by(leaf, lane);
                return ControlFlow::Break(());
            }
        }
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn consider<S: Simd, F: Filter>(
        &mut self,
        simd: S,
        tree: &WideBvh,
        judge: &mut dyn Judge,
        ray: &Ray,
        leaf: Child,
        lane: usize,
        sure: Option<[f32; 2]>,
    ) {
        let view = tree.leaves.view(leaf);
        if sure.is_some() {
            self.uncounted_hits += 1;
            self.block_by(leaf, lane);
        } else if F::blocks(simd, view, lane, &ExactRay::new(simd, ray), self.span, judge) {
            self.uncounted_hits += u64::from(F::decides(view, lane));
            self.block_by(leaf, lane);
        }
    }

    #[inline(always)]
    fn span(&self) -> Interval {
        self.span
    }

    fn ask_together(judge: &mut dyn Judge, index: u32, rays: &[(Ray, Interval)], answers: &mut [Self::Answer]) {
        judge.occluded_together(index, rays, answers);
    }

    #[inline(always)]
    fn take(&mut self, found: bool) {
        if found {
            self.block();
        }
    }

    #[inline(always)]
    fn finish<S: Simd, F: Filter>(
        &mut self,
        _: S,
        _: &WideBvh,
        _: &mut dyn Judge,
        _: &ExactRay<'_, S>,
        answer: &mut bool,
    ) {
        *answer = self.is_blocked;
    }

    #[inline(always)]
    fn uncounted_hits(&self) -> u64 {
        self.uncounted_hits
    }

    #[inline(always)]
    fn blocker(&self) -> Option<Place> {
        self.blocker
    }

    #[inline(always)]
    fn answer(&self) -> bool {
        self.is_blocked
    }
}
