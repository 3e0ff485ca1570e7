//! The two walks of the filters: to the first hit, and to any.

use core::mem::MaybeUninit;

use rt_math::{DVec3, Hit, Interval, Ray, ShearedRay, SlabRay};

use super::WideBvh;
use super::copy::Copied;
use super::leaf::{BoxFilter, Filter, LeafKind, LeafView, PreparedRay, SphereFilter, TriangleFilter};
use super::node::{Child, Node};
use super::ray::{FilterRay, LaneRay, at_least, at_most};
use super::simd::{Answer, Kernel, Simd};
use super::stack::Stack;

/// Decides about what the filters leave: the caller's primitives, behind one call.
pub(super) trait Judge {
    /// The hit on a primitive within the span.
    fn closest(&mut self, index: u32, ray: &SlabRay, span: Interval) -> Option<Hit>;
    /// True if the primitive blocks the ray within the span.
    fn occluded(&mut self, index: u32, ray: &SlabRay, span: Interval) -> bool;
}

/// What a walk has done, and found.
pub(super) struct Outcome {
    pub(super) nodes: u64,
    pub(super) tests: u64,
    pub(super) hits: u64,
    /// The first hit, if there is one.
    pub(super) hit: Hit,
}

impl Outcome {
    pub(super) const fn new() -> Self {
        Self { nodes: 0, tests: 0, hits: 0, hit: NO_HIT }
    }
}

const NO_HIT: Hit = Hit { t: f64::INFINITY, instance: 0, primitive: 0, uv: [0.0; 2] };

/// Who decides, and where it is written what comes of it.
pub(super) struct Query<'q> {
    pub(super) judge: &'q mut dyn Judge,
    pub(super) outcome: Outcome,
}

/// The ray and its filter, spread over lanes by the compiler where that is best.
struct Prepared<S: Simd, F> {
    ray: PreparedRay<S>,
    min: f32,
    filter: F,
}

impl<S: Simd, F: Filter> Prepared<S, F> {
    #[inline(always)]
    fn new(simd: S, tree: &WideBvh, ray: &Ray, span: Interval) -> Option<Self> {
        let lanes = LaneRay::new(simd, ray);
        let [x, y, z, _] = simd.to_doubles(lanes.inverse);
        let ray = PreparedRay {
            lanes,
            filter: FilterRay::new(simd, &lanes, span, tree.centre, tree.size)?,
            sheared: ShearedRay::with_inverse(ray, DVec3::new(x, y, z)),
        };
        Some(Self { min: at_most(span.min), filter: F::new(simd, &ray, span, tree), ray })
    }
}

/// The lowest lane of a mask that is not 0, which loses it.
#[inline(always)]
fn take_lane(mask: &mut u32) -> usize {
    let lane = mask.trailing_zeros() as usize;
    *mask &= *mask - 1;
    lane & 7
}

/// A primitive that is hit for sure, to be decided about at the end.
#[derive(Clone, Copy)]
struct Candidate {
    near: f32,
    leaf: Child,
    lane: usize,
}

/// Candidates that may be undecided at a time.
const MAX_CANDIDATES: usize = 8;

/// Finds the first hit of a ray for which the filters are proven.
pub(super) struct FirstHit<'q, 'j> {
    pub(super) tree: &'q WideBvh,
    pub(super) query: &'q mut Query<'j>,
}

impl Kernel for FirstHit<'_, '_> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S, ray: &Ray, span: Interval) -> Answer {
        match self.tree.leaves.kind {
            LeafKind::Watertight => self.walk::<S, TriangleFilter, true>(simd, ray, span),
            LeafKind::Triangles => self.walk::<S, TriangleFilter, false>(simd, ray, span),
            LeafKind::Spheres => self.walk::<S, SphereFilter, false>(simd, ray, span),
            LeafKind::Boxes => self.walk::<S, BoxFilter, false>(simd, ray, span),
        }
    }
}

/// The nearest hit so far, and who may still be nearer.
struct Search<'q, 'j, const COPIES: bool> {
    tree: &'q WideBvh,
    ray: &'q Ray,
    judge: &'q mut (dyn Judge + 'j),
    hits: u64,
    /// Ends at the nearest hit.
    span: Interval,
    is_hit: bool,
    /// The nearest hit, if there is one.
    best: Hit,
    /// What is entered or hit after this cannot be first.
    limit: f32,
    candidates: [MaybeUninit<Candidate>; MAX_CANDIDATES],
    n_candidates: usize,
    /// Of all candidates.
    least_near: f32,
}

