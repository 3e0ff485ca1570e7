//! Grows a tree from the root down, on one thread or on several, with the same result.

use glam::DVec3;
use rt_geometry::Primitives;
use rt_math::Aabb;

use super::{Cut, Node, Partition};
use crate::{BuildError, bounded_depth::MAX_DEPTH, own_boxes::PrimBounds};

/// Sets below this size are not worth another task.
const MIN_FORKED: usize = 4096;

/// Cuts and references that a tree may have per primitive, beyond that, and in all.
const MOST_PER_PRIMITIVE: u64 = 16;
const MOST_BESIDES: u64 = 4096;
const MOST: u64 = 1 << 31;

/// Decides where to cut. A pure function of its arguments, so that the tree is one of the primitives.
pub(crate) trait Chooser<C>: Sync {
    /// A cut that pays, or `None` where there should be a leaf.
    fn choose(&self, boxes: &[(u32, Aabb)], task: &Task<C>) -> Option<C>;
}

/// A part of space that will become a leaf or a split.
pub(crate) struct Task<C> {
    /// Places in the list of boxes of those that touch the part, rising.
    pub(crate) items: Vec<u32>,
    /// A box around the part, within the box around everything.
    pub(crate) cell: Aabb,
    /// What else bounds the part: cuts that boxes do not tell of, and whether the part is above them.
    pub(crate) walls: Vec<(C, bool)>,
    pub(crate) depth: u32,
    /// Which part it is: the way down from the root, bit by bit after a leading 1.
    pub(crate) path: u64,
    /// Cuts and references that there may be in the part.
    pub(crate) budget: u64,
}

impl<C: Cut> Task<C> {
    fn whole(boxes: &PrimBounds) -> Self {
        let count = boxes.bounded.len() as u64;
        let budget = (MOST_PER_PRIMITIVE * count + MOST_BESIDES).min(MOST).max(count);
        Self { items: (0..count as u32).collect(), cell: boxes.union, walls: Vec::new(), depth: 0, path: 1, budget }
    }

    /// The parts below and above a cut, or the task itself if they would take more than the budget.
    fn divide(self, cut: C, boxes: &[(u32, Aabb)]) -> Result<[Self; 2], Self> {
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
            let mut walls = self.walls.clone();
            if !cut.divides_exactly() {
                walls.push((cut, side == 1));
            }
            let count = items.len() as u64;
            let budget = count + (u128::from(rest) * u128::from(count) / u128::from(needed.max(1))) as u64;
            let task = Self {
                items,
                walls,
                cell: cells[side],
                depth: self.depth + 1,
                path: 2 * self.path + side as u64,
                budget,
            };
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
    /// Builds a tree of at most 16 cuts and references per primitive, and some.
    pub(crate) fn build<P: Primitives>(primitives: &P, chooser: &impl Chooser<C>) -> Result<Self, BuildError> {
        Self::build_forking(primitives, chooser, MIN_FORKED)
    }

    /// As [`build`](Self::build), with both sides of sets of `fork_from` primitives or more at the same time.
    fn build_forking<P: Primitives>(
        primitives: &P,
        chooser: &impl Chooser<C>,
        fork_from: usize,
    ) -> Result<Self, BuildError> {
        let boxes = PrimBounds::collect(primitives)?;
        let count = boxes.bounded.len();
        if count as u64 > MOST {
            return Err(BuildError::TooMany { count: count as u64, limit: MOST });
        }
        let mut tree = Subtree::default();
        Grower { boxes: &boxes.bounded, chooser, fork_from }.grow(Task::whole(&boxes), &mut tree);
        let Subtree { mut nodes, mut indices } = tree;
        nodes.shrink_to_fit();
        indices.shrink_to_fit();
        // All numbers are finite, so that they can be saved in any format.
        let bounds = if count == 0 { Aabb::new(DVec3::ZERO, DVec3::ZERO) } else { boxes.union };
        let primitives = (count + boxes.unbounded.len()) as u32;
        Ok(Self { nodes, indices, bounds, unbounded: boxes.unbounded, primitives })
    }
}

/// What all tasks have in common.
struct Grower<'a, H> {
    boxes: &'a [(u32, Aabb)],
    chooser: &'a H,
    fork_from: usize,
}

impl<H> Grower<'_, H> {
    /// Adds a part to the tree. The recursion is as deep as the tree, which is bounded.
    fn grow<C: Cut>(&self, task: Task<C>, tree: &mut Subtree<C>)
    where
        H: Chooser<C>,
    {
        let cut = if task.depth < MAX_DEPTH { self.chooser.choose(self.boxes, &task) } else { None };
        let Some(cut) = cut else { return self.push_leaf(&task, tree) };
        let tasks = match task.divide(cut, self.boxes) {
            Ok(tasks) => tasks,
            Err(task) => return self.push_leaf(&task, tree),
        };
        let number = tree.nodes.len();
        tree.nodes.push(Node::Split { cut, above: 0 });
        let above = self.grow_both(tasks, tree);
        tree.nodes[number] = Node::Split { cut, above };
    }

    fn push_leaf<C>(&self, task: &Task<C>, tree: &mut Subtree<C>) {
        tree.nodes.push(Node::Leaf { first: tree.indices.len() as u32, count: task.items.len() as u32 });
        tree.indices.extend(task.items.iter().map(|&item| self.boxes[item as usize].0));
    }

    /// Adds both parts to the tree, and returns the number of the second.
    fn grow_both<C: Cut>(&self, tasks: [Task<C>; 2], tree: &mut Subtree<C>) -> u32
    where
        H: Chooser<C>,
    {
        let is_large = tasks.iter().all(|task| task.items.len() >= self.fork_from);
        let [below, above] = tasks;
        if is_large {
            let grown = |task| {
                let mut part = Subtree::default();
                self.grow(task, &mut part);
                part
            };
            let (below, above) = both(|| grown(below), || grown(above));
            tree.append(below);
            let number = tree.nodes.len() as u32;
            tree.append(above);
            number
        } else {
            self.grow(below, tree);
            let number = tree.nodes.len() as u32;
            self.grow(above, tree);
            number
        }
    }
}

