//! Top-down construction of binary trees, on one thread or on several, with the same result.

use crate::node_ref::NodeRef;
use crate::parallel_for::parallel_for_each;

/// Node of a tree in depth-first order, the left child first.
pub(crate) trait TreeNode: Sized + Send {
    /// Contents of an inner node, known before its children.
    type Payload;

    /// Inner node whose children are set by [`link`](Self::link).
    fn inner(payload: Self::Payload) -> Self;

    /// Leaf, if the tree stores leaves as nodes.
    fn leaf(_first: u32, _count: u32) -> Option<Self> {
        None
    }

    fn link(&mut self, children: [NodeRef; 2]);

    /// Updates all references after `nodes` nodes and `indices` primitive indices have been inserted in front.
    fn shift(&mut self, nodes: u32, indices: u32);
}

/// Tree, or part of one. References count from 0.
#[derive(Debug, PartialEq)]
pub(crate) struct Subtree<N> {
    pub(crate) nodes: Vec<N>,
    /// Primitives leaf by leaf.
    pub(crate) indices: Vec<u32>,
    pub(crate) root: NodeRef,
    /// Depth of the deepest leaf below the root.
    pub(crate) height: u32,
}

/// Two sets that a set of primitives is split into.
pub(crate) struct Split<P, T> {
    pub(crate) payload: P,
    pub(crate) tasks: [T; 2],
    /// True if both sets are large enough for a thread each.
    pub(crate) is_large: bool,
}

/// Minimum number of items for a thread of their own.
pub(crate) const MIN_FORKED: usize = 4096;

/// Builds a tree. `split` splits the set of a task, or appends its primitives to a leaf. Recursion is as deep as the
/// tree, which `split` has to bound by [`MAX_DEPTH`](crate::traversal::MAX_DEPTH).
pub(crate) fn build_top_down<N: TreeNode, T: Send>(
    task: T,
    split: &(impl Fn(T, &mut Vec<u32>) -> Option<Split<N::Payload, T>> + Sync),
) -> Subtree<N> {
    let mut tree = Subtree::new();
    tree.build(task, split);
    tree
}

impl<N: TreeNode> Subtree<N> {
    const fn new() -> Self {
        Self { nodes: Vec::new(), indices: Vec::new(), root: NodeRef::leaf(0, 0), height: 0 }
    }

    /// Builds the tree of a task into this empty one.
    fn build<T: Send>(&mut self, task: T, split: &(impl Fn(T, &mut Vec<u32>) -> Option<Split<N::Payload, T>> + Sync)) {
        (self.root, self.height) = self.grow(task, split);
        self.nodes.shrink_to_fit();
        self.indices.shrink_to_fit();
    }

    /// Appends the tree of a task; returns its root and height.
    fn grow<T: Send>(
        &mut self,
        task: T,
        split: &(impl Fn(T, &mut Vec<u32>) -> Option<Split<N::Payload, T>> + Sync),
    ) -> (NodeRef, u32) {
        let first = self.indices.len() as u32;
        let Some(Split { payload, tasks: [left, right], is_large }) = split(task, &mut self.indices) else {
            return (self.push_leaf(first), 0);
        };
        let index = self.nodes.len();
        self.nodes.push(N::inner(payload));
        let [left, right] = if is_large {
            let mut parts = [Self::new(), Self::new()];
            let tasks = [left, right].into_iter().zip(&mut parts).collect();
            parallel_for_each(tasks, |(task, part): (T, &mut Self)| part.build(task, split));
            parts.map(|part| self.append(part))
        } else {
            let left = self.grow(left, split);
            [left, self.grow(right, split)]
        };
        self.nodes[index].link([left.0, right.0]);
        (NodeRef::node(index as u32), 1 + left.1.max(right.1))
    }

    fn push_leaf(&mut self, first: u32) -> NodeRef {
        let count = self.indices.len() as u32 - first;
        match N::leaf(first, count) {
            None => NodeRef::leaf(first, count),
            Some(leaf) => {
                self.nodes.push(leaf);
                NodeRef::node(self.nodes.len() as u32 - 1)
            }
        }
    }

