//! Conditions for leaves.

/// Condition for a range of three or more references to become a leaf without a search for splits.
#[derive(Clone, Copy, Debug)]
pub(super) struct LeafPolicy {
    /// Maximum references.
    pub(super) few: usize,
    /// Maximum cost of the leaf, relative to one leaf per reference.
    pub(super) limit: f32,
}

impl LeafPolicy {
    /// Trees as good as with all splits evaluated.
    pub(super) const STRICT: Self = Self { few: 4, limit: 0.75 };
    /// 17 % less build time, and up to 2 % higher cost; traversal speed is the same.
    pub(super) const LOOSE: Self = Self { few: 8, limit: 1.5 };
    /// A leaf wherever three or more references fit. An infinite limit would fail for areas of 0.
    pub(super) const GREEDY: Self = Self { few: 8, limit: f32::MAX };
}
