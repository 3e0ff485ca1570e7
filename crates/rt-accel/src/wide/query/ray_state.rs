//! Result of one ray during traversal.

use core::marker::PhantomData;
use core::mem::MaybeUninit;
use core::ops::ControlFlow;

use rt_geometry::Hit;
use rt_math::{Interval, Ray};

use super::{NO_HIT, Output, PrimSlot, PrimitiveTester, TravRay};
use crate::wide::WideBvh;
use crate::wide::filter::LeafTest;
use crate::wide::leaf::{Lane, LeafView};
use crate::wide::node::Child;
use crate::wide::ray::round_up;
use crate::wide::ray_f64::RayF64;
use crate::wide::simd::{Simd, take_lane};

/// A primitive that is certainly hit. The exact test is deferred to the end.
#[derive(Clone, Copy)]
struct CertainHit {
    t_near: f32,
    slot: PrimSlot,
}

const MAX_CANDIDATES: usize = 8;

/// The closest hit so far and candidates that may be closer, or the first occluder.
pub(in crate::wide) struct RayState<O> {
    uncounted_hits: u64,
    /// Ends at the closest hit.
    span: Interval,
    is_hit: bool,
    /// Meaningful for closest-hit queries if `is_hit`.
    hit: Hit,
    t_max: f32,
    /// The first `n_candidates` are written. Of an any-hit query, the occluder.
    candidates: [MaybeUninit<CertainHit>; MAX_CANDIDATES],
    n_candidates: usize,
    /// Minimum of all candidates.
    min_t_near: f32,
    output: PhantomData<O>,
}

impl<O: Output> RayState<O> {
    #[inline(always)]
    pub(in crate::wide) fn new(span: Interval) -> Self {
        Self {
            uncounted_hits: 0,
            span,
            is_hit: false,
            hit: NO_HIT,
            t_max: round_up(span.max),
            candidates: [const { MaybeUninit::uninit() }; MAX_CANDIDATES],
            n_candidates: 0,
            min_t_near: f32::INFINITY,
            output: PhantomData,
        }
    }

    /// Accepts a hit that is closer than the one before, or any hit.
    #[inline(always)]
    fn accept(&mut self, hit: &Hit) {
        self.is_hit = true;
        if O::ANY_HIT {
            self.t_max = -1.0;
            return;
        }
        self.span.max = hit.t;
        self.t_max = self.t_max.min(round_up(hit.t));
        // One number at a time: a copy of the whole would wait until all of it is in memory.
        self.hit.t = hit.t;
        self.hit.instance = hit.instance;
        self.hit.primitive = hit.primitive;
        self.hit.uv[0] = hit.uv[0];
        self.hit.uv[1] = hit.uv[1];
    }

    /// Ends an any-hit query.
    #[inline(always)]
    fn accept_occluder(&mut self, slot: PrimSlot) {
        self.accept(&NO_HIT);
        self.candidates[0].write(CertainHit { t_near: 0.0, slot });
        self.n_candidates = 1;
    }

    /// Accepts the output of another test within [`span`](Self::span), if it is closer.
    #[inline(always)]
    pub(in crate::wide) fn merge(&mut self, output: O) {
        if let Some(hit) = output.to_hit()
            && (O::ANY_HIT || !self.is_hit | hit.precedes(&self.hit))
        {
            self.accept(&hit);
        }
    }

