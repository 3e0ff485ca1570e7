//! Bounds that are kept up to date: each node knows the box around all below it.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use rt_math::{Aabb, AnimatedTransform, Transform};

use crate::{Content, GroupId, MeshId, Node, Scene};

/// Where things are, as far as that can be said.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// The box around all that is bounded; empty without any.
    pub bounds: Aabb,
    /// Whether there is anything beside it that has no bounds.
    pub unbounded: bool,
}

impl Extent {
    /// The extent of nothing.
    pub const NOTHING: Self = Self { bounds: Aabb::EMPTY, unbounded: false };

    fn of_box(bounds: Option<Aabb>) -> Self {
        bounds.map_or(Self { unbounded: true, ..Self::NOTHING }, |bounds| Self { bounds, unbounded: false })
    }

    fn union(self, other: Self) -> Self {
        Self { bounds: self.bounds.union(other.bounds), unbounded: self.unbounded || other.unbounded }
    }

    /// The same things seen from the target space of a transform. The identity changes no bit.
    fn mapped(self, target_from_source: &Transform) -> Self {
        if target_from_source.is_identity() {
            return self;
        }
        Self { bounds: target_from_source.aabb(&self.bounds), ..self }
    }

    /// The same things at all moments of a motion.
    fn swept(self, motion: &AnimatedTransform) -> Self {
        Self { bounds: motion.aabb(&self.bounds), ..self }
    }
}

/// The extents of a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeBounds {
    /// What stands at the node itself, in the node's own space; all of a group for an instance.
    pub own: Extent,
    /// The node with all below it at all moments, in the space of its parent.
    pub subtree: Extent,
}

/// One of the trees of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tree {
    /// [`Scene::nodes`].
    World,
    /// [`Group::nodes`](crate::Group::nodes) of this group.
    Group(GroupId),
}

/// The bounding volume hierarchy that a scene's tree is: the extent of every node in the space of its parent.
///
/// ```text
///   subtree(node) = parent_from_local · (own(node) ∪ subtree(child 1) ∪ subtree(child 2) ∪ …)
/// ```
///
/// As no extent depends on what is above, a change concerns a node and its ancestors alone:
/// [`update`](Self::update) measures these and nothing else. A group is measured once, however often it is placed;
/// when its extent changes, so do its instances and their ancestors.
///
/// Boxes around turned boxes grow with each turn on the way up, so that [`world`](Self::world) may be larger than
/// [`Scene::bounds`], which multiplies transforms first and has to visit everything for it.
///
/// Nodes are named by a [`Tree`] and the indices of the children on the way down from its list of nodes. Instances of
/// a group that does not come before the group that they are in have no extent, nor have those of missing groups.
///
/// ```
/// use rt_math::{DVec3, Transform};
/// use rt_scene_io::{Content, MaterialId, Node, Scene, SceneBounds, Tree};
/// # use rt_geometry::{Shape, Sphere};
/// # let ball = || Node::new(Content::Shape(Shape::Sphere(Sphere::new(DVec3::ZERO, 1.0).unwrap())), MaterialId(0));
/// let mut scene = Scene::empty("two balls");
/// scene.nodes = vec![ball(), ball()];
/// let mut bounds = SceneBounds::new(&scene);
///
/// scene.nodes[1].parent_from_local = Transform::translate(DVec3::X * 5.0);
/// assert_eq!(bounds.update(&scene, Tree::World, &[1]), Some(1));
/// assert!((bounds.world().bounds.max.x - 6.0).abs() < 1e-12);
/// ```
#[derive(Clone, Debug)]
pub struct SceneBounds {
    /// All nodes of all trees. The first ones stand for the trees themselves: groups in order, then the world.
    entries: Vec<Entry>,
    /// Entries that no node uses any more.
    free: Vec<usize>,
    /// For each group, the entries of its instances.
    instances: Vec<Vec<usize>>,
}

#[derive(Clone, Debug)]
struct Entry {
    /// Index of the entry that stands for the tree.
    tree: usize,
    depth: usize,
    parent: Option<usize>,
    children: Vec<usize>,
    parent_from_local: Transform,
    motion: Option<AnimatedTransform>,
    content: Measured,
    bounds: NodeBounds,
}

/// What is known of a node's content.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Measured {
    Extent(Extent),
    /// All of the group with this index.
    Group(usize),
}

