//! Many rays at a time: while one waits for memory, or for the result of its last box test, others go on.
//!
//! Each ray walks as it would alone, one node or leaf at a time, and its next is fetched meanwhile. Where rays go is not
//! asked by branches, which would be predicted wrongly as often as not, and hold up all.
//!
//! Kocberber, Falsafi and Grot, "Asynchronous Memory Access Chaining", 2015, do so for other trees.

use core::marker::PhantomData;
use core::mem::MaybeUninit;

use rt_math::{Interval, Ray};

use super::frustum::{BundleFrustum, Cut, same_octant_prefix};
use super::leaf::{BoxTest, Lane, LeafKind, LeafTest, SphereTest, TriangleTest};
use super::node::Child;
use super::packet::{FEW, Packet, PacketStack};
use super::packet_rays::{PACKET, is_coherent, pad_to_packet};
use super::query::{Goal, Place, PrimitiveTester, TravRay};
use super::simd::{Simd, WithSimd};
use super::single_ray::{Work, descend};
use super::stack::StackStorage;
use super::{STACK, WideBvh};
use crate::AcceleratorQueries;

/// Rays that are under way at a time: enough to outlast a wait, few enough to stay in the nearest cache.
const CREW: usize = 16;

/// Rays of which it is found out together what they may meet.
const BUNDLE: usize = 64;

/// In trees of fewer spheres there is nothing to find out: packets come to leaves as soon. Among triangles, most of which
/// are missed by most rays of a bundle, it does not pay at all.
const WORTH_A_LOOK: u32 = 256;

/// Trees of more bytes than that are waited for: rays that do not agree go through them side by side. Through smaller ones
/// each goes alone, which takes fewer instructions.
const FAR: usize = 8 << 20;

/// Sends many rays through a tree.
pub(super) struct Flight<'q, 'j, G> {
    pub(super) tree: &'q WideBvh,
    pub(super) ground: &'q mut Ground<'j>,
    pub(super) goal: PhantomData<G>,
}

/// Who decides, and counts.
pub(super) struct Ground<'j> {
    pub(super) tester: &'j mut dyn PrimitiveTester,
    pub(super) work: Work,
}

impl<G: Goal> WithSimd<&[(Ray, Interval)], &mut [G::Answer]> for Flight<'_, '_, G> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S, rays: &[(Ray, Interval)], answers: &mut [G::Answer]) {
        match self.tree.leaves.kind {
            LeafKind::Watertight => self.fly::<S, TriangleTest<true>>(simd, rays, answers),
            LeafKind::Triangles => self.fly::<S, TriangleTest<false>>(simd, rays, answers),
            LeafKind::Spheres => self.fly::<S, SphereTest>(simd, rays, answers),
            LeafKind::Boxes => self.fly::<S, BoxTest>(simd, rays, answers),
        }
    }
}

impl<G: Goal> Flight<'_, '_, G> {
    #[inline(always)]
    fn fly<S: Simd, F: LeafTest>(self, simd: S, rays: &[(Ray, Interval)], answers: &mut [G::Answer]) {
        let mut crew = Crew::<S, F, G> {
            simd,
            tree: self.tree,
            tester: self.ground.tester,
            work: Work::default(),
            rays,
            answers,
            n_boarded: 0,
            alone_until: 0,
            bundled_until: 0,
            cut: Cut::NONE,
            blocker: None,
            packet_stack: PacketStack::new(),
            stack: StackStorage::new(),
            is_far: S::INTERLEAVE && self.tree.memory() > FAR,
            seats: [const { MaybeUninit::uninit() }; CREW],
            routes: [const { MaybeUninit::uninit() }; CREW],
            at_nodes: Roster::EMPTY,
            at_leaves: Roster::EMPTY,
            home: Roster::EMPTY,
        };
        (0..CREW).for_each(|seat| crew.home.push_if(true, seat, Child::NONE));
        loop {
            crew.board();
            if crew.at_nodes.len + crew.at_leaves.len == 0 {
                break;
            }
            let n_free = crew.home.len;
            crew.visit_nodes();
            crew.visit_leaves();
            crew.welcome(n_free);
        }
        self.ground.work = crew.work;
    }
}

/// A ray that is under way.
struct Traveller<'r, S: Simd, F, G> {
    trav: TravRay<'r, S, F>,
    goal: G,
    /// Of the ray in the batch.
    number: usize,
}

