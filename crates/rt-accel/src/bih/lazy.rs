//! Bounding interval hierarchy that is built on demand.

#[cfg(feature = "serde")]
mod checked_serde;
mod node;
mod validate;

use core::ops::ControlFlow;

use rt_geometry::{Primitives, Probe};
use rt_math::Aabb;

use super::traverse::{BihNode, Hierarchy, traverse_ray, traverse_region};
use crate::prim_bounds::{PrimBounds, validate_lists};
use crate::{Accelerator, BuildError, BuildStats, RayQuery, Refit, RegionQuery, ValidationError};
use node::{LazyNode, NodeState};
use validate::Check;

/// [`Bih`](crate::Bih) whose nodes are split at the first visit.
///
/// Building takes O(n), and parts of the scene without rays are never sorted. Recommended for a first image as soon as
/// possible, or for scenes of which little is visible. After a visit of every node it is the full tree with the same
/// counters. Memory is 56 bytes per primitive at first and 40 to 60 at the end. That is about three times the memory of
/// the full tree, because nodes are allocated separately.
///
/// Any number of threads may query at once. A node is split once, by the first thread, while others wait. The split
/// depends on its primitives alone, so that the tree is independent of the order of rays. It is the only accelerator
/// whose queries allocate.
///
/// Copies, comparisons and statistics are of the current state.
#[derive(Clone, Debug, PartialEq)]
pub struct LazyBih {
    /// Bounds of all bounded primitives.
    bounds: Aabb,
    root: LazyNode,
    unbounded: Vec<u32>,
    primitives: u32,
}

impl LazyBih {
    /// Collects the padded bounds of all primitives: O(n).
    ///
    /// # Errors
    ///
    /// [`BuildError`] if bounds are NaN, inverted or infinite, or the primitives exceed 32-bit indices.
    pub fn build<P: Primitives>(primitives: &P) -> Result<Self, BuildError> {
        let boxes = PrimBounds::collect(primitives)?;
        let (bounds, primitives) = (boxes.finite_union(), (boxes.bounded.len() + boxes.unbounded.len()) as u32);
        Ok(Self { bounds, root: LazyNode::unsplit(boxes.bounded, bounds, 0), unbounded: boxes.unbounded, primitives })
    }

    /// Splits all remaining nodes.
    pub fn complete(&self) {
        let mut pending = vec![&self.root];
        while let Some(node) = pending.pop() {
            if let BihNode::Inner(_, children) = node.resolve() {
                pending.extend(children);
            }
        }
    }

    /// Visits all existing nodes depth first, with bounds and depth.
    fn for_each_node<'s>(&'s self, mut visit: impl FnMut(&NodeState<'s>, Aabb, u32)) {
        let mut pending = vec![(&self.root, self.bounds, 0)];
        while let Some((node, bounds, depth)) = pending.pop() {
            let state = node.state();
            visit(&state, bounds, depth);
            if let NodeState::Split(BihNode::Inner(planes, children)) = state {
                pending.extend([1, 0].map(|side| (children[side], planes.cut(side, bounds), depth + 1)));
            }
        }
    }
}

impl<'h> Hierarchy<'h> for &'h LazyBih {
    type Node = &'h LazyNode;

    fn bounds(self) -> &'h Aabb {
        &self.bounds
    }

    fn unbounded(self) -> &'h [u32] {
        &self.unbounded
    }

    fn primitives(self) -> u32 {
        self.primitives
    }

    fn root(self) -> &'h LazyNode {
        &self.root
    }

    #[inline(always)]
    fn resolve(self, node: &'h LazyNode) -> BihNode<'h, &'h LazyNode> {
        node.resolve()
    }
}

impl Accelerator for LazyBih {
    fn traverse_ray<P: Primitives, Q: RayQuery, S: Probe>(
        &self,
        primitives: &P,
        query: &mut Q,
        probe: &mut S,
    ) -> ControlFlow<()> {
        traverse_ray(self, primitives, query, probe)
    }

    fn traverse_region<Q: RegionQuery>(&self, query: &mut Q) -> ControlFlow<()> {
        traverse_region(self, query)
    }

    /// Describes the current state.
    fn memory(&self) -> usize {
        let mut heap = self.unbounded.capacity() * size_of::<u32>();
        self.for_each_node(|state, _, _| heap += state.heap());
        size_of::<Self>() + heap
    }

    /// Describes the current state: an unsplit node counts as a leaf.
    fn build_stats(&self) -> BuildStats {
        let mut stats = BuildStats {
            primitives: self.primitives as usize,
            unbounded: self.unbounded.len(),
            references: self.primitives as usize - self.unbounded.len(),
            ..BuildStats::default()
        };
        self.for_each_node(|state, _, depth| {
            stats.max_depth = stats.max_depth.max(depth as usize);
            if state.is_inner() {
                stats.nodes += 1;
            } else if stats.references > 0 {
                stats.leaves += 1;
            }
        });
        stats
    }

    /// Checks the existing nodes.
    fn validate<P: Primitives>(&self, primitives: &P) -> Result<(), ValidationError> {
        validate_lists(primitives, self.primitives, &self.unbounded)?;
        let mut check = Check::new(primitives, self.primitives);
        let mut verdict = Ok(());
        self.for_each_node(|state, bounds, depth| {
            if verdict.is_ok() {
                verdict = check.node(state, &bounds, depth);
            }
        });
        verdict?;
        check.finish(&self.unbounded)
    }

    /// Describes the current state.
    fn for_each_box(&self, mut visit: impl FnMut(Aabb, u32)) {
        if self.primitives as usize > self.unbounded.len() {
            self.for_each_node(|_, aabb, depth| visit(aabb, depth));
        }
    }
}

impl Refit for LazyBih {
    /// Rebuilds, as building is no slower than refitting.
    fn refit<P: Primitives>(&mut self, primitives: &P) -> Result<(), BuildError> {
        let fresh = Self::build(primitives)?;
        validate_lists(primitives, self.primitives, &self.unbounded).map_err(BuildError::Changed)?;
        *self = fresh;
        Ok(())
    }
}
