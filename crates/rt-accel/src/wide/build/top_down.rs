//! Top-down build of the binary tree; costs of its collapse are computed bottom-up.

use glam::Vec3A;

use super::binary::{BinaryNode, BinaryTree, Content};
use super::binning::{BestSplit, BinMapping, BinSplit, Bins};
use super::collapse::{CollapsePlan, Costs};
use super::config::BuildConfig;
use super::prim_ref::{PrimRange, PrimRef};
use crate::{bvh::Aabb32, traversal::depth_allows_median_split};

/// Consecutive references that become a leaf or a node.
pub(super) struct BuildRange<'a> {
    /// References, and scratch space to reorder them.
    pub(super) references: &'a mut [PrimRef],
    pub(super) scratch: &'a mut [PrimRef],
    /// Primitives in the order of leaves.
    pub(super) order: &'a mut [PrimRange],
    /// Index of the first in the order of all.
    pub(super) first: u32,
    pub(super) extent: PrimInfo,
    pub(super) depth: u32,
}

/// Bounds of references and of their centroids.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PrimInfo {
    pub(super) bounds: Aabb32,
    /// Bounds of [`PrimRef::centroid`].
    pub(super) centroids: Aabb32,
}

impl PrimInfo {
    pub(super) const EMPTY: Self = Self { bounds: Aabb32::EMPTY, centroids: Aabb32::EMPTY };

    pub(super) fn of(references: &[PrimRef]) -> Self {
        references.iter().fold(Self::EMPTY, |all, reference| Self {
            bounds: all.bounds.union(reference.bounds()),
            centroids: include(all.centroids, reference.centroid()),
        })
    }

    #[cfg(feature = "parallel")]
    pub(super) fn union(self, other: Self) -> Self {
        Self { bounds: self.bounds.union(other.bounds), centroids: self.centroids.union(other.centroids) }
    }
}

/// Copies each reference to its side, and returns the bounds of the centroids on both. Branch-free, as the side is
/// unpredictable.
pub(super) fn scatter(references: &[PrimRef], cut: &BinSplit, sides: [&mut [PrimRef]; 2]) -> [Aabb32; 2] {
    const AWAY: [[f32; 2]; 2] = [[0.0, f32::INFINITY], [f32::INFINITY, 0.0]];
    let mut centroids = [Aabb32::EMPTY; 2];
    let mut next = [0; 2];
    for reference in references {
        let side = cut.side(reference);
        let centroid = reference.centroid();
        for (bounds, away) in centroids.iter_mut().zip(AWAY[side]) {
            bounds.min = (centroid + away).min(bounds.min);
            bounds.max = (centroid - away).max(bounds.max);
        }
        sides[side][next[side]] = *reference;
        next[side] += 1;
    }
    centroids
}

#[inline(always)]
fn include(bounds: Aabb32, point: Vec3A) -> Aabb32 {
    Aabb32 { min: bounds.min.min(point), max: bounds.max.max(point) }
}

impl<'a> BuildRange<'a> {
    /// Splits a range of two or more references.
    pub(super) fn split(self, config: &BuildConfig, bins: &mut Bins) -> [Self; 2] {
        let best = self.binning(config).and_then(|binning| {
            bins.reset(binning);
            bins.add(self.references);
            bins.best_split(config.unit)
        });
        match best {
            Some(best) => self.partition(&best),
            None => self.halve(),
        }
    }

    /// Mapping to bins, unless the remaining depth only allows median splits.
    pub(super) fn binning(&self, config: &BuildConfig) -> Option<BinMapping> {
        let count = self.references.len();
        depth_allows_median_split(count, self.depth)
            .then(|| BinMapping::new(&self.extent.centroids, count, config.axes))
    }

    /// Moves the references of the left side first, in stable order.
    fn partition(self, BestSplit { cut, middle, bounds }: &BestSplit) -> [Self; 2] {
        let (left, right) = self.scratch.split_at_mut(*middle);
        let centroids = scatter(self.references, cut, [left, right]);
        self.exchange(*middle, [0, 1].map(|side| PrimInfo { bounds: bounds[side], centroids: centroids[side] }))
    }

    /// Swaps references and scratch space.
    pub(super) fn exchange(self, middle: usize, extents: [PrimInfo; 2]) -> [Self; 2] {
        BuildRange { references: self.scratch, scratch: self.references, ..self }.divide(middle, extents)
    }

    /// Splits at the median centroid of the widest axis, or by order if all centroids coincide.
    pub(super) fn halve(self) -> [Self; 2] {
        let spread = self.extent.centroids.max - self.extent.centroids.min;
        let middle = self.references.len() / 2;
        if !spread.cmple(Vec3A::ZERO).all() {
            let axis = spread.max_position();
            self.references.select_nth_unstable_by(middle, |a, b| {
                a.centroid()[axis].total_cmp(&b.centroid()[axis]).then(a.index().cmp(&b.index()))
            });
        }
        let (left, right) = self.references.split_at(middle);
        let extents = [left, right].map(PrimInfo::of);
        self.divide(middle, extents)
    }

    fn divide(self, middle: usize, extents: [PrimInfo; 2]) -> [Self; 2] {
        let (left, right) = self.references.split_at_mut(middle);
        let (left_scratch, right_scratch) = self.scratch.split_at_mut(middle);
        let (left_order, right_order) = self.order.split_at_mut(middle);
        let depth = self.depth + 1;
        [
            BuildRange {
                references: left,
                scratch: left_scratch,
                order: left_order,
                first: self.first,
                extent: extents[0],
                depth,
            },
            BuildRange {
                references: right,
                scratch: right_scratch,
                order: right_order,
                first: self.first + middle as u32,
                extent: extents[1],
                depth,
            },
        ]
    }
}

impl BinaryTree {
    pub(super) fn push(&mut self, bounds: &Aabb32, content: Content, plan: CollapsePlan) -> u32 {
        self.nodes.push(BinaryNode::new(bounds, content));
        self.plans.push(plan);
        self.root()
    }

    /// Builds the tree over a range that is not empty. The recursion is as deep as the tree, which is bounded.
    pub(super) fn grow(&mut self, set: BuildRange<'_>, config: &BuildConfig, bins: &mut Bins) -> (u32, Costs) {
        let bounds = set.extent.bounds;
        let count = set.references.len();
        let area = config.unit.area(&bounds);
        if let Some(costs) = config.leaf(set.references, area) {
            for (place, reference) in set.order.iter_mut().zip(&*set.references) {
                *place = reference.run();
            }
            let leaf = Content::Leaf { first: set.first, count: count as u32 };
            return (self.push(&bounds, leaf, CollapsePlan::LEAF), costs);
        }
        let [left, right] = if count == 2 { set.halve() } else { set.split(config, bins) };
        let (left, left_costs) = self.grow(left, config, bins);
        let (right, right_costs) = self.grow(right, config, bins);
        let (node, costs) = self.join(&bounds, [left, right], [&left_costs, &right_costs], config);
        self.keep(&costs, count);
        (node, costs)
    }

    /// Adds the parent of two nodes.
    pub(super) fn join(
        &mut self,
        bounds: &Aabb32,
        children: [u32; 2],
        costs: [&Costs; 2],
        config: &BuildConfig,
    ) -> (u32, Costs) {
        let (costs, plan) = Costs::above(config.unit.area(bounds), costs, config.max_leaf);
        (self.push(bounds, Content::Inner(children), plan), costs)
    }
}
