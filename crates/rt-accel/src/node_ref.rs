//! References to the nodes and leaves of binary trees.

/// Inner node, or leaf as a range of the list of primitive indices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct NodeRef {
    /// Index of the inner node, or start of the range.
    pub(crate) first: u32,
    /// Length of the range; 0 for an inner node.
    pub(crate) count: u32,
}

impl NodeRef {
    pub(crate) const fn node(index: u32) -> Self {
        Self { first: index, count: 0 }
    }

    pub(crate) const fn leaf(first: u32, count: u32) -> Self {
        Self { first, count }
    }

    /// Reference after `nodes` nodes and `indices` primitive indices have been inserted in front.
    pub(crate) fn shifted(self, nodes: u32, indices: u32) -> Self {
        Self { first: self.first + if self.count == 0 { nodes } else { indices }, ..self }
    }
}
