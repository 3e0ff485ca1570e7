//! The contract of primitives that know which of their points is nearest.

use crate::Primitives;
use rt_math::DVec3;

/// Primitives that a nearest-point query can be asked about.
pub trait ClosestPoint: Primitives {
    /// The point of primitive `index` that is nearest to `point`, in the space of the set; any one of several.
    /// `None` if the primitive has no such point, which takes it out of the query.
    fn nearest_point(&self, index: u32, point: DVec3) -> Option<DVec3>;
}