impl SceneBounds {
    /// Measures everything once.
    pub fn new(scene: &Scene) -> Self {
        let trees = scene.groups.len() + 1;
        let mut all = Self { entries: Vec::new(), free: Vec::new(), instances: vec![Vec::new(); scene.groups.len()] };
        all.entries.extend((0..trees).map(Entry::of_tree));
        for (tree, nodes) in scene.groups.iter().map(|group| &group.nodes).chain([&scene.nodes]).enumerate() {
            all.add(scene, nodes, tree);
            all.measure(tree);
        }
        all
    }

    /// Everything, in world space.
    pub fn world(&self) -> Extent {
        self.entries[self.instances.len()].bounds.subtree
    }

    /// All of a group, in its own space. `None` if there is no such group.
    pub fn group(&self, group: GroupId) -> Option<Extent> {
        Some(self.entries[self.root(Tree::Group(group))?].bounds.subtree)
    }

    /// The node at the end of the path; for an empty path the tree as a whole. `None` if the path leads nowhere.
    pub fn of(&self, tree: Tree, path: &[usize]) -> Option<NodeBounds> {
        Some(self.entries[self.entry(tree, path)?].bounds)
    }

    /// Takes note of a changed node: its transform, its content, or the number of its children.
    ///
    /// Measures the node and those of its ancestors, and of its group's instances and their ancestors, whose extent
    /// changes with it; returns how many nodes that were. If the number of children has changed, all below the node is
    /// measured as well; for children that were exchanged one for one, see [`update_below`](Self::update_below).
    ///
    /// `None` if the path leads nowhere, here or in the scene. Other numbers of groups or meshes, or other meshes,
    /// need a [`new`](Self::new) start.
    pub fn update(&mut self, scene: &Scene, tree: Tree, path: &[usize]) -> Option<usize> {
        let entry = self.entry(tree, path)?;
        let known = self.entries[entry].children.len();
        match node_at(scene, tree, path)? {
            Found::Tree(nodes) if nodes.len() == known => Some(self.propagate(entry)),
            Found::Node(node) if node.children.len() == known => {
                self.describe(scene, node, entry);
                Some(self.propagate(entry))
            }
            _ => self.update_below(scene, tree, path),
        }
    }

    /// As [`update`](Self::update), for a node of which anything below may have changed, too: all of that is measured.
    /// An empty path stands for all nodes of the tree.
    pub fn update_below(&mut self, scene: &Scene, tree: Tree, path: &[usize]) -> Option<usize> {
        let entry = self.entry(tree, path)?;
        let found = node_at(scene, tree, path)?;
        self.remove_below(entry);
        let children = match found {
            Found::Tree(nodes) => nodes,
            Found::Node(node) => {
                self.describe(scene, node, entry);
                &node.children
            }
        };
        let below = self.add(scene, children, entry);
        Some(below + self.propagate(entry))
    }

    fn root(&self, tree: Tree) -> Option<usize> {
        let groups = self.instances.len();
        match tree {
            Tree::World => Some(groups),
            Tree::Group(GroupId(id)) => Some(id as usize).filter(|&id| id < groups),
        }
    }

    fn entry(&self, tree: Tree, path: &[usize]) -> Option<usize> {
        let root = self.root(tree)?;
        path.iter().try_fold(root, |entry, &child| self.entries[entry].children.get(child).copied())
    }

    /// Adds nodes below an entry, and all below them, and measures them; returns how many that were. Trees may be
    /// deep, so the walk keeps its own stack.
    fn add(&mut self, scene: &Scene, nodes: &[Node], parent: usize) -> usize {
        let mut added = Vec::new();
        let mut open: Vec<(&Node, usize)> = nodes.iter().rev().map(|node| (node, parent)).collect();
        while let Some((node, parent)) = open.pop() {
            let (tree, depth) = (self.entries[parent].tree, self.entries[parent].depth + 1);
            let fresh = Entry { depth, parent: Some(parent), ..Entry::of_tree(tree) };
            let entry = match self.free.pop() {
                Some(entry) => {
                    self.entries[entry] = fresh;
                    entry
                }
                None => {
                    self.entries.push(fresh);
                    self.entries.len() - 1
                }
            };
            self.entries[parent].children.push(entry);
            self.describe(scene, node, entry);
            added.push(entry);
            open.extend(node.children.iter().rev().map(|child| (child, entry)));
        }
        for &entry in added.iter().rev() {
            self.measure(entry);
        }
        added.len()
    }