/// Where a ray still has to go, the nearest last, and where that is entered. Not cleared, as that would take as long as a
/// few nodes.
struct Route {
    children: [MaybeUninit<u32>; STACK + 8],
    enters: [MaybeUninit<f32>; STACK + 8],
    len: usize,
}

impl Route {
    /// Begins a route: nowhere but home. All but the first entry may stay unwritten.
    #[inline(always)]
    fn begin(place: &mut MaybeUninit<Self>) {
        // SAFETY: within the place; all but `len` may stay unwritten.
        let route = unsafe {
            (&raw mut (*place.as_mut_ptr()).len).write(1);
            place.assume_init_mut()
        };
        route.children[0].write(Child::NONE.to_bits());
        route.enters[0].write(f32::NEG_INFINITY);
    }

    /// Room for eight more.
    ///
    /// # Safety
    ///
    /// There must be fewer than [`STACK`] on the route: so it is while each node of a walk puts off seven children at most, as no
    /// tree is deeper than a seventh of the stack.
    #[inline(always)]
    unsafe fn rest(&mut self) -> (&mut [MaybeUninit<f32>; 8], &mut [MaybeUninit<u32>; 8]) {
        debug_assert!(self.len < STACK, "the tree is deeper than its builder promises");
        // SAFETY: as the caller promises, and there are eight places more.
        unsafe {
            (&mut *self.enters.as_mut_ptr().add(self.len).cast(), &mut *self.children.as_mut_ptr().add(self.len).cast())
        }
    }

    /// What comes next and is entered at or before `limit`; home is at 0.
    ///
    /// # Safety
    ///
    /// Home must not have been popped since the route [began](Self::begin), and all below `len` must have been written.
    #[inline(always)]
    unsafe fn pop(&mut self, limit: f32) -> Child {
        loop {
            self.len -= 1;
            // SAFETY: there was something to pop, and all below `len` has been written, as the caller promises.
            let (enter, child) = unsafe {
                (self.enters.get_unchecked(self.len).assume_init(), self.children.get_unchecked(self.len).assume_init())
            };
            if enter <= limit {
                return Child::from_bits(child);
            }
        }
    }
}

/// Some of the crew, by seat, and where they are.
#[derive(Clone, Copy)]
struct Roster {
    seats: [(u32, Child); CREW],
    len: usize,
}

impl Roster {
    const EMPTY: Self = Self { seats: [(0, Child::NONE); CREW], len: 0 };

    /// Adds one of them, if it is so.
    #[inline(always)]
    fn push_if(&mut self, is_so: bool, seat: usize, child: Child) {
        self.seats[self.len % CREW] = (seat as u32, child);
        self.len += usize::from(is_so);
    }

    #[inline(always)]
    fn get(&self, at: usize) -> (usize, Child) {
        let (seat, child) = self.seats[at % CREW];
        (seat as usize % CREW, child)
    }
}

