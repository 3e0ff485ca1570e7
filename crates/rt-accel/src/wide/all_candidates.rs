//! Traversal of a single ray for all of its hits: nothing found shortens the ray, so that the order does not matter.

use core::hint::black_box;
use core::marker::PhantomData;

use rt_math::{Interval, Ray};

use super::WideBvh;
use super::filter::{BoxTest, LeafTest, SphereTest, TriangleTest};
use super::leaf::{Lane, LeafKind};
use super::query::{TravRay, TraversalStats};
use super::ray::round_up;
use super::simd::{Simd, WithSimd, take_lane};
use super::stack::{ChildStack, StackStorage};

/// Visits all primitives that the filter does not exclude.
struct AllCandidates<'q, F> {
    tree: &'q WideBvh,
    visit: &'q mut dyn FnMut(u32),
    stats: &'q mut TraversalStats,
    /// Set if the proofs of the filters apply to the ray.
    is_filtered: &'q mut bool,
    leaf_test: PhantomData<F>,
}

impl WideBvh {
    /// Calls `visit` once for each bounded primitive that the ray may hit within `span`, in unspecified order. Counts nodes,
    /// and the tests of all other primitives of the leaves. False, without a call, for rays outside the range of the filters.
    #[inline(never)]
    pub(super) fn visit_all_candidates(
        &self,
        ray: &Ray,
        span: Interval,
        visit: &mut dyn FnMut(u32),
        stats: &mut TraversalStats,
    ) -> bool {
        match self.leaves.kind {
            LeafKind::Watertight => self.filter_all::<TriangleTest<true>>(ray, span, visit, stats),
            LeafKind::Triangles => self.filter_all::<TriangleTest<false>>(ray, span, visit, stats),
            LeafKind::Spheres => self.filter_all::<SphereTest>(ray, span, visit, stats),
            LeafKind::Boxes => self.filter_all::<BoxTest>(ray, span, visit, stats),
        }
    }

    fn filter_all<F: LeafTest>(
        &self,
        ray: &Ray,
        span: Interval,
        visit: &mut dyn FnMut(u32),
        stats: &mut TraversalStats,
    ) -> bool {
        let mut is_filtered = false;
        let (leaf_test, is_filtered_out) = (PhantomData::<F>, &mut is_filtered);
        let traversal = AllCandidates { tree: self, visit, stats, is_filtered: is_filtered_out, leaf_test };
        self.level.dispatch(traversal, ray, span);
        is_filtered
    }
}

impl<F: LeafTest> WithSimd<&Ray, Interval> for AllCandidates<'_, F> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S, ray: &Ray, span: Interval) {
        let Self { tree, visit, stats, is_filtered, .. } = self;
        let Some(trav) = TravRay::<S, F>::new(simd, tree, ray, span) else { return };
        *is_filtered = true;
        let t_max = round_up(span.max);
        let mut storage = StackStorage::new();
        let mut stack = ChildStack::new(&mut storage);
        let mut next = Some(tree.root);
        while let Some(child) = next {
            if child.is_node() {
                stats.nodes += 1;
                // SAFETY: the root, or a child of a node of the tree.
                let node = unsafe { tree.node(child) };
                let [enter, leave] = trav.boxes.cross(simd, node, trav.min, t_max);
                let mut hit = simd.le(enter, leave);
                while hit != 0 {
                    let other = node.children[take_lane(&mut hit)];
                    simd.prefetch(tree.line(other));
                    // SAFETY: each node pushes at most eight children, one of which is popped at once.
                    unsafe { stack.push(u64::from(other.to_bits())) };
                }
            } else {
                // SAFETY: a child of a node of the tree that is not a node itself.
                let leaf = unsafe { tree.leaves.view(child) };
                let mut possible = black_box(&trav).leaf_test.test(simd, leaf, t_max).possible;
                stats.tests += child.count() as u64 - u64::from(possible.count_ones());
                while possible != 0 {
                    visit(F::index(leaf, Lane::new(take_lane(&mut possible))));
                }
            }
            next = stack.pop();
        }
    }
}
