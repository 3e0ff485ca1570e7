//! Slot of a primitive in a tree.

use crate::wide::leaf::Lane;
use crate::wide::node::Child;

/// Leaf and lane of a primitive.
#[derive(Clone, Copy)]
pub(in crate::wide) struct PrimSlot {
    leaf: Child,
    lane: Lane,
}

impl PrimSlot {
    /// # Safety
    ///
    /// The child must be a leaf of the tree that the slot is used with.
    #[inline(always)]
    pub(in crate::wide) const unsafe fn new(leaf: Child, lane: Lane) -> Self {
        Self { leaf, lane }
    }

    /// A leaf of the tree.
    #[inline(always)]
    pub(in crate::wide) const fn leaf(self) -> Child {
        self.leaf
    }

    #[inline(always)]
    pub(in crate::wide) const fn lane(self) -> Lane {
        self.lane
    }
}
