//! Binary trees in one list each, for structures whose nodes are of `f64` numbers.

mod grow;
mod shape;

pub(crate) use grow::{Cut, halve, partition};

use rt_math::Aabb;

/// A primitive and its own box.
pub(crate) type Item = (u32, Aabb);

/// What is behind one side of a node: a run of primitives, or another node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Child {
    /// Start of the run in the list of indices, or the number of the node.
    pub(crate) first: u32,
    /// Length of the run; 0 for a node.
    pub(crate) count: u32,
}

impl Child {
    pub(crate) const fn node(number: u32) -> Self {
        Self { first: number, count: 0 }
    }

    pub(crate) const fn leaf(first: u32, count: u32) -> Self {
        Self { first, count }
    }
}

/// What a structure knows about both sides of a node, and what is behind them.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Node<C> {
    pub(crate) content: C,
    pub(crate) children: [Child; 2],
}

/// A binary tree: nodes in depth-first order, the left side first, and leaves as consecutive runs. A node and all that
/// is below it are therefore consecutive as well, in both lists.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(remote = "Self"))]
pub(crate) struct Tree<C> {
    pub(crate) nodes: Vec<Node<C>>,
    pub(crate) root: Child,
    /// Bounded primitives, leaf by leaf.
    pub(crate) indices: Vec<u32>,
    pub(crate) unbounded: Vec<u32>,
}

/// What a step down a tree leads to.
pub(crate) enum Place<'t, C> {
    /// Some primitives.
    Leaf(&'t [u32]),
    /// Two more steps.
    Node(&'t Node<C>),
}

impl<C> Tree<C> {
    /// What is behind a child.
    #[inline(always)]
    pub(crate) fn place(&self, child: Child) -> Place<'_, C> {
        if child.count == 0
            && let Some(node) = self.nodes.get(child.first as usize)
        {
            return Place::Node(node);
        }
        Place::Leaf(&self.indices[child.first as usize..][..child.count as usize])
    }

    /// Number of primitives, bounded or not.
    pub(crate) fn primitives(&self) -> u32 {
        (self.indices.len() + self.unbounded.len()) as u32
    }

    /// Bytes held on the heap.
    pub(crate) fn heap(&self) -> usize {
        self.nodes.capacity() * size_of::<Node<C>>()
            + (self.indices.capacity() + self.unbounded.capacity()) * size_of::<u32>()
    }
}

#[cfg(feature = "serde")]
crate::saved::saved_and_checked!(Tree<C>, Tree::check_shape, C: Sized);
