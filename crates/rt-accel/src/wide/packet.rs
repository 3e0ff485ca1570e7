//! F64x8 rays that go about the same way, side by side: each box is tested with all of them, and so is each primitive.
//!
//! Rays that [`is_coherent`](super::packet_rays::agree) may pass boxes through different sides, as those along an axis do. Where no more
//! than [`FEW`] of them are left, each goes on alone: there it is better to test eight boxes at a time.
//!
//! What they certainly hit stays in lanes as well, and those that hit the same triangle are decided about together: where
//! leaves hold triangles as they are, nothing is done ray by ray in a coherent packet but to write the answers.
//!
//! Wald, Slusallek, Benthin and Wagner, "Interactive Rendering with Coherent Ray Tracing", 2001.

use core::marker::PhantomData;
use core::mem::MaybeUninit;

use rt_math::{Interval, Ray};

use super::frustum::Cut;
use super::leaf::{Lane, LeafTest, RayF64};
use super::node::{Child, Node};
use super::packet_rays::{PACKET, PacketSlabs, RayPacket};
use super::packet_spheres::SpherePacket;
use super::query::{Goal, Place, PrimitiveTester, TravRay, take_lane};
use super::simd::Simd;
use super::single_ray::{Work, descend};
use super::stack::StackStorage;
use super::{STACK, WideBvh};

/// As many rays go on alone.
pub(super) const FEW: u32 = 2;

/// What a packet has put off.
#[derive(Clone, Copy)]
pub(super) struct Entry<S: Simd> {
    child: Child,
    /// The least of `enters`.
    least: f32,
    /// Where the rays enter, infinite for those that do not.
    enters: S::F32x8,
}

/// Entries that have been put off, of which those below `len` have been written.
pub(super) struct PacketStack<S: Simd> {
    entries: [MaybeUninit<Entry<S>>; STACK],
    len: usize,
}

impl<S: Simd> PacketStack<S> {
    /// Of which nothing is written: no constant, as that would be copied.
    #[inline(always)]
    pub(super) fn new() -> Self {
        Self { entries: [const { MaybeUninit::uninit() }; STACK], len: 0 }
    }

    /// Inserts an entry into those since `first`, so that the nearest is popped first.
    ///
    /// # Safety
    ///
    /// There must be fewer entries than [`STACK`]: so it is while each node of a walk puts off eight children at most, of which
    /// one is popped before the next, as no tree is deeper than a seventh of the stack.
    #[inline(always)]
    unsafe fn insert(&mut self, first: usize, entry: Entry<S>) {
        debug_assert!(self.len < STACK, "the tree is deeper than its builder promises");
        let mut place = self.len;
        self.len += 1;
        while place > first {
            // SAFETY: below what `len` was.
            let before = unsafe { self.entries.get_unchecked(place - 1).assume_init() };
            if before.least >= entry.least {
                break;
            }
            // SAFETY: as the caller promises, as `place` is at most what `len` was.
            unsafe { self.entries.get_unchecked_mut(place).write(before) };
            place -= 1;
        }
        // SAFETY: as above.
        unsafe { self.entries.get_unchecked_mut(place).write(entry) };
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<Entry<S>> {
        self.len = self.len.checked_sub(1)?;
        // SAFETY: below `len`.
        Some(unsafe { self.entries.get_unchecked(self.len).assume_init() })
    }
}

/// Rays of a packet that go alone.
struct Loners<'r, S: Simd, F> {
    trav: [MaybeUninit<TravRay<'r, S, F>>; PACKET],
    /// Which have been prepared.
    who: u32,
}

impl<'r, S: Simd, F: LeafTest> Loners<'r, S, F> {
    /// `None` if the filters are not proven for the ray.
    #[inline(always)]
    fn get(
        &mut self,
        simd: S,
        tree: &WideBvh,
        rays: &'r [(Ray, Interval); PACKET],
        lane: usize,
    ) -> Option<&TravRay<'r, S, F>> {
        if self.who >> lane & 1 == 0 {
            let (ray, span) = &rays[lane];
            self.trav[lane].write(TravRay::new(simd, tree, ray, *span)?);
            self.who |= 1 << lane;
        }
        // SAFETY: written now or before, as `who` says.
        Some(unsafe { self.trav[lane].assume_init_ref() })
    }
}

/// What rays of a packet have found: side by side, and each by itself.
struct Finds<S: Simd, G: Goal> {
    together: G::Found<S>,
    goals: [MaybeUninit<G>; PACKET],
    /// Which have a goal of their own.
    who: u32,
}