impl<const COPIES: bool> Search<'_, '_, COPIES> {
    #[inline(always)]
    fn decide<S: Simd, F: Filter>(&mut self, simd: S, ray: &PreparedRay<S>, leaf: LeafView<'_>, lane: usize) {
        let index = F::index(leaf, lane);
        let hit = if COPIES {
            let hit = Copied { leaf, lane, index }.hit::<S, false>(simd, ray, self.ray, self.span);
            self.hits += u64::from(hit.is_some());
            hit
        } else {
            self.judge.closest(index, &SlabRay::new(self.ray), self.span)
        };
        if let Some(hit) = hit
            && (!self.is_hit | hit.precedes(&self.best))
        {
            self.span.max = hit.t;
            self.limit = self.limit.min(at_least(hit.t));
            self.is_hit = true;
            // One number after the other: all at once would have to wait until they are in memory.
            self.best.t = hit.t;
            self.best.instance = hit.instance;
            self.best.primitive = hit.primitive;
            self.best.uv[0] = hit.uv[0];
            self.best.uv[1] = hit.uv[1];
        }
    }

    /// A hit is certain: nothing behind its far bound can be first. False if there is no room to remember it.
    #[inline(always)]
    fn remember(&mut self, leaf: Child, lane: usize, [near, far]: [f32; 2]) -> bool {
        if near > self.limit {
            return true;
        }
        if far < self.least_near {
            // The usual case: nearer than all others for sure.
            self.n_candidates = 0;
            self.least_near = near;
        } else {
            self.least_near = self.least_near.min(near);
        }
        self.limit = self.limit.min(far);
        let has_room = self.n_candidates < MAX_CANDIDATES;
        if has_room {
            self.candidates[self.n_candidates % MAX_CANDIDATES].write(Candidate { near, leaf, lane });
            self.n_candidates += 1;
        }
        has_room
    }

    #[inline(always)]
    fn visit<S: Simd, F: Filter>(&mut self, simd: S, ray: &PreparedRay<S>, filter: &F, leaf: Child) {
        let view = self.tree.leaves.view(leaf);
        let verdict = filter.judge(simd, view, self.limit);
        if verdict.maybe == 0 {
            return;
        }
        let (mut sure, mut unsure) = (verdict.sure, verdict.maybe & !verdict.sure);
        if sure != 0 {
            let (near, far) = (simd.to_array(verdict.near), simd.to_array(verdict.far));
            while sure != 0 {
                let lane = take_lane(&mut sure);
                if !self.remember(leaf, lane, [near[lane], far[lane]]) {
                    unsure |= 1 << lane;
                }
            }
        }
        while unsure != 0 {
            let lane = take_lane(&mut unsure);
            self.decide::<S, F>(simd, ray, view, lane);
        }
    }

    #[inline(always)]
    fn finish<S: Simd, F: Filter>(&mut self, simd: S, ray: &PreparedRay<S>) {
        if COPIES && self.n_candidates == 1 && !self.is_hit {
            // The usual case: a hit that is certain and first. Nothing is asked, so that the next ray need not wait.
            // SAFETY: the first has been written.
            let Candidate { leaf, lane, .. } = unsafe { self.candidates[0].assume_init() };
            let leaf = self.tree.leaves.view(leaf);
            let index = F::index(leaf, lane);
            let copied = Copied { leaf, lane, index };
            let Some(hit) = copied.hit::<S, true>(simd, ray, self.ray, self.span) else { return };
            self.hits += 1;
            self.is_hit = true;
            self.best.t = hit.t;
            self.best.primitive = hit.primitive;
            self.best.uv[0] = hit.uv[0];
            self.best.uv[1] = hit.uv[1];
            return;
        }
        for i in 0..self.n_candidates {
            // SAFETY: the first `n_candidates` have been written.
            let Candidate { near, leaf, lane } = unsafe { self.candidates[i % MAX_CANDIDATES].assume_init() };
            if near <= self.limit {
                self.decide::<S, F>(simd, ray, self.tree.leaves.view(leaf), lane);
            }
        }
    }
}

