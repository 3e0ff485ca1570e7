//! Whether anything blocks a ray.

use core::marker::PhantomData;
use core::ops::ControlFlow;

use rt_math::{Interval, Ray};

use super::{Goal, Place, PrimitiveTester, TravRay, take_lane};
use crate::wide::batch::{Flight, Ground};
use crate::wide::leaf::{Lane, LeafTest, RayF64};
use crate::wide::packet_rays::{PACKET, RayPacket};
use crate::wide::single_ray::{Query, Walk};
use crate::{wide::WideBvh, wide::node::Child, wide::ray::round_up, wide::simd::Simd};

/// Whether anything blocks the ray.
pub(in crate::wide) struct AnyHit {
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

    /// A primitive blocks the ray.
    #[inline(always)]
    fn block_by(&mut self, place: Place) {
        self.block();
        self.blocker = Some(place);
    }
}

/// Which of eight rays are blocked, and by what the last of them is.
pub(in crate::wide) struct FoundBlocked {
    who: u32,
    last: Option<Place>,
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
        Self { span, uncounted_hits: 0, is_blocked: false, blocker: None, limit: round_up(span.max) }
    }

    fn visit_unbounded(&mut self, tester: &mut dyn PrimitiveTester, ray: &Ray) -> ControlFlow<()> {
        if tester.occluded_unbounded(ray, self.span) {
            self.block();
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }

    fn visit_unfiltered(&mut self, tester: &mut dyn PrimitiveTester, ray: &Ray) {
        self.is_blocked = tester.occluded_unfiltered(ray, self.span);
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
        if verdict.sure != 0 {
            self.uncounted_hits += 1;
            // SAFETY: as the caller promises.
            self.block_by(unsafe { Place::new(leaf, Lane::new(verdict.sure.trailing_zeros() as usize)) });
            return ControlFlow::Break(());
        }
        let mut unsure = verdict.maybe;
        while unsure != 0 {
            let lane = Lane::new(take_lane(&mut unsure));
            if F::blocks(simd, view, lane, &trav.ray, self.span, tester) {
                self.uncounted_hits += u64::from(F::is_exact(view, lane));
                // SAFETY: as the caller promises.
                self.block_by(unsafe { Place::new(leaf, lane) });
                return ControlFlow::Break(());
            }
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
        if sure.is_some() {
            self.uncounted_hits += 1;
            self.block_by(place);
        } else if F::blocks(simd, view, lane, &RayF64::new(simd, ray), self.span, tester) {
            self.uncounted_hits += u64::from(F::is_exact(view, lane));
            self.block_by(place);
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
        tester.occluded_together(index, rays, answers);
    }

    #[inline(always)]
    fn take(&mut self, found: bool) {
        if found {
            self.block();
        }
    }

    #[inline(always)]
    fn finish<S: Simd, F: LeafTest>(
        &mut self,
        _: S,
        _: &WideBvh,
        _: &mut dyn PrimitiveTester,
        _: &RayF64<'_, S>,
        answer: &mut bool,
    ) {
        *answer = self.is_blocked;
    }

    type Found<S: Simd> = FoundBlocked;

    #[inline(always)]
    fn nothing<S: Simd>(_: S) -> FoundBlocked {
        FoundBlocked { who: 0, last: None }
    }

    #[inline(always)]
    fn find<S: Simd>(
        found: &mut FoundBlocked,
        simd: S,
        place: Place,
        sure: u32,
        _: [S::F32x8; 2],
        limits: &mut S::F32x8,
    ) -> u32 {
        found.who |= sure;
        found.last = Some(place);
        *limits = simd.select(sure, simd.splat(-1.0), *limits);
        0
    }

    #[inline(always)]
    fn settle<S: Simd, F: LeafTest>(
        found: &FoundBlocked,
        _: S,
        _: &WideBvh,
        _: &mut dyn PrimitiveTester,
        _: &RayPacket<S>,
        _: &[(Ray, Interval); PACKET],
        answers: &mut [bool; PACKET],
    ) -> u64 {
        for (lane, answer) in answers.iter_mut().enumerate() {
            *answer = found.who >> lane & 1 != 0;
        }
        u64::from(found.who.count_ones())
    }

    #[inline(always)]
    fn found_blocker<S: Simd>(found: &FoundBlocked) -> Option<Place> {
        found.last
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
    fn blocker(&self) -> Option<Place> {
        self.blocker
    }

    #[inline(always)]
    fn answer(&self) -> bool {
        self.is_blocked
    }
}
