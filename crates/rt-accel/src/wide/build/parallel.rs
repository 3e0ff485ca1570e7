//! Parallel top-down build, with the result of one thread.

use super::binary::{BinaryTree, Content};
use super::binning::Bins;
use super::collapse::{CollapsePlan, Costs};
use super::config::BuildConfig;
use super::prim_ref::PrimRange;
use super::top_down::BuildRange;
use crate::bvh::Aabb32;
use crate::parallel_for::parallel_for_each;

/// Ranges of at most this size are one task, whose references and nodes fit the cache of one core.
const TASK: usize = 4096;

/// Trees that are linked to each other.
#[derive(Debug)]
pub(super) struct SubtreeSet {
    pub(super) trees: Vec<BinaryTree>,
    pub(super) links: Vec<SubtreeRef>,
    /// Root of the joined tree.
    pub(super) top: SubtreeRef,
}

/// Root of a subtree, and its costs.
#[derive(Clone, Copy, Debug)]
pub(super) struct SubtreeRef {
    pub(super) place: NodeId,
    pub(super) costs: Costs,
}

/// A node of one of the trees.
#[derive(Clone, Copy, Debug)]
pub(super) struct NodeId {
    pub(super) tree: u32,
    pub(super) node: u32,
}

/// Upper part of the tree.
enum TopNode {
    Inner(Aabb32, Box<[TopNode; 2]>),
    Task(Aabb32, BinaryTree, Costs),
}

impl TopNode {
    fn empty() -> Self {
        Self::Task(Aabb32::EMPTY, BinaryTree::default(), Costs::NONE)
    }
}

impl SubtreeSet {
    /// Builds the trees over a range that is not empty.
    pub(super) fn grow(set: BuildRange<'_>, config: &BuildConfig) -> Self {
        let mut forest = Self { trees: vec![BinaryTree::default()], links: Vec::new(), top: SubtreeRef::NONE };
        let (node, costs) = forest.gather(build_top(set, config), config);
        forest.top = SubtreeRef { place: NodeId { tree: 0, node }, costs };
        forest
    }

    pub(super) fn root(&self) -> NodeId {
        self.follow(self.top.place)
    }

    pub(super) fn content(&self, place: NodeId) -> Content {
        self.trees[place.tree as usize].nodes[place.node as usize].content()
    }

    pub(super) fn bounds(&self, place: NodeId) -> Aabb32 {
        self.trees[place.tree as usize].nodes[place.node as usize].bounds()
    }

    pub(super) fn plan(&self, place: NodeId) -> CollapsePlan {
        self.trees[place.tree as usize].plans[place.node as usize]
    }

    /// Follows links to the node of another tree.
    pub(super) fn follow(&self, place: NodeId) -> NodeId {
        match self.content(place) {
            Content::Link(link) => self.follow(self.links[link as usize].place),
            Content::Inner(_) | Content::Leaf { .. } => place,
        }
    }

    /// Costs of a node. The recursion is as deep as the tree, which is bounded.
    pub(super) fn costs(&self, place: NodeId, order: &[PrimRange], config: &BuildConfig) -> Costs {
        let area = config.unit.area(&self.bounds(place));
        match self.content(place) {
            Content::Inner(children) => {
                if let Some(kept) = self.trees[place.tree as usize].kept(place.node) {
                    return kept;
                }
                let [left, right] = children.map(|node| self.costs(NodeId { node, ..place }, order, config));
                Costs::above(area, [&left, &right], config.max_leaf).0
            }
            Content::Leaf { first, count } => {
                let runs = &order[first as usize..][..count as usize];
                Costs::leaf(area, runs.iter().map(|run| run.count).sum())
            }
            Content::Link(link) => self.links[link as usize].costs,
        }
    }

    /// Adds a link, and a leaf of the tree that refers to it.
    pub(super) fn link(&mut self, bounds: &Aabb32, link: SubtreeRef, tree: usize) -> u32 {
        self.links.push(link);
        let content = Content::Link(self.links.len() as u32 - 1);
        self.trees[tree].push(bounds, content, CollapsePlan::LEAF)
    }

    /// Appends the lower trees, and adds the upper part to the first.
    fn gather(&mut self, build_top: TopNode, config: &BuildConfig) -> (u32, Costs) {
        match build_top {
            TopNode::Task(bounds, lower, costs) => {
                let place = NodeId { tree: self.trees.len() as u32, node: lower.root() };
                self.trees.push(lower);
                (self.link(&bounds, SubtreeRef { place, costs }, 0), costs)
            }
            TopNode::Inner(bounds, children) => {
                let [left, right] = *children;
                let (left, left_costs) = self.gather(left, config);
                let (right, right_costs) = self.gather(right, config);
                self.trees[0].join(&bounds, [left, right], [&left_costs, &right_costs], config)
            }
        }
    }
}

impl SubtreeRef {
    const NONE: Self = Self { place: NodeId { tree: 0, node: 0 }, costs: Costs::NONE };
}

/// The recursion is as deep as the tree, which is bounded.
fn build_top(set: BuildRange<'_>, config: &BuildConfig) -> TopNode {
    let bounds = set.extent.bounds;
    if set.references.len() <= TASK {
        let mut tree = BinaryTree::default();
        let (_, costs) = tree.grow(set, config, &mut Bins::new());
        return TopNode::Task(bounds, tree, costs);
    }
    let mut children = Box::new([TopNode::empty(), TopNode::empty()]);
    let tasks = split(set, config).into_iter().zip(&mut *children).collect();
    parallel_for_each(tasks, |(side, child)| *child = build_top(side, config));
    TopNode::Inner(bounds, children)
}

fn split<'a>(set: BuildRange<'a>, config: &BuildConfig) -> [BuildRange<'a>; 2] {
    #[cfg(feature = "parallel")]
    if set.references.len() >= super::parallel_partition::LARGE {
        return super::parallel_partition::split(set, config);
    }
    set.split(config, &mut Bins::new())
}
