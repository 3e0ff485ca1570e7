//! Grows a binary tree from the root down, and the costs of collapsing it from the leaves up.

use glam::Vec3A;

use super::binary::{BinaryNode, BinaryTree, Content};
use super::binning::{AreaUnit, Axes, Best, Binning, Bins, Cut};
use super::cluster::Haste;
use super::collapse::{Costs, Plan};
use super::params::{BuildParams, Quality};
use super::reference::{Reference, Run};
use crate::{bounded_depth::leaves_room_for_halving, bvh::NodeBox};

/// What all sets have in common.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rules {
    pub(super) unit: AreaUnit,
    pub(super) axes: Axes,
    pub(super) haste: Haste,
    /// True if neighbours in the list are joined before the tree grows.
    pub(super) pairs: bool,
    pub(super) max_leaf: usize,
}

impl Rules {
    /// For primitives within this box.
    pub(super) fn new(extent: &NodeBox, params: &BuildParams) -> Self {
        let (axes, haste) = match params.quality {
            Quality::Low => (Axes::Widest, Haste::GREATEST),
            Quality::Medium => (Axes::All, Haste::GREAT),
            Quality::High => (Axes::All, Haste::LITTLE),
        };
        let pairs = params.quality != Quality::High;
        Self { unit: AreaUnit::new(extent), axes, haste, pairs, max_leaf: params.leaf_limit() }
    }
}

/// A set of references that will become a leaf or a node.
pub(super) struct Set<'a> {
    /// The references, and room to put them in another order.
    pub(super) references: &'a mut [Reference],
    pub(super) room: &'a mut [Reference],
    /// What the leaves list.
    pub(super) order: &'a mut [Run],
    /// Place of the set in the list of all.
    pub(super) first: u32,
    pub(super) extent: Extent,
    pub(super) depth: u32,
}

/// Where the references of a set are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Extent {
    pub(super) bounds: NodeBox,
    /// Around all centroids, on the scale of [`Reference::centroid`].
    pub(super) centroids: NodeBox,
}

impl Extent {
    pub(super) const EMPTY: Self = Self { bounds: NodeBox::EMPTY, centroids: NodeBox::EMPTY };

    pub(super) fn of(references: &[Reference]) -> Self {
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
pub(super) fn scatter(references: &[Reference], cut: &Cut, sides: [&mut [Reference]; 2]) -> [NodeBox; 2] {
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
    pub(super) fn split(self, rules: &Rules, bins: &mut Bins) -> [Self; 2] {
        let best = self.binning(rules).and_then(|binning| {
            bins.reset(binning);
            bins.add(self.references);
            bins.best_cut(rules.unit)
        });
        match best {
            Some(best) => self.partition(&best),
            None => self.halve(),
        }
    }

    /// The map to bins, unless the depth that halving needs has been used up.
    pub(super) fn binning(&self, rules: &Rules) -> Option<Binning> {
        let count = self.references.len();
        leaves_room_for_halving(count, self.depth).then(|| Binning::new(&self.extent.centroids, count, rules.axes))
    }

    /// Moves the references over, those on the left of the cut first, in the order in which they were.
    fn partition(self, Best { cut, middle, bounds }: &Best) -> [Self; 2] {
        let (left, right) = self.room.split_at_mut(*middle);
        let centroids = scatter(self.references, cut, [left, right]);
        self.exchange(*middle, [0, 1].map(|side| Extent { bounds: bounds[side], centroids: centroids[side] }))
    }

    /// Goes on with what was moved over.
    pub(super) fn exchange(self, middle: usize, extents: [Extent; 2]) -> [Self; 2] {
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
        let extents = [left, right].map(Extent::of);
        self.divide(middle, extents)
    }

    fn divide(self, middle: usize, extents: [Extent; 2]) -> [Self; 2] {
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
    pub(super) fn push(&mut self, bounds: &NodeBox, content: Content, plan: Plan) -> u32 {
        self.nodes.push(BinaryNode::new(bounds, content));
        self.plans.push(plan);
        self.root()
    }

    /// Adds the tree over a set that is not empty. The recursion is as deep as the tree, which is bounded.
    pub(super) fn grow(&mut self, set: Set<'_>, rules: &Rules, bins: &mut Bins) -> (u32, Costs) {
        let bounds = set.extent.bounds;
        let count = set.references.len();
        let area = rules.unit.area(&bounds);
        if let Some(costs) = rules.leaf(set.references, area) {
            for (place, reference) in set.order.iter_mut().zip(&*set.references) {
                *place = reference.run();
            }
            let leaf = Content::Leaf { first: set.first, count: count as u32 };
            return (self.push(&bounds, leaf, Plan::LEAF), costs);
        }
        let [left, right] = if count == 2 { set.halve() } else { set.split(rules, bins) };
        let (left, left_costs) = self.grow(left, rules, bins);
        let (right, right_costs) = self.grow(right, rules, bins);
        let (node, costs) = self.join(&bounds, [left, right], [&left_costs, &right_costs], rules);
        self.keep(&costs, count);
        (node, costs)
    }

    /// Adds a node above two others.
    pub(super) fn join(
        &mut self,
        bounds: &NodeBox,
        children: [u32; 2],
        costs: [&Costs; 2],
        rules: &Rules,
    ) -> (u32, Costs) {
        let (costs, plan) = Costs::above(rules.unit.area(bounds), costs, rules.max_leaf);
        (self.push(bounds, Content::Inner(children), plan), costs)
    }
}
