//! Reinsertion: removes subtrees, largest first, and inserts each where the sum of all areas becomes minimal. See
//! Bittner, Hapala and Havran, "Fast Insertion-Based Optimization of Bounding Volume Hierarchies", 2013. The search
//! starts at the former position (Meister and Bittner, "Parallel Reinsertion for Bounding Volume Hierarchy
//! Optimization", 2018).
//!
//! ```text
//!          a                     a
//!        ┌─┴─┐                 ┌─┴─┐        Taking out x saves area(p) and what the nodes above it shrink by.
//!        p   c       ──▶       s   p        Putting it at t costs area(t ∪ x) and what the nodes above that grow by.
//!      ┌─┴─┐                     ┌─┴─┐
//!      s   x                     c   x      Here t = c.
//! ```

use std::collections::BinaryHeap;

use super::binary::{BinaryTree, Content};
use super::binning::NormalizedArea;
use super::collapse::{CollapsePlan, Costs};
use super::config::BuildConfig;
use super::parallel::{NodeId, SubtreeRef, SubtreeSet};
use super::prim_ref::PrimRange;
use crate::{bvh::Aabb32, traversal::MAX_DEPTH};

/// Extent of reinsertion.
#[derive(Clone, Copy, Debug)]
pub(super) struct ReinsertionParams {
    /// Maximum nodes of the optimised upper tree; subtrees below stay unchanged.
    pub(super) max_nodes: usize,
    /// Ratio of nodes that each iteration moves.
    pub(super) ratio: f64,
    pub(super) iterations: usize,
}

impl ReinsertionParams {
    /// Finds large primitives among small ones, in one or two milliseconds for any scene.
    pub(super) const MEDIUM: Self = Self { max_nodes: 1024, ratio: 1.0, iterations: 1 };
    pub(super) const HIGH: Self = Self { max_nodes: usize::MAX, ratio: 0.15, iterations: 3 };
}

const NONE: u32 = u32::MAX;

struct LinkedNode {
    bounds: Aabb32,
    area: f32,
    parent: u32,
    /// Children, if the node is part of the upper tree.
    children: Option<[u32; 2]>,
    /// Original node.
    place: NodeId,
}

/// Upper tree with parent links; the root is first.
struct ParentLinkedBvh {
    nodes: Vec<LinkedNode>,
    unit: NormalizedArea,
    /// Nodes to be searched, with an upper bound of the gain; empty between searches.
    pending: Vec<(f32, u32)>,
}

impl SubtreeSet {
    /// Optimises the tree; keeps the original if that is not more expensive.
    pub(super) fn reinsert(&mut self, order: &[PrimRange], config: &BuildConfig, params: ReinsertionParams) {
        let mut linked = ParentLinkedBvh::new(self, config.unit, params.max_nodes);
        for _ in 0..params.iterations {
            if !linked.pass(params.ratio) {
                break;
            }
        }
        match linked.collapse(self, order, config) {
            Some(better) if better.costs.as_one() < self.top.costs.as_one() => self.top = better,
            _ => {}
        }
    }
}

impl ParentLinkedBvh {
    fn new(forest: &SubtreeSet, unit: NormalizedArea, max_nodes: usize) -> Self {
        let mut linked = Self { nodes: Vec::new(), unit, pending: Vec::new() };
        linked.push(forest, forest.root(), NONE);
        // Largest first; NaN areas precede all.
        let key = |area: f32, number: u32| (area.to_bits(), core::cmp::Reverse(number));
        let mut largest = BinaryHeap::from([key(linked.area(0), 0)]);
        for _ in 0..max_nodes {
            let Some((_, core::cmp::Reverse(number))) = largest.pop() else { break };
            let place = linked.node(number).place;
            let Content::Inner(children) = forest.content(place) else { continue };
            let children = children.map(|node| {
                let child = linked.push(forest, forest.follow(NodeId { node, ..place }), number);
                largest.push(key(linked.area(child), child));
                child
            });
            linked.nodes[number as usize].children = Some(children);
        }
        linked
    }

    fn push(&mut self, forest: &SubtreeSet, place: NodeId, parent: u32) -> u32 {
        let bounds = forest.bounds(place);
        self.nodes.push(LinkedNode { bounds, area: self.unit.area(&bounds), parent, children: None, place });
        self.nodes.len() as u32 - 1
    }

