//! Traversal of a single ray.

use core::hint::black_box;
use core::marker::PhantomData;

use rt_math::{Interval, Ray};

use super::WideBvh;
use super::filter::LeafTest;
use super::node::{Child, WideNode};
use super::predicted_child::predicted_child;
use super::query::{Output, PrimitiveTester, RayState, TravRay, TraversalStats};
use super::simd::{Simd, WithSimd, take_lane};
use super::stack::{ChildStack, StackStorage};

/// Inputs and outputs of a query for one ray.
pub(crate) struct SingleContext<'q, O> {
    pub(super) tester: &'q mut dyn PrimitiveTester<O>,
    pub(super) stats: TraversalStats,
    pub(super) output: &'q mut O,
}

/// Traces one ray through a tree whose leaves have the test `F`.
pub(super) struct SingleTraversal<'q, 'j, O, F> {
    pub(super) tree: &'q WideBvh,
    pub(super) context: &'q mut SingleContext<'j, O>,
    pub(super) leaf_test: PhantomData<F>,
}

impl<O: Output, F: LeafTest> WithSimd<&Ray, Interval> for SingleTraversal<'_, '_, O, F> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S, ray: &Ray, span: Interval) {
        let Self { tree, context, .. } = self;
        let tester = &mut *context.tester;
        let mut state = RayState::new(span);
        if !tree.unbounded.is_empty() && state.test_unbounded(tree, tester, ray).is_break() {
            *context.output = state.output();
            return;
        }
        // Prepared here and not by the caller: a wide load of what was just stored in other pieces stalls.
        let Some(trav) = TravRay::<S, F>::new(simd, tree, ray, span) else {
            state.traverse_f64(tree, tester, ray);
            *context.output = state.output();
            return;
        };
        let mut storage = StackStorage::new();
        // SAFETY: the root, and the test of the leaves' kind.
        unsafe {
            let (storage, stats) = (&mut storage, &mut context.stats);
            traverse::<true, _, _, _>(simd, tree, tester, &trav, &mut state, tree.root, storage, stats);
        }
        state.resolve::<S, F>(simd, tree, tester, &trav.ray, context.output);
        context.stats.hits = state.uncounted_hits();
    }
}

/// Traverses the subtree below a child. If `PREDICTED`, branches choose the next child: streams trace incoherent rays one
/// by one, whose branches would be mispredicted.
///
/// # Safety
///
/// The child must be the root of the tree or one of a node of it. The test must be that of the kind of its leaves.
#[expect(clippy::too_many_arguments, reason = "callers keep the state of a ray in different places")]
#[inline(always)]
pub(super) unsafe fn traverse<const PREDICTED: bool, S: Simd, F: LeafTest, O: Output>(
    simd: S,
    tree: &WideBvh,
    tester: &mut dyn PrimitiveTester<O>,
    trav: &TravRay<'_, S, F>,
    state: &mut RayState<O>,
    mut child: Child,
    storage: &mut StackStorage,
    stats: &mut TraversalStats,
) {
    simd.call_part(
        #[inline(always)]
        || {
            let mut stack = ChildStack::new(storage);
            let (mut nodes, mut tests) = (0, 0);
            'traversal: loop {
                while child.is_node() {
                    nodes += 1;
                    // SAFETY: the caller's child, or one of a node that came before.
                    let node = unsafe { tree.node(child) };
                    let [enter, leave] = trav.boxes.cross(simd, node, trav.min, state.t_max());
                    let mut hit = simd.le(enter, leave);
                    if hit == 0 {
                        let Some(next) = pop(&mut stack, state) else { break 'traversal };
                        child = next;
                        continue;
                    }
                    let first_child =
                        |lane: usize| if PREDICTED { predicted_child(node, lane) } else { node.children[lane & 7] };
                    let lane = take_lane(&mut hit);
                    child = if hit == 0 {
                        first_child(lane)
                    } else if !O::ANY_HIT {
                        // SAFETY: one node of each level pushes at most seven children.
                        unsafe { push_sorted(simd, tree, node, &simd.to_array(enter), lane, hit, &mut stack) }
                    } else {
                        while hit != 0 {
                            let other = node.children[take_lane(&mut hit)];
                            simd.prefetch(tree.line(other));
                            // SAFETY: one node of each level pushes at most seven children.
                            unsafe { stack.push(u64::from(other.to_bits())) };
                        }
                        first_child(lane)
                    };
                }
                tests += child.count() as u64;
                // Broadcast the ray's numbers from memory at each leaf. Compilers would otherwise broadcast all of them before the
                // loop and spill them, although most rays visit one or two leaves. Only speed depends on it.
                // SAFETY: a child of a node that is not a node itself.
                if unsafe { state.intersect_leaf(simd, tree, tester, black_box(trav), child) }.is_break() {
                    break;
                }
                let Some(next) = pop(&mut stack, state) else { break };
                child = next;
            }
            stats.nodes += nodes;
            stats.tests += tests;
        },
    )
}

