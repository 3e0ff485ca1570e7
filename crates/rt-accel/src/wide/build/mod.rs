//! Builder: a binary tree by binned SAH, collapsed into the wide tree of minimum expected cost.

mod binary;
mod binning;
mod collapse;
mod config;
mod leaf_policy;
mod parallel;
#[cfg(feature = "parallel")]
mod parallel_partition;
mod params;
mod prim_ref;
mod prim_stats;
mod reinsertion;
mod top_down;
mod wide_nodes;

use rt_geometry::Primitives;

use crate::traversal::MAX_DEPTH;

use super::huge_pages::with_huge_pages;
use super::leaf::LeafKind;
use super::node::WideNode;
pub(super) use collapse::{LEAF, NODE, PRIMITIVE};
use config::BuildConfig;
use parallel::SubtreeSet;
pub use params::{BuildParams, Quality};
use prim_ref::{PrimRange, PrimRef};
use prim_stats::Gathered;
pub(super) use prim_stats::PrimStats;
use reinsertion::ReinsertionParams;
use top_down::{BuildRange, PrimInfo};
use wide_nodes::{WideBuilder, WideTree};

/// Builds the tree as a pure function of primitives and parameters; `None` if 28 bits cannot index nodes and leaves.
pub(super) fn build<P: Primitives>(
    primitives: &P,
    stats: &PrimStats,
    kind: LeafKind,
    params: &BuildParams,
) -> Option<WideTree> {
    let config = BuildConfig::new(&stats.extent(), params);
    over(prim_stats::references(primitives, stats.centre(), &config), &config, kind, params.quality)
}

fn over(gathered: Gathered, config: &BuildConfig, kind: LeafKind, quality: Quality) -> Option<WideTree> {
    let Gathered { mut references, mut scratch } = gathered;
    if references.is_empty() {
        return Some(WideTree { nodes: vec![WideNode::EMPTY], listings: Vec::new(), depth: 0 });
    }
    let extent = extent(&references);
    let mut order = with_huge_pages(references.len());
    order.resize(references.len(), PrimRange::default());
    let set = BuildRange {
        references: &mut references,
        scratch: &mut scratch,
        order: &mut order,
        first: 0,
        extent,
        depth: 0,
    };
    let mut forest = SubtreeSet::grow(set, config);
    drop((references, scratch));
    let grown = forest.top;
    match quality {
        Quality::Low => {}
        Quality::Medium => forest.reinsert(&order, config, ReinsertionParams::MEDIUM),
        Quality::High => forest.reinsert(&order, config, ReinsertionParams::HIGH),
    }
    let tree = WideBuilder { forest: &forest, indices: &order, kind }.run()?;
    if tree.depth <= MAX_DEPTH {
        return Some(tree);
    }
    // Reinsertion has made the tree too deep.
    forest.top = grown;
    WideBuilder { forest: &forest, indices: &order, kind }.run()
}

fn extent(references: &[PrimRef]) -> PrimInfo {
    #[cfg(feature = "parallel")]
    return PrimInfo::of_many(references);
    #[cfg(not(feature = "parallel"))]
    PrimInfo::of(references)
}

#[cfg(test)]
mod tests;
