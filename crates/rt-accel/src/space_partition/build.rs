//! Top-down construction within a budget of planes and references.

use rt_geometry::Primitives;
use rt_math::Aabb;

use super::{BspPartition, SplitPlane};
use crate::prim_bounds::{Item, PrimBounds};
use crate::top_down::{MIN_FORKED, Split, Subtree, build_top_down};
use crate::{BuildError, traversal::MAX_DEPTH};

/// Maximum number of planes and references per primitive, in addition, and in total.
const MAX_NODES_PER_PRIMITIVE: u64 = 16;
const EXTRA_NODES: u64 = 4096;
const MAX_NODES: u64 = 1 << 31;

/// Selects splitting planes. A pure function of its arguments, so that the tree depends on the primitives alone.
pub(crate) trait SplitHeuristic<C>: Sync {
    /// The best plane, or `None` for a leaf.
    fn find_split(&self, boxes: &[Item], task: &Task<C>) -> Option<C>;
}

/// Part of space that becomes a leaf or a split.
pub(crate) struct Task<C> {
    /// Positions in the list of boxes of those that touch the part, rising.
    pub(crate) items: Vec<u32>,
    /// Bounds of the part, within those of the scene.
    pub(crate) cell: Aabb,
    /// Planes that bound the part although `cell` does not show it, and whether the part is above them.
    pub(crate) clip_planes: Vec<(C, bool)>,
    pub(crate) depth: u32,
    /// Path from the root: a leading 1, then one bit per level.
    pub(crate) path: u64,
    /// Remaining number of planes and references.
    pub(crate) budget: u64,
}

impl<C: SplitPlane> Task<C> {
    fn whole(boxes: &PrimBounds) -> Self {
        let count = boxes.bounded.len() as u64;
        let budget = (MAX_NODES_PER_PRIMITIVE * count + EXTRA_NODES).min(MAX_NODES).max(count);
        Self {
            items: (0..count as u32).collect(),
            cell: boxes.union,
            clip_planes: Vec::new(),
            depth: 0,
            path: 1,
            budget,
        }
    }

    /// Parts below and above a plane, or the task itself if they exceed the budget.
    fn divide(self, plane: C, boxes: &[Item]) -> Result<[Self; 2], Self> {
        let mut lists = [Vec::with_capacity(self.items.len()), Vec::new()];
        for &item in &self.items {
            let sides = plane.classify(&boxes[item as usize].1);
            for (list, is_there) in lists.iter_mut().zip(sides) {
                if is_there {
                    list.push(item);
                }
            }
        }
        let needed = lists.iter().map(|list| list.len() as u64).sum::<u64>();
        let Some(rest) = self.budget.checked_sub(needed + 1) else { return Err(self) };
        let cells = plane.split_bounds(&self.cell);
        let mut side = 0;
        Ok(lists.map(|items| {
            let mut clip_planes = self.clip_planes.clone();
            if !plane.is_tight() {
                clip_planes.push((plane, side == 1));
            }
            let count = items.len() as u64;
            let budget = count + (u128::from(rest) * u128::from(count) / u128::from(needed.max(1))) as u64;
            let task = Self {
                items,
                clip_planes,
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

impl<C: SplitPlane> BspPartition<C> {
    /// Builds a tree of at most 16 planes and references per primitive, and 4096 more.
    pub(crate) fn build<P: Primitives>(primitives: &P, heuristic: &impl SplitHeuristic<C>) -> Result<Self, BuildError> {
        let boxes = PrimBounds::collect(primitives)?;
        let count = boxes.bounded.len();
        if count as u64 > MAX_NODES {
            return Err(BuildError::TooMany { count: count as u64, limit: MAX_NODES });
        }
        let items = &boxes.bounded;
        let Subtree { nodes, indices, .. } = build_top_down(Task::whole(&boxes), &|task: Task<C>, indices| {
            let plane = if task.depth < MAX_DEPTH { heuristic.find_split(items, &task) } else { None };
            let leaf = match plane {
                None => task,
                Some(payload) => match task.divide(payload, items) {
                    Ok(tasks) => {
                        let is_large = tasks.iter().all(|task| task.items.len() >= MIN_FORKED);
                        return Some(Split { payload, tasks, is_large });
                    }
                    Err(task) => task,
                },
            };
            indices.extend(leaf.items.iter().map(|&item| items[item as usize].0));
            None
        });
        let bounds = boxes.finite_union();
        let primitives = (count + boxes.unbounded.len()) as u32;
        Ok(Self { nodes, indices, bounds, unbounded: boxes.unbounded, primitives })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Accelerator, Boxes, BspTree, KdTree};
    use glam::DVec3;
    use rt_math::random::{hash, unit};

    /// Boxes of many sizes that overlap much.
    fn heap(count: u64, size: f64) -> Vec<Aabb> {
        let vector = |i, k| DVec3::new(unit(hash(&[i, k])), unit(hash(&[i, k + 1])), unit(hash(&[i, k + 2])));
        let around = |i| (vector(i, 0), vector(i, 3) * size * unit(hash(&[i, 6])));
        (0..count).map(around).map(|(centre, half)| Aabb::new(centre - half, centre + half)).collect()
    }

    #[test]
    fn references_are_bounded_however_much_boxes_overlap() {
        for (count, size) in [(3000, 0.5), (3000, 0.2), (300, 1.0)] {
            let heap = heap(count, size);
            for stats in [
                KdTree::build(&Boxes(&heap)).expect("boxes").build_stats(),
                BspTree::build(&Boxes(&heap)).expect("boxes").build_stats(),
            ] {
                assert!(
                    (stats.references + stats.nodes) as u64 <= MAX_NODES_PER_PRIMITIVE * count + EXTRA_NODES,
                    "{stats:?}"
                );
                assert!(stats.max_depth as u32 <= MAX_DEPTH && stats.leaves > 1, "{stats:?}");
            }
        }
    }

    #[test]
    fn budgets_of_parts_add_up() {
        let heap = heap(1000, 0.1);
        let boxes = PrimBounds::collect(&Boxes(&heap)).expect("boxes");
        let whole = Task::whole(&boxes);
        let (budget, cell) = (whole.budget, whole.cell);
        let plane = crate::kd::SahSplit.find_split(&boxes.bounded, &whole).expect("a cut");
        let [below, above] = whole.divide(plane, &boxes.bounded).ok().expect("a large budget");
        assert!(below.budget + above.budget < budget && below.budget + above.budget + 3 > budget);
        assert!(below.items.len() + above.items.len() >= 1000 && below.items.len().max(above.items.len()) < 1000);
        assert_eq!(below.cell.union(above.cell), cell);
        assert_eq!((below.path, above.path), (2, 3));
        let tight = Task { budget: below.items.len() as u64, ..below };
        let plane = crate::kd::SahSplit.find_split(&boxes.bounded, &tight).expect("a cut");
        assert!(tight.divide(plane, &boxes.bounded).is_err());
    }
}
