//! The first hit of a ray.

use core::marker::PhantomData;
use core::mem::MaybeUninit;
use core::ops::ControlFlow;

use rt_geometry::{Hit, SphereKernel};
use rt_math::{DVec3, Interval, Ray};

use super::{Goal, Place, PrimitiveTester, TravRay, take_lane};
use crate::wide::batch::{Flight, Ground};
use crate::wide::leaf::{Lane, LeafTest, LeafView, RayF64};
use crate::wide::packet_rays::{PACKET, RayPacket};
use crate::wide::single_ray::{Query, Walk};
use crate::{
    wide::WideBvh, wide::node::Child, wide::packet_spheres::SpherePacket, wide::ray::round_up, wide::simd::Simd,
};

/// A primitive that is hit for sure, to be decided about at the end.
#[derive(Clone, Copy)]
struct Candidate {
    near: f32,
    place: Place,
}

/// Candidates that may be undecided at a time.
const MAX_CANDIDATES: usize = 8;

const NO_HIT: Hit = Hit { t: f64::INFINITY, instance: 0, primitive: 0, uv: [0.0; 2] };

/// The nearest hit so far, and who may still be nearer.
pub(in crate::wide) struct FirstHit {
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
        self.limit = self.limit.min(round_up(hit.t));
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
    fn decide<S: Simd, F: LeafTest>(
        &mut self,
        simd: S,
        tester: &mut dyn PrimitiveTester,
        ray: &RayF64<'_, S>,
        leaf: LeafView<'_>,
        lane: Lane,
    ) {
        let hit = F::hit(simd, leaf, lane, ray, self.span, tester);
        self.uncounted_hits += u64::from(hit.is_some() && F::is_exact(leaf, lane));
        self.take(hit);
    }

    /// A hit is certain: nothing behind its far bound can be first. False if there is no room to remember it.
    #[inline(always)]
    fn remember(&mut self, place: Place, [near, far]: [f32; 2]) -> bool {
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
            self.candidates[self.n_candidates % MAX_CANDIDATES].write(Candidate { near, place });
            self.n_candidates += 1;
        }
        has_room
    }
}

/// What eight rays certainly hit, each nothing or one primitive.
pub(in crate::wide) struct FoundFirst<S: Simd> {
    /// A bit for each ray that hits something.
    who: u32,
    /// Where it is hit at the earliest, and where in the tree it is: as bits that are moved and compared as such, as they may be no
    /// numbers.
    near: S::F32x8,
    leaf: S::F32x8,
    lane: S::F32x8,
}

impl<S: Simd> FoundFirst<S> {
    /// By ray: the leaf and the lane of what it hits; meaningless where it hits nothing.
    #[inline(always)]
    fn places(&self, simd: S) -> [(Child, Lane); PACKET] {
        let (leaf, lane) = (simd.to_array(self.leaf), simd.to_array(self.lane));
        let mut places = [(Child::NONE, Lane::new(0)); PACKET];
        for (i, place) in places.iter_mut().enumerate() {
            *place = (Child::from_bits(leaf[i].to_bits()), Lane::new(lane[i].to_bits() as usize));
        }
        places
    }

    /// A bit for each ray that hits what is at this place.
    #[inline(always)]
    fn at(&self, simd: S, (leaf, lane): (Child, Lane)) -> u32 {
        simd.eq_bits(self.leaf, simd.splat(f32::from_bits(leaf.to_bits())))
            & simd.eq_bits(self.lane, simd.splat(f32::from_bits(lane.index() as u32)))
    }
}

