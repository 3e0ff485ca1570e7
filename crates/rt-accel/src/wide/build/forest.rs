//! Grows a tree over many references, on one thread or on several, with the same result.

use super::binary::{BinaryTree, Content};
use super::binning::Bins;
use super::collapse::{Costs, Plan};
use super::grow::{Rules, Set};
use super::reference::Run;
use crate::bvh::NodeBox;

/// Sets of at most this size are one task: their references and nodes stay in the cache of one core.
const TASK: usize = 4096;

/// Trees that are linked to each other.
#[derive(Debug)]
pub(super) struct Forest {
    pub(super) trees: Vec<BinaryTree>,
    pub(super) links: Vec<Link>,
    /// Where to start.
    pub(super) whole: Link,
}

/// A node, and the costs of what is below.
#[derive(Clone, Copy, Debug)]
pub(super) struct Link {
    pub(super) place: Place,
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
        let mut forest = Self { trees: vec![BinaryTree::default()], links: Vec::new(), whole: Link::NONE };
        let (node, costs) = forest.gather(upper(set, rules), rules);
        forest.whole = Link { place: Place { tree: 0, node }, costs };
        forest
    }

    /// Where to start.
    pub(super) fn root(&self) -> Place {
        self.follow(self.whole.place)
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

    /// The node of the other tree, if that is what a node stands for.
    pub(super) fn follow(&self, place: Place) -> Place {
        match self.content(place) {
            Content::Link(link) => self.follow(self.links[link as usize].place),
            Content::Inner(_) | Content::Leaf { .. } => place,
        }
    }

    /// The costs of what is below a node. The recursion is as deep as the tree, which is bounded.
    pub(super) fn costs(&self, place: Place, order: &[Run], rules: &Rules) -> Costs {
        let area = rules.unit.area(&self.bounds(place));
        match self.content(place) {
            Content::Inner(children) => {
                if let Some(kept) = self.trees[place.tree as usize].kept(place.node) {
                    return kept;
                }
                let [left, right] = children.map(|node| self.costs(Place { node, ..place }, order, rules));
                Costs::above(area, [&left, &right], rules.max_leaf).0
            }
            Content::Leaf { first, count } => {
                let runs = &order[first as usize..][..count as usize];
                Costs::leaf(area, runs.iter().map(|run| run.count).sum())
            }
            Content::Link(link) => self.links[link as usize].costs,
        }
    }

    /// Adds a link, and a leaf of the tree that leads there.
    pub(super) fn link(&mut self, bounds: &NodeBox, link: Link, tree: usize) -> u32 {
        self.links.push(link);
        let content = Content::Link(self.links.len() as u32 - 1);
        self.trees[tree].push(bounds, content, Plan::LEAF)
    }

    /// Adds the lower trees to the list, and the upper part to its first.
    fn gather(&mut self, upper: Upper, rules: &Rules) -> (u32, Costs) {
        match upper {
            Upper::Task(bounds, lower, costs) => {
                let place = Place { tree: self.trees.len() as u32, node: lower.root() };
                self.trees.push(lower);
                (self.link(&bounds, Link { place, costs }, 0), costs)
            }
            Upper::Inner(bounds, children) => {
                let [left, right] = *children;
                let (left, left_costs) = self.gather(left, rules);
                let (right, right_costs) = self.gather(right, rules);
                self.trees[0].join(&bounds, [left, right], [&left_costs, &right_costs], rules)
            }
        }
    }
}

impl Link {
    const NONE: Self = Self { place: Place { tree: 0, node: 0 }, costs: Costs::NONE };
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
