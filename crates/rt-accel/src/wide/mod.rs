//! Bounding volume hierarchy with eight children to a node, walked eight boxes at a time.
//!
//! * `build`: from boxes to a tree
//! * `node`, `leaf`: what a tree is made of
//! * `simd`: eight numbers at a time, on any processor
//! * `ray`, and the kinds of `leaf`: why what filters rule out is missed
//! * `list`: spheres without a tree; `handful`: few primitives without a tree
//! * `goal`: what a ray is sent for; `walk`: how it goes; `exact`: how it goes where filters cannot
//! * `packet`, over `across`: how eight go that agree; `round`, `facet`: how spheres and triangles are decided about for all of
//!   them; `shaft`: what many of them can meet; `flight`: how many go side by side, and remember what blocked them
//!
//! This is the only module with `unsafe`: for instructions that a processor may not have, for numbers that builders and
//! loaders have checked, and for memory that is written before it is read.
#![allow(unsafe_code, reason = "instructions chosen at run time, and loads without checks of what was checked before")]

mod batch;
mod build;
mod exact_triangle;
mod frustum;
mod huge_pages;
mod leaf;
mod node;
mod packet;
mod packet_rays;
mod packet_spheres;
mod packet_triangles;
mod query;
mod ray;
mod refit;
mod sah;
mod scalar;
mod simd;
mod single_ray;
mod small_set;
mod sphere_list;
mod stack;
mod validate;

use core::hint::select_unpredictable;
use core::ops::ControlFlow;

use crate::{
    Accelerator, AcceleratorQueries, BuildError, BuildStats, RayQuery, RegionQuery, ValidationError,
    bounded_depth::MAX_DEPTH,
};
use rt_geometry::{
    BatchKernel, Hit, PrimitiveGeometry, Primitives, Probe, SphereKernel, intersect_primitive_batch,
    intersect_primitive_uncounted, occludes_primitive_batch, occludes_primitive_uncounted,
};
use rt_math::{Aabb, DVec3, Interval, Ray};

use crate::ray_query::{Any, Closest, is_finite};
use batch::Ground;
use build::PrimStats;
pub use build::{BuildParams, Quality};
use leaf::{CacheLine, LeafKind, LeafWriter, Leaves};
use node::{Child, Node};
use query::{AnyHit, FirstHit, Goal, PrimitiveTester};
use simd::DetectedSimd;
pub use simd::SimdLevel;
use single_ray::{Query, Work};
pub use small_set::SmallSet;
pub(crate) use sphere_list::SphereList;

/// Entries of a walk's stack: seven children put off on every level, and one to spare.
const STACK: usize = 7 * MAX_DEPTH as usize + 8;

/// A tree of boxes with eight children to a node: the fastest to trace, whatever the primitives.
///
/// F64x8 boxes are tested at a time in `f32`, and so are the triangles, spheres or boxes in a leaf
/// ([`PrimitiveGeometry`]); what these filters leave is decided in `f64`, so that the answers are those of brute force to the
/// last bit. They run on AVX-512, AVX2 or anything, as the processor has it ([`SimdLevel`]), with the same answers.
///
/// Wald, Benthin and Boulos, "Getting Rid of Packets", 2008; Ernst and Greiner, "Multi Bounding Volume Hierarchies", 2008.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(remote = "Self"))]
pub struct WideBvh {
    /// The root comes first, and all others after their parents.
    nodes: Vec<Node>,
    leaves: Leaves,
    root: Child,
    /// World position that the boxes are relative to.
    centre: DVec3,
    /// Greatest coordinate relative to the centre.
    size: f64,
    unbounded: Vec<u32>,
    /// Number of bounded primitives.
    bounded: u32,
    n_leaves: usize,
    max_depth: u32,
    #[cfg_attr(feature = "serde", serde(skip))]
    level: DetectedSimd,
}

impl WideBvh {
    /// Builds the tree with medium quality: O(n log n) time, some 60 bytes per triangle afterwards.
    ///
    /// # Errors
    ///
    /// [`BuildError`] if bounds are NaN, inverted or infinite, or 28 bits cannot number the nodes and leaves.
    pub fn build<P: Primitives>(primitives: &P) -> Result<Self, BuildError> {
        Self::build_with(primitives, &BuildParams::default())
    }

