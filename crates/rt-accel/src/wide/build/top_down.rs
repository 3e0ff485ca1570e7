//! Grows a binary tree from the root down, and the costs of collapsing it from the leaves up.

use glam::Vec3A;

use super::binary::{BinaryNode, BinaryTree, Content};
use super::binning::{Axes, BestSplit, BinMapping, Bins, NormalizedArea, SplitPlane};
use super::collapse::{CollapsePlan, Costs};
use super::leaf_policy::LeafPolicy;
use super::params::{BuildParams, Quality};
use super::reference::{PrimRef, Run};
use crate::{bounded_depth::leaves_room_for_halving, bvh::NodeBox};

/// What all sets have in common.
#[derive(Clone, Copy, Debug)]
pub(super) struct BuildConfig {
    pub(super) unit: NormalizedArea,
    pub(super) axes: Axes,
    pub(super) leaf_policy: LeafPolicy,
    /// True if neighbours in the list are joined before the tree grows.
    pub(super) pairs: bool,
    pub(super) max_leaf: usize,
}

impl BuildConfig {
    /// For primitives within this box.
    pub(super) fn new(extent: &NodeBox, params: &BuildParams) -> Self {
        let (axes, leaf_policy) = match params.quality {
            Quality::Low => (Axes::Widest, LeafPolicy::GREEDY),
            Quality::Medium => (Axes::All, LeafPolicy::LOOSE),
            Quality::High => (Axes::All, LeafPolicy::STRICT),
        };
        let pairs = params.quality != Quality::High;
        Self { unit: NormalizedArea::new(extent), axes, leaf_policy, pairs, max_leaf: params.leaf_limit() }
    }
}

/// A set of references that will become a leaf or a node.
pub(super) struct Set<'a> {
    /// The references, and room to put them in another order.
    pub(super) references: &'a mut [PrimRef],
    pub(super) room: &'a mut [PrimRef],
    /// What the leaves list.
    pub(super) order: &'a mut [Run],
    /// Place of the set in the list of all.
    pub(super) first: u32,
    pub(super) extent: PrimInfo,
    pub(super) depth: u32,
}

/// Where the references of a set are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PrimInfo {
    pub(super) bounds: NodeBox,
    /// Around all centroids, on the scale of [`PrimRef::centroid`].
    pub(super) centroids: NodeBox,
}

impl PrimInfo {
    pub(super) const EMPTY: Self = Self { bounds: NodeBox::EMPTY, centroids: NodeBox::EMPTY };

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

/// Copies each reference to its side, and returns the boxes of the centroids on both. No branch depends on the side,
/// which cannot be foreseen.
pub(super) fn scatter(references: &[PrimRef], cut: &SplitPlane, sides: [&mut [PrimRef]; 2]) -> [NodeBox; 2] {
    const AWAY: [[f32; 2]; 2] = [[0.0, f32::INFINITY], [f32::INFINITY, 0.0]];
    let mut centroids = [NodeBox::EMPTY; 2];
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
fn include(bounds: NodeBox, point: Vec3A) -> NodeBox {
    NodeBox { min: bounds.min.min(point), max: bounds.max.max(point) }
}

impl<'a> Set<'a> {
    /// Cuts a set of two or more references in two.
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

    /// The map to bins, unless the depth that halving needs has been used up.
    pub(super) fn binning(&self, config: &BuildConfig) -> Option<BinMapping> {
        let count = self.references.len();
        leaves_room_for_halving(count, self.depth).then(|| BinMapping::new(&self.extent.centroids, count, config.axes))
    }

    /// Moves the references over, those on the left of the cut first, in the order in which they were.
    fn partition(self, BestSplit { cut, middle, bounds }: &BestSplit) -> [Self; 2] {
        let (left, right) = self.room.split_at_mut(*middle);
        let centroids = scatter(self.references, cut, [left, right]);
        self.exchange(*middle, [0, 1].map(|side| PrimInfo { bounds: bounds[side], centroids: centroids[side] }))
    }

    /// Goes on with what was moved over.
    pub(super) fn exchange(self, middle: usize, extents: [PrimInfo; 2]) -> [Self; 2] {
        Set { references: self.room, room: self.references, ..self }.divide(middle, extents)
    }

    /// Cuts at the median centroid of the widest axis; by order alone if all centroids coincide.
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
        let (left_room, right_room) = self.room.split_at_mut(middle);
        let (left_order, right_order) = self.order.split_at_mut(middle);
        let depth = self.depth + 1;
        [
            Set { references: left, room: left_room, order: left_order, first: self.first, extent: extents[0], depth },
            Set {
                references: right,
                room: right_room,
                order: right_order,
                first: self.first + middle as u32,
                extent: extents[1],
                depth,
            },
        ]
    }
}

impl BinaryTree {
    pub(super) fn push(&mut self, bounds: &NodeBox, content: Content, plan: CollapsePlan) -> u32 {
        self.nodes.push(BinaryNode::new(bounds, content));
        self.plans.push(plan);
        self.root()
    }

    /// Adds the tree over a set that is not empty. The recursion is as deep as the tree, which is bounded.
    pub(super) fn grow(&mut self, set: Set<'_>, config: &BuildConfig, bins: &mut Bins) -> (u32, Costs) {
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

    /// Adds a node above two others.
    pub(super) fn join(
        &mut self,
        bounds: &NodeBox,
        children: [u32; 2],
        costs: [&Costs; 2],
        config: &BuildConfig,
    ) -> (u32, Costs) {
        let (costs, plan) = Costs::above(config.unit.area(bounds), costs, config.max_leaf);
        (self.push(bounds, Content::Inner(children), plan), costs)
    }
}
