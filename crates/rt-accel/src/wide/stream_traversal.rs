//! Traversal of the rays of a stream: coherent packets, and interleaved single rays that hide memory latency.
//!
//! Interleaved rays advance by one node or leaf at a time, and prefetch their next one. Scheduling is branch-free: a branch
//! on the next child would be mispredicted about half the time and stall all rays.
//!
//! Kocberber, Falsafi and Grot, "Asynchronous Memory Access Chaining", 2015, interleave lookups in other trees.

use core::marker::PhantomData;
use core::mem::MaybeUninit;

use super::WideBvh;
use super::coherence::are_coherent;
use super::entry_points::EntryPoints;
use super::f64x8::PACKET;
use super::filter::LeafTest;
use super::frustum::BundleFrustum;
use super::leaf::Lane;
use super::node::Child;
use super::packet::{PacketStack, PacketTraversal, SWITCH_THRESHOLD};
use super::query::{Output, PrimSlot, PrimitiveTester, RayState, TravRay, TraversalStats};
use super::simd::{Simd, WithSimd};
use super::single_ray::traverse;
use super::stack::{STACK, StackStorage};
use super::stream_rays::{N_PACKETS, StreamRays};

/// Interleaved rays: enough to outlast a cache miss, few enough to stay in the first-level cache.
const N_IN_FLIGHT: usize = 16;

/// Trees of fewer spheres are not culled by frustum: packets reach their leaves as soon. Trees of triangles never are, as
/// most rays of a bundle miss most triangles.
const MIN_PRIMS_TO_CULL: u32 = 256;

/// Rays are interleaved in trees of more bytes. In smaller ones a ray takes fewer instructions by itself.
const INTERLEAVE_MIN_BYTES: usize = 8 << 20;

/// Traces a stream through a tree whose leaves have the test `F`.
pub(super) struct StreamTraversal<'q, 'j, O, F> {
    pub(super) tree: &'q WideBvh,
    pub(super) context: &'q mut StreamContext<'j, O>,
    /// A bit for each packet whose rays are traced.
    pub(super) packets: u32,
    pub(super) leaf_test: PhantomData<F>,
}

/// Exact tests and statistics of a stream.
pub(crate) struct StreamContext<'j, O> {
    pub(super) tester: &'j mut dyn PrimitiveTester<O>,
    pub(super) stats: TraversalStats,
    /// True if the caller uses the statistics.
    pub(super) counts_work: bool,
}

impl<O: Output, F: LeafTest> WithSimd<StreamRays<'_>, &mut O::OfStream> for StreamTraversal<'_, '_, O, F> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S, rays: StreamRays<'_>, outputs: &mut O::OfStream) {
        let mut pool = RayPool::<S, F, O> {
            simd,
            tree: self.tree,
            tester: self.context.tester,
            stats: TraversalStats::default(),
            rays,
            packets: self.packets,
            outputs,
            next_ray: 0,
            packet_end: 0,
            bundle_end: 0,
            entry_points: EntryPoints::new(),
            occluder: None,
            packet_stack: PacketStack::new(),
            stack: StackStorage::new(),
            is_interleaved: S::INTERLEAVE && self.tree.total_bytes() > INTERLEAVE_MIN_BYTES,
            active: [const { MaybeUninit::uninit() }; N_IN_FLIGHT],
            stacks: [const { MaybeUninit::uninit() }; N_IN_FLIGHT],
            node_queue: RayQueue::EMPTY,
            leaf_queue: RayQueue::EMPTY,
            free_slots: RayQueue::EMPTY,
        };
        (0..N_IN_FLIGHT).for_each(|slot| pool.free_slots.push_if(true, slot, Child::NONE));
        loop {
            pool.refill();
            if pool.node_queue.len + pool.leaf_queue.len == 0 {
                break;
            }
            let n_free = pool.free_slots.len;
            pool.visit_nodes();
            pool.visit_leaves();
            pool.retire(n_free);
        }
        self.context.stats += pool.stats;
    }
}

/// An interleaved ray.
struct ActiveRay<'r, S: Simd, F, O> {
    trav: TravRay<'r, S, F>,
    state: RayState<O>,
    /// Index in the stream.
    index: usize,
}