/// The rays that are under way, and those that wait.
struct Crew<'r, 'q, S: Simd, F, G: Goal> {
    simd: S,
    tree: &'q WideBvh,
    tester: &'q mut dyn PrimitiveTester,
    work: Work,
    rays: &'r [(Ray, Interval)],
    answers: &'r mut [G::Answer],
    n_boarded: usize,
    /// Up to this ray they do not agree.
    alone_until: usize,
    /// Up to this ray all may meet nothing but `cut`.
    bundled_until: usize,
    cut: Cut,
    /// What blocked the last packet, or the last ray that went alone, and may block the next. Rays side by side ask it as
    /// well, but what blocks them is not noted.
    blocker: Option<Place>,
    packet_stack: PacketStack<S>,
    /// Of a ray that goes alone.
    stack: StackStorage,
    /// True if it takes long to fetch what is not in the nearest caches.
    is_far: bool,
    /// Written where a roster but `home` lists them.
    seats: [MaybeUninit<Traveller<'r, S, F, G>>; CREW],
    routes: [MaybeUninit<Route>; CREW],
    at_nodes: Roster,
    at_leaves: Roster,
    /// Whose seats are free.
    home: Roster,
}

impl<'r, S: Simd, F: LeafTest, G: Goal> Crew<'r, '_, S, F, G> {
    /// Fills the free seats.
    #[inline(always)]
    fn board(&mut self) {
        loop {
            if self.n_boarded == self.alone_until {
                self.alone_until += PACKET;
                if self.go_together() {
                    self.n_boarded = self.alone_until.min(self.rays.len());
                    continue;
                }
            }
            let Some((ray, span)) = self.rays.get(self.n_boarded).filter(|_| self.home.len > 0) else { return };
            let number = self.n_boarded;
            self.n_boarded += 1;
            let mut goal = G::new(*span);
            if !self.tree.unbounded.is_empty() && goal.visit_unbounded(self.tester, ray).is_break() {
                self.answer(number, goal.answer());
                continue;
            }
            let Some(trav) = TravRay::<S, F>::new(self.simd, self.tree, ray, *span) else {
                goal.visit_unfiltered(self.tester, ray);
                self.answer(number, goal.answer());
                continue;
            };
            if self.ask_again(&trav, &mut goal) {
                self.arrive(&trav, &mut goal, number);
                continue;
            }
            if !self.is_far {
                // SAFETY: the root, and the filter that suits the leaves.
                unsafe {
                    descend(
                        self.simd,
                        self.tree,
                        self.tester,
                        &trav,
                        &mut goal,
                        self.tree.root,
                        &mut self.stack,
                        &mut self.work,
                    );
                }
                self.arrive(&trav, &mut goal, number);
                continue;
            }
            self.home.len -= 1;
            let (seat, _) = self.home.get(self.home.len);
            self.seats[seat].write(Traveller { trav, goal, number });
            Route::begin(&mut self.routes[seat]);
            self.send(seat, self.tree.root);
        }
    }

    /// Sends the next rays as a packet, if they agree.
    #[inline(always)]
    fn go_together(&mut self) -> bool {
        let first = self.n_boarded;
        let rest = self.rays.get(first..).unwrap_or(&[]);
        let n = rest.len().min(PACKET);
        if n <= FEW as usize {
            return false;
        }
        let filled;
        let rays = if let Some(rays) = rest.first_chunk() {
            rays
        } else {
            filled = pad_to_packet(rest);
            &filled
        };
        if !is_coherent(rays) {
            return false;
        }
        if first >= self.bundled_until {
            self.look_ahead();
        }
        let Some(places) = self.answers.get_mut(first..first + n) else { return false };
        let mut spare;
        let answers = if let Some(answers) = places.first_chunk_mut() {
            answers
        } else {
            spare = [G::Answer::default(); PACKET];
            &mut spare
        };
        let mut packet = Packet::<S, G> {
            simd: self.simd,
            tree: self.tree,
            tester: self.tester,
            work: &mut self.work,
            stack: &mut self.packet_stack,
            alone: &mut self.stack,
            cut: (first < self.bundled_until).then_some(&self.cut),
            blocker: &mut self.blocker,
            goal: PhantomData,
        };
        let has_gone = packet.go::<F>(n, rays, answers);
        if has_gone && n < PACKET {
            let answers = *answers;
            self.answers[first..first + n].copy_from_slice(&answers[..n]);
        }
        has_gone
    }

    /// Finds out what several of the next packets may meet, if they go through the same sides of boxes.
    #[inline(always)]
    fn look_ahead(&mut self) {
        if !F::IS_SPHERE || self.tree.bounded < WORTH_A_LOOK {
            return;
        }
        let rays = self.rays.get(self.n_boarded..).unwrap_or(&[]);
        let n_alike = same_octant_prefix(rays.get(..BUNDLE).unwrap_or(rays)) / PACKET * PACKET;
        if n_alike < 2 * PACKET {
            return;
        }
        if let Some(shaft) = rays.get(..n_alike).and_then(|rays| BundleFrustum::around(self.simd, self.tree, rays)) {
            self.work.nodes += self.cut.make::<S, F>(self.simd, self.tree, &shaft);
            self.bundled_until = self.n_boarded + n_alike;
        }
    }

