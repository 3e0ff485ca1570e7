//! Bounding volume hierarchy with eight children per node, tested eight boxes at a time.
//!
//! * `build`: binned SAH, reinsertion, and collapse of a binary tree into wide nodes
//! * `node`, `leaf`: the tree; `stack`, `huge_pages`: its memory; `validate`, `refit`, `sah`
//! * `simd`: eight numbers at a time on any processor
//! * `query`: closest-hit and any-hit queries, and exact tests of the caller's primitives
//! * `single_ray`, `packet`, `batch`: traversal; `scalar`: traversal in `f64`, outside the range of the filters
//! * `ray`, `packet_rays`: rays prepared for conservative box tests, with the proofs; `frustum`: culling of ray bundles
//! * `exact_triangle`, `packet_triangles`, `packet_spheres`: exact tests in SIMD lanes
//! * `small_set`, `sphere_list`: primitives without a tree
//!
//! This is the only module with `unsafe`: for instructions chosen at run time, for unchecked loads of what builders and
//! loaders have validated, and for memory that is written before it is read.
#![allow(unsafe_code, reason = "instructions chosen at run time, and unchecked loads of validated data")]

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
use rt_geometry::{Hit, Primitives, Probe};
use rt_math::{Aabb, DVec3, Interval, Ray};

use crate::ray_query::is_finite;
use batch::BatchContext;
use build::PrimStats;
pub use build::{BuildParams, Quality};
use leaf::{CacheLine, LeafKind, LeafWriter, Leaves};
use node::{Child, Node};
use query::{Output, PrimitiveTester, Tester};
use simd::DetectedSimd;
pub use simd::SimdLevel;
use single_ray::{SingleContext, TraversalStats};
pub use small_set::SmallSet;
pub(crate) use sphere_list::SphereList;

/// Entries of a traversal stack: seven deferred children on every level, and one to spare.
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
    /// The root is the first; all others come after their parents.
    nodes: Vec<Node>,
    leaves: Leaves,
    root: Child,
    /// World position of the local origin.
    centre: DVec3,
    /// Maximum coordinate relative to the centre.
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
    /// [`BuildError`] if bounds are NaN, inverted or infinite, or if 28 bits cannot number the nodes and leaves.
    pub fn build<P: Primitives>(primitives: &P) -> Result<Self, BuildError> {
        Self::build_with(primitives, &BuildParams::default())
    }

    /// Builds the tree with parameters.
    ///
    /// # Errors
    ///
    /// See [`build`](Self::build).
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

    /// Replaces the instruction set, for tests and comparisons; builders select the best. The portable level stands in for
    /// one that the processor does not support.
    #[must_use]
    pub fn with_level(mut self, level: SimdLevel) -> Self {
        self.level = DetectedSimd::new(level);
        self
    }

    /// Instruction set of traversal.
    pub const fn level(&self) -> SimdLevel {
        self.level.level()
    }

    #[inline]
    fn trace<O: Output, P: Primitives, S: Probe>(&self, primitives: &P, ray: &Ray, span: Interval, probe: &mut S) -> O
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

    fn trace_batch<O: Output, P: Primitives, S: Probe>(
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
        let mut tester = Tester { primitives, probe };
        let mut context = BatchContext { tester: &mut tester, stats: TraversalStats::default() };
        O::trace_batch(self, &mut context, rays, outputs);
        context.stats.add_to(tester.probe);
    }

    /// Traverses the bounded primitives in `f64`.
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

    /// # Safety
    ///
    /// The child must be a node, and the root or a child of a node of this tree.
    #[inline(always)]
    unsafe fn node(&self, child: Child) -> &Node {
        debug_assert!(child.is_node() && child.number() < self.nodes.len(), "checked by builders and loaders");
        // SAFETY: as the caller promises; builders and loaders have checked the children of nodes.
        unsafe { self.nodes.get_unchecked(child.number()) }
    }

    /// Memory location of a child.
    #[inline(always)]
    fn line(&self, child: Child) -> *const CacheLine {
        let node = self.nodes.as_ptr().wrapping_add(child.number()).cast();
        select_unpredictable(child.is_node(), node, self.leaves.line(child))
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
        self.validate_primitives(primitives)
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
crate::saved::saved_and_checked!(WideBvh, WideBvh::validate_shape);
