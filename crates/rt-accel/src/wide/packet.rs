//! Traversal of a coherent packet of eight rays: each box and each primitive is tested with all of them.
//!
//! Coherent rays may still pass a box through different sides, as rays along an axis do. At most [`SWITCH_THRESHOLD`]
//! active rays are traced one by one, as it is then faster to test eight boxes at once.
//!
//! Certain hits stay in SIMD lanes, and rays that hit the same triangle are intersected with it together.
//!
//! Wald, Slusallek, Benthin and Wagner, "Interactive Rendering with Coherent Ray Tracing", 2001.

use core::mem::MaybeUninit;

use rt_geometry::{PacketKernel, with_stream_buffers};
use rt_math::Interval;

use super::WideBvh;
use super::entry_points::EntryPoints;
use super::exact_packet::ExactPacketHits;
use super::f64x8::{F64x8, PACKET};
use super::filter::LeafTest;
use super::leaf::Lane;
use super::node::{Child, WideNode};
use super::packet_slabs::PacketSlabs;
use super::packet_spheres::SpherePacket;
use super::query::{Output, PacketResults, PrimSlot, PrimitiveTester, RayState, TravRay, TraversalStats};
use super::ray_f64::RayF64;
use super::ray_packet::RayPacket;
use super::simd::{Simd, take_lane};
use super::single_ray::traverse;
use super::stack::{STACK, StackStorage};
use super::stream_rays::PacketRays;

/// At most this many active rays continue one by one.
pub(super) const SWITCH_THRESHOLD: u32 = 2;

/// A child whose traversal is deferred.
#[derive(Clone, Copy)]
pub(super) struct Entry<S: Simd> {
    child: Child,
    /// Minimum of `t_near`.
    min_t_near: f32,
    /// By ray: `t` at entry, infinite for a miss.
    t_near: S::F32x8,
}

/// Stack of a packet. Entries below `len` are written.
pub(super) struct PacketStack<S: Simd> {
    entries: [MaybeUninit<Entry<S>>; STACK],
    len: usize,
}

impl<S: Simd> PacketStack<S> {
    /// Writes no entry: clearing them would take as long as several nodes.
    #[inline(always)]
    pub(super) fn new() -> Self {
        Self { entries: [const { MaybeUninit::uninit() }; STACK], len: 0 }
    }

    /// Inserts an entry into those from `first` on, so that the nearest is popped first.
    ///
    /// # Safety
    ///
    /// There must be fewer entries than [`STACK`]. This holds while each node pushes at most eight children, one of
    /// which is popped before the next node. No tree is deeper than a seventh of the stack.
    #[inline(always)]
    unsafe fn insert(&mut self, first: usize, entry: Entry<S>) {
        debug_assert!(self.len < STACK, "the tree is deeper than its builder promises");
        let mut at = self.len;
        self.len += 1;
        while at > first {
            // SAFETY: below the previous `len`.
            let before = unsafe { self.entries.get_unchecked(at - 1).assume_init() };
            if before.min_t_near >= entry.min_t_near {
                break;
            }
            // SAFETY: as the caller promises, as `at` is at most the previous `len`.
            unsafe { self.entries.get_unchecked_mut(at).write(before) };
            at -= 1;
        }
        // SAFETY: as above.
        unsafe { self.entries.get_unchecked_mut(at).write(entry) };
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<Entry<S>> {
        self.len = self.len.checked_sub(1)?;
        // SAFETY: below `len`.
        Some(unsafe { self.entries.get_unchecked(self.len).assume_init() })
    }
}

/// Rays of a packet that are traced one by one, prepared on first use.
struct SingleRays<'r, S: Simd, F> {
    prepared: [MaybeUninit<TravRay<'r, S, F>>; PACKET],
    /// A bit for each ray that is prepared.
    mask: u32,
}

impl<'r, S: Simd, F: LeafTest> SingleRays<'r, S, F> {
    /// `None` where the proofs of the filters do not apply.
    #[inline(always)]
    fn get(&mut self, simd: S, tree: &WideBvh, rays: PacketRays<'r>, lane: usize) -> Option<&TravRay<'r, S, F>> {
        if self.mask >> lane & 1 == 0 {
            let (ray, span) = rays.get(lane);
            self.prepared[lane].write(TravRay::new(simd, tree, ray, *span)?);
            self.mask |= 1 << lane;
        }
        // SAFETY: written now or before, as `mask` says.
        Some(unsafe { self.prepared[lane].assume_init_ref() })
    }
}

/// Results of a packet: those in lanes, and those of single rays.
struct Results<S: Simd, O> {
    lanes: PacketResults<S, O>,
    states: [MaybeUninit<RayState<O>>; PACKET],
    /// A bit for each ray with a state of its own.
    mask: u32,
}

impl<S: Simd, O: Output> Results<S, O> {
    #[inline(always)]
    fn empty(simd: S) -> Self {
        Self { lanes: PacketResults::empty(simd), states: [const { MaybeUninit::uninit() }; PACKET], mask: 0 }
    }

