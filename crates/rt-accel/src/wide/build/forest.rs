//! Grows a tree over many references, on one thread or on several, with the same result.

use super::binary::{BinaryTree, Content};
use super::binning::Bins;
use super::collapse::{Costs, Plan};
use super::grow::{Rules, Set};
use crate::bvh::NodeBox;

/// Sets of at most this size are one task: their references and nodes stay in the cache of one core.
const TASK: usize = 4096;

/// Trees that are linked to each other.
#[derive(Debug)]
pub(super) struct Forest {
    /// The first is the one to start from.
    pub(super) trees: Vec<BinaryTree>,
    /// Costs of the whole.
    pub(super) costs: Costs,
}

/// A node of one of the trees.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) tree: u32,
    pub(super) node: u32,
}

/// The upper part of a tree.
enum Upper {
    Inner(NodeBox, Box<[Upper; 2]>),
    Task(NodeBox, BinaryTree, Costs),
}

impl Forest {
    /// Grows the trees over a set that is not empty.
    pub(super) fn grow(set: Set<'_>, rules: &Rules) -> Self {
        let mut trees = vec![BinaryTree::default()];
        let (_, costs) = gather(upper(set, rules), &mut trees, rules);
        Self { trees, costs }
    }

    /// Where to start.
    pub(super) fn root(&self) -> Place {
        self.follow(Place { tree: 0, node: self.trees[0].root() })
    }

    pub(super) fn content(&self, place: Place) -> Content {
        self.trees[place.tree as usize].nodes[place.node as usize].content()
    }

    pub(super) fn bounds(&self, place: Place) -> NodeBox {
        self.trees[place.tree as usize].nodes[place.node as usize].bounds()
    }

    pub(super) fn plan(&self, place: Place) -> Plan {
        self.trees[place.tree as usize].plans[place.node as usize]
    }

    /// The root of the other tree, if that is what a node stands for.
    pub(super) fn follow(&self, place: Place) -> Place {
        match self.content(place) {
            Content::Link(tree) => Place { tree, node: self.trees[tree as usize].root() },
            Content::Inner(_) | Content::Leaf { .. } => place,
        }
    }
}

/// Adds the lower trees to the list, and the upper part to its first.
fn gather(upper: Upper, trees: &mut Vec<BinaryTree>, rules: &Rules) -> (u32, Costs) {
    match upper {
        Upper::Task(bounds, tree, costs) => {
            let link = Content::Link(trees.len() as u32);
            trees.push(tree);
            (trees[0].push(&bounds, link, Plan::LEAF), costs)
        }
        Upper::Inner(bounds, children) => {
            let [left, right] = *children;
            let (left, left_costs) = gather(left, trees, rules);
            let (right, right_costs) = gather(right, trees, rules);
            trees[0].join(&bounds, [left, right], [&left_costs, &right_costs], rules)
        }
    }
}

/// The recursion is as deep as the tree, which is bounded.
fn upper(set: Set<'_>, rules: &Rules) -> Upper {
    let bounds = set.extent.bounds;
    if set.references.len() <= TASK {
        let mut tree = BinaryTree::default();
        let (_, costs) = tree.grow(set, rules, &mut Bins::new());
        return Upper::Task(bounds, tree, costs);
    }
    let [left, right] = split(set, rules);
    let (left, right) = join(|| upper(left, rules), || upper(right, rules));
    Upper::Inner(bounds, Box::new([left, right]))
}

fn split<'a>(set: Set<'a>, rules: &Rules) -> [Set<'a>; 2] {
    #[cfg(feature = "parallel")]
    if set.references.len() >= super::chunks::LARGE {
        return super::chunks::split(set, rules);
    }
    set.split(rules, &mut Bins::new())
}

#[cfg(feature = "parallel")]
use rayon::join;

#[cfg(not(feature = "parallel"))]
fn join<A, B>(a: impl FnOnce() -> A, b: impl FnOnce() -> B) -> (A, B) {
    (a(), b())
}
