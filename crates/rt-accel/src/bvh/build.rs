//! Grows a tree from the root down, on one thread or on several, with the same result.

use super::node::{Child, Node, NodeBox};
use super::split::{Item, Split, SplitMethod, split, union};

/// A tree, or the part of one that is below a node; nodes are in depth-first order and numbered from 0.
#[derive(Debug, PartialEq)]
pub(super) struct Subtree {
    pub(super) nodes: Vec<Node>,
    pub(super) root: Child,
    pub(super) leaves: usize,
    /// Of the deepest leaf, from the root of the whole tree.
    pub(super) max_depth: u32,
}

/// A set of items that will become a leaf or a node.
struct Task<'a> {
    items: &'a mut [Item],
    /// Position of the first item in the whole list.
    first: u32,
    bounds: NodeBox,
    depth: u32,
    method: SplitMethod,
}

impl<'a> Task<'a> {
    fn whole(items: &'a mut [Item], method: SplitMethod) -> Self {
        Self { bounds: union(items), items, first: 0, depth: 0, method }
    }

    fn split(&mut self) -> Option<Split> {
        split(self.items, &self.bounds, self.depth, self.method)
    }

    /// The two tasks that a split leaves, and their boxes.
    fn divide(self, Split { middle, bounds }: Split) -> [Self; 2] {
        let (left, right) = self.items.split_at_mut(middle);
        let (depth, method) = (self.depth + 1, self.method);
        [
            Task { items: left, first: self.first, bounds: bounds[0], depth, method },
            Task { items: right, first: self.first + middle as u32, bounds: bounds[1], depth, method },
        ]
    }

    fn leaf(&self) -> Child {
        Child::leaf(self.first, self.items.len() as u32)
    }
}

/// Grows the tree over `items`, which must not be empty, and reorders them so that each leaf is a run.
pub(super) fn build(items: &mut [Item], method: SplitMethod) -> Subtree {
    let task = Task::whole(items, method);
    #[cfg(feature = "parallel")]
    return parallel::grow(task);
    #[cfg(not(feature = "parallel"))]
    grow(task)
}

/// What a node or leaf, once made, is attached to.
#[derive(Clone, Copy)]
pub(super) enum Parent {
    None,
    Node { number: usize, side: usize },
}

impl Subtree {
    /// A tree without nodes.
    pub(super) const fn new() -> Self {
        Self { nodes: Vec::new(), root: Child::leaf(0, 0), leaves: 0, max_depth: 0 }
    }

    /// Attaches a leaf at this depth.
    pub(super) fn attach_leaf(&mut self, parent: Parent, leaf: Child, depth: u32) {
        self.leaves += 1;
        self.max_depth = self.max_depth.max(depth);
        self.attach(parent, leaf);
    }

    /// Attaches a node, and says what its children are to be attached to.
    pub(super) fn attach_node(&mut self, parent: Parent, bounds: [NodeBox; 2]) -> [Parent; 2] {
        let number = self.nodes.len();
        self.nodes.push(Node::new(bounds, [Child::node(0); 2]));
        self.attach(parent, Child::node(number as u32));
        [0, 1].map(|side| Parent::Node { number, side })
    }

    fn attach(&mut self, parent: Parent, child: Child) {
        match parent {
            Parent::None => self.root = child,
            Parent::Node { number, side } => self.nodes[number].children[side] = child,
        }
    }
}

fn grow(task: Task<'_>) -> Subtree {
    let mut subtree = Subtree::new();
    let mut pending = vec![(task, Parent::None)];
    while let Some((mut task, parent)) = pending.pop() {
        match task.split() {
            None => subtree.attach_leaf(parent, task.leaf(), task.depth),
            Some(split) => {
                let [left_of, right_of] = subtree.attach_node(parent, split.bounds);
                let [left, right] = task.divide(split);
                pending.push((right, right_of));
                pending.push((left, left_of));
            }
        }
    }
    subtree
}

#[cfg(feature = "parallel")]
mod parallel {
    use super::{Child, Node, Subtree, Task, grow as grow_serially};

    /// Sets below this size are not worth another task.
    const MIN_ITEMS: usize = 8192;

    /// As the serial function, but both sides of large sets grow at the same time. The recursion is as deep as the
    /// tree, which is bounded.
    pub(super) fn grow(mut task: Task<'_>) -> Subtree {
        if task.items.len() < MIN_ITEMS {
            return grow_serially(task);
        }
        let Some(split) = task.split() else {
            return grow_serially(task);
        };
        let bounds = split.bounds;
        let [left, right] = task.divide(split);
        let (left, right) = rayon::join(|| grow(left), || grow(right));

        let right_start = 1 + left.nodes.len() as u32;
        let children = [left.root.moved(1), right.root.moved(right_start)];
        let mut nodes = Vec::with_capacity(1 + left.nodes.len() + right.nodes.len());
        nodes.push(Node::new(bounds, children));
        nodes.extend(left.nodes.into_iter().map(|node| node.moved(1)));
        nodes.extend(right.nodes.into_iter().map(|node| node.moved(right_start)));
        Subtree {
            nodes,
            root: Child::node(0),
            leaves: left.leaves + right.leaves,
            max_depth: left.max_depth.max(right.max_depth),
        }
    }

    impl Child {
        /// The same child after all nodes have been moved back by `offset`.
        fn moved(self, offset: u32) -> Self {
            if self.count == 0 { Self::node(self.first + offset) } else { self }
        }
    }

    impl Node {
        fn moved(mut self, offset: u32) -> Self {
            self.children = self.children.map(|child| child.moved(offset));
            self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3A;
    use rt_math::random::{hash, unit};

    fn items(count: u32) -> Vec<Item> {
        let item = |index: u32| {
            let draw = |axis| unit(hash(&[u64::from(index), axis])) as f32;
            // Coarse coordinates, so that many centroids coincide.
            let min = Vec3A::new((draw(0) * 40.0).round(), (draw(1) * 9.0).round(), draw(2));
            Item { bounds: NodeBox { min, max: min + 0.1 * draw(3) }, index }
        };
        (0..count).map(item).collect()
    }

    fn order(items: &[Item]) -> Vec<u32> {
        items.iter().map(|item| item.index).collect()
    }

    #[test]
    fn leaves_are_small_and_nodes_are_one_fewer() {
        let mut items = items(5000);
        let tree = build(&mut items, SplitMethod::SurfaceArea);
        assert_eq!(tree.leaves, tree.nodes.len() + 1);
        let counts = tree.nodes.iter().flat_map(|node| node.children).map(|child| child.count as usize);
        assert!(counts.clone().all(|count| count <= super::super::split::MAX_LEAF));
        assert_eq!(counts.sum::<usize>(), 5000);
        let mut all = order(&items);
        all.sort_unstable();
        assert_eq!(all, (0..5000).collect::<Vec<_>>());
    }

    #[cfg(feature = "parallel")]
    #[test]
    fn any_number_of_threads_grows_the_same_tree() {
        let mut serial_items = items(50_000);
        let serial = grow(Task::whole(&mut serial_items, SplitMethod::SurfaceArea));
        for n_threads in [1, 2, 7] {
            let mut items = items(50_000);
            let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().expect("a pool");
            let tree = pool.install(|| parallel::grow(Task::whole(&mut items, SplitMethod::SurfaceArea)));
            assert_eq!(tree, serial);
            assert_eq!(order(&items), order(&serial_items));
        }
    }
}
