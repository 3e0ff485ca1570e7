//! Building and queries of a [`WideBvh`].

use core::ops::ControlFlow;

use rt_geometry::{Hit, HitStream, Primitives, Probe, RayStream, STREAM_CAPACITY};
use rt_math::{Aabb, Interval, Ray};

use super::batch::BatchContext;
use super::build::{BuildParams, PrimStats, build};
use super::f64x8::PACKET;
use super::leaf::{LeafKind, LeafWriter, Leaves};
use super::list_traversal::ListStream;
use super::node::Child;
use super::query::{PrimitiveTester, Tester, TraversalStats};
use super::simd::{DetectedSimd, SimdLevel, take_lane};
use super::single_ray::SingleContext;
use super::tree_query::TreeQuery;
use super::triangle_list::TriangleList;
use super::{WideBvh, sah};
use crate::erased::DynPrimitives;
use crate::ray_query::AllHits;
use crate::{Accelerator, BuildError, BuildStats, RayQuery, RegionQuery, ValidationError};

/// Traces a stream through the list of triangles at a level; false if there is no kernel for it.
type TraceList<R> = fn(ListStream<'_>, DetectedSimd, &RayStream, &mut R) -> bool;

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

    fn trace_batch<O: TreeQuery, P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        rays: &[(Ray, Interval)],
        outputs: &mut [O],
        probe: &mut S,
    ) where
        for<'a> Tester<'a, P, S>: PrimitiveTester<O>,
    {
        let n = rays.len().min(outputs.len());
        let (Some(rays), Some(outputs)) = (rays.get(..n), outputs.get_mut(..n)) else { return };
        let counts_work = probe.counts_work();
        let mut tester = Tester { primitives, probe };
        let mut context = BatchContext { tester: &mut tester, stats: TraversalStats::default(), counts_work };
        O::trace_batch(self, &mut context, rays, outputs);
        context.stats.add_to(tester.probe);
    }

    /// Version of [`closest_batch`](Accelerator::closest_batch) for a stream of rays of any directions. Returns false, without any result,
    /// unless the tree is small and most of its primitives are exact triangles. So it does for a probe that counts work.
    #[must_use]
    pub fn closest_stream<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        rays: &RayStream,
        hits: &mut HitStream,
        probe: &mut S,
    ) -> bool {
        let trace: TraceList<_> = |list, level, rays, hits| list.closest(level, rays, hits);
        self.trace_list(trace, rays, hits, probe.counts_work(), |at, ray, span, hits| {
            hits.set(at, self.closest(primitives, ray, span, probe).as_ref());
        })
    }

    /// Version of [`occluded_batch`](Accelerator::occluded_batch) for a stream. Returns false as
    /// [`closest_stream`](Self::closest_stream) does.
    #[must_use]
    pub fn occluded_stream<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        rays: &RayStream,
        occluded: &mut [bool],
        probe: &mut S,
    ) -> bool {
        let trace: TraceList<_> = |list, level, rays, occluded| list.occluded(level, rays, occluded);
        self.trace_list(trace, rays, occluded, probe.counts_work(), |at, ray, span, occluded| {
            if let Some(occluded) = occluded.get_mut(at) {
                *occluded = self.occluded(primitives, ray, span, probe);
            }
        })
    }

    /// Traces a stream through the list of triangles. `trace_open` traces a ray without a result. False, without any result, if there
    /// is no such list, or no kernel for it at this level.
    fn trace_list<R: ?Sized>(
        &self,
        trace: TraceList<R>,
        rays: &RayStream,
        results: &mut R,
        counts_work: bool,
        mut trace_open: impl FnMut(usize, &Ray, Interval, &mut R),
    ) -> bool {
        let Some(list) = self.list.as_ref().filter(|_| !counts_work) else { return false };
        let mut open = [0; STREAM_CAPACITY / PACKET];
        let traversal = ListStream { tree: self, list, open: &mut open };
        if !trace(traversal, self.level, rays, results) {
            return false;
        }
        for (first, open) in (0..).step_by(PACKET).zip(open) {
            let mut open = u32::from(open);
            while open != 0 {
                let at = first + take_lane(&mut open);
                let (ray, span) = rays.get(at);
                trace_open(at, &ray, span, results);
            }
        }
        true
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

    fn closest_batch<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        rays: &[(Ray, Interval)],
        hits: &mut [Option<Hit>],
        probe: &mut S,
    ) {
        self.trace_batch(primitives, rays, hits, probe);
    }

    fn occluded_batch<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        rays: &[(Ray, Interval)],
        occluded: &mut [bool],
        probe: &mut S,
    ) {
        self.trace_batch(primitives, rays, occluded, probe);
    }

    fn all_hits<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        ray: &Ray,
        span: Interval,
        hits: &mut Vec<Hit>,
        probe: &mut S,
    ) {
        let mut query = AllHits::new(ray, span, hits);
        let _ = query.test_leaf(primitives, &self.unbounded, probe);
        let mut stats = TraversalStats::default();
        let mut visit = |index: u32| _ = query.test_primitive(primitives, index, probe);
        if self.visit_all_candidates(ray, span, &mut visit, &mut stats) {
            stats.add_to(probe);
        } else {
            let _ = self.walk_bounded_erased(primitives, &mut query, probe);
        }
        query.finish();
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