    fn remove_below(&mut self, entry: usize) {
        let mut open = std::mem::take(&mut self.entries[entry].children);
        while let Some(entry) = open.pop() {
            self.set_content(entry, Measured::Extent(Extent::NOTHING));
            open.append(&mut self.entries[entry].children);
            self.free.push(entry);
        }
    }

    /// Takes over a node's transform and content.
    fn describe(&mut self, scene: &Scene, node: &Node, entry: usize) {
        let content = match &node.content {
            None => Measured::Extent(Extent::NOTHING),
            Some(Content::Shape(shape)) => Measured::Extent(Extent::of_box(shape.bounds())),
            Some(Content::Mesh(MeshId(id))) => Measured::Extent(
                scene.meshes.get(*id as usize).map_or(Extent::NOTHING, |mesh| Extent::of_box(Some(mesh.mesh.bounds()))),
            ),
            // The entries of trees are in the order of the groups: only groups before this one have been measured.
            Some(Content::Instance(GroupId(id))) if (*id as usize) < self.entries[entry].tree => {
                Measured::Group(*id as usize)
            }
            Some(Content::Instance(_)) => Measured::Extent(Extent::NOTHING),
        };
        self.set_content(entry, content);
        self.entries[entry].parent_from_local = node.parent_from_local;
        // What cannot move as it should stays where it is.
        self.entries[entry].motion = node.motion().unwrap_or_default();
    }

    fn set_content(&mut self, entry: usize, content: Measured) {
        let before = std::mem::replace(&mut self.entries[entry].content, content);
        if before == content {
            return;
        }
        if let Measured::Group(group) = before {
            self.instances[group].retain(|&instance| instance != entry);
        }
        if let Measured::Group(group) = content {
            self.instances[group].push(entry);
        }
    }

    /// Computes the extents of an entry from those below it; true if the extent of the subtree is another now.
    fn measure(&mut self, entry: usize) -> bool {
        let Entry { children, parent_from_local, motion, content, bounds: before, .. } = &self.entries[entry];
        let own = match content {
            Measured::Extent(extent) => *extent,
            Measured::Group(group) => self.entries[*group].bounds.subtree,
        };
        let all = children.iter().fold(own, |sum, &child| sum.union(self.entries[child].bounds.subtree));
        let subtree = motion.as_ref().map_or_else(|| all.mapped(parent_from_local), |motion| all.swept(motion));
        let bounds = NodeBounds { own, subtree };
        let changed = bounds.subtree != before.subtree;
        self.entries[entry].bounds = bounds;
        changed
    }

    /// Measures an entry and whatever depends on it and changes; returns how many nodes that were.
    fn propagate(&mut self, entry: usize) -> usize {
        // Groups before what they are placed in, deep nodes before their ancestors: each is measured once.
        let key = |entries: &[Entry], entry: usize| (Reverse(entries[entry].tree), entries[entry].depth, entry);
        let mut open = BinaryHeap::from([key(&self.entries, entry)]);
        let mut nodes = 0;
        while let Some(next) = open.pop() {
            while open.peek() == Some(&next) {
                open.pop();
            }
            let (_, depth, entry) = next;
            nodes += usize::from(depth > 0);
            if !self.measure(entry) {
                continue;
            }
            match self.entries[entry].parent {
                Some(parent) => open.push(key(&self.entries, parent)),
                None => {
                    let instances = self.instances.get(entry).into_iter().flatten();
                    open.extend(instances.map(|&instance| key(&self.entries, instance)));
                }
            }
        }
        nodes
    }
}

impl Entry {
    /// The entry that stands for a tree.
    const fn of_tree(tree: usize) -> Self {
        Self {
            tree,
            depth: 0,
            parent: None,
            children: Vec::new(),
            parent_from_local: Transform::IDENTITY,
            motion: None,
            content: Measured::Extent(Extent::NOTHING),
            bounds: NodeBounds { own: Extent::NOTHING, subtree: Extent::NOTHING },
        }
    }
}

/// What a path leads to.
enum Found<'s> {
    Tree(&'s [Node]),
    Node(&'s Node),
}

fn node_at<'s>(scene: &'s Scene, tree: Tree, path: &[usize]) -> Option<Found<'s>> {
    let nodes = match tree {
        Tree::World => &scene.nodes,
        Tree::Group(GroupId(id)) => &scene.groups.get(id as usize)?.nodes,
    };
    let Some((&first, rest)) = path.split_first() else { return Some(Found::Tree(nodes)) };
    rest.iter().try_fold(nodes.get(first)?, |node, &child| node.children.get(child)).map(Found::Node)
}

#[cfg(test)]
mod tests;
