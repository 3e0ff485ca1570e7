//! Grows a tree over many references, on one thread or on several, with the same result.

use super::binary::{BinaryTree, Content};
use super::binning::Bins;
use super::collapse::{CollapsePlan, Costs};
use super::reference::Run;
use super::top_down::{BuildConfig, Set};
use crate::bvh::NodeBox;

/// Sets of at most this size are one task: their references and nodes stay in the cache of one core.
const TASK: usize = 4096;

/// Trees that are linked to each other.
#[derive(Debug)]
pub(super) struct SubtreeSet {
    pub(super) trees: Vec<BinaryTree>,
    pub(super) links: Vec<SubtreeRef>,
    /// Where to start.
    pub(super) whole: SubtreeRef,
}

/// A node, and the costs of what is below.
#[derive(Clone, Copy, Debug)]
pub(super) struct SubtreeRef {
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

impl SubtreeSet {
    /// Grows the trees over a set that is not empty.
    pub(super) fn grow(set: Set<'_>, config: &BuildConfig) -> Self {
        let mut forest = Self { trees: vec![BinaryTree::default()], links: Vec::new(), whole: SubtreeRef::NONE };
        let (node, costs) = forest.gather(upper(set, config), config);
        forest.whole = SubtreeRef { place: Place { tree: 0, node }, costs };
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

    pub(super) fn plan(&self, place: Place) -> CollapsePlan {
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
    pub(super) fn costs(&self, place: Place, order: &[Run], config: &BuildConfig) -> Costs {
        let area = config.unit.area(&self.bounds(place));
        match self.content(place) {
            Content::Inner(children) => {
                if let Some(kept) = self.trees[place.tree as usize].kept(place.node) {
                    return kept;
                }
                let [left, right] = children.map(|node| self.costs(Place { node, ..place }, order, config));
                Costs::above(area, [&left, &right], config.max_leaf).0
            }
            Content::Leaf { first, count } => {
                let runs = &order[first as usize..][..count as usize];
                Costs::leaf(area, runs.iter().map(|run| run.count).sum())
            }
            Content::Link(link) => self.links[link as usize].costs,
        }
    }

    /// Adds a link, and a leaf of the tree that leads there.
    pub(super) fn link(&mut self, bounds: &NodeBox, link: SubtreeRef, tree: usize) -> u32 {
        self.links.push(link);
        let content = Content::Link(self.links.len() as u32 - 1);
        self.trees[tree].push(bounds, content, CollapsePlan::LEAF)
    }

    /// Adds the lower trees to the list, and the upper part to its first.
    fn gather(&mut self, upper: Upper, config: &BuildConfig) -> (u32, Costs) {
        match upper {
            Upper::Task(bounds, lower, costs) => {
                let place = Place { tree: self.trees.len() as u32, node: lower.root() };
                self.trees.push(lower);
                (self.link(&bounds, SubtreeRef { place, costs }, 0), costs)
            }
            Upper::Inner(bounds, children) => {
                let [left, right] = *children;
                let (left, left_costs) = self.gather(left, config);
                let (right, right_costs) = self.gather(right, config);
                self.trees[0].join(&bounds, [left, right], [&left_costs, &right_costs], config)
            }
        }
    }
}

impl SubtreeRef {
    const NONE: Self = Self { place: Place { tree: 0, node: 0 }, costs: Costs::NONE };
}

/// The recursion is as deep as the tree, which is bounded.
fn upper(set: Set<'_>, config: &BuildConfig) -> Upper {
    let bounds = set.extent.bounds;
    if set.references.len() <= TASK {
        let mut tree = BinaryTree::default();
        let (_, costs) = tree.grow(set, config, &mut Bins::new());
        return Upper::Task(bounds, tree, costs);
    }
    let [left, right] = split(set, config);
    let (left, right) = join(|| upper(left, config), || upper(right, config));
    Upper::Inner(bounds, Box::new([left, right]))
}

fn split<'a>(set: Set<'a>, config: &BuildConfig) -> [Set<'a>; 2] {
    #[cfg(feature = "parallel")]
    if set.references.len() >= super::parallel_partition::LARGE {
        return super::parallel_partition::split(set, config);
    }
    set.split(config, &mut Bins::new())
}

#[cfg(feature = "parallel")]
use rayon::join;

#[cfg(not(feature = "parallel"))]
fn join<A, B>(a: impl FnOnce() -> A, b: impl FnOnce() -> B) -> (A, B) {
    (a(), b())
}
