//! Interface of primitives for nearest-point queries.

use crate::Primitives;
use rt_math::DVec3;

/// Primitives that support nearest-point queries.
pub trait ClosestPoint: Primitives {
    /// Point of primitive `index` that is nearest to `point`, in the space of the set; any one of several. `None`
    /// excludes the primitive from the query.
    fn nearest_point(&self, index: u32, point: DVec3) -> Option<DVec3>;
}
