//! Binary trees with `f64` payloads.

mod validate;

use crate::node_ref::NodeRef;
use crate::prim_bounds::{Item, PrimBounds};
use crate::top_down::{SliceSplit, Subtree, TreeNode, build_in_place};

/// Payload and children of an inner node.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct PayloadNode<C> {
    pub(crate) payload: C,
    pub(crate) children: [NodeRef; 2],
}

impl<C: Send> TreeNode for PayloadNode<C> {
    type Payload = C;

    fn inner(payload: C) -> Self {
        Self { payload, children: [NodeRef::node(0); 2] }
    }

    fn link(&mut self, children: [NodeRef; 2]) {
        self.children = children;
    }

    fn shift(&mut self, nodes: u32, indices: u32) {
        self.children = self.children.map(|child| child.shifted(nodes, indices));
    }
}

/// Binary tree. Nodes are in depth-first order, the left child first, and leaves are consecutive ranges of indices. So
/// each subtree is consecutive in both lists.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(remote = "Self"))]
pub(crate) struct Tree<C> {
    pub(crate) nodes: Vec<PayloadNode<C>>,
    pub(crate) root: NodeRef,
    /// Bounded primitives, leaf by leaf.
    pub(crate) indices: Vec<u32>,
    pub(crate) unbounded: Vec<u32>,
}

impl<C: Send> Tree<C> {
    /// Builds the tree over all bounded primitives: see [`build_in_place`].
    pub(crate) fn build<S: Send>(
        boxes: PrimBounds,
        state: S,
        split: impl Fn(&mut [Item], &S, u32) -> Option<SliceSplit<C, S>> + Sync,
    ) -> Self {
        let mut items = boxes.bounded;
        let Subtree { nodes, indices, root, .. } = build_in_place(&mut items, state, split);
        Self { nodes, root, indices, unbounded: boxes.unbounded }
    }
}

/// Node or leaf behind a reference.
pub(crate) enum NodeKind<'t, C> {
    Leaf(&'t [u32]),
    Inner(&'t PayloadNode<C>),
}

impl<C> Tree<C> {
    #[inline(always)]
    pub(crate) fn resolve(&self, child: NodeRef) -> NodeKind<'_, C> {
        if child.count == 0
            && let Some(node) = self.nodes.get(child.first as usize)
        {
            return NodeKind::Inner(node);
        }
        NodeKind::Leaf(&self.indices[child.first as usize..][..child.count as usize])
    }

    /// Number of primitives, bounded or not.
    pub(crate) fn primitives(&self) -> u32 {
        (self.indices.len() + self.unbounded.len()) as u32
    }

    /// Heap memory in bytes.
    pub(crate) fn heap(&self) -> usize {
        self.nodes.capacity() * size_of::<PayloadNode<C>>()
            + (self.indices.capacity() + self.unbounded.capacity()) * size_of::<u32>()
    }
}

#[cfg(feature = "serde")]
crate::checked_serde::impl_checked_serde!(Tree<C>, Tree::check_shape, C: Sized);
