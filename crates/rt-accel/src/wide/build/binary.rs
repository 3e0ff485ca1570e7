//! Binary tree, an intermediate step of the builder.

use glam::Vec3A;

use super::collapse::{CollapsePlan, Costs};
use crate::bvh::Aabb32;

/// Minimum number of references of a node whose costs are stored.
const LARGE: usize = 32;

/// A node of the binary tree, in 32 bytes.
#[derive(Clone, Copy, Debug)]
pub(super) struct BinaryNode {
    min: [f32; 3],
    first: u32,
    max: [f32; 3],
    second: u32,
}

/// Kind of a binary node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Content {
    /// Indices of both children.
    Inner([u32; 2]),
    /// Consecutive references.
    Leaf {
        /// First, in the order of all.
        first: u32,
        /// Count, from 1 to 8.
        count: u32,
    },
    /// Index of a link to another tree.
    Link(u32),
}

/// TopNode limit of node indices; leaves and links are marked by larger numbers.
const MARKS: u32 = u32::MAX - 8;

impl BinaryNode {
    pub(super) fn new(bounds: &Aabb32, content: Content) -> Self {
        let (first, second) = match content {
            Content::Inner([left, right]) => (left, right),
            Content::Leaf { first, count } => (first, MARKS + count),
            Content::Link(link) => (link, MARKS),
        };
        Self { min: bounds.min.to_array(), first, max: bounds.max.to_array(), second }
    }

    pub(super) fn bounds(&self) -> Aabb32 {
        Aabb32 { min: Vec3A::from_array(self.min), max: Vec3A::from_array(self.max) }
    }

    #[inline(always)]
    pub(super) fn content(&self) -> Content {
        match self.second.checked_sub(MARKS) {
            None => Content::Inner([self.first, self.second]),
            Some(0) => Content::Link(self.first),
            Some(count) => Content::Leaf { first: self.first, count },
        }
    }
}

/// A tree, or the part that one task built: children precede their parent, and the root is last.
#[derive(Debug, Default)]
pub(super) struct BinaryTree {
    pub(super) nodes: Vec<BinaryNode>,
    /// Best collapse of each node.
    pub(super) plans: Vec<CollapsePlan>,
    /// Costs of large nodes, by rising index.
    kept: Vec<(u32, Costs)>,
}

impl BinaryTree {
    /// Keeps the costs of the last node, which has `count` references.
    pub(super) fn keep(&mut self, costs: &Costs, count: usize) {
        if count >= LARGE {
            self.kept.push((self.root(), *costs));
        }
    }

    /// Costs of a large node.
    pub(super) fn kept(&self, node: u32) -> Option<Costs> {
        let place = self.kept.binary_search_by_key(&node, |kept| kept.0).ok()?;
        Some(self.kept[place].1)
    }

    pub(super) fn root(&self) -> u32 {
        self.nodes.len() as u32 - 1
    }
}
