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

use super::binary::{BinaryTree, Content};
use super::binning::AreaUnit;
use super::collapse::{Costs, Plan};
use super::forest::{Forest, Place};
use super::grow::Rules;
use super::reference::Run;
use crate::bounded_depth::MAX_DEPTH;
use crate::bvh::NodeBox;

/// Times that the tree is gone through.
const PASSES: usize = 3;

/// The part of all nodes that is moved each time.
const MOVED: f64 = 0.15;

const NONE: u32 = u32::MAX;

struct Node {
    bounds: NodeBox,
    area: f32,
    parent: u32,
    /// Never a link.
    content: Content,
}

/// A tree that knows its parents; the root is the first.
struct Linked {
    nodes: Vec<Node>,
    unit: AreaUnit,
    /// Nodes yet to be searched, and what is gained at them at most; empty between searches.
    pending: Vec<(f32, u32)>,
}

impl Forest {
    /// The improved tree, or this one if it could not be made better.
    pub(super) fn reinserted(self, order: &[Run], rules: &Rules) -> Self {
        let mut linked = Linked::new(&self, rules.unit);
        for _ in 0..PASSES {
            if !linked.pass() {
                break;
            }
        }
        match linked.collapse(order, rules) {
            Some(better) if better.costs.whole() < self.costs.whole() => better,
            _ => self,
        }
    }
}

impl Linked {
    fn new(forest: &Forest, unit: AreaUnit) -> Self {
        let mut nodes = Vec::with_capacity(forest.trees.iter().map(|tree| tree.nodes.len()).sum());
        let mut pending = vec![(forest.root(), NONE, 0)];
        while let Some((place, parent, side)) = pending.pop() {
            let (bounds, number) = (forest.bounds(place), nodes.len() as u32);
            let content = forest.content(place);
            if let Some(Node { content: Content::Inner(children), .. }) = nodes.get_mut(parent as usize) {
                children[side] = number;
            }
            nodes.push(Node { bounds, area: unit.area(&bounds), parent, content });
            if let Content::Inner(children) = content {
                for side in [1, 0] {
                    pending.push((forest.follow(Place { node: children[side], ..place }), number, side));
                }
            }
        }
        Self { nodes, unit, pending: Vec::new() }
    }

