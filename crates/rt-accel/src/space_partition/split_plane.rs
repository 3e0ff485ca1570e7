//! What cuts space in two, and why walks along a ray miss nothing.
//!
//! # Why no primitive is missed
//!
//! Take a ray, and a primitive that has a hit. Brute force accepts the hit at no less than `E`, where the slab test
//! enters the primitive's own box within the span. The walk keeps an interval of the ray for every node that it
//! visits, and **always visits a leaf that lists the primitive, with an interval that contains `E`**:
//!
//! * The interval of the root is that of the box around everything, which contains `E` as the slab test is monotone.
//! * Let a cut split the interval `[a, b]` of a node into `[a, min(b, near_max)]` and `[max(a, far_min), b]`. If the
//!   primitive lies on one side only, `E` is in the interval of that side: that is what [`SplitPlane::plane_hit`] promises, and
//!   each kind of cut proves. If it lies on both sides, then `E` is at or after `far_min` and in the far interval, or
//!   before `far_min ≤ near_max` and in the near one.
//! * A NaN is no constraint, for it fails every comparison.
//!
//! A node is given up only if its interval is empty or begins strictly after the best hit. The accepted hit is not
//! before `E`, so it could not have won. Hits that lie outside the interval of their leaf are as good as others.

use core::fmt::Debug;

use glam::DVec3;
use rt_math::{Aabb, Interval, SlabRay};

/// Divides space into what is below it and what is above it. The border belongs to both sides.
pub(crate) trait SplitPlane: Copy + Debug + PartialEq + Send + Sync {
    /// A ray prepared for many cuts.
    type Ray: Copy;

    /// Prepares a finite ray, which is within `bounds`, the box around everything, for `inside`. `None` if the proof
    /// does not hold for it, so that every primitive has to be asked.
    fn prepare(ray: &SlabRay, bounds: &Aabb, inside: Interval) -> Option<Self::Ray>;

    /// Where the ray changes sides. For every box that [`classify`](Self::sides) puts on one side only, the entry `E` of
    /// the slab test is `≤ near_max` if that is the near side, and `≥ far_min` if that is the far side.
    fn plane_hit(&self, ray: &Self::Ray) -> PlaneHit;

    /// The side that owns a point.
    fn is_above(&self, point: DVec3) -> bool;

    /// Whether a box has anything below and above: at least on the sides that own one of its points.
    fn classify(&self, aabb: &Aabb) -> [bool; 2];

    /// Boxes around the parts of `cell` below and above.
    fn split_bounds(&self, cell: &Aabb) -> [Aabb; 2];

    /// True if the boxes of [`divide`](Self::split_bounds) are the parts of `cell`, and not only around them.
    fn is_tight(&self) -> bool;

    /// True if all numbers are such that the proofs hold.
    fn is_valid(&self) -> bool;
}

/// Where a ray changes sides. `far_min ≤ near_max`, unless one is NaN, which is no constraint.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlaneHit {
    /// True if the ray comes from above.
    pub(crate) from_above: bool,
    /// The near side need not be looked at after this.
    pub(crate) near_max: f64,
    /// The far side need not be looked at before this.
    pub(crate) far_min: f64,
}
