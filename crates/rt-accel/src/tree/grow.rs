//! Grows a tree from the root down.

use core::cmp::Ordering;
use core::ops::Range;

use rt_math::Aabb;

use super::{Child, Item, Node, Tree};
use crate::own_boxes::PrimBounds;

/// Two halves of a set of items: the first `middle` of them, and the others.
pub(crate) struct Cut<C, T> {
    pub(crate) middle: usize,
    /// What the node is to know about both.
    pub(crate) content: C,
    /// What the next cuts are to know about each.
    pub(crate) sides: [T; 2],
}

/// A set of items that will become a leaf or a node.
struct Task<T> {
    run: Range<usize>,
    knowledge: T,
    depth: u32,
    /// Number and side of the node that it is below.
    parent: Option<(usize, usize)>,
}

impl<C> Tree<C> {
    /// Grows the tree over all boxes. `split` reorders some items and cuts them in two, or returns `None` where they
    /// should be a leaf; it is given what the cut above knew about them and their depth.
    pub(crate) fn grow<T>(
        boxes: PrimBounds,
        knowledge: T,
        split: impl Fn(&mut [Item], &T, u32) -> Option<Cut<C, T>>,
    ) -> Self {
        let mut items = boxes.bounded;
        let mut nodes = Vec::new();
        let mut root = Child::leaf(0, items.len() as u32);
        let mut pending = vec![Task { run: 0..items.len(), knowledge, depth: 0, parent: None }];
        while let Some(Task { run, knowledge, depth, parent }) = pending.pop() {
            let Some(cut) = split(&mut items[run.clone()], &knowledge, depth) else {
                attach(&mut root, &mut nodes, parent, Child::leaf(run.start as u32, run.len() as u32));
                continue;
            };
            let number = nodes.len();
            attach(&mut root, &mut nodes, parent, Child::node(number as u32));
            nodes.push(Node { content: cut.content, children: [Child::node(0); 2] });
            let middle = run.start + cut.middle;
            let [left, right] = cut.sides;
            let task = |run, knowledge, side| Task { run, knowledge, depth: depth + 1, parent: Some((number, side)) };
            pending.push(task(middle..run.end, right, 1));
            pending.push(task(run.start..middle, left, 0));
        }
        nodes.shrink_to_fit();
        let indices = items.iter().map(|&(index, _)| index).collect();
        Self { nodes, root, indices, unbounded: boxes.unbounded }
    }
}

fn attach<C>(root: &mut Child, nodes: &mut [Node<C>], parent: Option<(usize, usize)>, child: Child) {
    match parent {
        None => *root = child,
        Some((number, side)) => nodes[number].children[side] = child,
    }
}

/// Moves the half of the items with the lower centres along the widest axis of `centres` to the front, or if all
/// centres coincide, leaves them in order. Returns the size of that half.
pub(crate) fn halve(items: &mut [Item], centres: &Aabb) -> usize {
    let extent = centres.extent();
    if extent.cmpgt(glam::DVec3::ZERO).any() {
        let axis = extent.max_position();
        items.sort_unstable_by(|(a, a_box), (b, b_box)| {
            let by_place = a_box.centre()[axis].total_cmp(&b_box.centre()[axis]);
            if by_place == Ordering::Equal { a.cmp(b) } else { by_place }
        });
    }
    items.len() / 2
}

/// Moves the items for which `is_left` holds to the front, in a fixed order, and counts them.
pub(crate) fn partition(items: &mut [Item], is_left: impl Fn(&Item) -> bool) -> usize {
    let (mut left, mut right) = (0, items.len());
    loop {
        while left < right && is_left(&items[left]) {
            left += 1;
        }
        while left < right && !is_left(&items[right - 1]) {
            right -= 1;
        }
        if left >= right {
            return left;
        }
        items.swap(left, right - 1);
    }
}
