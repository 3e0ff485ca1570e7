//! Tree of axis-aligned planes.

mod plane;
mod split;

use rt_geometry::Primitives;

use crate::BuildError;
use crate::space_partition::{BspPartition, accelerator_by_partition};
use plane::AxisPlane;
pub(crate) use split::SahSplit;

/// Binary partition of space by axis-aligned planes (Bentley 1975): O(log n) per ray. Visits are the fewest of all
/// where primitives do not overlap, as in most meshes of rooms and buildings.
///
/// Built top-down by the surface area heuristic with a bonus for cutting off empty space, at planes next to the faces
/// of padded bounds. See Wald and Havran, "On building fast kd-trees for ray tracing, and on doing that in O(N log N)",
/// 2006. A primitive is listed in every leaf that it touches, and tested in each. Where primitives overlap much, a
/// [`Bvh`](crate::Bvh) is smaller and faster. A traversal visits leaves in strict order, and ends at the first hit
/// before the next leaf. Moving primitives require a new tree.
///
/// No leaf is deeper than 60, and planes and references together are at most 16 per primitive and 4096 more. Primitives
/// that no plane can separate share a leaf. The tree is a pure function of the primitives, with or without the feature
/// `parallel`. With the feature `serde`, use a format that keeps every bit of an `f64`.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct KdTree(pub(crate) BspPartition<AxisPlane>);

impl KdTree {
    /// Builds the tree: O(n log n) time, 45 to 100 bytes per primitive afterwards.
    ///
    /// # Errors
    ///
    /// [`BuildError`] if bounds are NaN, inverted or infinite, or there are too many primitives.
    pub fn build<P: Primitives>(primitives: &P) -> Result<Self, BuildError> {
        Ok(Self(BspPartition::build(primitives, &SahSplit)?))
    }
}

accelerator_by_partition!(KdTree);