    /// Tests the primitives without bounds; breaks if the query is complete.
    pub(in crate::wide) fn test_unbounded(
        &mut self,
        tree: &WideBvh,
        tester: &mut dyn PrimitiveTester<O>,
        ray: &Ray,
    ) -> ControlFlow<()> {
        // `span` stays inclusive: an equally near primitive of lower index must still be found.
        if let Some(hit) = tester.test_all(&tree.unbounded, ray, self.span).to_hit() {
            self.accept(&hit);
        }
        if O::ANY_HIT && self.is_hit { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// Traverses the tree without filters.
    pub(in crate::wide) fn traverse_f64(&mut self, tree: &WideBvh, tester: &mut dyn PrimitiveTester<O>, ray: &Ray) {
        let output = tester.traverse_f64(tree, ray, self.span);
        self.merge(output);
    }

    #[inline(always)]
    fn test_exactly<S: Simd, F: LeafTest>(
        &mut self,
        simd: S,
        tester: &mut dyn PrimitiveTester<O>,
        ray: &RayF64<'_, S>,
        leaf: LeafView<'_>,
        slot: PrimSlot,
    ) {
        simd.call_part(
            #[inline(always)]
            || {
                let output = F::intersect(simd, leaf, slot.lane(), ray, self.span, tester);
                let hit = output.to_hit();
                self.uncounted_hits += u64::from(hit.is_some() && F::is_exact(leaf, slot.lane()));
                if !O::ANY_HIT {
                    self.merge(output);
                } else if hit.is_some() {
                    self.accept_occluder(slot);
                }
            },
        )
    }

    /// Records a certain hit between two bounds: no hit after the far one can be closest. False if the list is full.
    #[inline(always)]
    fn record_certain(&mut self, slot: PrimSlot, [t_near, t_far]: [f32; 2]) -> bool {
        if t_near > self.t_max {
            return true;
        }
        if t_far < self.min_t_near {
            // The usual case: certainly closer than all others.
            self.n_candidates = 0;
            self.min_t_near = t_near;
        } else {
            self.min_t_near = self.min_t_near.min(t_near);
        }
        self.t_max = self.t_max.min(t_far);
        let has_capacity = self.n_candidates < MAX_CANDIDATES;
        if has_capacity {
            self.candidates[self.n_candidates % MAX_CANDIDATES].write(CertainHit { t_near, slot });
            self.n_candidates += 1;
        }
        has_capacity
    }

    /// Intersects the primitives of a leaf; breaks if the query is complete.
    ///
    /// # Safety
    ///
    /// The leaf must be one of the tree, and the test that of the kind of its leaves.
    #[inline(always)]
    pub(in crate::wide) unsafe fn intersect_leaf<S: Simd, F: LeafTest>(
        &mut self,
        simd: S,
        tree: &WideBvh,
        tester: &mut dyn PrimitiveTester<O>,
        trav: &TravRay<'_, S, F>,
        leaf: Child,
    ) -> ControlFlow<()> {
        // SAFETY: as the caller promises.
        let view = unsafe { tree.leaves.view(leaf) };
        // SAFETY: as the caller promises.
        let slot = |lane: usize| unsafe { PrimSlot::new(leaf, Lane::new(lane)) };
        let bounds = trav.leaf_test.test(simd, view, self.t_max);
        if bounds.possible == 0 {
            return ControlFlow::Continue(());
        }
        let (mut certain, mut uncertain) = (bounds.certain, bounds.possible & !bounds.certain);
        if certain != 0 {
            if O::ANY_HIT {
                self.uncounted_hits += 1;
                self.accept_occluder(slot(certain.trailing_zeros() as usize));
                return ControlFlow::Break(());
            }
            let (t_min, t_max) = (simd.to_array(bounds.t_min), simd.to_array(bounds.t_max));
            while certain != 0 {
                let lane = take_lane(&mut certain);
                if !self.record_certain(slot(lane), [t_min[lane], t_max[lane]]) {
                    uncertain |= 1 << lane;
                }
            }
        }
        while uncertain != 0 {
            let lane = take_lane(&mut uncertain);
            self.test_exactly::<S, F>(simd, tester, &trav.ray, view, slot(lane));
            if O::ANY_HIT && self.is_hit {
                return ControlFlow::Break(());
            }
        }
        ControlFlow::Continue(())
    }

    /// Intersects one primitive that is possibly hit; `certain` bounds the `t` of a certain hit.
    ///
    /// # Safety
    ///
    /// The slot must be one of the tree, and the test that of the kind of its leaves.
    #[inline(always)]
    pub(in crate::wide) unsafe fn intersect_candidate<S: Simd, F: LeafTest>(
        &mut self,
        simd: S,
        tree: &WideBvh,
        tester: &mut dyn PrimitiveTester<O>,
        ray: &Ray,
        slot: PrimSlot,
        certain: Option<[f32; 2]>,
    ) {
        if O::ANY_HIT && certain.is_some() {
            self.uncounted_hits += 1;
            self.accept_occluder(slot);
        } else if certain.is_none_or(|bounds| !self.record_certain(slot, bounds)) {
            // SAFETY: as the caller promises.
            let view = unsafe { tree.leaves.view(slot.leaf()) };
            self.test_exactly::<S, F>(simd, tester, &RayF64::new(simd, ray), view, slot);
        }
    }

    /// Interval in which a hit still matters.
    #[inline(always)]
    pub(in crate::wide) const fn span(&self) -> Interval {
        self.span
    }

    /// Boxes entered after this are pruned; negative if all are.
    #[inline(always)]
    pub(in crate::wide) const fn t_max(&self) -> f32 {
        self.t_max
    }

    #[inline(always)]
    pub(in crate::wide) fn shrink(&mut self, t_max: f32) {
        self.t_max = self.t_max.min(t_max);
    }

    /// Hits that no [`PrimitiveTester`] has counted.
    #[inline(always)]
    pub(in crate::wide) const fn uncounted_hits(&self) -> u64 {
        self.uncounted_hits
    }

    /// Occluder of an any-hit query, if it is in a leaf.
    #[inline(always)]
    pub(in crate::wide) fn last_occluder(&self) -> Option<PrimSlot> {
        // SAFETY: the first candidate is written.
        (O::ANY_HIT && self.n_candidates == 1).then(|| unsafe { self.candidates[0].assume_init() }.slot)
    }

    /// Result without the candidates.
    #[inline(always)]
    pub(in crate::wide) fn output(&self) -> O {
        O::from_hit(self.is_hit.then_some(self.hit))
    }

    /// Tests the candidates, and writes the result in place, so that callers may read its fields one by one. A result that is moved as a
    /// whole would wait until all of it is in memory.
    #[inline(always)]
    pub(in crate::wide) fn resolve<S: Simd, F: LeafTest>(
        &mut self,
        simd: S,
        tree: &WideBvh,
        tester: &mut dyn PrimitiveTester<O>,
        ray: &RayF64<'_, S>,
        output: &mut O,
    ) {
        if O::ANY_HIT {
            *output = self.output();
            return;
        }
        if self.n_candidates == 1 && !self.is_hit {
            // The usual case: one certain hit. An exact leaf needs no check here, so that the next ray need not wait.
            // SAFETY: the first candidate is written, and slots are those of the tree.
            let (slot, leaf) = unsafe {
                let slot = self.candidates[0].assume_init().slot;
                (slot, tree.leaves.view(slot.leaf()))
            };
            if F::is_exact(leaf, slot.lane()) {
                let hit = F::exact_hit::<S, true>(simd, leaf, slot.lane(), ray, self.span);
                self.uncounted_hits += u64::from(hit.is_some());
                *output = O::from_hit(hit);
            } else {
                *output = tester.test(F::index(leaf, slot.lane()), ray.ray, self.span);
            }
            return;
        }
        for i in 0..self.n_candidates {
            // SAFETY: the first `n_candidates` are written.
            let CertainHit { t_near, slot } = unsafe { self.candidates[i % MAX_CANDIDATES].assume_init() };
            if t_near <= self.t_max {
                // SAFETY: slots are those of the tree.
                let leaf = unsafe { tree.leaves.view(slot.leaf()) };
                self.test_exactly::<S, F>(simd, tester, ray, leaf, slot);
            }
        }
        *output = self.output();
    }
}
