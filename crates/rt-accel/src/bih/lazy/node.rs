//! Node that is split at the first visit.

use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

use rt_math::Aabb;

use crate::bih::{planes::Planes, split::split, traverse::BihNode};
use crate::prim_bounds::Item;

/// Node of a lazy hierarchy: first a list of primitives, after the split a leaf or an inner node.
///
/// Copying, comparing and dropping recurse, at most as deep as the tree.
#[derive(Debug)]
pub(in crate::bih) struct LazyNode {
    kind: OnceLock<SplitNode>,
    /// `None` as soon as a thread has begun to split the node.
    unsplit: Mutex<Option<Box<Unsplit>>>,
}

/// Input of the split.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Unsplit {
    pub(super) items: Vec<Item>,
    pub(super) cell: Aabb,
    depth: u32,
}

/// Result of the split.
#[derive(Clone, Debug, PartialEq)]
enum SplitNode {
    Leaf(Box<[u32]>),
    Node(Box<Inner>),
}

#[derive(Clone, Debug, PartialEq)]
struct Inner {
    planes: Planes,
    children: [LazyNode; 2],
}

/// Current state of a node.
pub(super) enum NodeState<'n> {
    /// Not split. The lock keeps other threads from splitting it.
    Unsplit(MutexGuard<'n, Option<Box<Unsplit>>>),
    /// Result of the split.
    Split(BihNode<'n, &'n LazyNode>),
}

impl LazyNode {
    pub(super) fn unsplit(items: Vec<Item>, cell: Aabb, depth: u32) -> Self {
        Self { kind: OnceLock::new(), unsplit: Mutex::new(Some(Box::new(Unsplit { items, cell, depth }))) }
    }

    #[cfg(feature = "serde")]
    pub(super) fn leaf(indices: Vec<u32>) -> Self {
        Self { kind: OnceLock::from(SplitNode::Leaf(indices.into())), unsplit: Mutex::new(None) }
    }

    #[cfg(feature = "serde")]
    pub(super) fn inner(planes: Planes, children: [Self; 2]) -> Self {
        Self { kind: OnceLock::from(SplitNode::Node(Box::new(Inner { planes, children }))), unsplit: Mutex::new(None) }
    }

    /// Splits the node if necessary.
    #[inline(always)]
    pub(super) fn resolve(&self) -> BihNode<'_, &Self> {
        match self.kind() {
            SplitNode::Leaf(indices) => BihNode::Leaf(indices),
            SplitNode::Node(sides) => BihNode::Inner(&sides.planes, sides.children.each_ref()),
        }
    }

    #[inline(always)]
    fn kind(&self) -> &SplitNode {
        // Only one thread takes the list, once.
        self.kind.get_or_init(|| self.lock().take().map_or(SplitNode::Leaf(Box::default()), |unsplit| unsplit.split()))
    }

    /// Current state, without splitting the node. Waits for a split in progress.
    pub(super) fn state(&self) -> NodeState<'_> {
        let unsplit = self.lock();
        if unsplit.is_some() {
            return NodeState::Unsplit(unsplit);
        }
        drop(unsplit);
        NodeState::Split(self.resolve())
    }

    fn lock(&self) -> MutexGuard<'_, Option<Box<Unsplit>>> {
        // No holder of the lock can leave the list half changed.
        self.unsplit.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Unsplit {
    fn split(mut self) -> SplitNode {
        match split(&mut self.items, &self.cell, self.depth) {
            None => SplitNode::Leaf(self.items.iter().map(|&(index, _)| index).collect()),
            Some(cut) => {
                let right = self.items.split_off(cut.middle);
                let mut left = self.items;
                left.shrink_to_fit();
                let [left_cell, right_cell] = cut.states;
                let depth = self.depth + 1;
                let children = [LazyNode::unsplit(left, left_cell, depth), LazyNode::unsplit(right, right_cell, depth)];
                SplitNode::Node(Box::new(Inner { planes: cut.payload, children }))
            }
        }
    }
}

impl NodeState<'_> {
    pub(super) fn is_inner(&self) -> bool {
        matches!(self, Self::Split(BihNode::Inner(..)))
    }

    /// Heap memory in bytes, without that of children.
    pub(super) fn heap(&self) -> usize {
        match self {
            Self::Unsplit(unsplit) => unsplit
                .as_ref()
                .map_or(0, |unsplit| size_of::<Unsplit>() + unsplit.items.capacity() * size_of::<Item>()),
            Self::Split(BihNode::Leaf(indices)) => size_of_val(*indices),
            Self::Split(BihNode::Inner(..)) => size_of::<Inner>(),
        }
    }
}

impl Clone for LazyNode {
    /// Copies the current state.
    fn clone(&self) -> Self {
        let unsplit = self.lock().clone();
        let kind = if unsplit.is_some() { OnceLock::new() } else { OnceLock::from(self.kind().clone()) };
        Self { kind, unsplit: Mutex::new(unsplit) }
    }
}

impl PartialEq for LazyNode {
    /// True if both nodes are in the same state, and so are their children.
    fn eq(&self, other: &Self) -> bool {
        // One lock at a time, as both may be the same node.
        let mine = self.lock().clone();
        let is_same = *other.lock() == mine;
        is_same && (mine.is_some() || self.kind() == other.kind())
    }
}