/// Stack of an interleaved ray, the nearest child on top, with the `t` at entry. Entries are not cleared, as that would
/// take as long as several nodes.
struct RayStack {
    children: [MaybeUninit<u32>; STACK + 8],
    enters: [MaybeUninit<f32>; STACK + 8],
    len: usize,
}

impl RayStack {
    /// Writes [`Child::NONE`] as the only entry. All others may stay unwritten.
    #[inline(always)]
    fn init(stack: &mut MaybeUninit<Self>) {
        // SAFETY: in bounds; all but `len` may stay unwritten.
        let stack = unsafe {
            (&raw mut (*stack.as_mut_ptr()).len).write(1);
            stack.assume_init_mut()
        };
        stack.children[0].write(Child::NONE.to_bits());
        stack.enters[0].write(f32::NEG_INFINITY);
    }

    /// Space for eight more entries.
    ///
    /// # Safety
    ///
    /// There must be fewer than [`STACK`] entries. This holds while each node pushes at most seven children, as no tree is
    /// deeper than a seventh of the stack.
    #[inline(always)]
    unsafe fn spare(&mut self) -> (&mut [MaybeUninit<f32>; 8], &mut [MaybeUninit<u32>; 8]) {
        debug_assert!(self.len < STACK, "the tree is deeper than its builder promises");
        // SAFETY: as the caller promises, and there are eight entries more.
        unsafe {
            (&mut *self.enters.as_mut_ptr().add(self.len).cast(), &mut *self.children.as_mut_ptr().add(self.len).cast())
        }
    }

    /// Pops the next child that is entered at or before `t_max`.
    ///
    /// # Safety
    ///
    /// [`Child::NONE`] must not have been popped since [`init`](Self::init), and all entries below `len` must be written.
    #[inline(always)]
    unsafe fn pop(&mut self, t_max: f32) -> Child {
        loop {
            self.len -= 1;
            // SAFETY: there is an entry, and all below `len` are written, as the caller promises.
            let (enter, child) = unsafe {
                (self.enters.get_unchecked(self.len).assume_init(), self.children.get_unchecked(self.len).assume_init())
            };
            if enter <= t_max {
                return Child::from_bits(child);
            }
        }
    }
}

/// Slots of interleaved rays, with the child that each visits next.
#[derive(Clone, Copy)]
struct RayQueue {
    slots: [(u32, Child); N_IN_FLIGHT],
    len: usize,
}

impl RayQueue {
    const EMPTY: Self = Self { slots: [(0, Child::NONE); N_IN_FLIGHT], len: 0 };

    #[inline(always)]
    fn push_if(&mut self, condition: bool, slot: usize, child: Child) {
        self.slots[self.len % N_IN_FLIGHT] = (slot as u32, child);
        self.len += usize::from(condition);
    }

    #[inline(always)]
    fn get(&self, at: usize) -> (usize, Child) {
        let (slot, child) = self.slots[at % N_IN_FLIGHT];
        (slot as usize % N_IN_FLIGHT, child)
    }
}