    /// Reinserts the largest nodes; true if any was moved.
    fn pass(&mut self, moved: f64) -> bool {
        // Areas are not negative, so that their bits are in the order of their values.
        let key = |number| (u64::from(!self.area(number).to_bits()) << 32) | u64::from(number);
        let mut largest: Vec<u64> = (1..self.nodes.len() as u32).map(key).collect();
        let count = (self.nodes.len() as f64 * moved).ceil() as usize;
        if count < largest.len() {
            largest.select_nth_unstable(count);
            largest.truncate(count);
        }
        largest.sort_unstable();
        largest.iter().filter(|&&key| self.reinsert_node(key as u32)).count() > 0
    }

    fn node(&self, number: u32) -> &LinkedNode {
        &self.nodes[number as usize]
    }

    fn area(&self, number: u32) -> f32 {
        self.node(number).area
    }

    fn children(&self, number: u32) -> Option<[u32; 2]> {
        self.node(number).children
    }

    /// Other child of the parent; not for the root.
    fn sibling(&self, number: u32) -> u32 {
        self.children(self.node(number).parent).map_or(0, |[a, b]| if a == number { b } else { a })
    }

    /// Moves a node to its best position, if that is elsewhere.
    fn reinsert_node(&mut self, moved: u32) -> bool {
        let parent = self.node(moved).parent;
        // A child of the root stays, as removal needs a grandparent.
        if parent == NONE || self.node(parent).parent == NONE {
            return false;
        }
        let best = self.best_place(moved);
        if let Some(place) = best {
            self.remove(moved);
            self.insert(moved, parent, place);
        }
        best.is_some()
    }

    /// Best new sibling, if there is a gain.
    fn best_place(&mut self, moved: u32) -> Option<u32> {
        let LinkedNode { bounds, area, parent, .. } = *self.node(moved);
        let sibling = self.sibling(moved);
        let (mut best, mut place) = (0.0, None);
        // Area saved by removal below the pivot, and the remaining bounds of the pivot.
        let (mut saved, mut rest) = (self.area(parent), self.node(sibling).bounds);
        let (mut pivot, mut side) = (parent, sibling);
        loop {
            self.pending.push((saved, side));
            while let Some((saved, target)) = self.pending.pop() {
                // No position below gains more.
                if !(saved - area > best) {
                    continue;
                }
                let both = self.unit.area(&self.node(target).bounds.union(bounds));
                if saved - both > best && target != sibling {
                    (best, place) = (saved - both, Some(target));
                }
                if let Some(children) = self.children(target) {
                    let saved = saved + self.area(target) - both;
                    self.pending.extend(children.map(|child| (saved, child)));
                }
            }
            if pivot != parent {
                saved += self.area(pivot) - self.unit.area(&rest);
            }
            if self.node(pivot).parent == NONE {
                return place;
            }
            side = self.sibling(pivot);
            pivot = self.node(pivot).parent;
            rest = rest.union(self.node(side).bounds);
        }
    }

    /// Replaces the parent by the sibling.
    fn remove(&mut self, moved: u32) {
        let (parent, sibling) = (self.node(moved).parent, self.sibling(moved));
        self.replace(parent, sibling);
        self.refit(self.node(sibling).parent);
    }

    /// Inserts a node, with `above` as the parent of both.
    fn insert(&mut self, moved: u32, above: u32, place: u32) {
        self.replace(place, above);
        self.nodes[above as usize].children = Some([place, moved]);
        for child in [place, moved] {
            self.nodes[child as usize].parent = above;
        }
        self.refit(above);
    }

    /// Replaces a child of a parent.
    fn replace(&mut self, old: u32, new: u32) {
        let parent = self.node(old).parent;
        if let Some(LinkedNode { children: Some(children), .. }) = self.nodes.get_mut(parent as usize) {
            *children = children.map(|child| if child == old { new } else { child });
        }
        self.nodes[new as usize].parent = parent;
    }

    /// Refits the bounds of a node and its ancestors.
    fn refit(&mut self, mut number: u32) {
        while let Some([a, b]) = self.nodes.get(number as usize).and_then(|_| self.children(number)) {
            let bounds = self.node(a).bounds.union(self.node(b).bounds);
            let area = self.unit.area(&bounds);
            let node = &mut self.nodes[number as usize];
            (node.bounds, node.area) = (bounds, area);
            number = node.parent;
        }
    }