/// Pops the nearest child that still matters.
#[inline(always)]
fn pop<O: Output>(stack: &mut ChildStack<'_>, state: &RayState<O>) -> Option<Child> {
    // Any-hit queries push children without keys.
    if O::ANY_HIT { stack.pop() } else { stack.pop_before(state.t_max()) }
}

/// Returns the nearest of the children `lane` and `others`, and pushes the rest, the nearest of them last.
///
/// # Safety
///
/// There must be at least one other, and room for seven more entries.
#[inline(always)]
unsafe fn push_sorted<S: Simd>(
    simd: S,
    tree: &WideBvh,
    node: &WideNode,
    enter: &[f32; 8],
    lane: usize,
    mut others: u32,
    stack: &mut ChildStack<'_>,
) -> Child {
    let second = take_lane(&mut others);
    simd.prefetch(tree.line(node.children[lane]));
    simd.prefetch(tree.line(node.children[second]));
    let a = ChildStack::key(enter[lane], node.children[lane]);
    let b = ChildStack::key(enter[second], node.children[second]);
    let (nearest, farther) = (a.min(b), a.max(b));
    if others == 0 {
        // SAFETY: there is room.
        unsafe { stack.push(farther) };
        return Child::from_bits(nearest as u32);
    }
    // A sorting network for four, the last of which may be missing: branches on the order would be mispredicted.
    let third = take_lane(&mut others);
    simd.prefetch(tree.line(node.children[third]));
    let c = ChildStack::key(enter[third], node.children[third]);
    let is_fourth = others != 0;
    let fourth = if is_fourth { take_lane(&mut others) } else { third };
    let d = if is_fourth { ChildStack::key(enter[fourth], node.children[fourth]) } else { u64::MAX };
    simd.prefetch(tree.line(node.children[fourth]));
    let (c, d) = (c.min(d), c.max(d));
    let (nearest, b) = (nearest.min(c), nearest.max(c));
    let (c, farthest) = (farther.min(d), farther.max(d));
    let (b, c) = (b.min(c), b.max(c));
    let start = stack.len();
    // SAFETY: there is room, and all entries below the new end have been written.
    unsafe {
        stack.put(start, farthest);
        stack.put(start + usize::from(is_fourth), c);
        stack.put(start + usize::from(is_fourth) + 1, b);
        stack.set_len(start + 2 + usize::from(is_fourth));
    }
    if others == 0 {
        return Child::from_bits(nearest as u32);
    }
    // SAFETY: there is room for seven, and stacks have a spare entry for an eighth that is popped at once.
    unsafe { stack.push(nearest) };
    while others != 0 {
        let lane = take_lane(&mut others);
        simd.prefetch(tree.line(node.children[lane]));
        // SAFETY: as above.
        unsafe { stack.insert(start, ChildStack::key(enter[lane], node.children[lane])) };
    }
    let last = stack.len() - 1;
    // SAFETY: one was pushed above; all below have been written.
    unsafe {
        stack.set_len(last);
        Child::from_bits(stack.get(last) as u32)
    }
}