/// A stream, and its rays in flight.
struct RayPool<'r, 'q, S: Simd, F, O: Output> {
    simd: S,
    tree: &'q WideBvh,
    tester: &'q mut dyn PrimitiveTester<O>,
    stats: TraversalStats,
    rays: StreamRays<'r>,
    /// A bit for each packet whose rays are traced.
    packets: u32,
    outputs: &'q mut O::OfStream,
    next_ray: usize,
    /// Rays before this one are traced singly.
    packet_end: usize,
    /// Rays before this one can hit only the subtrees of `entry_points`.
    bundle_end: usize,
    entry_points: EntryPoints,
    /// Occluder of the last packet or single ray. Interleaved rays test it but do not set it.
    occluder: Option<PrimSlot>,
    packet_stack: PacketStack<S>,
    /// Stack of a single ray.
    stack: StackStorage,
    is_interleaved: bool,
    /// Written for slots in the node and leaf queues.
    active: [MaybeUninit<ActiveRay<'r, S, F, O>>; N_IN_FLIGHT],
    stacks: [MaybeUninit<RayStack>; N_IN_FLIGHT],
    node_queue: RayQueue,
    leaf_queue: RayQueue,
    free_slots: RayQueue,
}

impl<'r, S: Simd, F: LeafTest, O: Output> RayPool<'r, '_, S, F, O> {
    /// Traces packets and single rays until all slots are filled with interleaved rays or the stream ends.
    #[inline(always)]
    fn refill(&mut self) {
        loop {
            if self.next_ray == self.packet_end {
                self.packet_end += PACKET;
                let is_wanted = self.packets >> (self.next_ray / PACKET % N_PACKETS) & 1 != 0;
                if !is_wanted || self.trace_packet() {
                    self.next_ray = self.packet_end.min(self.rays.len());
                    continue;
                }
            }
            if self.next_ray >= self.rays.len() || self.free_slots.len == 0 {
                return;
            }
            let (ray, span) = self.rays.get(self.next_ray);
            let index = self.next_ray;
            self.next_ray += 1;
            let mut state = RayState::new(*span);
            if !self.tree.unbounded.is_empty() && state.test_unbounded(self.tree, self.tester, ray).is_break() {
                state.output().write(self.outputs, index);
                continue;
            }
            let Some(trav) = TravRay::<S, F>::new(self.simd, self.tree, ray, *span) else {
                state.traverse_f64(self.tree, self.tester, ray);
                state.output().write(self.outputs, index);
                continue;
            };
            let is_occluded = O::ANY_HIT && self.test_last_occluder(&trav, &mut state);
            if is_occluded || !self.is_interleaved {
                if !is_occluded {
                    let root = self.tree.root;
                    let (stack, stats) = (&mut self.stack, &mut self.stats);
                    // SAFETY: the root, and the test of the leaves' kind.
                    unsafe {
                        traverse::<false, _, _, _>(
                            self.simd,
                            self.tree,
                            self.tester,
                            &trav,
                            &mut state,
                            root,
                            stack,
                            stats,
                        )
                    };
                }
                self.finish(&trav, &mut state, index);
                continue;
            }
            self.free_slots.len -= 1;
            let (slot, _) = self.free_slots.get(self.free_slots.len);
            self.active[slot].write(ActiveRay { trav, state, index });
            RayStack::init(&mut self.stacks[slot]);
            self.schedule(slot, self.tree.root);
        }
    }

    /// Traces the next rays as a packet if they are coherent.
    #[inline(always)]
    fn trace_packet(&mut self) -> bool {
        let first = self.next_ray;
        let n = self.rays.len().saturating_sub(first).min(PACKET);
        if n <= SWITCH_THRESHOLD as usize || !are_coherent(self.simd, self.rays.directions(self.simd, first), n) {
            return false;
        }
        if first >= self.bundle_end {
            self.cull_bundle();
        }
        let mut outputs = [O::default(); PACKET];
        let mut packet = PacketTraversal::<S, O> {
            simd: self.simd,
            tree: self.tree,
            tester: self.tester,
            stats: &mut self.stats,
            stack: &mut self.packet_stack,
            single_stack: &mut self.stack,
            entry_points: (first < self.bundle_end).then_some(&self.entry_points),
            occluder: &mut self.occluder,
        };
        let is_traced = packet.trace::<F>(n, self.rays.packet(first), &mut outputs);
        if is_traced {
            for (lane, output) in outputs.into_iter().enumerate().take(n) {
                output.write(self.outputs, first + lane);
            }
        }
        is_traced
    }

    /// Finds the entry points of the next packets that share an octant.
    #[inline(always)]
    fn cull_bundle(&mut self) {
        if !F::IS_SPHERE || self.tree.bounded < MIN_PRIMS_TO_CULL {
            return;
        }
        if let Some((frustum, n)) = BundleFrustum::enclosing(self.simd, self.tree, self.rays, self.next_ray) {
            self.stats.nodes += self.entry_points.build::<S, F>(self.simd, self.tree, &frustum);
            self.bundle_end = self.next_ray + n;
        }
    }