    /// State of a single ray.
    #[inline(always)]
    fn state(&mut self, lane: usize, span: Interval) -> &mut RayState<O> {
        if self.mask >> lane & 1 == 0 {
            self.states[lane].write(RayState::new(span));
            self.mask |= 1 << lane;
        }
        // SAFETY: written now or before, as `mask` says.
        unsafe { self.states[lane].assume_init_mut() }
    }

    /// State of a single ray, with its `t_max` lowered.
    #[inline(always)]
    fn state_until(&mut self, lane: usize, span: Interval, t_max: f32) -> &mut RayState<O> {
        let state = self.state(lane, span);
        state.shrink(t_max);
        state
    }
}

/// Entry of the rays into the boxes of a node, infinite for a miss, and a bit for each box that is hit. All boxes are tested
/// before any branch, which would be mispredicted.
#[inline(always)]
fn intersect_boxes<S: Simd, const SAME_OCTANT: bool>(
    simd: S,
    boxes: &PacketSlabs<S>,
    node: &WideNode,
    t_max: S::F32x8,
) -> ([S::F32x8; 8], u32) {
    let mut enters = [simd.splat(0.0); 8];
    let mut hit = 0;
    for (lane, enters) in enters.iter_mut().enumerate() {
        let [enter, leave] = boxes.cross::<SAME_OCTANT>(simd, |row| node.plane(simd, row, lane), t_max);
        *enters = simd.or_inf(enter, leave);
        hit |= u32::from(simd.le(enter, leave) != 0) << lane;
    }
    (enters, hit)
}

/// A coherent packet as the tests of boxes and primitives read it.
struct PacketView<'r, 'p, S: Simd, F: LeafTest> {
    rays: PacketRays<'r>,
    packet: &'p RayPacket<S>,
    leaf_rays: &'p F::Packet<S>,
}

/// Traverses a tree with eight rays.
pub(super) struct PacketTraversal<'q, 'j, S: Simd, O> {
    pub(super) simd: S,
    pub(super) tree: &'q WideBvh,
    pub(super) tester: &'q mut (dyn PrimitiveTester<O> + 'j),
    pub(super) stats: &'q mut TraversalStats,
    pub(super) stack: &'q mut PacketStack<S>,
    pub(super) single_stack: &'q mut StackStorage,
    /// Subtrees that the rays may hit, if known.
    pub(super) entry_points: Option<&'q EntryPoints>,
    /// Occluder of a ray in the previous packet, then in this one.
    pub(super) occluder: &'q mut Option<PrimSlot>,
}

impl<S: Simd, O: Output> PacketTraversal<'_, '_, S, O> {
    /// Traces the first `n` of eight coherent rays; false if the proofs do not apply to all eight.
    #[inline(always)]
    pub(super) fn trace<F: LeafTest>(&mut self, n: usize, rays: PacketRays<'_>, outputs: &mut [O; PACKET]) -> bool {
        let Some(packet) = RayPacket::new(self.simd, self.tree, rays.soa(self.simd)) else {
            return false;
        };
        let leaf_rays = F::packet(self.simd, &packet, self.tree);
        let mut t_max = packet.t_max;
        for lane in n..PACKET {
            t_max = self.simd.insert(t_max, lane, -1.0);
        }
        let mut results = Results::<S, O>::empty(self.simd);
        if !self.tree.unbounded.is_empty() {
            for (lane, (ray, span)) in rays.all().iter().enumerate().take(n) {
                let state = results.state(lane, *span);
                let _ = state.test_unbounded(self.tree, self.tester, ray);
                t_max = self.simd.insert(t_max, lane, state.t_max());
            }
        }
        let view = PacketView::<S, F> { rays, packet: &packet, leaf_rays: &leaf_rays };
        if O::ANY_HIT
            && let Some(slot) = self.occluder.take()
        {
            self.test_last_occluder(&view, &mut results, slot, &mut t_max);
        }
        let t_max = self.traverse_all(&view, &mut results, t_max);
        results.lanes.drop_beyond(self.simd, t_max);
        *self.occluder = results.lanes.last_occluder();
        self.stats.hits += results.lanes.resolve::<F>(self.simd, self.tree, self.tester, &packet, rays, outputs);
        let mut single = results.mask;
        while single != 0 {
            let lane = take_lane(&mut single);
            let (ray, span) = rays.get(lane);
            let state = results.state(lane, *span);
            state.merge(outputs[lane]);
            if self.occluder.is_none() {
                *self.occluder = state.last_occluder();
            }
            let ray = RayF64::new(self.simd, ray);
            state.resolve::<S, F>(self.simd, self.tree, self.tester, &ray, &mut outputs[lane]);
            self.stats.hits += state.uncounted_hits();
        }
        true
    }

