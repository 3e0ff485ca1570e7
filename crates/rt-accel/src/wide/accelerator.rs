//! Building and queries of a [`WideBvh`].

use core::ops::ControlFlow;

use rt_geometry::{Hit, HitStream, Primitives, Probe, RayStream};
use rt_math::{Aabb, Interval, Ray};

use super::build::{BuildParams, PrimStats, build};
use super::leaf::{LeafKind, LeafWriter, Leaves};
use super::node::Child;
use super::query::{PrimitiveTester, Tester, TraversalStats};
use super::simd::{DetectedSimd, SimdLevel};
use super::single_ray::SingleContext;
use super::stream_traversal::StreamContext;
use super::tree_query::TreeQuery;
use super::triangle_list::TriangleList;
use super::{WideBvh, sah};
use crate::erased::DynPrimitives;
use crate::ray_query::AllHits;
use crate::{Accelerator, BuildError, BuildStats, RayQuery, RegionQuery, ValidationError};

impl WideBvh {
    /// Builds the tree with medium quality: O(n log n) time, some 60 bytes per triangle afterwards.
    ///
    /// # Errors
    ///
    /// [`BuildError`] if bounds are NaN, inverted or infinite, or if nodes and leaves exceed 28-bit indices.
    pub fn build<P: Primitives>(primitives: &P) -> Result<Self, BuildError> {
        Self::build_with(primitives, &BuildParams::default())
    }

    /// Builds the tree with parameters.
    ///
    /// # Errors
    ///
    /// See [`build`](Self::build).
    pub fn build_with<P: Primitives>(primitives: &P, params: &BuildParams) -> Result<Self, BuildError> {
        Self::build_erased(&DynPrimitives::new(primitives), params)
    }

    /// Compiled once: the dynamic calls take a hundredth of the time.
    fn build_erased(primitives: &DynPrimitives<'_>, params: &BuildParams) -> Result<Self, BuildError> {
        let stats = PrimStats::of(primitives)?;
        let (centre, size) = (stats.centre(), stats.size());
        let kind = LeafKind::of(stats.layouts, centre, size);
        let bounded = stats.bounded;
        let Some(tree) = build(primitives, &stats, kind, params) else {
            return Err(BuildError::TooMany { count: u64::from(bounded), limit: Child::LIMIT as u64 });
        };
        Ok(Self {
            leaves: Leaves::new(&LeafWriter { primitives, centre, kind }, &tree.listings),
            n_leaves: tree.listings.iter().map(|listing| listing.sizes.len()).sum(),
            nodes: tree.nodes,
            list: TriangleList::of(primitives, kind, centre, size),
            root: Child::node(0),
            centre,
            size,
            unbounded: stats.unbounded,
            bounded,
            max_depth: tree.depth,
            level: DetectedSimd::default(),
        })
    }

    /// Replaces the instruction set, for tests and comparisons; builders select the best. The portable level replaces
    /// one that the processor does not support.
    #[must_use]
    pub fn with_level(mut self, level: SimdLevel) -> Self {
        self.level = DetectedSimd::new(level);
        self
    }

    #[inline]
    fn trace<O: TreeQuery, P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        ray: &Ray,
        span: Interval,
        probe: &mut S,
    ) -> O
    where
        for<'a> Tester<'a, P, S>: PrimitiveTester<O>,
    {
        let mut tester = Tester { primitives, probe };
        let mut output = O::default();
        let stats = TraversalStats::default();
        let mut context = SingleContext { tester: &mut tester, stats, output: &mut output };
        O::trace(self, &mut context, ray, span);
        context.stats.add_to(tester.probe);
        output
    }

    fn trace_stream<O: TreeQuery, P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        rays: &RayStream,
        outputs: &mut O::OfStream,
        probe: &mut S,
    ) where
        for<'a> Tester<'a, P, S>: PrimitiveTester<O>,
    {
        let counts_work = probe.counts_work();
        let mut tester = Tester { primitives, probe };
        let mut context = StreamContext { tester: &mut tester, stats: TraversalStats::default(), counts_work };
        O::trace_stream(self, &mut context, rays, outputs);
        context.stats.add_to(tester.probe);
    }

    /// All hits, not sorted yet.
    pub(crate) fn collect_hits<'h, P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        ray: &Ray,
        span: Interval,
        hits: &'h mut Vec<Hit>,
        probe: &mut S,
    ) -> AllHits<'h> {
        let mut query = AllHits::new(ray, span, hits);
        let _ = query.test_leaf(primitives, &self.unbounded, probe);
        let mut stats = TraversalStats::default();
        let mut visit = |index: u32| _ = query.test_primitive(primitives, index, probe);
        if self.visit_all_candidates(ray, span, &mut visit, &mut stats) {
            stats.add_to(probe);
        } else {
            let _ = self.walk_bounded_erased(primitives, &mut query, probe);
        }
        query
    }
}

impl Accelerator for WideBvh {
    #[inline]
    fn closest<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        ray: &Ray,
        span: Interval,
        probe: &mut S,
    ) -> Option<Hit> {
        self.trace(primitives, ray, span, probe)
    }

    #[inline]
    fn occluded<P: Primitives, S: Probe>(&self, primitives: &P, ray: &Ray, span: Interval, probe: &mut S) -> bool {
        self.trace(primitives, ray, span, probe)
    }

    fn closest_stream<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        rays: &RayStream,
        hits: &mut HitStream,
        probe: &mut S,
    ) {
        self.trace_stream::<Option<Hit>, _, _>(primitives, rays, hits, probe);
    }

    fn occluded_stream<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        rays: &RayStream,
        occluded: &mut [bool],
        probe: &mut S,
    ) {
        self.trace_stream::<bool, _, _>(primitives, rays, occluded, probe);
    }

    fn all_hits<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        ray: &Ray,
        span: Interval,
        hits: &mut Vec<Hit>,
        probe: &mut S,
    ) {
        self.collect_hits(primitives, ray, span, hits, probe).finish();
    }

    fn traverse_ray<P: Primitives, Q: RayQuery, S: Probe>(
        &self,
        primitives: &P,
        query: &mut Q,
        probe: &mut S,
    ) -> ControlFlow<()> {
        query.test_leaf(primitives, &self.unbounded, probe)?;
        self.walk_bounded_erased(primitives, query, probe)
    }

    fn traverse_region<Q: RegionQuery>(&self, query: &mut Q) -> ControlFlow<()> {
        query.test_leaf(&self.unbounded)?;
        self.descend_region(query)
    }

    fn memory(&self) -> usize {
        self.total_bytes()
    }

    fn build_stats(&self) -> BuildStats {
        BuildStats {
            primitives: self.bounded as usize + self.unbounded.len(),
            unbounded: self.unbounded.len(),
            nodes: self.nodes.len(),
            leaves: self.n_leaves,
            max_depth: self.max_depth as usize,
            references: self.leaves().map(|leaf| leaf.count()).sum(),
            sah_cost: sah::sah_cost(&self.nodes),
        }
    }

    fn validate<P: Primitives>(&self, primitives: &P) -> Result<(), ValidationError> {
        self.validate_primitives(&DynPrimitives::new(primitives))
    }

    fn for_each_box(&self, mut visit: impl FnMut(Aabb, u32)) {
        let mut pending = vec![(self.root, 0)];
        while let Some((child, depth)) = pending.pop() {
            let Some(node) = self.nodes.get(child.number()).filter(|_| child.is_node()) else { continue };
            for (bounds, child) in node.children() {
                visit(bounds.at(self.centre), depth + 1);
                pending.push((child, depth + 1));
            }
        }
    }
}