impl<S: Simd, G: Goal> Finds<S, G> {
    /// Nothing yet.
    #[inline(always)]
    fn new(simd: S) -> Self {
        Self { together: G::nothing(simd), goals: [const { MaybeUninit::uninit() }; PACKET], who: 0 }
    }

    /// What a ray has found by itself.
    #[inline(always)]
    fn goal(&mut self, lane: usize, span: Interval) -> &mut G {
        if self.who >> lane & 1 == 0 {
            self.goals[lane].write(G::new(span));
            self.who |= 1 << lane;
        }
        // SAFETY: written now or before, as `who` says.
        unsafe { self.goals[lane].assume_init_mut() }
    }

    /// As [`goal`](Self::goal), of a ray for which nothing matters after `limit`.
    #[inline(always)]
    fn goal_until(&mut self, lane: usize, span: Interval, limit: f32) -> &mut G {
        let goal = self.goal(lane, span);
        goal.lower(limit);
        goal
    }
}

/// Where rays enter the boxes of a node, infinite for those that do not, and a bit for each box that some enter. All boxes are
/// tested before anything is asked: which are passed cannot be predicted.
#[inline(always)]
fn enter<S: Simd, const SAME_OCTANT: bool>(
    simd: S,
    boxes: &PacketSlabs<S>,
    node: &Node,
    limits: S::F32x8,
) -> ([S::F32x8; 8], u32) {
    let mut enters = [simd.splat(0.0); 8];
    let mut passed = 0;
    for (lane, enters) in enters.iter_mut().enumerate() {
        let [enter, leave] = boxes.cross::<SAME_OCTANT>(simd, |row| node.plane(simd, row, lane), limits);
        *enters = simd.or_inf(enter, leave);
        passed |= u32::from(simd.le(enter, leave) != 0) << lane;
    }
    (enters, passed)
}

/// F64x8 rays that agree, as those who test boxes, primitives, and spheres see them.
struct Eights<'r, 'p, S: Simd, F: LeafTest> {
    rays: &'r [(Ray, Interval); PACKET],
    across: &'p RayPacket<S>,
    filter: &'p F::Packet<S>,
}

/// F64x8 rays on their way through a tree.
pub(super) struct Packet<'q, 'j, S: Simd, G: Goal> {
    pub(super) simd: S,
    pub(super) tree: &'q WideBvh,
    pub(super) tester: &'q mut (dyn PrimitiveTester + 'j),
    pub(super) work: &'q mut Work,
    pub(super) stack: &'q mut PacketStack<S>,
    pub(super) alone: &'q mut StackStorage,
    /// What the rays may meet, if that is known.
    pub(super) cut: Option<&'q Cut>,
    /// What blocked a ray of the packets before, and at least one of the last.
    pub(super) blocker: &'q mut Option<Place>,
    pub(super) goal: PhantomData<G>,
}

impl<S: Simd, G: Goal> Packet<'_, '_, S, G> {
    /// Sends the first `n` of eight rays through the tree; false unless all eight agree in all that they must.
    #[inline(always)]
    pub(super) fn go<F: LeafTest>(
        &mut self,
        n: usize,
        rays: &[(Ray, Interval); PACKET],
        answers: &mut [G::Answer; PACKET],
    ) -> bool {
        let Some(across) = RayPacket::new(self.simd, self.tree, rays) else { return false };
        let filter = F::across(self.simd, &across, self.tree);
        let mut limits = across.limits;
        for lane in n..PACKET {
            limits = self.simd.insert(limits, lane, -1.0);
        }
        let mut finds = Finds::<S, G>::new(self.simd);
        if !self.tree.unbounded.is_empty() {
            for (lane, (ray, span)) in rays.iter().enumerate().take(n) {
                let goal = finds.goal(lane, *span);
                let _ = goal.visit_unbounded(self.tester, ray);
                limits = self.simd.insert(limits, lane, goal.limit());
            }
        }
        let eights = Eights::<S, F> { rays, across: &across, filter: &filter };
        if let Some(place) = self.blocker.take() {
            self.ask_again(&eights, &mut finds, place, &mut limits);
        }
        let limits = self.walk(&eights, &mut finds, limits);
        G::forget(&mut finds.together, self.simd, limits);
        *self.blocker = G::found_blocker(&finds.together);
        self.work.hits += G::settle::<S, F>(&finds.together, self.simd, self.tree, self.tester, &across, rays, answers);
        let mut alone = finds.who;
        while alone != 0 {
            let lane = take_lane(&mut alone);
            let (ray, span) = &rays[lane];
            let goal = finds.goal(lane, *span);
            goal.take(answers[lane]);
            if self.blocker.is_none() {
                *self.blocker = goal.blocker();
            }
            goal.finish::<S, F>(self.simd, self.tree, self.tester, &RayF64::new(self.simd, ray), &mut answers[lane]);
            self.work.hits += goal.uncounted_hits();
        }
        true
    }