    /// Tests the primitive that occluded the rays before.
    #[inline(always)]
    fn test_last_occluder<F: LeafTest>(
        &mut self,
        view: &PacketView<'_, '_, S, F>,
        results: &mut Results<S, O>,
        slot: PrimSlot,
        t_max: &mut S::F32x8,
    ) {
        let simd = self.simd;
        let active = simd.le(simd.splat(0.0), *t_max);
        self.stats.tests += u64::from(active.count_ones());
        // SAFETY: slots are those of the tree.
        let leaf = unsafe { self.tree.leaves.view(slot.leaf()) };
        let bounds = F::test_packet(simd, view.leaf_rays, leaf, slot.lane(), *t_max);
        let certain = bounds.certain & active;
        if certain != 0 {
            let left = results.lanes.record_certain(simd, slot, certain, [bounds.t_min, bounds.t_max], t_max);
            debug_assert_eq!(left, 0, "only any-hit queries know an occluder");
        }
    }

    /// Traverses all subtrees that the rays may hit; returns their `t_max`.
    #[inline(always)]
    fn traverse_all<F: LeafTest>(
        &mut self,
        view: &PacketView<'_, '_, S, F>,
        results: &mut Results<S, O>,
        mut t_max: S::F32x8,
    ) -> S::F32x8 {
        let simd = self.simd;
        let mut single_rays = SingleRays { prepared: [const { MaybeUninit::uninit() }; PACKET], mask: 0 };
        self.stack.len = 0;
        // Only trees of spheres have entry points; for others there is no second copy of the traversal.
        let Some(entry_points) = self.entry_points.filter(|_| F::IS_SPHERE) else {
            // SAFETY: the stack is empty.
            unsafe { self.stack.insert(0, Entry { child: self.tree.root, min_t_near: 0.0, t_near: simd.splat(0.0) }) };
            return self.traverse(view, results, t_max, &mut single_rays);
        };
        for subtree in entry_points.subtrees() {
            if simd.le(simd.splat(subtree.t_near), t_max) == 0 {
                break;
            }
            let Some(node) = self.tree.nodes.get(subtree.node as usize) else { break };
            let plane = |row| node.plane(simd, row, usize::from(subtree.lane));
            let [enter, leave] = view.packet.boxes.cross::<false>(simd, plane, t_max);
            let mask = simd.le(enter, leave);
            if mask == 0 {
                continue;
            }
            if subtree.child.is_node() {
                let t_near = simd.or_inf(enter, leave);
                // SAFETY: the stack is empty, as `traverse` pops all entries.
                unsafe { self.stack.insert(0, Entry { child: subtree.child, min_t_near: 0.0, t_near }) };
                t_max = self.traverse(view, results, t_max, &mut single_rays);
            } else {
                let lanes = u32::from(subtree.mask);
                // SAFETY: entry points are children of nodes of the tree, and this is not a node.
                t_max = unsafe { self.intersect_leaf(view, results, (subtree.child, lanes), mask, t_max) };
            }
        }
        t_max
    }