    /// Moves the largest nodes, and says whether any was moved.
    fn pass(&mut self) -> bool {
        let mut largest: Vec<_> = (1..self.nodes.len() as u32).map(|number| (self.area(number), number)).collect();
        let count = (self.nodes.len() as f64 * MOVED).ceil() as usize;
        let order = |a: &(f32, u32), b: &(f32, u32)| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1));
        if count < largest.len() {
            largest.select_nth_unstable_by(count, order);
            largest.truncate(count);
        }
        largest.sort_unstable_by(order);
        largest.iter().fold(false, |any, &(_, number)| self.improve(number) || any)
    }

    fn node(&self, number: u32) -> &Node {
        &self.nodes[number as usize]
    }

    fn area(&self, number: u32) -> f32 {
        self.node(number).area
    }

    fn children(&self, number: u32) -> Option<[u32; 2]> {
        match self.node(number).content {
            Content::Inner(children) => Some(children),
            Content::Leaf { .. } | Content::Link(_) => None,
        }
    }

    /// The other child of the parent; not for the root.
    fn sibling(&self, number: u32) -> u32 {
        self.children(self.node(number).parent).map_or(0, |[a, b]| if a == number { b } else { a })
    }

    /// Puts a node where it is best, if that is elsewhere.
    fn improve(&mut self, moved: u32) -> bool {
        let parent = self.node(moved).parent;
        // A child of the root stays: there is no node above to take its sibling.
        if parent == NONE || self.node(parent).parent == NONE {
            return false;
        }
        let best = self.best_place(moved);
        if let Some(place) = best {
            self.take_out(moved);
            self.put_in(moved, parent, place);
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
    fn take_out(&mut self, moved: u32) {
        let (parent, sibling) = (self.node(moved).parent, self.sibling(moved));
        self.replace(parent, sibling);
        self.refit(self.node(sibling).parent);
    }

    /// Puts a node above `place` and `moved`.
    fn put_in(&mut self, moved: u32, above: u32, place: u32) {
        self.replace(place, above);
        self.nodes[above as usize].content = Content::Inner([place, moved]);
        for child in [place, moved] {
            self.nodes[child as usize].parent = above;
        }
        self.refit(above);
    }

    /// Makes the parent of `old` that of `new`.
    fn replace(&mut self, old: u32, new: u32) {
        let parent = self.node(old).parent;
        if let Some(Node { content: Content::Inner(children), .. }) = self.nodes.get_mut(parent as usize) {
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

    /// The best way to collapse the tree, unless it has become too deep.
    fn collapse(&self, order: &[Run], rules: &Rules) -> Option<Forest> {
        let mut from_root = Vec::with_capacity(self.nodes.len());
        let mut pending = vec![(0, 0)];
        while let Some((number, depth)) = pending.pop() {
            if depth > MAX_DEPTH {
                return None;
            }
            from_root.push(number);
            pending.extend(self.children(number).into_iter().flatten().map(|child| (child, depth + 1)));
        }
        let mut tree = BinaryTree::default();
        let mut made = vec![(0, Costs::leaf(0.0, 0)); self.nodes.len()];
        for &number in from_root.iter().rev() {
            let node = self.node(number);
            made[number as usize] = match node.content {
                Content::Inner(children) => {
                    let [(a, a_costs), (b, b_costs)] = children.map(|child| made[child as usize]);
                    tree.join(&node.bounds, [a, b], [&a_costs, &b_costs], rules)
                }
                Content::Leaf { first, count } => {
                    let runs = &order[first as usize..][..count as usize];
                    let costs = Costs::leaf(node.area, runs.iter().map(|run| run.count).sum());
                    (tree.push(&node.bounds, node.content, Plan::LEAF), costs)
                }
                Content::Link(_) => return None,
            };
        }
        Some(Forest { trees: vec![tree], costs: made[0].1 })
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
        let unit = AreaUnit::new(&NodeBox { min: Vec3A::ZERO, max: Vec3A::splat(102.0) });
        let rules = Rules {
            unit,
            axes: crate::wide::build::binning::Axes::All,
            haste: crate::wide::build::cluster::Haste::LITTLE,
            max_leaf: 1,
        };
        let mut tree = BinaryTree::default();
        let leaves = [0.0, 100.0, 1.0, 101.0].into_iter().zip(0..).map(|(x, first)| {
            let bounds = NodeBox { min: Vec3A::X * x, max: Vec3A::new(x + 1.0, 1.0, 1.0) };
            let number = tree.push(&bounds, Content::Leaf { first, count: 1 }, Plan::LEAF);
            (number, bounds, Costs::leaf(unit.area(&bounds), 1))
        });
        let leaves: Vec<_> = leaves.collect();
        let whole = leaves.into_iter().reduce(|(a, a_box, a_costs), (b, b_box, b_costs)| {
            let bounds = a_box.union(b_box);
            let (number, costs) = tree.join(&bounds, [a, b], [&a_costs, &b_costs], &rules);
            (number, bounds, costs)
        });
        let (_, _, costs) = whole.expect("four leaves");
        let mut linked = Linked::new(&Forest { trees: vec![tree], costs }, unit);
        while (1..7).any(|number| linked.improve(number)) {}
        let inner = linked.nodes.iter().filter(|node| matches!(node.content, Content::Inner(_)));
        let mut lengths: Vec<_> = inner.map(|node| node.bounds.max.x - node.bounds.min.x).collect();
        lengths.sort_unstable_by(f32::total_cmp);
        assert_eq!(lengths, [2.0, 2.0, 102.0]);
        assert!(linked.collapse(&order, &rules).is_some_and(|better| better.costs.whole() <= costs.whole()));
    }
}