    /// Asks what blocked rays before whether it certainly blocks these.
    #[inline(always)]
    fn ask_again<F: LeafTest>(
        &mut self,
        eights: &Eights<'_, '_, S, F>,
        finds: &mut Finds<S, G>,
        place: Place,
        limits: &mut S::F32x8,
    ) {
        let simd = self.simd;
        let asked = simd.le(simd.splat(0.0), *limits);
        self.work.tests += u64::from(asked.count_ones());
        // SAFETY: places are leaves of the tree with which they are used.
        let leaf = unsafe { self.tree.leaves.view(place.leaf()) };
        let verdict = F::test_packet(simd, eights.filter, leaf, place.lane(), *limits);
        let sure = verdict.sure & asked;
        if sure != 0 {
            let left = G::find(&mut finds.together, simd, place, sure, [verdict.near, verdict.far], limits);
            debug_assert_eq!(left, 0, "goals that know a blocker want no more than one");
        }
    }

    /// Walks through all that the rays may meet; returns their limits.
    #[inline(always)]
    fn walk<F: LeafTest>(
        &mut self,
        eights: &Eights<'_, '_, S, F>,
        finds: &mut Finds<S, G>,
        mut limits: S::F32x8,
    ) -> S::F32x8 {
        let simd = self.simd;
        let mut loners = Loners { trav: [const { MaybeUninit::uninit() }; PACKET], who: 0 };
        self.stack.len = 0;
        let Some(cut) = self.cut else {
            // SAFETY: the stack is empty.
            unsafe { self.stack.insert(0, Entry { child: self.tree.root, least: 0.0, enters: simd.splat(0.0) }) };
            return self.descend(eights, finds, limits, &mut loners);
        };
        for subtree in cut.subtrees() {
            if simd.le(simd.splat(subtree.enter), limits) == 0 {
                break;
            }
            let Some(node) = self.tree.nodes.get(subtree.node as usize) else { break };
            let [enter, leave] = eights.across.boxes.cross::<false>(
                simd,
                |row| node.plane(simd, row, usize::from(subtree.lane)),
                limits,
            );
            let mask = simd.le(enter, leave);
            if mask == 0 {
                continue;
            }
            if subtree.child.is_node() {
                let enters = simd.or_inf(enter, leave);
                // SAFETY: the stack is empty, as all that was on it has been gone through.
                unsafe { self.stack.insert(0, Entry { child: subtree.child, least: 0.0, enters }) };
                limits = self.descend(eights, finds, limits, &mut loners);
            } else {
                let lanes = u32::from(subtree.mask);
                // SAFETY: subtrees of a cut are children of nodes of the tree, and this is no node.
                limits = unsafe { self.visit(eights, finds, (subtree.child, lanes), mask, limits) };
            }
        }
        limits
    }

