//! Saves a hierarchy as it is, part split and part not, and checks what is loaded.

use rt_math::Aabb;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::LazyBih;
use super::node::{Known, LazyNode};
use crate::{ValidationError, bih::planes::Planes, bih::walk::Step, bounded_depth::MAX_DEPTH, tree::Item};

#[derive(Serialize, Deserialize)]
struct Saved {
    bounds: Aabb,
    /// Depth first, the left side first: which are below which follows from that.
    nodes: Vec<SavedNode>,
    unbounded: Vec<u32>,
}

#[derive(Serialize, Deserialize)]
enum SavedNode {
    Waiting { items: Vec<Item>, cell: Aabb },
    Leaf(Vec<u32>),
    Node(Planes),
}

impl Serialize for LazyBih {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut nodes = Vec::new();
        self.for_each_node(|known, _, _| nodes.push(SavedNode::of(known)));
        Saved { bounds: self.bounds, nodes, unbounded: self.unbounded.clone() }.serialize(serializer)
    }
}

impl SavedNode {
    fn of(known: &Known<'_>) -> Self {
        match known {
            Known::Split(Step::Node(planes, _)) => Self::Node(**planes),
            Known::Split(Step::Leaf(indices)) => Self::Leaf(indices.to_vec()),
            Known::Waiting(waiting) => match waiting.as_ref() {
                Some(waiting) => Self::Waiting { items: waiting.items.clone(), cell: waiting.cell },
                None => Self::Leaf(Vec::new()),
            },
        }
    }

    fn listed(&self) -> Vec<u32> {
        match self {
            Self::Waiting { items, .. } => items.iter().map(|&(index, _)| index).collect(),
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
        // From the end: what is below a node has been made when the node is.
        let mut made = Vec::new();
        for (node, depth) in self.nodes.into_iter().zip(depths).rev() {
            let node = match node {
                SavedNode::Waiting { items, cell } => LazyNode::waiting(items, cell, depth),
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

    /// Checks that the lists number all primitives, and each of them once; returns how many there are.
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

    /// Checks that the nodes make one tree, which will not become too deep; returns their depths.
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
                SavedNode::Waiting { items, .. } => {
                    let is_box = |own: &Aabb| own.is_finite() && !own.is_empty();
                    if let Some(&(primitive, _)) = items.iter().find(|(_, own)| !is_box(own)) {
                        return Err(ValidationError::Outside { primitive });
                    }
                    // Halving needs that much, and no builder leaves less.
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
