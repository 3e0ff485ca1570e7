//! Grows a tree from the root down, on one thread or on several, with the same result.

use rt_math::{Aabb, Primitives};

use super::{Cut, Node, Partition};
use crate::BuildError;
use crate::bounded_depth::MAX_DEPTH;
use crate::own_boxes::OwnBoxes;

/// Nodes and references that a tree may have per primitive, and in all.
const MOST_PER_PRIMITIVE: u64 = 16;
const MOST_BESIDES: u64 = 4096;
const MOST: u64 = 1 << 31;

/// Decides where to cut. A pure function of its arguments, so that the tree is one of the primitives.
pub(crate) trait Chooser<C>: Sync {
    /// A cut that pays, or `None` where there should be a leaf.
    fn choose(&self, boxes: &[(u32, Aabb)], task: &Task) -> Option<C>;
}

/// A part of space that will become a leaf or a split.
pub(crate) struct Task {
    /// Places in the list of boxes of those that touch the part, rising.
    pub(crate) items: Vec<u32>,
    /// A box around the part, within the box around everything.
    pub(crate) cell: Aabb,
    pub(crate) depth: u32,
    /// Which part it is: the way down from the root, bit by bit after a leading 1.
    pub(crate) path: u64,
    /// Nodes and references that there may yet be in the part, without its own references if it becomes a leaf.
    budget: u64,
}

impl Task {
    fn whole(boxes: &OwnBoxes) -> Self {
        let count = boxes.bounded.len() as u64;
        let budget = (MOST_PER_PRIMITIVE * count + MOST_BESIDES).min(MOST).max(count);
        Self { items: (0..count as u32).collect(), cell: boxes.union, depth: 0, path: 1, budget }
    }

    /// The parts below and above a cut, or the task itself if they would take more than the budget.
    fn divide<C: Cut>(self, cut: C, boxes: &[(u32, Aabb)]) -> Result<[Self; 2], Self> {
        let mut lists = [Vec::with_capacity(self.items.len()), Vec::new()];
        for &item in &self.items {
            let sides = cut.sides(&boxes[item as usize].1);
            for (list, is_there) in lists.iter_mut().zip(sides) {
                if is_there {
                    list.push(item);
                }
            }
        }
        let needed = lists.iter().map(|list| list.len() as u64).sum::<u64>();
        let Some(rest) = self.budget.checked_sub(needed + 1) else { return Err(self) };
        let cells = cut.divide(&self.cell);
        let mut side = 0;
        Ok(lists.map(|items| {
            let count = items.len() as u64;
            let budget = count + (u128::from(rest) * u128::from(count) / u128::from(needed.max(1))) as u64;
            let task =
                Self { items, cell: cells[side], depth: self.depth + 1, path: 2 * self.path + side as u64, budget };
            side += 1;
            task
        }))
    }
}

/// A tree, or the part of one that is below a node; nodes and references are numbered from 0.
#[derive(Debug, PartialEq)]
struct Subtree<C> {
    nodes: Vec<Node<C>>,
    indices: Vec<u32>,
}

impl<C> Default for Subtree<C> {
    fn default() -> Self {
        Self { nodes: Vec::new(), indices: Vec::new() }
    }
}

impl<C: Cut> Partition<C> {
    /// Builds a tree of at most 16 nodes and references per primitive, and some.
    pub(crate) fn build<P: Primitives>(primitives: &P, chooser: &impl Chooser<C>) -> Result<Self, BuildError> {
        let boxes = OwnBoxes::collect(primitives)?;
        if boxes.bounded.len() as u64 > MOST {
            return Err(BuildError::TooMany { count: boxes.bounded.len() as u64, limit: MOST });
        }
        let mut tree = Subtree::default();
        tree.grow(Task::whole(&boxes), &boxes.bounded, chooser);
        tree.nodes.shrink_to_fit();
        tree.indices.shrink_to_fit();
        let primitives = (boxes.bounded.len() + boxes.unbounded.len()) as u32;
        let Subtree { nodes, indices } = tree;
        Ok(Self { nodes, indices, bounds: boxes.union, unbounded: boxes.unbounded, primitives })
    }
}

impl<C: Cut> Subtree<C> {
    /// Adds a part. The recursion is as deep as the tree, which is bounded.
    fn grow(&mut self, task: Task, boxes: &[(u32, Aabb)], chooser: &impl Chooser<C>) {
        let cut = if task.depth < MAX_DEPTH { chooser.choose(boxes, &task) } else { None };
        let Some(cut) = cut else { return self.push_leaf(&task, boxes) };
        let tasks = match task.divide(cut, boxes) {
            Ok(tasks) => tasks,
            Err(task) => return self.push_leaf(&task, boxes),
        };
        let number = self.nodes.len();
        self.nodes.push(Node::Split { cut, above: 0 });
        let above = self.grow_both(tasks, boxes, chooser);
        self.nodes[number] = Node::Split { cut, above };
    }

    fn push_leaf(&mut self, task: &Task, boxes: &[(u32, Aabb)]) {
        self.nodes.push(Node::Leaf { first: self.indices.len() as u32, count: task.items.len() as u32 });
        self.indices.extend(task.items.iter().map(|&item| boxes[item as usize].0));
    }

    /// Adds both parts, and returns the number of the second.
    fn grow_both(&mut self, tasks: [Task; 2], boxes: &[(u32, Aabb)], chooser: &impl Chooser<C>) -> u32 {
        #[cfg(feature = "parallel")]
        if tasks.iter().all(|task| task.items.len() >= MIN_ITEMS) {
            let grown = |task| {
                let mut part = Self::default();
                part.grow(task, boxes, chooser);
                part
            };
            let [below, above] = tasks;
            let (below, above) = rayon::join(|| grown(below), || grown(above));
            self.append(below);
            let number = self.nodes.len() as u32;
            self.append(above);
            return number;
        }
        let [below, above] = tasks;
        self.grow(below, boxes, chooser);
        let number = self.nodes.len() as u32;
        self.grow(above, boxes, chooser);
        number
    }

    #[cfg(feature = "parallel")]
    fn append(&mut self, part: Self) {
        let (node_offset, reference_offset) = (self.nodes.len() as u32, self.indices.len() as u32);
        self.nodes.extend(part.nodes.into_iter().map(|node| match node {
            Node::Split { cut, above } => Node::Split { cut, above: above + node_offset },
            Node::Leaf { first, count } => Node::Leaf { first: first + reference_offset, count },
        }));
        self.indices.extend(part.indices);
    }
}

/// Sets below this size are not worth another task.
#[cfg(feature = "parallel")]
const MIN_ITEMS: usize = 4096;
