//! Builds the wide tree: a binary tree first, and from it the wide one of least expected cost.

mod binary;
mod binning;
#[cfg(feature = "parallel")]
mod chunks;
mod cluster;
mod collapse;
mod emit;
mod forest;
mod grow;
mod params;
mod reference;
mod reinsertion;

use crate::bvh::NodeBox;
use binning::{AreaUnit, Axes};
use cluster::Haste;
use collapse::WIDTH;
use emit::Emission;
use forest::Forest;
use grow::{Extent, Rules, Set};
pub use params::{BuildParams, Quality};
pub(crate) use reference::Reference;
use reference::Run;

/// A tree whose nodes have up to eight children. The first node is the root.
#[derive(Debug, PartialEq)]
pub(super) struct WideTree {
    /// In depth-first order. There is always a root, whose one child may be a leaf; without references it has none.
    pub(super) nodes: Vec<WideNode>,
    /// Primitives, leaf by leaf: the leaves of a node follow each other. Each leaf's are sorted and differ.
    pub(super) order: Vec<u32>,
    /// Of the deepest leaf; those below the root have depth 1.
    pub(super) depth: u32,
    /// Expected cost of a ray that meets the root's box, where visiting a node is 1 (MacDonald and Booth 1990).
    pub(super) sah_cost: f64,
}

/// Up to eight boxes side by side, and what is in them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct WideNode {
    pub(super) boxes: [NodeBox; WIDTH],
    pub(super) children: [WideChild; WIDTH],
    /// How many there are; the others are empty.
    pub(super) count: u8,
}

/// What is in one box of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum WideChild {
    /// The node of this number.
    Node(u32),
    /// A run in the list of primitives.
    Leaf {
        /// Place of the first.
        first: u32,
        /// Number of primitives.
        count: u32,
    },
}

impl WideNode {
    const EMPTY: Self =
        Self { boxes: [NodeBox::EMPTY; WIDTH], children: [WideChild::Leaf { first: 0, count: 0 }; WIDTH], count: 0 };

    /// Adds a child if there is room for it.
    fn push(&mut self, bounds: NodeBox, child: WideChild) {
        let at = usize::from(self.count);
        if at < WIDTH {
            self.boxes[at] = bounds;
            self.children[at] = child;
            self.count += 1;
        }
    }
}

/// Builds the tree, which is a pure function of the references and the parameters.
pub(super) fn build(mut references: Vec<Reference>, params: &BuildParams) -> WideTree {
    if references.is_empty() {
        return WideTree { nodes: vec![WideNode::EMPTY], order: Vec::new(), depth: 0, sah_cost: 0.0 };
    }
    let count = references.len();
    let (axes, haste) = match params.quality {
        Quality::Low => (Axes::Widest, Haste::GREAT),
        Quality::Medium | Quality::High => (Axes::All, Haste::LITTLE),
    };
    let unit = AreaUnit::new(&extent(&references).bounds);
    let rules = Rules { unit, axes, haste, max_leaf: params.leaf_limit() };
    rules.pair(&mut references);
    let extent = extent(&references);
    let mut room = references.clone();
    let mut order = vec![Run::default(); references.len()];
    let set = Set { references: &mut references, room: &mut room, order: &mut order, first: 0, extent, depth: 0 };
    let mut forest = Forest::grow(set, &rules);
    if params.quality == Quality::High {
        forest = forest.reinserted(&order, &rules);
    }
    Emission::new(&forest, &order, count).run()
}

fn extent(references: &[Reference]) -> Extent {
    #[cfg(feature = "parallel")]
    return Extent::of_many(references);
    #[cfg(not(feature = "parallel"))]
    Extent::of(references)
}

#[cfg(test)]
mod tests;