    /// Builds the tree as the parameters say.
    ///
    /// # Errors
    ///
    /// As [`build`](Self::build).
    pub fn build_with<P: Primitives>(primitives: &P, params: &BuildParams) -> Result<Self, BuildError> {
        let stats = PrimStats::of(primitives)?;
        let (centre, size) = (stats.centre(), stats.size());
        let kind = LeafKind::of(stats.layouts, centre, size);
        let bounded = stats.bounded;
        let Some(tree) = build::build(primitives, &stats, kind, params) else {
            return Err(BuildError::TooMany { count: u64::from(bounded), limit: Child::LIMIT as u64 });
        };
        Ok(Self {
            leaves: Leaves::new(&LeafWriter { primitives, centre, kind }, &tree.listings),
            n_leaves: tree.listings.iter().map(|listing| listing.sizes.len()).sum(),
            nodes: tree.nodes,
            root: Child::node(0),
            centre,
            size,
            unbounded: stats.unbounded,
            bounded,
            max_depth: tree.depth,
            level: DetectedSimd::default(),
        })
    }

    /// The same tree, walked by other instructions: for tests and comparisons, as the best that the processor has are
    /// chosen when it is built. What the processor does not have is replaced by the portable level.
    #[must_use]
    pub fn with_level(mut self, level: SimdLevel) -> Self {
        self.level = DetectedSimd::new(level);
        self
    }

    /// The instructions that it is walked by.
    pub const fn level(&self) -> SimdLevel {
        self.level.level()
    }

    /// Sends one ray for the goal.
    #[inline]
    fn send<G: Goal, P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        ray: &Ray,
        span: Interval,
        probe: &mut S,
    ) -> G::Answer {
        let mut tester = Asked { tree: self, primitives, probe };
        let mut answer = G::Answer::default();
        let mut query = Query { tester: &mut tester, work: Work::default(), answer: &mut answer };
        G::walk(self, &mut query, ray, span);
        let Work { nodes, tests, hits } = query.work;
        probe.work(nodes, tests, hits);
        answer
    }

    /// Sends many rays for the goal.
    fn send_all<G: Goal, P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        rays: &[(Ray, Interval)],
        answers: &mut [G::Answer],
        probe: &mut S,
    ) {
        let n = rays.len().min(answers.len());
        let (Some(rays), Some(answers)) = (rays.get(..n), answers.get_mut(..n)) else { return };
        let mut tester = Asked { tree: self, primitives, probe };
        let mut ground = Ground { tester: &mut tester, work: Work::default() };
        G::fly(self, &mut ground, rays, answers);
        let Work { nodes, tests, hits } = ground.work;
        probe.work(nodes, tests, hits);
    }

    /// Offers the query every bounded primitive that can matter to it, in `f64`.
    fn walk_bounded<P: Primitives, Q: RayQuery, S: Probe>(
        &self,
        primitives: &P,
        query: &mut Q,
        probe: &mut S,
    ) -> ControlFlow<()> {
        if is_finite(&query.ray().ray) {
            return self.descend(primitives, query, probe);
        }
        for leaf in self.leaves() {
            query.offer_all(primitives, self.leaves.indices(leaf), probe)?;
        }
        ControlFlow::Continue(())
    }

    /// The node that a child is.
    ///
    /// # Safety
    ///
    /// The child must be a node, and the root or a child of a node of this tree.
    #[inline(always)]
    unsafe fn node(&self, child: Child) -> &Node {
        debug_assert!(child.is_node() && child.number() < self.nodes.len(), "checked when it is made or loaded");
        // SAFETY: as the caller promises; nodes have no other children than builders have made and loaders have checked.
        unsafe { self.nodes.get_unchecked(child.number()) }
    }

    /// Where a child lies in memory.
    #[inline(always)]
    fn line(&self, child: Child) -> *const CacheLine {
        let node = self.nodes.as_ptr().wrapping_add(child.number()).cast();
        select_unpredictable(child.is_node(), node, self.leaves.line(child))
    }
}