/// Decides about some rays of eight at once, where each hits a sphere of its own; returns those that are answered.
///
/// # Safety
///
/// The places of the rays `asked` about must be leaves of the tree, and the filter that of their kind.
#[inline(always)]
unsafe fn settle_round<S: Simd, F: LeafTest>(
    simd: S,
    tree: &WideBvh,
    tester: &mut dyn PrimitiveTester,
    across: &RayPacket<S>,
    places: &[(Child, Lane); PACKET],
    asked: u32,
    answers: &mut [Option<Hit>; PACKET],
) -> u32 {
    let mut spheres = [SphereKernel { centre: DVec3::ZERO, radius: 1.0 }; PACKET];
    let mut indices = [0; PACKET];
    let (mut left, mut who) = (asked, 0);
    while left != 0 {
        let lane = take_lane(&mut left);
        let (leaf, of_leaf) = places[lane];
        // SAFETY: as the caller promises.
        let index = F::index(unsafe { tree.leaves.view(leaf) }, of_leaf);
        if let Some(sphere) = tester.round(index) {
            (spheres[lane], indices[lane]) = (sphere, index);
            who |= 1 << lane;
        }
    }
    if who == 0 {
        return 0;
    }
    let meetings = SpherePacket::new(simd, &spheres).meet(simd, &across.lanes);
    who &= meetings.hit;
    let t = meetings.t.to_array(simd);
    for (lane, answer) in answers.iter_mut().enumerate() {
        if who >> lane & 1 != 0 {
            *answer = Some(Hit { t: t[lane], instance: 0, primitive: indices[lane], uv: [0.0; 2] });
        }
    }
    who
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
            limit: round_up(span.max),
            candidates: [const { MaybeUninit::uninit() }; MAX_CANDIDATES],
            n_candidates: 0,
            least_near: f32::INFINITY,
        }
    }

    fn visit_unbounded(&mut self, tester: &mut dyn PrimitiveTester, ray: &Ray) -> ControlFlow<()> {
        // What is equally near, but of lower index, must still be found.
        if let Some(hit) = tester.closest_unbounded(ray, self.span) {
            self.accept(&hit);
        }
        ControlFlow::Continue(())
    }

    fn visit_unfiltered(&mut self, tester: &mut dyn PrimitiveTester, ray: &Ray) {
        let found = tester.closest_unfiltered(ray, self.span);
        self.take(found);
    }

    #[inline(always)]
    fn limit(&self) -> f32 {
        self.limit
    }

    #[inline(always)]
    unsafe fn visit<S: Simd, F: LeafTest>(
        &mut self,
        simd: S,
        tree: &WideBvh,
        tester: &mut dyn PrimitiveTester,
        trav: &TravRay<'_, S, F>,
        leaf: Child,
    ) -> ControlFlow<()> {
        // SAFETY: as the caller promises.
        let view = unsafe { tree.leaves.view(leaf) };
        let verdict = trav.filter.test(simd, view, self.limit);
        if verdict.maybe == 0 {
            return ControlFlow::Continue(());
        }
        let (mut sure, mut unsure) = (verdict.sure, verdict.maybe & !verdict.sure);
        if sure != 0 {
            let (near, far) = (simd.to_array(verdict.near), simd.to_array(verdict.far));
            while sure != 0 {
                let lane = take_lane(&mut sure);
                // SAFETY: as the caller promises.
                let place = unsafe { Place::new(leaf, Lane::new(lane)) };
                if !self.remember(place, [near[lane], far[lane]]) {
                    unsure |= 1 << lane;
                }
            }
        }
        while unsure != 0 {
            let lane = Lane::new(take_lane(&mut unsure));
            self.decide::<S, F>(simd, tester, &trav.ray, view, lane);
        }
        ControlFlow::Continue(())
    }

    #[inline(always)]
    unsafe fn consider<S: Simd, F: LeafTest>(
        &mut self,
        simd: S,
        tree: &WideBvh,
        tester: &mut dyn PrimitiveTester,
        ray: &Ray,
        leaf: Child,
        lane: Lane,
        sure: Option<[f32; 2]>,
    ) {
        // SAFETY: as the caller promises.
        let (view, place) = unsafe { (tree.leaves.view(leaf), Place::new(leaf, lane)) };
        if sure.is_none_or(|bounds| !self.remember(place, bounds)) {
            self.decide::<S, F>(simd, tester, &RayF64::new(simd, ray), view, lane);
        }
    }

    #[inline(always)]
    fn span(&self) -> Interval {
        self.span
    }

    fn ask_together(
        tester: &mut dyn PrimitiveTester,
        index: u32,
        rays: &[(Ray, Interval)],
        answers: &mut [Self::Answer],
    ) {
        tester.closest_together(index, rays, answers);
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
    fn finish<S: Simd, F: LeafTest>(
        &mut self,
        simd: S,
        tree: &WideBvh,
        tester: &mut dyn PrimitiveTester,
        ray: &RayF64<'_, S>,
        answer: &mut Option<Hit>,
    ) {
        if let Some(Candidate { place, .. }) = self.only_candidate() {
            // Where leaves decide, nothing is asked, so that the next ray need not wait.
            // SAFETY: places are leaves of the tree with which they are used.
            let (leaf, lane) = (unsafe { tree.leaves.view(place.leaf()) }, place.lane());
            if F::is_exact(leaf, lane) {
                *answer = F::exact_hit::<S, true>(simd, leaf, lane, ray, self.span);
                self.uncounted_hits += u64::from(answer.is_some());
            } else {
                *answer = tester.closest(F::index(leaf, lane), ray.ray, self.span);
            }
            return;
        }
        for i in 0..self.n_candidates {
            // SAFETY: the first `n_candidates` have been written.
            let Candidate { near, place } = unsafe { self.candidates[i % MAX_CANDIDATES].assume_init() };
            if near <= self.limit {
                // SAFETY: places are leaves of the tree with which they are used.
                let leaf = unsafe { tree.leaves.view(place.leaf()) };
                self.decide::<S, F>(simd, tester, ray, leaf, place.lane());
            }
        }
        *answer = self.answer();
    }

    type Found<S: Simd> = FoundFirst<S>;

    #[inline(always)]
    fn nothing<S: Simd>(simd: S) -> FoundFirst<S> {
        FoundFirst { who: 0, near: simd.splat(f32::INFINITY), leaf: simd.splat(0.0), lane: simd.splat(0.0) }
    }

    #[inline(always)]
    fn find<S: Simd>(
        found: &mut FoundFirst<S>,
        simd: S,
        place: Place,
        sure: u32,
        [near, far]: [S::F32x8; 2],
        limits: &mut S::F32x8,
    ) -> u32 {
        // The usual case: nearer for sure than what has been found before.
        let is_nearest = sure & simd.lt(far, found.near);
        found.who |= is_nearest;
        found.near = simd.select(is_nearest, near, found.near);
        found.leaf = simd.select(is_nearest, simd.splat(f32::from_bits(place.leaf().to_bits())), found.leaf);
        found.lane = simd.select(is_nearest, simd.splat(f32::from_bits(place.lane().index() as u32)), found.lane);
        *limits = simd.select(sure, simd.min(*limits, far), *limits);
        sure & !is_nearest
    }

    #[inline(always)]
    fn forget<S: Simd>(found: &mut FoundFirst<S>, simd: S, limits: S::F32x8) {
        found.who &= simd.le(found.near, limits);
    }

    #[inline(always)]
    fn settle<S: Simd, F: LeafTest>(
        found: &FoundFirst<S>,
        simd: S,
        tree: &WideBvh,
        tester: &mut dyn PrimitiveTester,
        across: &RayPacket<S>,
        rays: &[(Ray, Interval); PACKET],
        answers: &mut [Option<Hit>; PACKET],
    ) -> u64 {
        for answer in answers.iter_mut() {
            *answer = None;
        }
        if found.who == 0 {
            return 0;
        }
        let places = found.places(simd);
        let mut left = found.who;
        let mut uncounted_hits = 0;
        if F::IS_SPHERE {
            // SAFETY: these rays have found places in the tree.
            let settled = unsafe { settle_round::<S, F>(simd, tree, tester, across, &places, left, answers) };
            uncounted_hits += u64::from(settled.count_ones());
            left &= !settled;
        }
        while left != 0 {
            let first = left.trailing_zeros() as usize & 7;
            let place = places[first];
            let mut same_octant_prefix = left & found.at(simd, place);
            left &= !same_octant_prefix;
            // SAFETY: this ray has found a place in the tree.
            let (leaf, of_leaf) = (unsafe { tree.leaves.view(place.0) }, place.1);
            if !F::is_exact(leaf, of_leaf) {
                while same_octant_prefix != 0 {
                    let lane = take_lane(&mut same_octant_prefix);
                    let (ray, span) = &rays[lane];
                    answers[lane] = tester.closest(F::index(leaf, of_leaf), ray, *span);
                }
                continue;
            }
            uncounted_hits += u64::from(same_octant_prefix.count_ones());
            let mut together = same_octant_prefix & across.same_axis_mask;
            if together.count_ones() < 2 {
                together = 0;
            }
            let mut alone = same_octant_prefix & !together;
            while alone != 0 {
                let lane = take_lane(&mut alone);
                let (ray, span) = &rays[lane];
                answers[lane] = F::exact_hit::<S, true>(simd, leaf, of_leaf, &RayF64::new(simd, ray), *span);
            }
            if together == 0 {
                continue;
            }
            let [t, v, w] = F::certain_hits(simd, leaf, of_leaf, across);
            let (t, v, w) = (t.to_array(simd), v.to_array(simd), w.to_array(simd));
            let primitive = F::index(leaf, of_leaf);
            while together != 0 {
                let lane = take_lane(&mut together);
                answers[lane] = Some(Hit { t: t[lane], instance: 0, primitive, uv: [v[lane], w[lane]] });
            }
        }
        uncounted_hits
    }

    #[inline(always)]
    fn lower(&mut self, limit: f32) {
        self.limit = self.limit.min(limit);
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
