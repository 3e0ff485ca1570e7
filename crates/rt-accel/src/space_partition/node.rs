//! Nodes in depth-first order.

use crate::node_ref::NodeRef;
use crate::top_down::TreeNode;
use crate::{ValidationError, traversal::MAX_DEPTH};

/// Part of space. The child below the plane is the next node.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) enum PartitionNode<C> {
    /// Inner node.
    Split {
        plane: C,
        /// Index of the child above the plane.
        above: u32,
    },
    /// Leaf with its range of primitive indices.
    Leaf { first: u32, count: u32 },
}

impl<C: Send> TreeNode for PartitionNode<C> {
    type Payload = C;

    fn inner(plane: C) -> Self {
        Self::Split { plane, above: 0 }
    }

    fn leaf(first: u32, count: u32) -> Option<Self> {
        Some(Self::Leaf { first, count })
    }

    fn link(&mut self, children: [NodeRef; 2]) {
        if let Self::Split { above, .. } = self {
            *above = children[1].first;
        }
    }

    fn shift(&mut self, nodes: u32, indices: u32) {
        match self {
            Self::Split { above, .. } => *above += nodes,
            Self::Leaf { first, .. } => *first += indices,
        }
    }
}

/// Checks that the nodes are a tree in depth-first order with valid references and leaves of `n_references` in total.
///
/// # Errors
/// The first node that is out of order or too deep.
pub(crate) fn check_order<C>(nodes: &[PartitionNode<C>], n_references: usize) -> Result<(), ValidationError> {
    // Expected nodes, the next one last, with their depths.
    let mut expected = vec![(0, 0)];
    let mut next_first = 0;
    for (number, node) in (0..).zip(nodes) {
        let misplaced = ValidationError::Node { node: number };
        let depth = match expected.pop() {
            Some((promised, depth)) if promised == number => depth,
            _ => return Err(misplaced),
        };
        match *node {
            PartitionNode::Split { .. } if depth == MAX_DEPTH => {
                return Err(ValidationError::Depth { depth: depth + 1 });
            }
            PartitionNode::Split { above, .. } => expected.extend([(above, depth + 1), (number + 1, depth + 1)]),
            PartitionNode::Leaf { first, count } => {
                if first != next_first {
                    return Err(misplaced);
                }
                next_first = first.checked_add(count).ok_or(misplaced)?;
            }
        }
    }
    match expected.pop() {
        Some((missing, _)) => Err(ValidationError::Node { node: missing }),
        None if next_first as usize != n_references => Err(ValidationError::Node { node: nodes.len() as u32 - 1 }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn split(above: u32) -> PartitionNode<()> {
        PartitionNode::Split { plane: (), above }
    }

    const fn leaf(first: u32, count: u32) -> PartitionNode<()> {
        PartitionNode::Leaf { first, count }
    }

    #[test]
    fn only_depth_first_trees_pass() {
        let good = [split(4), split(3), leaf(0, 2), leaf(2, 0), leaf(2, 1)];
        assert_eq!(check_order(&good, 3), Ok(()));
        assert_eq!(check_order(&[leaf(0, 0)], 0), Ok(()));
        let verdict = |nodes: &[PartitionNode<()>]| check_order(nodes, 3);
        let at = |node| Err(ValidationError::Node { node });
        assert_eq!(verdict(&[]), at(0));
        assert_eq!(verdict(&good[..4]), at(4), "cut short");
        assert_eq!(verdict(&[good[0], good[1], good[2], good[3], good[4], leaf(3, 0)]), at(5), "left over");
        assert_eq!(verdict(&[split(0), leaf(0, 1), leaf(1, 2)]), at(2), "a loop");
        assert_eq!(verdict(&[split(1), leaf(0, 1), leaf(1, 2)]), at(2), "a node with two parents");
        assert_eq!(verdict(&[split(9), leaf(0, 1), leaf(1, 2)]), at(2), "a node that is not there");
        assert_eq!(verdict(&[split(2), leaf(0, 1), leaf(1, 1)]), at(2), "a reference too few");
        assert_eq!(verdict(&[split(2), leaf(0, 1), leaf(2, 1)]), at(2), "a reference left out");
        assert_eq!(verdict(&[split(2), leaf(0, 1), leaf(1, u32::MAX)]), at(2), "past all numbers");
    }

    #[test]
    fn deep_trees_do_not_pass() {
        let comb = |depth: u32| {
            let splits = (0..depth).map(|level| split(2 * depth - level));
            splits.chain((0..=depth).map(|_| leaf(0, 0))).collect::<Vec<_>>()
        };
        assert_eq!(check_order(&comb(60), 0), Ok(()));
        assert_eq!(check_order(&comb(61), 0), Err(ValidationError::Depth { depth: 61 }));
    }
}
