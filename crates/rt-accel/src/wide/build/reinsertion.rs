//! Improves a binary tree: takes out subtrees one by one, largest first, and puts each back where the sum of all areas
//! becomes least (Bittner, Hapala and Havran, "Fast Insertion-Based Optimization of Bounding Volume Hierarchies", 2013),
//! searching from where it was (Meister and Bittner, "Parallel Reinsertion for Bounding Volume Hierarchy Optimization",
//! 2018).
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
use super::parallel::{Place, SubtreeRef, SubtreeSet};
use super::reference::Run;
use super::top_down::BuildConfig;
use crate::{bounded_depth::MAX_DEPTH, bvh::NodeBox};

/// How much is done.
#[derive(Clone, Copy, Debug)]
pub(super) struct ReinsertionParams {
    /// So many of the largest nodes are opened; what is below the others stays as it is.
    pub(super) opened: usize,
    /// The part of the nodes that is moved each time.
    pub(super) moved: f64,
    /// Times that the nodes are gone through.
    pub(super) passes: usize,
}

impl ReinsertionParams {
    /// Finds large primitives among small ones, in one or two milliseconds whatever the scene.
    pub(super) const MEDIUM: Self = Self { opened: 1024, moved: 1.0, passes: 1 };
    pub(super) const HIGH: Self = Self { opened: usize::MAX, moved: 0.15, passes: 3 };
}

const NONE: u32 = u32::MAX;

struct Node {
    bounds: NodeBox,
    area: f32,
    parent: u32,
    /// The children, if it has been opened.
    children: Option<[u32; 2]>,
    /// What it was made of.
    place: Place,
}

/// A tree that knows its parents; the root is the first.
struct ParentLinkedBvh {
    nodes: Vec<Node>,
    unit: NormalizedArea,
    /// Nodes yet to be searched, and what is gained at them at most; empty between searches.
    pending: Vec<(f32, u32)>,
}

impl SubtreeSet {
    /// Improves the tree, unless it could not be made better.
    pub(super) fn reinsert(&mut self, order: &[Run], config: &BuildConfig, effort: ReinsertionParams) {
        let mut linked = ParentLinkedBvh::new(self, config.unit, effort.opened);
        for _ in 0..effort.passes {
            if !linked.pass(effort.moved) {
                break;
            }
        }
        match linked.collapse(self, order, config) {
            Some(better) if better.costs.whole() < self.whole.costs.whole() => self.whole = better,
            _ => {}
        }
    }
}

impl ParentLinkedBvh {
    fn new(forest: &SubtreeSet, unit: NormalizedArea, opened: usize) -> Self {
        let mut linked = Self { nodes: Vec::new(), unit, pending: Vec::new() };
        linked.push(forest, forest.root(), NONE);
        // The largest first; areas that are no numbers come before all.
        let key = |area: f32, number: u32| (area.to_bits(), core::cmp::Reverse(number));
        let mut largest = BinaryHeap::from([key(linked.area(0), 0)]);
        for _ in 0..opened {
            let Some((_, core::cmp::Reverse(number))) = largest.pop() else { break };
            let place = linked.node(number).place;
            let Content::Inner(children) = forest.content(place) else { continue };
            let children = children.map(|node| {
                let child = linked.push(forest, forest.follow(Place { node, ..place }), number);
                largest.push(key(linked.area(child), child));
                child
            });
            linked.nodes[number as usize].children = Some(children);
        }
        linked
    }

    fn push(&mut self, forest: &SubtreeSet, place: Place, parent: u32) -> u32 {
        let bounds = forest.bounds(place);
        self.nodes.push(Node { bounds, area: self.unit.area(&bounds), parent, children: None, place });
        self.nodes.len() as u32 - 1
    }

