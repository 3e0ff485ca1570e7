//! The walk of a single ray.

use core::hint::black_box;
use core::marker::PhantomData;

use rt_math::{Interval, Ray};

use super::WideBvh;
use super::leaf::{BoxTest, LeafKind, LeafTest, SphereTest, TriangleTest};
use super::node::{Child, Node};
use super::query::{Goal, PrimitiveTester, TravRay, take_lane};
use super::simd::{Simd, WithSimd};
use super::stack::{Stack, StackStorage};

/// Work that nobody has counted yet.
#[derive(Default)]
pub(super) struct Work {
    pub(super) nodes: u64,
    pub(super) tests: u64,
    pub(super) hits: u64,
}

/// A query about one ray, and what came of it.
pub(super) struct Query<'q, A> {
    pub(super) tester: &'q mut dyn PrimitiveTester,
    pub(super) work: Work,
    pub(super) answer: &'q mut A,
}

/// Sends one ray through a tree.
pub(super) struct Walk<'q, 'j, G: Goal> {
    pub(super) tree: &'q WideBvh,
    pub(super) query: &'q mut Query<'j, G::Answer>,
    pub(super) goal: PhantomData<G>,
}

impl<G: Goal> WithSimd<&Ray, Interval> for Walk<'_, '_, G> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S, ray: &Ray, span: Interval) {
        match self.tree.leaves.kind {
            LeafKind::Watertight => self.walk::<S, TriangleTest<true>>(simd, ray, span),
            LeafKind::Triangles => self.walk::<S, TriangleTest<false>>(simd, ray, span),
            LeafKind::Spheres => self.walk::<S, SphereTest>(simd, ray, span),
            LeafKind::Boxes => self.walk::<S, BoxTest>(simd, ray, span),
        }
    }
}

impl<G: Goal> Walk<'_, '_, G> {
    #[inline(always)]
    fn walk<S: Simd, F: LeafTest>(self, simd: S, ray: &Ray, span: Interval) {
        let Self { tree, query, .. } = self;
        let tester = &mut *query.tester;
        let mut goal = G::new(span);
        if !tree.unbounded.is_empty() && goal.visit_unbounded(tester, ray).is_break() {
            *query.answer = goal.answer();
            return;
        }
        // Made here and not by the caller: what has just been stored cannot be loaded in other pieces at once.
        let Some(trav) = TravRay::<S, F>::new(simd, tree, ray, span) else {
            goal.visit_unfiltered(tester, ray);
            *query.answer = goal.answer();
            return;
        };
        let mut room = StackStorage::new();
        // SAFETY: the root, and the filter that suits the leaves.
        unsafe { descend(simd, tree, tester, &trav, &mut goal, tree.root, &mut room, &mut query.work) };
        goal.finish::<S, F>(simd, tree, tester, &trav.ray, query.answer);
        query.work.hits = goal.uncounted_hits();
    }
}

/// Walks all below a child.
///
/// # Safety
///
/// The child must be the root of the tree or one of a node of it, and the filter that of the kind of its leaves.
#[expect(clippy::too_many_arguments, reason = "one function of the state of a ray, which others keep elsewhere")]
#[inline(always)]
pub(super) unsafe fn descend<S: Simd, F: LeafTest, G: Goal>(
    simd: S,
    tree: &WideBvh,
    tester: &mut dyn PrimitiveTester,
    trav: &TravRay<'_, S, F>,
    goal: &mut G,
    mut child: Child,
    room: &mut StackStorage,
    work: &mut Work,
) {
    let mut stack = Stack::new(room);
    let (mut nodes, mut tests) = (0, 0);
    'walk: loop {
        while child.is_node() {
            nodes += 1;
            // SAFETY: the caller's child, or one of a node that came before.
            let node = unsafe { tree.node(child) };
            let [enter, leave] = trav.boxes.cross(simd, node, trav.min, goal.limit());
            let mut passed = simd.le(enter, leave);
            if passed == 0 {
                let Some(next) = pop(&mut stack, goal) else { break 'walk };
                child = next;
                continue;
            }
            let lane = take_lane(&mut passed);
            child = if passed == 0 {
                node.children[lane]
            } else if G::ORDERED {
                // SAFETY: one node of each level puts off seven children at most.
                unsafe { push_sorted(simd, tree, node, &simd.to_array(enter), lane, passed, &mut stack) }
            } else {
                while passed != 0 {
                    let other = node.children[take_lane(&mut passed)];
                    simd.prefetch(tree.line(other));
                    // SAFETY: one node of each level puts off seven children at most.
                    unsafe { stack.push(u64::from(other.to_bits())) };
                }
                node.children[lane]
            };
        }
        tests += child.count() as u64;
        // Out of memory, where a number is repeated eight times as it is read. Compilers would else repeat all of them before the
        // ray sets out, and keep them on the stack; most rays come to one leaf or two. Nothing but speed depends on it.
        // SAFETY: as for nodes, and this is none.
        if unsafe { goal.visit(simd, tree, tester, black_box(trav), child) }.is_break() {
            break;
        }
        let Some(next) = pop(&mut stack, goal) else { break };
        child = next;
    }
    work.nodes += nodes;
    work.tests += tests;
}

/// What was put off last and still matters.
#[inline(always)]
fn pop<G: Goal>(stack: &mut Stack<'_>, goal: &G) -> Option<Child> {
    // Where nothing is ordered nothing is said of where it is entered.
    if G::ORDERED { stack.pop_before(goal.limit()) } else { stack.pop() }
}

/// Returns the nearest of the children `lane` and `others`, and pushes the rest, the nearest of them last.
///
/// # Safety
///
/// There must be one other at least, and room for seven entries more.
#[inline(always)]
unsafe fn push_sorted<S: Simd>(
    simd: S,
    tree: &WideBvh,
    node: &Node,
    enter: &[f32; 8],
    lane: usize,
    mut others: u32,
    stack: &mut Stack<'_>,
) -> Child {
    let second = take_lane(&mut others);
    simd.prefetch(tree.line(node.children[lane]));
    simd.prefetch(tree.line(node.children[second]));
    let a = Stack::key(enter[lane], node.children[lane]);
    let b = Stack::key(enter[second], node.children[second]);
    let (nearest, farther) = (a.min(b), a.max(b));
    if others == 0 {
        // SAFETY: there is room.
        unsafe { stack.push(farther) };
        return Child::from_bits(nearest as u32);
    }
    // A network for four, of which the last may be missing: what is nearer cannot be predicted, so nothing is asked.
    let third = take_lane(&mut others);
    simd.prefetch(tree.line(node.children[third]));
    let c = Stack::key(enter[third], node.children[third]);
    let is_fourth = others != 0;
    let fourth = if is_fourth { take_lane(&mut others) } else { third };
    let d = if is_fourth { Stack::key(enter[fourth], node.children[fourth]) } else { u64::MAX };
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
    // SAFETY: there is room for seven, and an eighth that is popped at once is what stacks have to spare.
    unsafe { stack.push(nearest) };
    while others != 0 {
        let lane = take_lane(&mut others);
        simd.prefetch(tree.line(node.children[lane]));
        // SAFETY: as above.
        unsafe { stack.insert(start, Stack::key(enter[lane], node.children[lane])) };
    }
    let last = stack.len() - 1;
    // SAFETY: one was pushed above; all below have been written.
    unsafe {
        stack.set_len(last);
        Child::from_bits(stack.get(last) as u32)
    }
}
