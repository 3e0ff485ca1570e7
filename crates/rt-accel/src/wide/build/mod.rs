//! Builds the wide tree: a binary tree first, and from it the wide one of least expected cost.

mod binary;
mod binning;
#[cfg(feature = "parallel")]
mod chunks;
mod cluster;
mod collapse;
mod emit;
mod forest;
mod gather;
mod grow;
mod params;
mod reference;
mod reinsertion;

use rt_geometry::Primitives;

use crate::bounded_depth::MAX_DEPTH;

use super::leaf::{LeafKind, Listing};
use super::node::Node;
use super::pages::room_for;
pub(super) use collapse::{LEAF, NODE, PRIMITIVE};
use emit::Emission;
use forest::Forest;
pub(super) use gather::Census;
use gather::Gathered;
use grow::{Extent, Rules, Set};
pub use params::{BuildParams, Quality};
use reference::{Reference, Run};
use reinsertion::Effort;

/// A tree whose nodes have up to eight children. The first node is the root, whose one child may be a leaf.
#[derive(Debug, PartialEq)]
pub(super) struct WideTree {
    /// Children come after their parents.
    pub(super) nodes: Vec<Node>,
    /// The leaves in the order of nodes and lanes, part by part.
    pub(super) listings: Vec<Listing>,
    /// Of the deepest leaf; those below the root have depth 1.
    pub(super) depth: u32,
}

/// Builds the tree over the primitives that were counted, which is a pure function of them and the parameters; `None` if
/// numbers run out.
pub(super) fn build<P: Primitives>(
    primitives: &P,
    census: &Census,
    kind: LeafKind,
    params: &BuildParams,
) -> Option<WideTree> {
    let rules = Rules::new(&census.extent(), params);
    over(gather::references(primitives, census.centre(), &rules), &rules, kind, params.quality)
}

/// Builds the tree over references.
fn over(gathered: Gathered, rules: &Rules, kind: LeafKind, quality: Quality) -> Option<WideTree> {
    let Gathered { mut references, mut room } = gathered;
    if references.is_empty() {
        return Some(WideTree { nodes: vec![Node::EMPTY], listings: Vec::new(), depth: 0 });
    }
    let extent = extent(&references);
    let mut order = room_for(references.len());
    order.resize(references.len(), Run::default());
    let set = Set { references: &mut references, room: &mut room, order: &mut order, first: 0, extent, depth: 0 };
    let mut forest = Forest::grow(set, rules);
    drop((references, room));
    let grown = forest.whole;
    match quality {
        Quality::Low => {}
        Quality::Medium => forest.reinsert(&order, rules, Effort::LITTLE),
        Quality::High => forest.reinsert(&order, rules, Effort::GREAT),
    }
    let tree = Emission { forest: &forest, indices: &order, kind }.run()?;
    if tree.depth <= MAX_DEPTH {
        return Some(tree);
    }
    // What was moved down has taken something deep along.
    forest.whole = grown;
    Emission { forest: &forest, indices: &order, kind }.run()
}

/// Does as many things, on several threads, and lists what comes of them in order.
#[cfg(feature = "parallel")]
pub(super) fn in_order<T: Send>(count: usize, each: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    use rayon::prelude::*;
    (0..count).into_par_iter().map(each).collect()
}

/// Does as many things, and lists what comes of them in order.
#[cfg(not(feature = "parallel"))]
pub(super) fn in_order<T: Send>(count: usize, each: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    (0..count).map(each).collect()
}

fn extent(references: &[Reference]) -> Extent {
    #[cfg(feature = "parallel")]
    return Extent::of_many(references);
    #[cfg(not(feature = "parallel"))]
    Extent::of(references)
}

#[cfg(test)]
mod tests;