    /// Moves the largest nodes, and says whether any was moved.
    fn pass(&mut self, moved: f64) -> bool {
        let mut largest: Vec<_> = (1..self.nodes.len() as u32).map(|number| (self.area(number), number)).collect();
        let count = (self.nodes.len() as f64 * moved).ceil() as usize;
        let order = |a: &(f32, u32), b: &(f32, u32)| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1));
        if count < largest.len() {
            largest.select_nth_unstable_by(count, order);
            largest.truncate(count);
        }
        largest.sort_unstable_by(order);
        largest.iter().fold(false, |any, &(_, number)| self.reinsert_node(number) || any)
    }

    fn node(&self, number: u32) -> &Node {
        &self.nodes[number as usize]
    }

    fn area(&self, number: u32) -> f32 {
        self.node(number).area
    }

    fn children(&self, number: u32) -> Option<[u32; 2]> {
        self.node(number).children
    }

    /// The other child of the parent; not for the root.
    fn sibling(&self, number: u32) -> u32 {
        self.children(self.node(number).parent).map_or(0, |[a, b]| if a == number { b } else { a })
    }

    /// Puts a node where it is best, if that is elsewhere.
    fn reinsert_node(&mut self, moved: u32) -> bool {
        let parent = self.node(moved).parent;
        // A child of the root stays: there is no node above to take its sibling.
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

    /// The node that it should be the sibling of, if anything is gained.
    fn best_place(&mut self, moved: u32) -> Option<u32> {
        let Node { bounds, area, parent, .. } = *self.node(moved);
        let sibling = self.sibling(moved);
        let (mut best, mut place) = (0.0, None);
        // What taking it out saves below the pivot, and the box of what is then left in that.
        let (mut saved, mut rest) = (self.area(parent), self.node(sibling).bounds);
        let (mut pivot, mut side) = (parent, sibling);
        loop {
            self.pending.push((saved, side));
            while let Some((saved, target)) = self.pending.pop() {
                // No place below gains more.
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

    /// Puts the sibling in the parent's place.
    fn remove(&mut self, moved: u32) {
        let (parent, sibling) = (self.node(moved).parent, self.sibling(moved));
        self.replace(parent, sibling);
        self.refit(self.node(sibling).parent);
    }

    /// Puts a node above `place` and `moved`.
    fn insert(&mut self, moved: u32, above: u32, place: u32) {
        self.replace(place, above);
        self.nodes[above as usize].children = Some([place, moved]);
        for child in [place, moved] {
            self.nodes[child as usize].parent = above;
        }
        self.refit(above);
    }

    /// Makes the parent of `old` that of `new`.
    fn replace(&mut self, old: u32, new: u32) {
        let parent = self.node(old).parent;
        if let Some(Node { children: Some(children), .. }) = self.nodes.get_mut(parent as usize) {
            *children = children.map(|child| if child == old { new } else { child });
        }
        self.nodes[new as usize].parent = parent;
    }

    /// Fits the boxes of a node and of all above it to their children.
    fn refit(&mut self, mut number: u32) {
        while let Some([a, b]) = self.nodes.get(number as usize).and_then(|_| self.children(number)) {
            let bounds = self.node(a).bounds.union(self.node(b).bounds);
            let area = self.unit.area(&bounds);
            let node = &mut self.nodes[number as usize];
            (node.bounds, node.area) = (bounds, area);
            number = node.parent;
        }
    }

    /// The best way to collapse the tree, unless it has become too deep. What was not opened is linked to.
    fn collapse(&self, forest: &mut SubtreeSet, order: &[Run], config: &BuildConfig) -> Option<SubtreeRef> {
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
            let Node { bounds, place, .. } = self.node(number);
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
        Some(SubtreeRef { place: Place { tree: tree as u32, node }, costs })
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3A;

    use super::*;

    #[test]
    fn a_leaf_far_from_its_sibling_moves_to_its_neighbour() {
        // From (((0, 100), 1), 101) to ((0, 1), (100, 101)).
        let order = [0, 1, 2, 3].map(|first| Run { first, count: 1 });
        let unit = NormalizedArea::new(&NodeBox { min: Vec3A::ZERO, max: Vec3A::splat(102.0) });
        let config = BuildConfig {
            unit,
            axes: crate::wide::build::binning::Axes::All,
            leaf_policy: crate::wide::build::leaf_policy::LeafPolicy::STRICT,
            pairs: true,
            max_leaf: 1,
        };
        let mut tree = BinaryTree::default();
        let leaves = [0.0, 100.0, 1.0, 101.0].into_iter().zip(0..).map(|(x, first)| {
            let bounds = NodeBox { min: Vec3A::X * x, max: Vec3A::new(x + 1.0, 1.0, 1.0) };
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
        let whole = SubtreeRef { place: Place { tree: 0, node }, costs };
        let mut forest = SubtreeSet { trees: vec![tree], links: Vec::new(), whole };
        let mut linked = ParentLinkedBvh::new(&forest, unit, usize::MAX);
        while (1..7).any(|number| linked.reinsert_node(number)) {}
        let inner = linked.nodes.iter().filter(|node| node.children.is_some());
        let mut lengths: Vec<_> = inner.map(|node| node.bounds.max.x - node.bounds.min.x).collect();
        lengths.sort_unstable_by(f32::total_cmp);
        assert_eq!(lengths, [2.0, 2.0, 102.0]);
        assert!(
            linked.collapse(&mut forest, &order, &config).is_some_and(|better| better.costs.whole() <= costs.whole())
        );
    }
}
