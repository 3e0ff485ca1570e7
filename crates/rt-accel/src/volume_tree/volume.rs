//! What a tree of volumes asks of them.

use core::fmt::Debug;

use rt_math::{Aabb, Interval, SlabRay};

/// A volume that a [`VolumeTree`](crate::VolumeTree) is made of.
///
/// # Contract
///
/// The tree gives the bits of brute force if [`enter`](Self::enter) culls no ray that passes the box of a primitive
/// inside; the implementations here come with a proof. It is memory safe and ends in any case.
pub trait BoundingVolume: Copy + Debug + PartialEq + Send + Sync {
    /// A volume around some boxes, all of which are finite. Any volume for none.
    fn around(boxes: impl Iterator<Item = Aabb> + Clone) -> Self;

    /// True if the box is inside, as it is for those that the volume was made around.
    fn encloses(&self, aabb: &Aabb) -> bool;

    /// Where within `span` the ray is inside for the first time, or `None` if it never is.
    ///
    /// Conservative for finite rays: where [`Aabb::clip`] leaves something of the span for a box inside, the entry is
    /// no later than the beginning of that. `span.min` is always a right answer.
    fn enter(&self, ray: &SlabRay, span: Interval) -> Option<f64>;

    /// A box around it; sides may be infinite.
    fn bounds(&self) -> Aabb;

    /// A number proportional to how likely rays are to hit it: the surface area, for convex volumes.
    fn measure(&self) -> f64;
}