#[cfg(feature = "parallel")]
use rayon::join as both;

#[cfg(not(feature = "parallel"))]
fn both<A, B>(first: impl FnOnce() -> A, second: impl FnOnce() -> B) -> (A, B) {
    (first(), second())
}

impl<C> Subtree<C> {
    /// Adds a part that has been grown apart.
    fn append(&mut self, part: Self) {
        let (node_offset, reference_offset) = (self.nodes.len() as u32, self.indices.len() as u32);
        self.nodes.extend(part.nodes.into_iter().map(|node| match node {
            Node::Split { cut, above } => Node::Split { cut, above: above + node_offset },
            Node::Leaf { first, count } => Node::Leaf { first: first + reference_offset, count },
        }));
        self.indices.extend(part.indices);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{AcceleratorQueries, BspTree, KdTree};
    use rt_geometry::Hit;
    use rt_math::random::{hash, unit};
    use rt_math::{Interval, Ray};

    /// Boxes of many sizes that overlap much.
    struct Heap(Vec<Aabb>);

    impl Primitives for Heap {
        fn len(&self) -> usize {
            self.0.len()
        }
        fn bounds(&self, index: u32) -> Option<Aabb> {
            Some(self.0[index as usize])
        }
        fn intersect(&self, _: u32, _: &Ray, _: Interval) -> Option<Hit> {
            None
        }
    }

    fn heap(count: u64, size: f64) -> Heap {
        let vector = |i, k| DVec3::new(unit(hash(&[i, k])), unit(hash(&[i, k + 1])), unit(hash(&[i, k + 2])));
        let around = |i| (vector(i, 0), vector(i, 3) * size * unit(hash(&[i, 6])));
        Heap((0..count).map(around).map(|(centre, half)| Aabb::new(centre - half, centre + half)).collect())
    }

    #[test]
    fn any_number_of_threads_grows_the_same_tree() {
        fn check<C: Cut>(heap: &Heap, chooser: &impl Chooser<C>) {
            let serial = Partition::build_forking(heap, chooser, usize::MAX).expect("boxes");
            assert_eq!(serial.validate(heap), Ok(()));
            #[cfg(feature = "parallel")]
            for n_threads in [1, 2, 7] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().expect("a pool");
                let forked = pool.install(|| Partition::build_forking(heap, chooser, 50)).expect("boxes");
                assert!(forked == serial, "{n_threads} threads");
            }
            assert!(Partition::build_forking(heap, chooser, 50).expect("boxes") == serial);
        }
        let heap = heap(20_000, 0.02);
        check(&heap, &crate::kd::SurfaceArea);
        check(&heap, &crate::bsp::Sampled { primitives: &heap });
    }

    #[test]
    fn references_are_bounded_however_much_boxes_overlap() {
        for (count, size) in [(3000, 0.5), (3000, 0.2), (300, 1.0)] {
            let heap = heap(count, size);
            for stats in [
                KdTree::build(&heap).expect("boxes").build_stats(),
                BspTree::build(&heap).expect("boxes").build_stats(),
            ] {
                assert!(
                    (stats.references + stats.nodes) as u64 <= MOST_PER_PRIMITIVE * count + MOST_BESIDES,
                    "{stats:?}"
                );
                assert!(stats.max_depth as u32 <= MAX_DEPTH && stats.leaves > 1, "{stats:?}");
            }
        }
    }

    #[test]
    fn budgets_of_parts_add_up() {
        let heap = heap(1000, 0.1);
        let boxes = PrimBounds::collect(&heap).expect("boxes");
        let whole = Task::whole(&boxes);
        let (budget, cell) = (whole.budget, whole.cell);
        let cut = crate::kd::SurfaceArea.choose(&boxes.bounded, &whole).expect("a cut");
        let [below, above] = whole.divide(cut, &boxes.bounded).ok().expect("a large budget");
        assert!(below.budget + above.budget < budget && below.budget + above.budget + 3 > budget);
        assert!(below.items.len() + above.items.len() >= 1000 && below.items.len().max(above.items.len()) < 1000);
        assert_eq!(below.cell.union(above.cell), cell);
        assert_eq!((below.path, above.path), (2, 3));
        let tight = Task { budget: below.items.len() as u64, ..below };
        let cut = crate::kd::SurfaceArea.choose(&boxes.bounded, &tight).expect("a cut");
        assert!(tight.divide(cut, &boxes.bounded).is_err());
    }
}
