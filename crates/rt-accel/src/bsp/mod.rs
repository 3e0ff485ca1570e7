//! Tree of planes of any direction.

mod candidates;
mod plane;
mod split;

use rt_math::Primitives;

use crate::BuildError;
use crate::partition::{Partition, structure_by_partition};
use plane::Plane;
use split::Sampled;

/// A tree that cuts space in two by planes that the primitives suggest (Fuchs, Kedem and Naylor, "On visible surface
/// generation by a priori tree structures", 1980): of triangles, their own planes; of spheres, tangent planes and such
/// through the centre that face another; of everything, the faces of own boxes.
///
/// Candidates of some primitives are compared by the surface area heuristic, with a sample of the others (after Ize,
/// Wald and Parker, "Ray Tracing with the BSP Tree", 2008). Primitives are never split: they are listed on both sides of
/// a plane that their own box touches or comes within rounding of. Choose it where long walls stand at odd angles and
/// what is between them is small; otherwise a [`KdTree`](crate::KdTree) builds faster and costs less per node.
///
/// No leaf is deeper than 60, and nodes and references are at most 16 per primitive and 4096 in all. Primitives that no
/// plane can separate share a leaf, however many they are. The tree is a pure function of the primitives, with or
/// without the feature `parallel`.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BspTree(Partition<Plane>);

impl BspTree {
    /// Builds the tree: O(n log n) time, about 100 bytes per primitive afterwards.
    ///
    /// # Errors
    ///
    /// [`BuildError`] if bounds are NaN, inverted or infinite, or there are too many primitives.
    pub fn build<P: Primitives>(primitives: &P) -> Result<Self, BuildError> {
        Ok(Self(Partition::build(primitives, &Sampled { primitives })?))
    }
}

structure_by_partition!(BspTree);
