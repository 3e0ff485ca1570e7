//! Planes that clip the two sides of a node.
//!
//! # Why the culling is conservative
//!
//! The left side of a node is the half-space below a plane, the right side that above another one. The planes are
//! faces of padded bounds. A side is a box that is infinite but for one face, and contains the padded bounds of all
//! primitives in its subtree. A ray is clipped to the sides on its path one after the other, by the operations of
//! [`Aabb::clip`], `fl(fl(b − o)·v)` and the far factor. These are monotone in `b`, and so are minimum and maximum.
//! Hence for every finite ray, **bit for bit**: the remaining range contains that of [`Aabb::clip`] for all padded
//! bounds below. `0 · ∞`, a ray within a plane, is NaN and imposes no constraint, as in the slab test.

use rt_math::{Aabb, FAR_FACTOR, SlabRay};

use crate::axis::Axis;

/// Planes of a node.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Planes {
    pub(super) axis: Axis,
    /// End of the left side and beginning of the right side. These may overlap, or leave a gap.
    pub(super) at: [f64; 2],
}

/// Parameters between which a ray is inside a region. Empty if `enter > leave`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TRange {
    pub(super) enter: f64,
    pub(super) leave: f64,
}

impl Planes {
    /// The tightest planes around the boxes of either side.
    pub(super) fn around(axis: Axis, left: &Aabb, right: &Aabb) -> Self {
        Self { axis, at: [left.max[axis as usize], right.min[axis as usize]] }
    }

    /// True if a box lies on a side.
    pub(super) fn encloses(&self, side: usize, own: &Aabb) -> bool {
        let axis = self.axis as usize;
        if side == 0 { own.max[axis] <= self.at[0] } else { own.min[axis] >= self.at[1] }
    }

    /// Part of a box on a side.
    pub(super) fn cut(&self, side: usize, mut aabb: Aabb) -> Aabb {
        let axis = self.axis as usize;
        if side == 0 {
            aabb.max[axis] = aabb.max[axis].min(self.at[0]);
        } else {
            aabb.min[axis] = aabb.min[axis].max(self.at[1]);
        }
        aabb
    }

    /// Side that the ray enters first.
    #[inline(always)]
    pub(super) fn near(&self, ray: &SlabRay) -> usize {
        usize::from(ray.inverse[self.axis as usize].is_sign_negative())
    }

    /// Part of a range on a side.
    #[inline(always)]
    pub(super) fn clip(&self, ray: &SlabRay, side: usize, stretch: TRange) -> TRange {
        let axis = self.axis as usize;
        let t = (self.at[side] - ray.ray.origin[axis]) * ray.inverse[axis];
        // A NaN fails both comparisons and keeps the old value.
        if side == self.near(ray) {
            let t_far = t * FAR_FACTOR;
            TRange { leave: if t_far < stretch.leave { t_far } else { stretch.leave }, ..stretch }
        } else {
            TRange { enter: if t > stretch.enter { t } else { stretch.enter }, ..stretch }
        }
    }
}
