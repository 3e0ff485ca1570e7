//! The binary tree that the wide one is made of.

use glam::Vec3A;

use crate::bvh::NodeBox;

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
    /// The root of another tree of the forest.
    Link(u32),
}

/// No number of a node is as high: leaves and links are marked from here on.
const MARKS: u32 = u32::MAX - 8;

impl BinaryNode {
    pub(super) fn new(bounds: &NodeBox, content: Content) -> Self {
        let (first, second) = match content {
            Content::Inner([left, right]) => (left, right),
            Content::Leaf { first, count } => (first, MARKS + count),
            Content::Link(tree) => (tree, MARKS),
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
    pub(super) plans: Vec<super::collapse::Plan>,
}

impl BinaryTree {
    pub(super) fn root(&self) -> u32 {
        self.nodes.len() as u32 - 1
    }
}
