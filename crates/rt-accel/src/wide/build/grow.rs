//! Grows a binary tree from the root down, and the costs of collapsing it from the leaves up.

use glam::Vec3A;

use super::binary::{BinaryNode, BinaryTree, Content};
use super::binning::{AreaUnit, Best, Binning, Bins};
use super::collapse::{Costs, Plan};
use super::reference::Reference;
use crate::bounded_depth::leaves_room_for_halving;
use crate::bvh::NodeBox;

/// What all sets have in common.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rules {
    pub(super) unit: AreaUnit,
    pub(super) max_leaf: usize,
}

/// A set of references that will become a leaf or a node.
pub(super) struct Set<'a> {
    /// The references, and room to put them in another order.
    pub(super) references: &'a mut [Reference],
    pub(super) room: &'a mut [Reference],
    /// What the references in leaves are the indices of.
    pub(super) order: &'a mut [u32],
    /// Place of the set in the list of all.
    pub(super) first: u32,
    pub(super) extent: Extent,
    pub(super) depth: u32,
}

/// Where the references of a set are.
#[derive(Clone, Copy, Debug)]
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

    pub(super) fn union(self, other: Self) -> Self {
        Self { bounds: self.bounds.union(other.bounds), centroids: self.centroids.union(other.centroids) }
    }
}

#[inline(always)]
fn include(bounds: NodeBox, point: Vec3A) -> NodeBox {
    NodeBox { min: bounds.min.min(point), max: bounds.max.max(point) }
}

impl<'a> Set<'a> {
    /// Cuts a set of two or more references in two.
    pub(super) fn split(self, rules: &Rules) -> [Self; 2] {
        let binning = leaves_room_for_halving(self.references.len(), self.depth)
            .then(|| Binning::new(&self.extent.centroids, self.references.len()));
        let best = binning.and_then(|binning| {
            let mut bins = Bins::new(binning);
            bins.add(self.references);
            bins.best_cut(rules.unit)
        });
        match best {
            Some(best) => self.partition(&best),
            None => self.halve(),
        }
    }

    /// Moves the references over, those on the left of the cut first, in the order in which they were.
    fn partition(self, Best { cut, middle, bounds }: &Best) -> [Self; 2] {
        let mut centroids = [NodeBox::EMPTY; 2];
        let mut next = [0, *middle];
        for reference in &*self.references {
            let side = cut.side(reference);
            centroids[side] = include(centroids[side], reference.centroid());
            self.room[next[side]] = *reference;
            next[side] += 1;
        }
        let extents = [0, 1].map(|side| Extent { bounds: bounds[side], centroids: centroids[side] });
        let moved = Set { references: self.room, room: self.references, ..self };
        moved.divide(*middle, extents)
    }

    /// Cuts at the median centroid of the widest axis; by order alone if all centroids coincide.
    fn halve(self) -> [Self; 2] {
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
    pub(super) fn grow(&mut self, set: Set<'_>, rules: &Rules) -> (u32, Costs) {
        let bounds = set.extent.bounds;
        if set.references.len() == 1 {
            for (place, reference) in set.order.iter_mut().zip(&*set.references) {
                *place = reference.index();
            }
            let leaf = Content::Leaf { first: set.first, count: 1 };
            return (self.push(&bounds, leaf, Plan::LEAF), Costs::leaf(rules.unit.area(&bounds), 1));
        }
        let [left, right] = set.split(rules);
        let (left, left_costs) = self.grow(left, rules);
        let (right, right_costs) = self.grow(right, rules);
        self.join(&bounds, [left, right], [&left_costs, &right_costs], rules)
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
