//! Binary space partitions (Fuchs, Kedem and Naylor 1980) by planes of any kind.

mod bsp_partition;
mod build;
mod node;
mod sah_cost;
mod split_plane;
mod traverse;
mod validate;

pub(crate) use bsp_partition::BspPartition;
pub(crate) use build::{SplitHeuristic, Task};
pub(crate) use node::PartitionNode;
pub(crate) use sah_cost::SahCost;
pub(crate) use split_plane::{PlaneHit, SplitPlane};

/// Implements [`Accelerator`](crate::Accelerator) for a type with one unnamed field, a partition.
macro_rules! accelerator_by_partition {
    ($accelerator:ty) => {
        impl $crate::Accelerator for $accelerator {
            fn traverse_ray<P: rt_geometry::Primitives, Q: $crate::RayQuery, S: rt_geometry::Probe>(
                &self,
                primitives: &P,
                query: &mut Q,
                probe: &mut S,
            ) -> core::ops::ControlFlow<()> {
                self.0.traverse_ray(primitives, query, probe)
            }

            fn traverse_region<Q: $crate::RegionQuery>(&self, query: &mut Q) -> core::ops::ControlFlow<()> {
                self.0.traverse_region(query)
            }

            fn memory(&self) -> usize {
                self.0.memory()
            }

            fn build_stats(&self) -> $crate::BuildStats {
                self.0.build_stats()
            }

            /// Checks that each bounded primitive is listed in all leaves that its padded bounds touch. Checks that the
            /// leaves form a tree, and that no leaf is too deep for the traversal stack.
            fn validate<P: rt_geometry::Primitives>(&self, primitives: &P) -> Result<(), $crate::ValidationError> {
                self.0.validate(primitives)
            }

            fn for_each_box(&self, visit: impl FnMut(rt_math::Aabb, u32)) {
                self.0.for_each_box(visit);
            }
        }
    };
}

pub(crate) use accelerator_by_partition;