    /// Traverses all entries of the stack; returns the `t_max` of the rays.
    #[inline(always)]
    fn traverse<'r, F: LeafTest>(
        &mut self,
        view: &PacketView<'r, '_, S, F>,
        results: &mut Results<S, O>,
        mut t_max: S::F32x8,
        single_rays: &mut SingleRays<'r, S, F>,
    ) -> S::F32x8 {
        let simd = self.simd;
        let is_same_octant = view.packet.boxes.is_same_octant();
        while let Some(Entry { child, t_near, .. }) = self.stack.pop() {
            let mut mask = simd.le(t_near, t_max);
            let n_rays = mask.count_ones();
            if n_rays <= SWITCH_THRESHOLD {
                let ends = simd.to_array(t_max);
                while mask != 0 {
                    let lane = take_lane(&mut mask);
                    let state = results.state_until(lane, view.rays.get(lane).1, ends[lane]);
                    match single_rays.get(simd, self.tree, view.rays, lane) {
                        Some(trav) => {
                            let (stack, stats) = (&mut *self.single_stack, &mut *self.stats);
                            // SAFETY: entries are the root of the tree, subtrees of it, or children of its nodes.
                            unsafe {
                                traverse::<false, _, _, _>(
                                    simd,
                                    self.tree,
                                    self.tester,
                                    trav,
                                    state,
                                    child,
                                    stack,
                                    stats,
                                )
                            };
                        }
                        None => state.traverse_f64(self.tree, self.tester, &view.rays.get(lane).0),
                    }
                    t_max = simd.insert(t_max, lane, state.t_max());
                }
            } else if child.is_node() {
                self.stats.nodes += u64::from(n_rays);
                // SAFETY: entries are the root of the tree, subtrees of it, or children of its nodes.
                let node = unsafe { self.tree.node(child) };
                let first = self.stack.len;
                let (enters, mut hit) = if is_same_octant {
                    intersect_boxes::<S, true>(simd, &view.packet.boxes, node, t_max)
                } else {
                    intersect_boxes::<S, false>(simd, &view.packet.boxes, node, t_max)
                };
                while hit != 0 {
                    let lane = take_lane(&mut hit);
                    let t_near = enters[lane];
                    let entry = Entry { child: node.children[lane], min_t_near: simd.reduce_min(t_near), t_near };
                    // SAFETY: at most eight of each level, one of which is popped before the next.
                    unsafe { self.stack.insert(first, entry) };
                }
            } else {
                let all = (1 << child.count()) - 1;
                // SAFETY: a child of a node that is not a node itself.
                t_max = unsafe { self.intersect_leaf(view, results, (child, all), mask, t_max) };
            }
        }
        t_max
    }