    fn append(&mut self, part: Self) -> (NodeRef, u32) {
        let (nodes, indices) = (self.nodes.len() as u32, self.indices.len() as u32);
        self.nodes.extend(part.nodes.into_iter().map(|mut node| {
            node.shift(nodes, indices);
            node
        }));
        self.indices.extend(part.indices);
        (part.root.shifted(nodes, indices), part.height)
    }
}

/// Split of a slice after its first `middle` items.
pub(crate) struct SliceSplit<P, S> {
    pub(crate) middle: usize,
    pub(crate) payload: P,
    /// State of either side.
    pub(crate) states: [S; 2],
}

/// Builds a tree whose leaves are consecutive ranges of `items`, which are reordered. `split` gets the items of a node,
/// the state handed down by the split above, and the depth; it returns `None` for a leaf.
pub(crate) fn build_in_place<N: TreeNode, B: Send, S: Send>(
    items: &mut [(u32, B)],
    state: S,
    split: impl Fn(&mut [(u32, B)], &S, u32) -> Option<SliceSplit<N::Payload, S>> + Sync,
) -> Subtree<N> {
    build_top_down((items, state, 0), &|(items, state, depth), indices| {
        let Some(SliceSplit { middle, payload, states: [left, right] }) = split(items, &state, depth) else {
            indices.extend(items.iter().map(|&(index, _)| index));
            return None;
        };
        let (low, high) = items.split_at_mut(middle);
        let is_large = low.len().min(high.len()) >= MIN_FORKED;
        Some(Split { payload, tasks: [(low, left, depth + 1), (high, right, depth + 1)], is_large })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Leaf, or a node with both children.
    #[derive(Debug, PartialEq)]
    enum Node {
        Inner(u32, [NodeRef; 2]),
        Leaf(u32, u32),
    }

    impl TreeNode for Node {
        type Payload = u32;

        fn inner(payload: u32) -> Self {
            Self::Inner(payload, [NodeRef::node(0); 2])
        }

        fn leaf(first: u32, count: u32) -> Option<Self> {
            Some(Self::Leaf(first, count))
        }

        fn link(&mut self, children: [NodeRef; 2]) {
            if let Self::Inner(_, links) = self {
                *links = children;
            }
        }

        fn shift(&mut self, nodes: u32, indices: u32) {
            match self {
                Self::Inner(_, children) => *children = children.map(|child| child.shifted(nodes, indices)),
                Self::Leaf(first, _) => *first += indices,
            }
        }
    }

    fn build(fork_from: u32) -> Subtree<Node> {
        build_top_down(0..1000u32, &|task: core::ops::Range<u32>, indices| {
            if task.len() < 4 {
                indices.extend(task);
                return None;
            }
            let middle = task.start + 1 + task.len() as u32 / 3;
            let is_large = task.len() as u32 >= fork_from;
            Some(Split { payload: middle, tasks: [task.start..middle, middle..task.end], is_large })
        })
    }

    #[test]
    fn forks_change_nothing() {
        let serial = build(u32::MAX);
        assert_eq!(serial.indices, (0..1000).collect::<Vec<_>>());
        for fork_from in [0, 10, 500] {
            assert_eq!(build(fork_from), serial);
        }
    }

    #[test]
    fn nodes_are_in_depth_first_order_and_heights_are_depths() {
        let tree = build(100);
        let mut pending = vec![(tree.root, 0)];
        let (mut n_visited, mut n_listed, mut max_depth) = (0, 0, 0);
        while let Some((node, depth)) = pending.pop() {
            assert_eq!(node, NodeRef::node(n_visited));
            match &tree.nodes[n_visited as usize] {
                Node::Inner(_, [left, right]) => pending.extend([(*right, depth + 1), (*left, depth + 1)]),
                &Node::Leaf(first, count) => {
                    assert_eq!(first, n_listed);
                    n_listed += count;
                    max_depth = max_depth.max(depth);
                }
            }
            n_visited += 1;
        }
        assert_eq!((n_visited as usize, n_listed, max_depth), (tree.nodes.len(), 1000, tree.height));
    }
}
