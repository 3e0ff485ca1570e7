//! A node that does not know what it is until somebody asks.

use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

use rt_math::Aabb;

use crate::{bih::planes::Planes, bih::split::split, bih::walk::Step, tree::Item};

/// First it has a list, then it is split and the list is gone.
///
/// Copies, comparisons and the end of it recurse, no deeper than the tree, which is bounded.
#[derive(Debug)]
pub(in crate::bih) struct LazyNode {
    found: OnceLock<Found>,
    /// `None` from the moment when somebody has begun to split it.
    waiting: Mutex<Option<Box<Waiting>>>,
}

/// All that splitting a node depends on.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Waiting {
    pub(super) items: Vec<Item>,
    pub(super) cell: Aabb,
    depth: u32,
}

/// What a node was split into.
#[derive(Clone, Debug, PartialEq)]
enum Found {
    Leaf(Box<[u32]>),
    Node(Box<Sides>),
}

#[derive(Clone, Debug, PartialEq)]
struct Sides {
    planes: Planes,
    children: [LazyNode; 2],
}

/// What is known of a node.
pub(super) enum Known<'n> {
    /// It has not been split. As long as this exists nobody will.
    Waiting(MutexGuard<'n, Option<Box<Waiting>>>),
    /// What it was split into.
    Split(Step<'n, &'n LazyNode>),
}

impl LazyNode {
    pub(super) fn waiting(items: Vec<Item>, cell: Aabb, depth: u32) -> Self {
        Self { found: OnceLock::new(), waiting: Mutex::new(Some(Box::new(Waiting { items, cell, depth }))) }
    }

    #[cfg(feature = "serde")]
    pub(super) fn leaf(indices: Vec<u32>) -> Self {
        Self { found: OnceLock::from(Found::Leaf(indices.into())), waiting: Mutex::new(None) }
    }

    #[cfg(feature = "serde")]
    pub(super) fn inner(planes: Planes, children: [Self; 2]) -> Self {
        Self { found: OnceLock::from(Found::Node(Box::new(Sides { planes, children }))), waiting: Mutex::new(None) }
    }

    /// What it leads to; it is split if it has not been.
    #[inline(always)]
    pub(super) fn step(&self) -> Step<'_, &Self> {
        match self.found() {
            Found::Leaf(indices) => Step::Leaf(indices),
            Found::Node(sides) => Step::Node(&sides.planes, sides.children.each_ref()),
        }
    }

    #[inline(always)]
    fn found(&self) -> &Found {
        // Only one thread at a time gets to take the list, and once only.
        self.found.get_or_init(|| self.lock().take().map_or(Found::Leaf(Box::default()), |waiting| waiting.split()))
    }

    /// What is known of it, without splitting it. Waits if it is just being split.
    pub(super) fn known(&self) -> Known<'_> {
        let waiting = self.lock();
        if waiting.is_some() {
            return Known::Waiting(waiting);
        }
        drop(waiting);
        Known::Split(self.step())
    }

    fn lock(&self) -> MutexGuard<'_, Option<Box<Waiting>>> {
        // Nobody who holds the lock can leave the list half changed.
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Waiting {
    fn split(mut self) -> Found {
        match split(&mut self.items, &self.cell, self.depth) {
            None => Found::Leaf(self.items.iter().map(|&(index, _)| index).collect()),
            Some(cut) => {
                let right = self.items.split_off(cut.middle);
                let mut left = self.items;
                left.shrink_to_fit();
                let [left_cell, right_cell] = cut.sides;
                let depth = self.depth + 1;
                let children = [LazyNode::waiting(left, left_cell, depth), LazyNode::waiting(right, right_cell, depth)];
                Found::Node(Box::new(Sides { planes: cut.content, children }))
            }
        }
    }
}

impl Known<'_> {
    pub(super) fn is_inner(&self) -> bool {
        matches!(self, Self::Split(Step::Node(..)))
    }

    /// Bytes held on the heap, but for those of what is below.
    pub(super) fn heap(&self) -> usize {
        match self {
            Self::Waiting(waiting) => waiting
                .as_ref()
                .map_or(0, |waiting| size_of::<Waiting>() + waiting.items.capacity() * size_of::<Item>()),
            Self::Split(Step::Leaf(indices)) => size_of_val(*indices),
            Self::Split(Step::Node(..)) => size_of::<Sides>(),
        }
    }
}

impl Clone for LazyNode {
    /// A copy of its present state.
    fn clone(&self) -> Self {
        let waiting = self.lock().clone();
        let found = if waiting.is_some() { OnceLock::new() } else { OnceLock::from(self.found().clone()) };
        Self { found, waiting: Mutex::new(waiting) }
    }
}

impl PartialEq for LazyNode {
    /// True if both are in the same state, and so are all below.
    fn eq(&self, other: &Self) -> bool {
        // One lock at a time, as the other node may be the same one.
        let mine = self.lock().clone();
        let is_same = *other.lock() == mine;
        is_same && (mine.is_some() || self.found() == other.found())
    }
}