    /// Intersects some primitives of a leaf, a bit for each, with the rays of the mask; returns the `t_max` of the rays.
    ///
    /// # Safety
    ///
    /// The leaf must be one of the tree.
    #[inline(always)]
    unsafe fn intersect_leaf<F: LeafTest>(
        &mut self,
        view: &PacketView<'_, '_, S, F>,
        results: &mut Results<S, O>,
        (leaf, mut lanes): (Child, u32),
        mut mask: u32,
        mut t_max: S::F32x8,
    ) -> S::F32x8 {
        let simd = self.simd;
        // SAFETY: as the caller promises.
        let leaf_view = unsafe { self.tree.leaves.view(leaf) };
        self.stats.tests += u64::from(mask.count_ones()) * u64::from(lanes.count_ones());
        while lanes != 0 {
            let lane = Lane::new(take_lane(&mut lanes));
            // SAFETY: as the caller promises.
            let slot = unsafe { PrimSlot::new(leaf, lane) };
            let bounds = F::test_packet(simd, view.leaf_rays, leaf_view, lane, t_max);
            let mut possible = bounds.possible & mask;
            if possible == 0 {
                continue;
            }
            let certain = bounds.certain & possible;
            if certain != 0 {
                let t_bounds = [bounds.t_min, bounds.t_max];
                let left = results.lanes.record_certain(simd, slot, certain, t_bounds, &mut t_max);
                possible &= !certain | left;
                mask &= simd.le(simd.splat(0.0), t_max);
                if possible == 0 {
                    continue;
                }
            }
            let uncertain = possible & !bounds.certain;
            if uncertain != 0 && !F::is_exact(leaf_view, lane) {
                let index = F::index(leaf_view, lane);
                if let Some(sphere) = if F::IS_SPHERE { self.tester.exact_sphere(index) } else { None } {
                    // Rays that start on a sphere are uncertain, and most of them leave it.
                    possible &= bounds.certain | !SpherePacket::all(simd, &sphere).miss_mask(simd, &view.packet.soa);
                    let open = possible & !bounds.certain;
                    if open.count_ones() > SWITCH_THRESHOLD {
                        let kernel = PacketKernel::Sphere(sphere);
                        let left = self.intersect_exactly(&kernel, (slot, open), view.rays, results, &mut t_max);
                        possible &= bounds.certain | left;
                        mask &= simd.le(simd.splat(0.0), t_max);
                    }
                } else if uncertain.count_ones() > SWITCH_THRESHOLD {
                    match self.tester.packet_kernel(index) {
                        PacketKernel::Instance => {
                            possible &= bounds.certain;
                            t_max = self.intersect_instance(index, view.rays, uncertain, results, t_max);
                        }
                        // A triangle in a tree of other primitives: a floor among spheres.
                        kernel @ PacketKernel::Triangle(_) if !O::ANY_HIT || self.tester.casts_shadow(index) => {
                            let left =
                                self.intersect_exactly(&kernel, (slot, uncertain), view.rays, results, &mut t_max);
                            possible &= bounds.certain | left;
                        }
                        _ => {}
                    }
                    mask &= simd.le(simd.splat(0.0), t_max);
                }
            }
            let (near, far) = (simd.to_array(bounds.t_min), simd.to_array(bounds.t_max));
            let ends = simd.to_array(t_max);
            while possible != 0 {
                let at = take_lane(&mut possible);
                let certain = (bounds.certain >> at & 1 != 0).then_some([near[at], far[at]]);
                let (ray, span) = view.rays.get(at);
                let state = results.state_until(at, *span, ends[at]);
                // SAFETY: as the caller promises.
                unsafe { state.intersect_candidate::<S, F>(simd, self.tree, self.tester, ray, slot, certain) };
                t_max = simd.insert(t_max, at, state.t_max());
                mask &= !(u32::from(state.t_max() < 0.0) << at);
            }
        }
        t_max
    }

    /// Intersects a sphere or a triangle exactly with all rays of a mask, and lowers their `t_max`. Returns the rays whose result is
    /// open.
    #[inline(always)]
    fn intersect_exactly(
        &self,
        kernel: &PacketKernel,
        (slot, mask): (PrimSlot, u32),
        rays: PacketRays<'_>,
        results: &mut Results<S, O>,
        t_max: &mut S::F32x8,
    ) -> u32 {
        let simd = self.simd;
        let hits = ExactPacketHits::of(self.tree.level, kernel, rays, mask);
        if hits.hit == 0 {
            return hits.uncertain;
        }
        let t = F64x8::new(simd, hits.t);
        let t_bounds = [t.round_down(simd), t.round_up(simd)];
        hits.uncertain | results.lanes.record_certain(simd, slot, hits.hit, t_bounds, t_max)
    }

    /// Intersects an instance with all rays of a mask; returns the `t_max` of the rays.
    #[inline(always)]
    fn intersect_instance(
        &mut self,
        index: u32,
        rays: PacketRays<'_>,
        mut mask: u32,
        results: &mut Results<S, O>,
        mut t_max: S::F32x8,
    ) -> S::F32x8 {
        let rays = rays.all();
        let mut outputs = [O::default(); PACKET];
        // Not compiled for the instructions of the kernel.
        with_stream_buffers(&mut |buffers| {
            let (stream, found) = O::of_buffers(buffers);
            let mut rest = mask;
            while rest != 0 {
                let lane = take_lane(&mut rest);
                stream.push(&rays[lane].0, results.state(lane, rays[lane].1).span());
            }
            self.tester.test_stream(index, stream, found);
            for (at, output) in outputs.iter_mut().enumerate().take(stream.len()) {
                *output = O::read(found, at);
            }
        });
        let ends = self.simd.to_array(t_max);
        for output in outputs {
            if mask == 0 {
                break;
            }
            let lane = take_lane(&mut mask);
            let state = results.state_until(lane, rays[lane].1, ends[lane]);
            state.merge(output);
            t_max = self.simd.insert(t_max, lane, state.t_max());
        }
        t_max
    }
}