    /// Tests the last occluder and its neighbours in the leaf; true if one of them certainly occludes this ray.
    #[inline(always)]
    fn test_last_occluder(&mut self, trav: &TravRay<'_, S, F>, state: &mut RayState<O>) -> bool {
        let Some(leaf) = self.occluder.take().map(PrimSlot::leaf) else { return false };
        // SAFETY: slots are those of the tree.
        let view = unsafe { self.tree.leaves.view(leaf) };
        self.stats.tests += view.count as u64;
        let bounds = trav.leaf_test.test(self.simd, view, state.t_max());
        if bounds.certain == 0 {
            return false;
        }
        // SAFETY: as above.
        unsafe {
            let slot = PrimSlot::new(leaf, Lane::new(bounds.certain.trailing_zeros() as usize));
            let certain = Some([0.0; 2]);
            state.intersect_candidate::<S, F>(self.simd, self.tree, self.tester, trav.ray.ray, slot, certain);
        }
        true
    }

    /// Resolves a single ray and writes its result.
    #[inline(always)]
    fn finish(&mut self, trav: &TravRay<'_, S, F>, state: &mut RayState<O>, index: usize) {
        let mut output = O::default();
        state.resolve::<S, F>(self.simd, self.tree, self.tester, &trav.ray, &mut output);
        output.write(self.outputs, index);
        self.stats.hits += state.uncounted_hits();
        self.occluder = state.last_occluder();
    }

    /// Queues an interleaved ray for its next child, without branches between nodes and leaves.
    #[inline(always)]
    fn schedule(&mut self, slot: usize, child: Child) {
        for line in 0..4 {
            self.simd.prefetch(self.tree.line(child).wrapping_add(line));
        }
        if child == Child::NONE {
            return self.free_slots.push_if(true, slot, child);
        }
        self.node_queue.push_if(child.is_node(), slot, child);
        self.leaf_queue.push_if(!child.is_node(), slot, child);
    }

    /// Visits all queued nodes, and schedules the nearest child of each.
    #[inline(always)]
    fn visit_nodes(&mut self) {
        let n = self.node_queue.len;
        self.stats.nodes += n as u64;
        self.node_queue.len = 0;
        for i in 0..n {
            let (slot, child) = self.node_queue.get(i);
            // SAFETY: written, as the ray is queued.
            let ActiveRay { trav, state, .. } = unsafe { self.active[slot].assume_init_ref() };
            // SAFETY: queued nodes are the root or children of nodes.
            let node = unsafe { self.tree.node(child) };
            let [enter, leave] = trav.boxes.cross(self.simd, node, trav.min, state.t_max());
            // SAFETY: written, as the ray is queued.
            let stack = unsafe { self.stacks[slot].assume_init_mut() };
            // SAFETY: one node of each level pushes at most seven children.
            let (enters, children) = unsafe { stack.spare() };
            stack.len += self.simd.compress_sorted(enter, leave, node.child_bits(), enters, children);
            // SAFETY: a queued ray has not popped `Child::NONE`, and the new entries are written.
            let next = unsafe { stack.pop(state.t_max()) };
            self.schedule(slot, next);
        }
    }

    /// Visits all queued leaves, and schedules the next child of each ray.
    #[inline(always)]
    fn visit_leaves(&mut self) {
        let n = self.leaf_queue.len;
        self.leaf_queue.len = 0;
        for i in 0..n {
            let (slot, leaf) = self.leaf_queue.get(i);
            // SAFETY: written, as the ray is queued.
            let ActiveRay { trav, state, .. } = unsafe { self.active[slot].assume_init_mut() };
            self.stats.tests += leaf.count() as u64;
            // SAFETY: queued leaves are children of nodes.
            if unsafe { state.intersect_leaf::<S, F>(self.simd, self.tree, self.tester, trav, leaf) }.is_break() {
                RayStack::init(&mut self.stacks[slot]);
            }
            // SAFETY: written, and a queued ray has not popped `Child::NONE`.
            let next = unsafe { self.stacks[slot].assume_init_mut().pop(state.t_max()) };
            self.schedule(slot, next);
        }
    }

    /// Resolves the rays whose slots have become free since there were `n_free`.
    #[inline(always)]
    fn retire(&mut self, n_free: usize) {
        for i in n_free..self.free_slots.len {
            let (slot, _) = self.free_slots.get(i);
            // SAFETY: written, as the ray has been queued.
            let ActiveRay { trav, state, index } = unsafe { self.active[slot].assume_init_mut() };
            let mut output = O::default();
            state.resolve::<S, F>(self.simd, self.tree, self.tester, &trav.ray, &mut output);
            output.write(self.outputs, *index);
            self.stats.hits += state.uncounted_hits();
        }
    }
}
