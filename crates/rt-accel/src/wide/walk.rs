//! The walk of a single ray.

use core::hint::black_box;
use core::marker::PhantomData;

use rt_math::{Interval, Ray};

use super::WideBvh;
use super::goal::{Goal, Judge, Prepared, take_lane};
use super::leaf::{BoxFilter, Filter, LeafKind, SphereFilter, TriangleFilter};
use super::node::{Child, Node};
use super::simd::{Kernel, Simd};
use super::stack::{Stack, StackRoom};

/// Work that nobody has counted yet.
#[derive(Default)]
pub(super) struct Work {
    pub(super) nodes: u64,
    pub(super) tests: u64,
    pub(super) hits: u64,
}

/// A query about one ray, and what came of it.
pub(super) struct Query<'q, A> {
    pub(super) judge: &'q mut dyn Judge,
    pub(super) work: Work,
    pub(super) answer: &'q mut A,
}

/// Sends one ray through a tree.
pub(super) struct Walk<'q, 'j, G: Goal> {
    pub(super) tree: &'q WideBvh,
    pub(super) query: &'q mut Query<'j, G::Answer>,
    pub(super) goal: PhantomData<G>,
}

impl<G: Goal> Kernel<&Ray, Interval> for Walk<'_, '_, G> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S, ray: &Ray, span: Interval) {
        match self.tree.leaves.kind {
            LeafKind::Watertight => self.walk::<S, TriangleFilter<true>>(simd, ray, span),
            LeafKind::Triangles => self.walk::<S, TriangleFilter<false>>(simd, ray, span),
            LeafKind::Spheres => self.walk::<S, SphereFilter>(simd, ray, span),
            LeafKind::Boxes => self.walk::<S, BoxFilter>(simd, ray, span),
        }
    }
}

impl<G: Goal> Walk<'_, '_, G> {
    #[inline(always)]
    fn walk<S: Simd, F: Filter>(self, simd: S, ray: &Ray, span: Interval) {
        let Self { tree, query, .. } = self;
        let judge = &mut *query.judge;
        let mut goal = G::new(span);
        if !tree.unbounded.is_empty() && goal.visit_unbounded(judge, ray).is_break() {
            *query.answer = goal.answer();
            return;
        }
        // Made here and not by the caller: what has just been stored cannot be loaded in other pieces at once.
        let Some(prepared) = Prepared::<S, F>::new(simd, tree, ray, span) else {
            goal.visit_unfiltered(judge, ray);
            *query.answer = goal.answer();
            return;
        };
        let mut room = StackRoom::new();
        // SAFETY: the root, and the filter that suits the leaves.
        unsafe { descend(simd, tree, judge, &prepared, &mut goal, tree.root, &mut room, &mut query.work) };
        goal.finish::<S, F>(simd, tree, judge, &prepared.ray, query.answer);
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
pub(super) unsafe fn descend<S: Simd, F: Filter, G: Goal>(
    simd: S,
    tree: &WideBvh,
    judge: &mut dyn Judge,
    prepared: &Prepared<'_, S, F>,
    goal: &mut G,
    mut child: Child,
    room: &mut StackRoom,
    work: &mut Work,
) {
    let mut stack = Stack::new(room);
    let (mut nodes, mut tests) = (0, 0);
    'walk: loop {
        while child.is_node() {
            nodes += 1;
            // SAFETY: the caller's child, or one of a node that came before.
            let node = unsafe { tree.node(child) };
            let [enter, leave] = prepared.boxes.cross(simd, node, prepared.min, goal.limit());
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
                unsafe { put_off(simd, tree, node, &simd.to_array(enter), lane, passed, &mut stack) }
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
        if unsafe { goal.visit(simd, tree, judge, black_box(prepared), child) }.is_break() {
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
unsafe fn put_off<S: Simd>(
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
