//! The binary tree that the wide one is made of.

use glam::Vec3A;

use super::collapse::{CollapsePlan, Costs};
use crate::bvh::NodeBox;

/// References below a node from which on its costs are kept: so many that it takes little room.
const LARGE: usize = 32;

/// A node of the binary tree, in 32 bytes.
#[derive(Clone, Copy, Debug)]
pub(super) struct BinaryNode {
    min: [f32; 3],
    first: u32,
    max: [f32; 3],
    second: u32,
}

/// What a node of the binary tree stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Content {
    /// The numbers of both children.
    Inner([u32; 2]),
    /// A run of references.
    Leaf {
        /// Place of the first in the list.
        first: u32,
        /// Their number, from 1 to 8.
        count: u32,
    },
    /// What this link of the forest leads to.
    Link(u32),
}

/// No number of a node is as high: leaves and links are marked from here on.
const MARKS: u32 = u32::MAX - 8;

impl BinaryNode {
    pub(super) fn new(bounds: &NodeBox, content: Content) -> Self {
        let (first, second) = match content {
            Content::Inner([left, right]) => (left, right),
            Content::Leaf { first, count } => (first, MARKS + count),
            Content::Link(link) => (link, MARKS),
        };
        Self { min: bounds.min.to_array(), first, max: bounds.max.to_array(), second }
    }

    pub(super) fn bounds(&self) -> NodeBox {
        NodeBox { min: Vec3A::from_array(self.min), max: Vec3A::from_array(self.max) }
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

/// A tree, or the part of one that was grown by one task: children come before their parent, the root last.
#[derive(Debug, Default)]
pub(super) struct BinaryTree {
    pub(super) nodes: Vec<BinaryNode>,
    /// For each node, how it is best collapsed.
    pub(super) plans: Vec<CollapsePlan>,
    /// The costs of what is below large nodes, by rising number.
    kept: Vec<(u32, Costs)>,
}

impl BinaryTree {
    /// Remembers what is below the last node: `count` references.
    pub(super) fn keep(&mut self, costs: &Costs, count: usize) {
        if count >= LARGE {
            self.kept.push((self.root(), *costs));
        }
    }

    /// The costs of what is below a node, if it is a large one.
    pub(super) fn kept(&self, node: u32) -> Option<Costs> {
        let place = self.kept.binary_search_by_key(&node, |kept| kept.0).ok()?;
        Some(self.kept[place].1)
    }

    pub(super) fn root(&self) -> u32 {
        self.nodes.len() as u32 - 1
    }
}
