//! Serialisation of the current state, with checks on loading.

use rt_math::Aabb;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::LazyBih;
use super::node::{LazyNode, NodeState};
use crate::bih::{planes::Planes, traverse::BihNode};
use crate::{ValidationError, prim_bounds::Item, traversal::MAX_DEPTH};

#[derive(Serialize, Deserialize)]
struct Saved {
    bounds: Aabb,
    /// Depth first, the left child first, which defines the topology.
    nodes: Vec<SavedNode>,
    unbounded: Vec<u32>,
}

#[derive(Serialize, Deserialize)]
enum SavedNode {
    Unsplit { items: Vec<Item>, cell: Aabb },
    Leaf(Vec<u32>),
    Node(Planes),
}

impl Serialize for LazyBih {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut nodes = Vec::new();
        self.for_each_node(|state, _, _| nodes.push(SavedNode::of(state)));
        Saved { bounds: self.bounds, nodes, unbounded: self.unbounded.clone() }.serialize(serializer)
    }
}

impl SavedNode {
    fn of(state: &NodeState<'_>) -> Self {
        match state {
            NodeState::Split(BihNode::Inner(planes, _)) => Self::Node(**planes),
            NodeState::Split(BihNode::Leaf(indices)) => Self::Leaf(indices.to_vec()),
            NodeState::Unsplit(unsplit) => match unsplit.as_ref() {
                Some(unsplit) => Self::Unsplit { items: unsplit.items.clone(), cell: unsplit.cell },
                None => Self::Leaf(Vec::new()),
            },
        }
    }

    fn listed(&self) -> Vec<u32> {
        match self {
            Self::Unsplit { items, .. } => items.iter().map(|&(index, _)| index).collect(),
            Self::Leaf(indices) => indices.clone(),
            Self::Node(_) => Vec::new(),
        }
    }
}

impl<'de> Deserialize<'de> for LazyBih {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Saved::deserialize(deserializer)?.restore().map_err(D::Error::custom)
    }
}

impl Saved {
    fn restore(self) -> Result<LazyBih, ValidationError> {
        let primitives = self.check_lists()?;
        let depths = self.check_shape()?;
        // Backward, so that the children of a node exist.
        let mut made = Vec::new();
        for (node, depth) in self.nodes.into_iter().zip(depths).rev() {
            let node = match node {
                SavedNode::Unsplit { items, cell } => LazyNode::unsplit(items, cell, depth),
                SavedNode::Leaf(indices) => LazyNode::leaf(indices),
                SavedNode::Node(planes) => match (made.pop(), made.pop()) {
                    (Some(left), Some(right)) => LazyNode::inner(planes, [left, right]),
                    _ => return Err(ValidationError::Node { node: 0 }),
                },
            };
            made.push(node);
        }
        let root = made.pop().ok_or(ValidationError::Node { node: 0 })?;
        Ok(LazyBih { bounds: self.bounds, root, unbounded: self.unbounded, primitives })
    }

    /// Checks that each primitive is listed once; returns their number.
    fn check_lists(&self) -> Result<u32, ValidationError> {
        let lists: Vec<_> =
            self.nodes.iter().flat_map(SavedNode::listed).chain(self.unbounded.iter().copied()).collect();
        let mut is_listed = vec![false; lists.len()];
        for primitive in lists {
            match is_listed.get_mut(primitive as usize) {
                Some(listed) if !*listed => *listed = true,
                _ => return Err(ValidationError::Misplaced { primitive }),
            }
        }
        Ok(is_listed.len() as u32)
    }

    /// Checks that the nodes are one tree whose depth will stay within the limit; returns their depths.
    fn check_shape(&self) -> Result<Vec<u32>, ValidationError> {
        let mut depths = Vec::with_capacity(self.nodes.len());
        let mut pending = vec![0];
        for (number, node) in self.nodes.iter().enumerate() {
            let depth = pending.pop().ok_or(ValidationError::Node { node: number as u32 })?;
            let deepest = match node {
                SavedNode::Node(_) => {
                    pending.extend([depth + 1; 2]);
                    depth + 1
                }
                SavedNode::Leaf(_) => depth,
                SavedNode::Unsplit { items, .. } => {
                    let is_box = |own: &Aabb| own.is_finite() && !own.is_empty();
                    if let Some(&(primitive, _)) = items.iter().find(|(_, own)| !is_box(own)) {
                        return Err(ValidationError::Outside { primitive });
                    }
                    // Median splits need that depth, and no builder leaves less.
                    depth + items.len().next_power_of_two().ilog2()
                }
            };
            if deepest > MAX_DEPTH {
                return Err(ValidationError::Depth { depth: deepest });
            }
            depths.push(depth);
        }
        if pending.is_empty() { Ok(depths) } else { Err(ValidationError::Node { node: self.nodes.len() as u32 }) }
    }
}