/// The primitives of a query, and who counts.
struct Asked<'a, P, S> {
    tree: &'a WideBvh,
    primitives: &'a P,
    probe: &'a mut S,
}

impl<P: Primitives, S: Probe> PrimitiveTester for Asked<'_, P, S> {
    fn closest(&mut self, index: u32, ray: &Ray, span: Interval) -> Option<Hit> {
        intersect_primitive_uncounted(self.primitives, index, ray, span, self.probe)
    }

    fn occluded(&mut self, index: u32, ray: &Ray, span: Interval) -> bool {
        occludes_primitive_uncounted(self.primitives, index, ray, span, self.probe)
    }

    fn round(&mut self, index: u32) -> Option<SphereKernel> {
        if let PrimitiveGeometry::ExactSphere(sphere) = self.primitives.geometry(index) { Some(sphere) } else { None }
    }

    fn is_structure(&mut self, index: u32) -> bool {
        matches!(self.primitives.batch_kernel(index), BatchKernel::Instance)
    }

    fn closest_together(&mut self, index: u32, rays: &[(Ray, Interval)], hits: &mut [Option<Hit>]) {
        intersect_primitive_batch(self.primitives, index, rays, hits, self.probe);
    }

    fn occluded_together(&mut self, index: u32, rays: &[(Ray, Interval)], blocked: &mut [bool]) {
        occludes_primitive_batch(self.primitives, index, rays, blocked, self.probe);
    }

    fn closest_unbounded(&mut self, ray: &Ray, span: Interval) -> Option<Hit> {
        let mut query = Closest::new(ray, span);
        let _ = query.offer_all(self.primitives, &self.tree.unbounded, self.probe);
        query.hit
    }

    fn occluded_unbounded(&mut self, ray: &Ray, span: Interval) -> bool {
        Any::new(ray, span).offer_all(self.primitives, &self.tree.unbounded, self.probe).is_break()
    }

    fn closest_unfiltered(&mut self, ray: &Ray, span: Interval) -> Option<Hit> {
        let mut query = Closest::new(ray, span);
        let _ = self.tree.walk_bounded(self.primitives, &mut query, self.probe);
        query.hit
    }

    fn occluded_unfiltered(&mut self, ray: &Ray, span: Interval) -> bool {
        self.tree.walk_bounded(self.primitives, &mut Any::new(ray, span), self.probe).is_break()
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
        self.send::<FirstHit, _, _>(primitives, ray, span, probe)
    }

    #[inline]
    fn occluded<P: Primitives, S: Probe>(&self, primitives: &P, ray: &Ray, span: Interval, probe: &mut S) -> bool {
        self.send::<AnyHit, _, _>(primitives, ray, span, probe)
    }

    fn closest_batch<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        rays: &[(Ray, Interval)],
        hits: &mut [Option<Hit>],
        probe: &mut S,
    ) {
        self.send_all::<FirstHit, _, _>(primitives, rays, hits, probe);
    }

    fn occluded_batch<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        rays: &[(Ray, Interval)],
        blocked: &mut [bool],
        probe: &mut S,
    ) {
        self.send_all::<AnyHit, _, _>(primitives, rays, blocked, probe);
    }
}

impl AcceleratorQueries for WideBvh {
    fn walk<P: Primitives, Q: RayQuery, S: Probe>(
        &self,
        primitives: &P,
        query: &mut Q,
        probe: &mut S,
    ) -> ControlFlow<()> {
        query.offer_all(primitives, &self.unbounded, probe)?;
        self.walk_bounded(primitives, query, probe)
    }

    fn search<Q: RegionQuery>(&self, query: &mut Q) -> ControlFlow<()> {
        query.offer_all(&self.unbounded)?;
        self.descend_region(query)
    }

    fn memory(&self) -> usize {
        size_of::<Self>()
            + self.nodes.capacity() * size_of::<Node>()
            + self.leaves.memory()
            + self.unbounded.capacity() * size_of::<u32>()
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
        self.check(primitives)
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

#[cfg(feature = "serde")]
crate::saved::saved_and_checked!(WideBvh, WideBvh::check_shape);
