//! Eight rays that go the same way, side by side: each box is tested with all of them, and so is each primitive.
//!
//! Rays agree if they pass all boxes through the same sides. Where no more than [`FEW`] of them are left, each goes on
//! alone: there it is better to test eight boxes at a time.
//!
//! Wald, Slusallek, Benthin and Wagner, "Interactive Rendering with Coherent Ray Tracing", 2001.

use core::marker::PhantomData;
use core::mem::MaybeUninit;

use rt_math::{Interval, Ray};

use super::across::{Across, AcrossBoxes, PACKET};
use super::goal::{Goal, Judge, Prepared, take_lane};
use super::leaf::{ExactRay, Filter};
use super::node::Child;
use super::simd::Simd;
use super::stack::Stack;
use super::walk::{Work, descend};
use super::{STACK, WideBvh};

/// As many rays go on alone.
const FEW: u32 = 3;

/// What a packet has put off.
#[derive(Clone, Copy)]
pub(super) struct Entry<S: Simd> {
    child: Child,
    /// The least of `enters`.
    least: f32,
    /// Where the rays enter, infinite for those that do not.
    enters: S::Lanes,
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
    #[inline(always)]
    fn insert(&mut self, first: usize, entry: Entry<S>) {
        debug_assert!(self.len < STACK, "the tree is deeper than its builder promises");
        let mut place = self.len;
        self.len += 1;
        while place > first {
            // SAFETY: below what `len` was.
            let before = unsafe { self.entries.get_unchecked(place - 1).assume_init() };
            if before.least >= entry.least {
                break;
            }
            // SAFETY: nodes put off eight children at most, of which one is popped before the next, and no tree is deeper
            // than a seventh of the stack.
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

/// A ray of a packet that goes alone, `None` if the filters are not proven for it. `who` says which have been prepared.
#[inline(always)]
fn loner<'r, 'p, S: Simd, F: Filter>(
    simd: S,
    tree: &WideBvh,
    rays: &'r [(Ray, Interval); PACKET],
    lane: usize,
    prepared: &'p mut [MaybeUninit<Prepared<'r, S, F>>; PACKET],
    who: &mut u32,
) -> Option<&'p Prepared<'r, S, F>> {
    if *who >> lane & 1 == 0 {
        let (ray, span) = &rays[lane];
        prepared[lane].write(Prepared::new(simd, tree, ray, *span)?);
        *who |= 1 << lane;
    }
    // SAFETY: written now or before, as `who` says.
    Some(unsafe { prepared[lane].assume_init_ref() })
}

/// Eight rays on their way through a tree.
pub(super) struct Packet<'q, 'j, S: Simd, G: Goal> {
    pub(super) simd: S,
    pub(super) tree: &'q WideBvh,
    pub(super) judge: &'q mut (dyn Judge + 'j),
    pub(super) work: &'q mut Work,
    pub(super) stack: &'q mut PacketStack<S>,
    pub(super) alone: &'q mut Stack,
    pub(super) goal: PhantomData<G>,
}

impl<S: Simd, G: Goal> Packet<'_, '_, S, G> {
    /// Sends eight rays through the tree; false if they do not agree in all that they must.
    #[inline(always)]
    pub(super) fn go<F: Filter>(
        &mut self,
        rays: &[(Ray, Interval); PACKET],
        answers: &mut [G::Answer; PACKET],
    ) -> bool {
        let Some(across) = Across::new(self.simd, self.tree, rays) else { return false };
        let filter = F::across(self.simd, &across, self.tree);
        let mut goals = [const { MaybeUninit::<G>::uninit() }; PACKET];
        for ((_, span), goal) in rays.iter().zip(&mut goals) {
            goal.write(G::new(*span));
        }
        // SAFETY: all have just been written.
        let goals: &mut [G; PACKET] = unsafe { &mut *goals.as_mut_ptr().cast() };
        let mut limits = across.limits;
        if !self.tree.unbounded.is_empty() {
            for (lane, ((ray, _), goal)) in rays.iter().zip(goals.iter_mut()).enumerate() {
                let _ = goal.visit_unbounded(self.judge, ray);
                limits = self.simd.replaced(limits, lane, goal.limit());
            }
        }
        self.walk::<F>(rays, goals, &across.boxes, &filter, limits);
        for (((ray, _), goal), answer) in rays.iter().zip(goals).zip(answers) {
            *answer = goal.finish::<S, F>(self.simd, self.tree, self.judge, &ExactRay::new(self.simd, ray));
            self.work.hits += goal.uncounted_hits();
        }
        true
    }