    /// Goes through all that has been put off; returns the limits of the rays.
    #[inline(always)]
    fn descend<'r, F: LeafTest>(
        &mut self,
        eights: &Eights<'r, '_, S, F>,
        finds: &mut Finds<S, G>,
        mut limits: S::F32x8,
        loners: &mut Loners<'r, S, F>,
    ) -> S::F32x8 {
        let simd = self.simd;
        let is_same_octant = eights.across.boxes.is_same_octant();
        while let Some(Entry { child, enters, .. }) = self.stack.pop() {
            let mut mask = simd.le(enters, limits);
            let n_rays = mask.count_ones();
            if n_rays <= FEW {
                let ends = simd.to_array(limits);
                while mask != 0 {
                    let lane = take_lane(&mut mask);
                    let goal = finds.goal_until(lane, eights.rays[lane].1, ends[lane]);
                    match loners.get(simd, self.tree, eights.rays, lane) {
                        Some(trav) => {
                            // SAFETY: entries are the root of the tree, subtrees of it, or children of its nodes.
                            unsafe {
                                descend(simd, self.tree, self.tester, trav, goal, child, self.alone, self.work);
                            }
                        }
                        None => goal.visit_unfiltered(self.tester, &eights.rays[lane].0),
                    }
                    limits = simd.insert(limits, lane, goal.limit());
                }
            } else if child.is_node() {
                self.work.nodes += u64::from(n_rays);
                // SAFETY: entries are the root of the tree, subtrees of it, or children of its nodes.
                let node = unsafe { self.tree.node(child) };
                let first = self.stack.len;
                let (enters, mut passed) = if is_same_octant {
                    enter::<S, true>(simd, &eights.across.boxes, node, limits)
                } else {
                    enter::<S, false>(simd, &eights.across.boxes, node, limits)
                };
                while passed != 0 {
                    let lane = take_lane(&mut passed);
                    let enters = enters[lane];
                    let entry = Entry { child: node.children[lane], least: simd.least(enters), enters };
                    // SAFETY: eight at most of each level, of which one is popped before the next.
                    unsafe { self.stack.insert(first, entry) };
                }
            } else {
                let all = (1 << child.count()) - 1;
                // SAFETY: a child of a node, and none itself.
                limits = unsafe { self.visit(eights, finds, (child, all), mask, limits) };
            }
        }
        limits
    }

    /// Tests some primitives of a leaf, a bit for each, with all rays of the mask; returns their limits.
    ///
    /// # Safety
    ///
    /// The leaf must be one of the tree.
    #[inline(always)]
    unsafe fn visit<F: LeafTest>(
        &mut self,
        eights: &Eights<'_, '_, S, F>,
        finds: &mut Finds<S, G>,
        (leaf, mut lanes): (Child, u32),
        mut mask: u32,
        mut limits: S::F32x8,
    ) -> S::F32x8 {
        let simd = self.simd;
        // SAFETY: as the caller promises.
        let view = unsafe { self.tree.leaves.view(leaf) };
        self.work.tests += u64::from(mask.count_ones()) * u64::from(lanes.count_ones());
        while lanes != 0 {
            let lane = Lane::new(take_lane(&mut lanes));
            let verdict = F::test_packet(simd, eights.filter, view, lane, limits);
            let mut maybe = verdict.maybe & mask;
            if maybe == 0 {
                continue;
            }
            let sure = verdict.sure & maybe;
            if sure != 0 {
                // SAFETY: as the caller promises.
                let place = unsafe { Place::new(leaf, lane) };
                let left = G::find(&mut finds.together, simd, place, sure, [verdict.near, verdict.far], &mut limits);
                maybe &= !sure | left;
                mask &= simd.le(simd.splat(0.0), limits);
                if maybe == 0 {
                    continue;
                }
            }
            let unsure = maybe & !verdict.sure;
            if unsure != 0 && !F::is_exact(view, lane) {
                let index = F::index(view, lane);
                if let Some(sphere) = if F::IS_SPHERE { self.tester.round(index) } else { None } {
                    // Rays that start on a sphere are left to be decided about, and most of them lead away.
                    maybe &= verdict.sure | !SpherePacket::all(simd, &sphere).miss_mask(simd, &eights.across.lanes);
                } else if unsure.count_ones() > FEW && self.tester.is_structure(index) {
                    maybe &= verdict.sure;
                    limits = self.ask_together(index, eights.rays, unsure, finds, limits);
                    mask &= simd.le(simd.splat(0.0), limits);
                }
            }
            let (near, far, ends) = (simd.to_array(verdict.near), simd.to_array(verdict.far), simd.to_array(limits));
            while maybe != 0 {
                let ray = take_lane(&mut maybe);
                let sure = verdict.sure >> ray & 1 != 0;
                let bounds = sure.then_some([near[ray], far[ray]]);
                let (asked, span) = &eights.rays[ray];
                let goal = finds.goal_until(ray, *span, ends[ray]);
                // SAFETY: as the caller promises.
                unsafe { goal.consider::<S, F>(simd, self.tree, self.tester, asked, leaf, lane, bounds) };
                let limit = goal.limit();
                limits = simd.insert(limits, ray, limit);
                mask &= !(u32::from(limit < 0.0) << ray);
            }
        }
        limits
    }

    /// Asks a structure for all rays of a mask; returns the limits of the rays.
    #[inline(always)]
    fn ask_together(
        &mut self,
        index: u32,
        rays: &[(Ray, Interval); PACKET],
        mut mask: u32,
        finds: &mut Finds<S, G>,
        mut limits: S::F32x8,
    ) -> S::F32x8 {
        let n = mask.count_ones() as usize;
        let (mut asked, mut lanes, mut found) = (*rays, [0; PACKET], [G::Answer::default(); PACKET]);
        for place in 0..n {
            let lane = take_lane(&mut mask);
            lanes[place] = lane;
            asked[place] = (rays[lane].0, finds.goal(lane, rays[lane].1).span());
        }
        G::ask_together(self.tester, index, &asked[..n], &mut found[..n]);
        let ends = self.simd.to_array(limits);
        for (lane, found) in lanes.into_iter().zip(found).take(n) {
            let goal = finds.goal_until(lane, rays[lane].1, ends[lane]);
            goal.take(found);
            limits = self.simd.insert(limits, lane, goal.limit());
        }
        limits
    }
}
