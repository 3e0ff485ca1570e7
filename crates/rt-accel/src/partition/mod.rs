//! Trees that cut space in two again and again (Fuchs, Kedem and Naylor 1980), whatever it is that cuts.

mod build;
mod cut;
mod node;
mod shape;
mod validate;
mod walk;

use rt_math::Aabb;

use crate::BuildStats;
pub(crate) use build::{Chooser, Task};
pub(crate) use cut::{Crossing, Cut};
pub(crate) use node::Node;
pub(crate) use shape::Shape;

/// A binary space partition with cuts of one kind: leaves tile all of space, and a primitive is listed in every leaf
/// that its own box touches.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(remote = "Self"))]
pub(crate) struct Partition<C> {
    /// In depth-first order; never empty.
    nodes: Vec<Node<C>>,
    /// Bounded primitives leaf by leaf, by rising index in each.
    indices: Vec<u32>,
    /// The box around all own boxes.
    bounds: Aabb,
    unbounded: Vec<u32>,
    primitives: u32,
}

impl<C: Cut> Partition<C> {
    pub(crate) fn memory(&self) -> usize {
        size_of::<Self>()
            + self.nodes.capacity() * size_of::<Node<C>>()
            + (self.indices.capacity() + self.unbounded.capacity()) * size_of::<u32>()
    }

    pub(crate) fn build_stats(&self) -> BuildStats {
        let mut max_depth = 0;
        self.for_each_box(|_, depth| max_depth = max_depth.max(depth as usize));
        BuildStats {
            primitives: self.primitives as usize,
            unbounded: self.unbounded.len(),
            nodes: self.nodes.len() / 2,
            leaves: if self.indices.is_empty() { 0 } else { self.nodes.len().div_ceil(2) },
            max_depth,
            references: self.indices.len(),
            sah_cost: None,
        }
    }

    /// Visits a box around every part of the box around everything, the whole first.
    pub(crate) fn for_each_box(&self, mut visit: impl FnMut(Aabb, u32)) {
        if self.indices.is_empty() {
            return;
        }
        let mut pending = vec![(self.bounds, 0)];
        for node in &self.nodes {
            let Some((cell, depth)) = pending.pop() else { return };
            visit(cell, depth);
            if let Node::Split { cut, .. } = node {
                let [below, above] = cut.divide(&cell);
                pending.extend([(above, depth + 1), (below, depth + 1)]);
            }
        }
    }

    fn leaf(&self, first: u32, count: u32) -> &[u32] {
        &self.indices[first as usize..][..count as usize]
    }
}

/// Makes a [`AcceleratorQueries`](crate::AcceleratorQueries) of a type with one unnamed field, a partition.
macro_rules! structure_by_partition {
    ($structure:ty) => {
        impl $crate::AcceleratorQueries for $structure {
            fn walk<P: rt_geometry::Primitives, Q: $crate::RayQuery, S: rt_geometry::Probe>(
                &self,
                primitives: &P,
                query: &mut Q,
                probe: &mut S,
            ) -> core::ops::ControlFlow<()> {
                self.0.walk(primitives, query, probe)
            }

            fn search<Q: $crate::RegionQuery>(&self, query: &mut Q) -> core::ops::ControlFlow<()> {
                self.0.search(query)
            }

            fn memory(&self) -> usize {
                self.0.memory()
            }

            fn build_stats(&self) -> $crate::BuildStats {
                self.0.build_stats()
            }

            /// Every bounded primitive is listed in all leaves that its own box touches, the leaves are those of a
            /// tree, and none is too deep for the stack of a walk.
            fn validate<P: rt_geometry::Primitives>(&self, primitives: &P) -> Result<(), $crate::ValidationError> {
                self.0.validate(primitives)
            }

            fn for_each_box(&self, visit: impl FnMut(rt_math::Aabb, u32)) {
                self.0.for_each_box(visit);
            }
        }

        $crate::structure::accelerator_by_walk!($structure);
    };
}

pub(crate) use structure_by_partition;
