//! Splitting planes, and the proof that traversal along a ray misses no hit.
//!
//! # Why no primitive is missed
//!
//! Take a ray, and a primitive that has a hit. Brute force accepts the hit at no less than `E`, where the slab test
//! enters the primitive's padded bounds within the span. The traversal keeps an interval of the ray for every node that
//! it visits. It **always visits a leaf that lists the primitive, with an interval that contains `E`**:
//!
//! * The interval of the root is that of the box around all primitives, which contains `E` as the slab test is monotone.
//! * Let a cut split the interval `[a, b]` of a node into `[a, min(b, near_max)]` and `[max(a, far_min), b]`. If the
//!   primitive lies on one side only, `E` is in the interval of that side. This is what [`SplitPlane::plane_hit`]
//!   promises, and each kind of plane proves. Otherwise it lies on both sides. Then `E` is at or after `far_min` and in
//!   the far interval, or before `far_min ≤ near_max` and in the near one.
//! * A NaN is no constraint, for it fails every comparison.
//!
//! A node is given up only if its interval is empty or begins strictly after the best hit. The accepted hit is not
//! before `E`, so it could not have won. Hits that lie outside the interval of their leaf are as good as others.

use core::fmt::Debug;

use glam::DVec3;
use rt_math::{Aabb, Interval, SlabRay};

/// Divides space into a part below and a part above. The border belongs to both.
pub(crate) trait SplitPlane: Copy + Debug + PartialEq + Send + Sync {
    /// Ray prepared for many planes.
    type Ray: Copy;

    /// Prepares a finite ray, which is within `bounds`, the bounds of the scene, for `inside`. `None` if the proof does
    /// not cover it, so that every primitive has to be tested.
    fn prepare(ray: &SlabRay, bounds: &Aabb, inside: Interval) -> Option<Self::Ray>;

    /// Parameters at which the ray changes sides. Take a box that [`classify`](Self::classify) puts on one side only.
    /// The entry `E` of the slab test is `≤ near_max` if that is the near side, and `≥ far_min` if that is the far
    /// side.
    fn plane_hit(&self, ray: &Self::Ray) -> PlaneHit;

    /// True if the side above owns the point.
    fn is_above(&self, point: DVec3) -> bool;

    /// True for below and for above if a box has points there: at least on the sides that own one of its points.
    fn classify(&self, aabb: &Aabb) -> [bool; 2];

    /// Bounds of the parts of `cell` below and above.
    fn split_bounds(&self, cell: &Aabb) -> [Aabb; 2];

    /// True if the boxes of [`split_bounds`](Self::split_bounds) are exactly the parts of `cell`.
    fn is_tight(&self) -> bool;

    /// True if the proofs hold for this plane.
    fn is_valid(&self) -> bool;
}

/// Intersection of a ray with a plane. `far_min ≤ near_max`, unless one is NaN, which is no constraint.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlaneHit {
    /// True if the ray comes from above.
    pub(crate) from_above: bool,
    /// The near side can be skipped after this parameter.
    pub(crate) near_max: f64,
    /// The far side can be skipped before this parameter.
    pub(crate) far_min: f64,
}
