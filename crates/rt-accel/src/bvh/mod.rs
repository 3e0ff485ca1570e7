//! Bounding volume hierarchy.

mod build;
mod node;
mod refit;
mod spatial;
mod split;
mod traverse;
mod validate;

use core::ops::ControlFlow;

use glam::DVec3;
use rt_geometry::{Primitives, Probe};
use rt_math::Aabb;

use crate::{
    AcceleratorQueries, BuildError, BuildStats, RayQuery, RegionQuery, ValidationError, own_boxes::PrimBounds,
    ray_query::is_finite, structure::accelerator_by_walk,
};
use node::{Child, Node};
pub(crate) use node::{NodeBox, NodeRay};
pub(crate) use spatial::Cell;
use spatial::{Piece, SpatialTree};
use split::Item;
pub use split::SplitMethod;
pub(crate) use validate::encloses;

/// A binary tree of boxes: O(log n) per ray for most scenes, whatever the sizes of the primitives.
///
/// Built from the root down by one of the [`SplitMethod`]s. Nodes are cache lines of 64 bytes that hold the boxes of both children as `f32`, relative to the centre of the
/// tree and rounded outward; all culling arithmetic is `f64`. No leaf is deeper than 60, so that a traversal needs a
/// small fixed stack and never allocates.
///
/// The tree is a pure function of the primitives, with or without the feature `parallel`.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(remote = "Self"))]
pub struct Bvh {
    nodes: Vec<Node>,
    /// Bounded primitives, leaf by leaf.
    indices: Vec<u32>,
    root: Child,
    /// World position that the boxes are relative to.
    centre: DVec3,
    unbounded: Vec<u32>,
    leaves: usize,
    max_depth: u32,
    /// Number of bounded primitives, each of which is listed at least once.
    bounded: u32,
    /// Cells of the references to primitives that are listed several times.
    pieces: Vec<Piece>,
}

impl Bvh {
    /// Builds the tree: O(n log n) time, 25 to 45 bytes per primitive afterwards.
    ///
    /// # Errors
    ///
    /// [`BuildError`] if bounds are NaN, inverted or infinite, or 32 bits cannot number the primitives.
    pub fn build<P: Primitives>(primitives: &P) -> Result<Self, BuildError> {
        Self::build_with(primitives, SplitMethod::default())
    }

    /// Builds the tree by this method.
    ///
    /// # Errors
    ///
    /// As [`build`](Self::build).
    pub fn build_with<P: Primitives>(primitives: &P, method: SplitMethod) -> Result<Self, BuildError> {
        let PrimBounds { bounded, unbounded, union } = PrimBounds::collect(primitives)?;
        if bounded.is_empty() {
            return Ok(Self {
                nodes: Vec::new(),
                indices: Vec::new(),
                root: Child::leaf(0, 0),
                centre: DVec3::ZERO,
                unbounded,
                leaves: 0,
                max_depth: 0,
                bounded: 0,
                pieces: Vec::new(),
            });
        }
        let centre = union.centre();
        let mut items: Vec<_> =
            bounded.into_iter().map(|(index, own)| Item { bounds: NodeBox::outward(&own, centre), index }).collect();
        let SpatialTree { subtree: mut tree, mut indices, mut pieces } = match method {
            SplitMethod::Spatial => spatial::build(&items),
            SplitMethod::Median | SplitMethod::SurfaceArea => {
                let subtree = build::build(&mut items, method);
                let indices = items.iter().map(|item| item.index).collect();
                SpatialTree { subtree, indices, pieces: Vec::new() }
            }
        };
        tree.nodes.shrink_to_fit();
        indices.shrink_to_fit();
        pieces.shrink_to_fit();
        Ok(Self {
            nodes: tree.nodes,
            indices,
            root: tree.root,
            centre,
            unbounded,
            leaves: tree.leaves,
            max_depth: tree.max_depth,
            bounded: items.len() as u32,
            pieces,
        })
    }

    /// In visits of a node.
    fn sah_cost(&self) -> Option<f64> {
        let boxes = |node: &Node| [0, 1].map(|side| (node.child_box(side).half_area(), node.children[side].count));
        let [left, right] = [0, 1].map(|side| self.nodes.first().map(|root| root.child_box(side)));
        let whole = left?.union(right?).half_area();
        let below: f64 = self.nodes.iter().flat_map(boxes).map(|(area, count)| area * split::cost(count)).sum();
        (whole > 0.0).then(|| 1.0 + below / whole)
    }

    #[inline]
    fn leaf(&self, child: Child) -> &[u32] {
        &self.indices[child.first as usize..][..child.count as usize]
    }
}

impl AcceleratorQueries for Bvh {
    fn walk<P: Primitives, Q: RayQuery, S: Probe>(
        &self,
        primitives: &P,
        query: &mut Q,
        probe: &mut S,
    ) -> ControlFlow<()> {
        query.offer_all(primitives, &self.unbounded, probe)?;
        if is_finite(&query.ray().ray) {
            self.descend(primitives, query, probe)
        } else {
            query.offer_all(primitives, &self.indices, probe)
        }
    }

    fn search<Q: RegionQuery>(&self, query: &mut Q) -> ControlFlow<()> {
        query.offer_all(&self.unbounded)?;
        self.descend_region(query)
    }

    fn memory(&self) -> usize {
        size_of::<Self>()
            + self.nodes.capacity() * size_of::<Node>()
            + (self.indices.capacity() + self.unbounded.capacity()) * size_of::<u32>()
            + self.pieces.capacity() * size_of::<Piece>()
    }

    fn build_stats(&self) -> BuildStats {
        BuildStats {
            primitives: self.bounded as usize + self.unbounded.len(),
            unbounded: self.unbounded.len(),
            nodes: self.nodes.len(),
            leaves: self.leaves,
            max_depth: self.max_depth as usize,
            references: self.indices.len(),
            sah_cost: self.sah_cost(),
        }
    }

    fn validate<P: Primitives>(&self, primitives: &P) -> Result<(), ValidationError> {
        self.check(primitives)
    }

    fn for_each_box(&self, mut visit: impl FnMut(Aabb, u32)) {
        let mut pending = vec![(self.root, 0)];
        while let Some((child, depth)) = pending.pop() {
            let Some(node) = self.nodes.get(child.first as usize).filter(|_| child.count == 0) else { continue };
            for side in [1, 0] {
                visit(node.child_box(side).at(self.centre), depth + 1);
                pending.push((node.children[side], depth + 1));
            }
        }
    }
}

accelerator_by_walk!(Bvh);
#[cfg(feature = "serde")]
crate::saved::saved_and_checked!(Bvh, Bvh::check_shape);