    /// Collapses the tree, unless it has become too deep. Unopened subtrees become links.
    fn collapse(&self, forest: &mut SubtreeSet, order: &[PrimRange], config: &BuildConfig) -> Option<SubtreeRef> {
        let mut from_root = Vec::with_capacity(self.nodes.len());
        let mut pending = vec![(0, 0)];
        while let Some((number, depth)) = pending.pop() {
            if depth > MAX_DEPTH {
                return None;
            }
            from_root.push(number);
            pending.extend(self.children(number).into_iter().flatten().map(|child| (child, depth + 1)));
        }
        let tree = forest.trees.len();
        forest.trees.push(BinaryTree::default());
        let mut made = vec![(0, Costs::NONE); self.nodes.len()];
        for &number in from_root.iter().rev() {
            let LinkedNode { bounds, place, .. } = self.node(number);
            made[number as usize] = match (self.children(number), forest.content(*place)) {
                (Some(children), _) => {
                    let [(a, a_costs), (b, b_costs)] = children.map(|child| made[child as usize]);
                    forest.trees[tree].join(bounds, [a, b], [&a_costs, &b_costs], config)
                }
                (None, content @ Content::Leaf { .. }) => {
                    (forest.trees[tree].push(bounds, content, CollapsePlan::LEAF), forest.costs(*place, order, config))
                }
                (None, _) => {
                    let costs = forest.costs(*place, order, config);
                    (forest.link(bounds, SubtreeRef { place: *place, costs }, tree), costs)
                }
            };
        }
        let (node, costs) = made[0];
        Some(SubtreeRef { place: NodeId { tree: tree as u32, node }, costs })
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3A;

    use super::*;

    #[test]
    fn a_leaf_far_from_its_sibling_moves_to_its_neighbour() {
        // From (((0, 100), 1), 101) to ((0, 1), (100, 101)).
        let order = [0, 1, 2, 3].map(|first| PrimRange { first, count: 1 });
        let unit = NormalizedArea::new(&Aabb32 { min: Vec3A::ZERO, max: Vec3A::splat(102.0) });
        let config = BuildConfig {
            unit,
            axes: crate::wide::build::binning::Axes::All,
            leaf_policy: crate::wide::build::leaf_policy::LeafPolicy::STRICT,
            pairs: true,
            max_leaf: 1,
        };
        let mut tree = BinaryTree::default();
        let leaves = [0.0, 100.0, 1.0, 101.0].into_iter().zip(0..).map(|(x, first)| {
            let bounds = Aabb32 { min: Vec3A::X * x, max: Vec3A::new(x + 1.0, 1.0, 1.0) };
            let number = tree.push(&bounds, Content::Leaf { first, count: 1 }, CollapsePlan::LEAF);
            (number, bounds, Costs::leaf(unit.area(&bounds), 1))
        });
        let leaves: Vec<_> = leaves.collect();
        let whole = leaves.into_iter().reduce(|(a, a_box, a_costs), (b, b_box, b_costs)| {
            let bounds = a_box.union(b_box);
            let (number, costs) = tree.join(&bounds, [a, b], [&a_costs, &b_costs], &config);
            (number, bounds, costs)
        });
        let (node, _, costs) = whole.expect("four leaves");
        let whole = SubtreeRef { place: NodeId { tree: 0, node }, costs };
        let mut forest = SubtreeSet { trees: vec![tree], links: Vec::new(), top: whole };
        let mut linked = ParentLinkedBvh::new(&forest, unit, usize::MAX);
        while (1..7).any(|number| linked.reinsert_node(number)) {}
        let inner = linked.nodes.iter().filter(|node| node.children.is_some());
        let mut lengths: Vec<_> = inner.map(|node| node.bounds.max.x - node.bounds.min.x).collect();
        lengths.sort_unstable_by(f32::total_cmp);
        assert_eq!(lengths, [2.0, 2.0, 102.0]);
        assert!(
            linked.collapse(&mut forest, &order, &config).is_some_and(|better| better.costs.as_one() <= costs.as_one())
        );
    }
}