    #[inline(always)]
    fn walk<F: Filter>(
        &mut self,
        rays: &[(Ray, Interval); PACKET],
        goals: &mut [G; PACKET],
        across: &AcrossBoxes<S>,
        filter: &F::Across<S>,
        mut limits: S::Lanes,
    ) {
        let simd = self.simd;
        let mut loners = [const { MaybeUninit::<Prepared<'_, S, F>>::uninit() }; PACKET];
        let mut who = 0;
        self.stack.len = 0;
        self.stack.insert(0, Entry { child: self.tree.root, least: 0.0, enters: simd.splat(0.0) });
        while let Some(Entry { child, enters, .. }) = self.stack.pop() {
            let mut mask = simd.le(enters, limits);
            let n_rays = mask.count_ones();
            if n_rays <= FEW {
                while mask != 0 {
                    let lane = take_lane(&mut mask);
                    let goal = &mut goals[lane];
                    match loner(simd, self.tree, rays, lane, &mut loners, &mut who) {
                        Some(prepared) => {
                            descend(simd, self.tree, self.judge, prepared, goal, child, self.alone, self.work);
                        }
                        None => goal.visit_unfiltered(self.judge, &rays[lane].0),
                    }
                    limits = simd.replaced(limits, lane, goal.limit());
                }
            } else if child.is_node() {
                self.work.nodes += u64::from(n_rays);
                let Some(node) = self.tree.nodes.get(child.number()) else { return };
                let first = self.stack.len;
                for lane in 0..8 {
                    let plane = |row: usize| node.plane(simd, row, lane);
                    let [enter, leave] = across.cross(simd, plane, limits);
                    if simd.le(enter, leave) != 0 {
                        let enters = simd.or_infinity(enter, leave);
                        let entry = Entry { child: node.children[lane], least: simd.least(enters), enters };
                        self.stack.insert(first, entry);
                    }
                }
            } else {
                self.work.tests += u64::from(n_rays) * child.count() as u64;
                limits = self.visit::<F>(rays, goals, filter, child, mask, limits);
            }
        }
    }

    /// Tests each primitive of a leaf with all rays of the mask; returns their limits.
    #[inline(always)]
    fn visit<F: Filter>(
        &mut self,
        rays: &[(Ray, Interval); PACKET],
        goals: &mut [G; PACKET],
        filter: &F::Across<S>,
        leaf: Child,
        mut mask: u32,
        mut limits: S::Lanes,
    ) -> S::Lanes {
        let simd = self.simd;
        let view = self.tree.leaves.view(leaf);
        for lane in 0..leaf.count() {
            let verdict = F::judge_across(simd, filter, view, lane, limits);
            let mut maybe = verdict.maybe & mask;
            if maybe == 0 {
                continue;
            }
            let (near, far) = (simd.to_array(verdict.near), simd.to_array(verdict.far));
            while maybe != 0 {
                let ray = take_lane(&mut maybe);
                let sure = verdict.sure >> ray & 1 != 0;
                let bounds = sure.then_some([near[ray], far[ray]]);
                goals[ray].consider::<S, F>(simd, self.tree, self.judge, &rays[ray].0, leaf, lane, bounds);
                let limit = goals[ray].limit();
                limits = simd.replaced(limits, ray, limit);
                mask &= !(u32::from(limit < 0.0) << ray);
            }
        }
        limits
    }
}
