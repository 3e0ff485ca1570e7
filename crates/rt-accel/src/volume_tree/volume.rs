//! Interface of bounding volumes.

use core::fmt::Debug;

use rt_math::{Aabb, Interval, SlabRay};

/// Bounding volume of a [`VolumeTree`](crate::VolumeTree).
///
/// # Contract
///
/// The tree returns the bits of brute force if [`enter`](Self::enter) culls no ray that passes the padded bounds of a
/// primitive inside. The implementations here have a proof. Memory safety and termination do not depend on it.
pub trait BoundingVolume: Copy + Debug + PartialEq + Send + Sync {
    /// Volume around finite boxes. Any volume for none.
    fn around(boxes: impl Iterator<Item = Aabb> + Clone) -> Self;

    /// True if the box is inside. Holds for the boxes that the volume was built from.
    fn encloses(&self, aabb: &Aabb) -> bool;

    /// First parameter within `span` at which the ray is inside; `None` if it never is.
    ///
    /// Conservative for finite rays: if [`Aabb::clip`] returns an interval for a box inside, the entry is no later than
    /// its beginning. `span.min` is always valid.
    fn enter(&self, ray: &SlabRay, span: Interval) -> Option<f64>;

    /// Bounds; sides may be infinite.
    fn bounds(&self) -> Aabb;

    /// Proportional to the probability of a hit: the surface area, for convex volumes.
    fn measure(&self) -> f64;
}
