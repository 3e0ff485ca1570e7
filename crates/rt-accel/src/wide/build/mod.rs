//! Builds the wide tree: a binary tree first, and from it the wide one of least expected cost.

mod binary;
mod binning;
mod collapse;
mod leaf_policy;
mod parallel;
#[cfg(feature = "parallel")]
mod parallel_partition;
mod params;
mod prim_refs;
mod reference;
mod reinsertion;
mod top_down;
mod wide_nodes;

use rt_geometry::Primitives;

use crate::bounded_depth::MAX_DEPTH;

use super::huge_pages::with_huge_pages;
use super::leaf::{LeafKind, LeafOrder};
use super::node::Node;
pub(super) use collapse::{LEAF, NODE, PRIMITIVE};
use parallel::SubtreeSet;
pub use params::{BuildParams, Quality};
use prim_refs::Gathered;
pub(super) use prim_refs::PrimStats;
use reference::{PrimRef, Run};
use reinsertion::ReinsertionParams;
use top_down::{BuildConfig, PrimInfo, Set};
use wide_nodes::WideBuilder;

/// A tree whose nodes have up to eight children. The first node is the root, whose one child may be a leaf.
#[derive(Debug, PartialEq)]
pub(super) struct WideTree {
    /// Children come after their parents.
    pub(super) nodes: Vec<Node>,
    /// The leaves in the order of nodes and lanes, part by part.
    pub(super) listings: Vec<LeafOrder>,
    /// Of the deepest leaf; those below the root have depth 1.
    pub(super) depth: u32,
}

/// Builds the tree over the primitives that were counted, which is a pure function of them and the parameters; `None` if
/// numbers run out.
pub(super) fn build<P: Primitives>(
    primitives: &P,
    stats: &PrimStats,
    kind: LeafKind,
    params: &BuildParams,
) -> Option<WideTree> {
    let config = BuildConfig::new(&stats.extent(), params);
    over(prim_refs::references(primitives, stats.centre(), &config), &config, kind, params.quality)
}

/// Builds the tree over references.
fn over(gathered: Gathered, config: &BuildConfig, kind: LeafKind, quality: Quality) -> Option<WideTree> {
    let Gathered { mut references, mut room } = gathered;
    if references.is_empty() {
        return Some(WideTree { nodes: vec![Node::EMPTY], listings: Vec::new(), depth: 0 });
    }
    let extent = extent(&references);
    let mut order = with_huge_pages(references.len());
    order.resize(references.len(), Run::default());
    let set = Set { references: &mut references, room: &mut room, order: &mut order, first: 0, extent, depth: 0 };
    let mut forest = SubtreeSet::grow(set, config);
    drop((references, room));
    let grown = forest.whole;
    match quality {
        Quality::Low => {}
        Quality::Medium => forest.reinsert(&order, config, ReinsertionParams::MEDIUM),
        Quality::High => forest.reinsert(&order, config, ReinsertionParams::HIGH),
    }
    let tree = WideBuilder { forest: &forest, indices: &order, kind }.run()?;
    if tree.depth <= MAX_DEPTH {
        return Some(tree);
    }
    // What was moved down has taken something deep along.
    forest.whole = grown;
    WideBuilder { forest: &forest, indices: &order, kind }.run()
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

fn extent(references: &[PrimRef]) -> PrimInfo {
    #[cfg(feature = "parallel")]
    return PrimInfo::of_many(references);
    #[cfg(not(feature = "parallel"))]
    PrimInfo::of(references)
}

#[cfg(test)]
mod tests;