    /// Asks what blocked a ray before, and its neighbours in the leaf; true if that certainly blocks this one.
    #[inline(always)]
    fn ask_again(&mut self, trav: &TravRay<'_, S, F>, goal: &mut G) -> bool {
        let Some(leaf) = self.blocker.take().map(Place::leaf) else { return false };
        // SAFETY: places are leaves of the tree with which they are used.
        let view = unsafe { self.tree.leaves.view(leaf) };
        self.work.tests += view.count as u64;
        let verdict = trav.filter.test(self.simd, view, goal.limit());
        if verdict.sure == 0 {
            return false;
        }
        let lane = Lane::new(verdict.sure.trailing_zeros() as usize);
        // SAFETY: as above.
        unsafe { goal.consider::<S, F>(self.simd, self.tree, self.tester, trav.ray.ray, leaf, lane, Some([0.0; 2])) };
        true
    }

    /// Takes down what a ray has found.
    #[inline(always)]
    fn arrive(&mut self, trav: &TravRay<'_, S, F>, goal: &mut G, number: usize) {
        let Some(place) = self.answers.get_mut(number) else { return };
        goal.finish::<S, F>(self.simd, self.tree, self.tester, &trav.ray, place);
        self.work.hits += goal.uncounted_hits();
        self.blocker = goal.blocker();
    }

    #[inline(always)]
    fn answer(&mut self, number: usize, answer: G::Answer) {
        if let Some(place) = self.answers.get_mut(number) {
            *place = answer;
        }
    }

    /// Sends a traveller somewhere. Nothing is asked: where rays go next cannot be predicted.
    #[inline(always)]
    fn send(&mut self, seat: usize, child: Child) {
        for line in 0..4 {
            self.simd.prefetch(self.tree.line(child).wrapping_add(line));
        }
        if child == Child::NONE {
            return self.home.push_if(true, seat, child);
        }
        self.at_nodes.push_if(child.is_node(), seat, child);
        self.at_leaves.push_if(!child.is_node(), seat, child);
    }

    /// Tests the boxes of all nodes at which rays are, and goes to the nearest.
    #[inline(always)]
    fn visit_nodes(&mut self) {
        let n = self.at_nodes.len;
        self.work.nodes += n as u64;
        self.at_nodes.len = 0;
        for i in 0..n {
            let (seat, child) = self.at_nodes.get(i);
            // SAFETY: has been written, as who is at a node.
            let Traveller { trav, goal, .. } = unsafe { self.seats[seat].assume_init_ref() };
            // SAFETY: who is at a node has been sent there, to the root or to a child of a node.
            let node = unsafe { self.tree.node(child) };
            let [enter, leave] = trav.boxes.cross(self.simd, node, trav.min, goal.limit());
            // SAFETY: as above.
            let route = unsafe { self.routes[seat].assume_init_mut() };
            // SAFETY: one node of each level puts off seven children at most.
            let (enters, children) = unsafe { route.rest() };
            route.len += self.simd.compress_sorted(enter, leave, node.child_bits(), enters, children);
            // SAFETY: who is at a node has not come home; what was put has been written.
            let next = unsafe { route.pop(goal.limit()) };
            self.send(seat, next);
        }
    }

    #[inline(always)]
    fn visit_leaves(&mut self) {
        let n = self.at_leaves.len;
        self.at_leaves.len = 0;
        for i in 0..n {
            let (seat, leaf) = self.at_leaves.get(i);
            // SAFETY: has been written, as who is at a leaf.
            let Traveller { trav, goal, .. } = unsafe { self.seats[seat].assume_init_mut() };
            self.work.tests += leaf.count() as u64;
            // SAFETY: who is at a leaf has been sent there, to a child of a node.
            if unsafe { goal.visit::<S, F>(self.simd, self.tree, self.tester, trav, leaf) }.is_break() {
                Route::begin(&mut self.routes[seat]);
            }
            // SAFETY: as above, and who is at a leaf has not come home.
            let next = unsafe { self.routes[seat].assume_init_mut().pop(goal.limit()) };
            self.send(seat, next);
        }
    }

    /// Finishes those that have come home since it was last done.
    #[inline(always)]
    fn welcome(&mut self, n_free: usize) {
        for i in n_free..self.home.len {
            let (seat, _) = self.home.get(i);
            // SAFETY: has been written, as who has come home.
            let Traveller { trav, goal, number } = unsafe { self.seats[seat].assume_init_mut() };
            let Some(place) = self.answers.get_mut(*number) else { return };
            goal.finish::<S, F>(self.simd, self.tree, self.tester, &trav.ray, place);
            self.work.hits += goal.uncounted_hits();
        }
    }
}