impl FirstHit<'_, '_> {
    #[inline(always)]
    fn walk<S: Simd, F: Filter, const COPIES: bool>(self, simd: S, ray: &Ray, span: Interval) -> Answer {
        let Self { tree, query } = self;
        // Made here, where it stays in registers: what a caller has just stored cannot be loaded in other pieces at once.
        let Some(prepared) = Prepared::<S, F>::new(simd, tree, ray, span) else { return Answer::Unproven };
        let mut search = Search::<COPIES> {
            tree,
            ray,
            judge: query.judge,
            hits: 0,
            span,
            is_hit: false,
            best: NO_HIT,
            limit: at_least(span.max),
            candidates: [const { MaybeUninit::uninit() }; MAX_CANDIDATES],
            n_candidates: 0,
            least_near: f32::INFINITY,
        };
        let mut stack = Stack::new();
        let (mut nodes, mut tests) = (0, 0);
        let mut child = tree.root;
        'walk: loop {
            while child.is_node() {
                nodes += 1;
                let Some(node) = tree.nodes.get(child.number()) else { break 'walk };
                let (enter, mut passed) = prepared.ray.filter.cross(simd, node, prepared.min, search.limit);
                if passed == 0 {
                    let Some(next) = stack.pop(search.limit) else { break 'walk };
                    child = next;
                    continue;
                }
                let lane = take_lane(&mut passed);
                if passed == 0 {
                    child = node.children[lane];
                    continue;
                }
                child = put_off(simd, tree, node, &simd.to_array(enter), lane, passed, &mut stack);
            }
            tests += child.count() as u64;
            search.visit(simd, &prepared.ray, &prepared.filter, child);
            let Some(next) = stack.pop(search.limit) else { break };
            child = next;
        }
        search.finish::<S, F>(simd, &prepared.ray);
        query.outcome = Outcome { nodes, tests, hits: search.hits, hit: search.best };
        search.is_hit.into()
    }
}

/// Returns the nearest of the children `lane` and `others`, and pushes the rest, the nearest of them last.
#[inline(always)]
fn put_off<S: Simd>(
    simd: S,
    tree: &WideBvh,
    node: &Node,
    enter: &[f32; 8],
    lane: usize,
    mut others: u32,
    stack: &mut Stack,
) -> Child {
    let second = take_lane(&mut others);
    simd.prefetch(tree.line(node.children[lane]));
    simd.prefetch(tree.line(node.children[second]));
    let a = Stack::key(enter[lane], node.children[lane]);
    let b = Stack::key(enter[second], node.children[second]);
    let (nearest, farther) = (a.min(b), a.max(b));
    if others == 0 {
        stack.push(farther);
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
    let start = stack.len;
    stack.put(start, farthest);
    stack.put(start + usize::from(is_fourth), c);
    stack.put(start + usize::from(is_fourth) + 1, b);
    stack.len += 2 + usize::from(is_fourth);
    if others == 0 {
        return Child::from_bits(nearest as u32);
    }
    stack.push(nearest);
    while others != 0 {
        let lane = take_lane(&mut others);
        simd.prefetch(tree.line(node.children[lane]));
        stack.insert(start, Stack::key(enter[lane], node.children[lane]));
    }
    stack.len -= 1;
    Child::from_bits(stack.get(stack.len) as u32)
}

/// Finds out whether a ray for which the filters are proven is blocked.
pub(super) struct AnyHit<'q, 'j> {
    pub(super) tree: &'q WideBvh,
    pub(super) query: &'q mut Query<'j>,
}

impl Kernel for AnyHit<'_, '_> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S, ray: &Ray, span: Interval) -> Answer {
        match self.tree.leaves.kind {
            LeafKind::Watertight => self.walk::<S, TriangleFilter, true>(simd, ray, span),
            LeafKind::Triangles => self.walk::<S, TriangleFilter, false>(simd, ray, span),
            LeafKind::Spheres => self.walk::<S, SphereFilter, false>(simd, ray, span),
            LeafKind::Boxes => self.walk::<S, BoxFilter, false>(simd, ray, span),
        }
    }
}

impl AnyHit<'_, '_> {
    #[inline(always)]
    fn walk<S: Simd, F: Filter, const COPIES: bool>(self, simd: S, ray: &Ray, span: Interval) -> Answer {
        let Self { tree, query } = self;
        let Some(prepared) = Prepared::<S, F>::new(simd, tree, ray, span) else { return Answer::Unproven };
        let limit = at_least(span.max);
        let mut stack = Stack::new();
        let (mut nodes, mut tests, mut hits) = (0, 0, 0);
        let mut child = tree.root;
        let blocked = 'walk: loop {
            while child.is_node() {
                nodes += 1;
                let Some(node) = tree.nodes.get(child.number()) else { break 'walk false };
                let (_, mut passed) = prepared.ray.filter.cross(simd, node, prepared.min, limit);
                if passed == 0 {
                    let Some(next) = stack.pop(f32::INFINITY) else { break 'walk false };
                    child = next;
                    continue;
                }
                child = node.children[take_lane(&mut passed)];
                while passed != 0 {
                    let other = node.children[take_lane(&mut passed)];
                    simd.prefetch(tree.line(other));
                    stack.push(u64::from(other.to_bits()));
                }
            }
            tests += child.count() as u64;
            let view = tree.leaves.view(child);
            let verdict = prepared.filter.judge(simd, view, limit);
            if verdict.sure != 0 {
                hits += 1;
                break true;
            }
            let mut unsure = verdict.maybe;
            while unsure != 0 {
                let lane = take_lane(&mut unsure);
                let is_blocked = if COPIES {
                    let copied = Copied { leaf: view, lane, index: F::index(view, lane) };
                    let hit = copied.hit::<S, false>(simd, &prepared.ray, ray, span);
                    hits += u64::from(hit.is_some());
                    hit.is_some()
                } else {
                    query.judge.occluded(F::index(view, lane), &SlabRay::new(ray), span)
                };
                if is_blocked {
                    break 'walk true;
                }
            }
            let Some(next) = stack.pop(f32::INFINITY) else { break false };
            child = next;
        };
        query.outcome = Outcome { nodes, tests, hits, hit: NO_HIT };
        blocked.into()
    }
}
