//! Depth-first traversal of binary trees, the nearer child first.

use core::ops::ControlFlow;

use rt_math::Aabb;

/// Maximum depth of a leaf in any tree; the root has depth 0. Bounds the traversal stack.
pub(crate) const MAX_DEPTH: u32 = 60;

/// True if median splits can still reduce `count` primitives to single ones after a lopsided split at this depth.
pub(crate) fn depth_allows_median_split(count: usize, depth: u32) -> bool {
    depth + 1 + count.next_power_of_two().ilog2() <= MAX_DEPTH
}

/// Deferred nodes: at most one per level of a binary tree.
struct TraversalStack<T> {
    entries: [T; CAPACITY],
    len: usize,
}

/// A power of two, so that the remainder is a mask.
const CAPACITY: usize = (MAX_DEPTH as usize).next_power_of_two();

impl<T: Copy> TraversalStack<T> {
    fn new(filler: T) -> Self {
        Self { entries: [filler; CAPACITY], len: 0 }
    }

    /// Pushes the entry if `is_wanted` is true. Branch-free, because the outcome is unpredictable.
    #[inline(always)]
    fn push_if(&mut self, is_wanted: bool, entry: T) {
        debug_assert!(self.len < CAPACITY, "the tree is deeper than its builder promises");
        self.entries[self.len % CAPACITY] = entry;
        self.len += usize::from(is_wanted);
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<T> {
        self.len = self.len.checked_sub(1)?;
        Some(self.entries[self.len % CAPACITY])
    }
}

/// Order in which the children of a node are visited.
pub(crate) struct Descent<E> {
    pub(crate) next: E,
    /// Visited later, if `is_deferred`.
    pub(crate) deferred: E,
    pub(crate) is_deferred: bool,
}

impl<E: Copy> Descent<E> {
    /// The child of the smaller key first, the left one on a tie. `None` as a key culls the child.
    #[inline(always)]
    pub(crate) fn by_key(keys: [Option<f64>; 2], children: [E; 2]) -> Option<Self> {
        let near = match keys {
            [Some(left), Some(right)] => usize::from(right < left),
            [Some(_), None] => 0,
            [None, Some(_)] => 1,
            [None, None] => return None,
        };
        Some(Self { next: children[near], deferred: children[near ^ 1], is_deferred: keys[near ^ 1].is_some() })
    }

    /// `near` before `far`, each unless it is culled.
    #[inline(always)]
    pub(crate) fn in_order(near: E, visits_near: bool, far: E, visits_far: bool) -> Option<Self> {
        if visits_near {
            Some(Self { next: near, deferred: far, is_deferred: visits_far })
        } else {
            visits_far.then_some(Self { next: far, deferred: far, is_deferred: false })
        }
    }
}

/// Visits nodes depth first from `root`. `visit` tests a leaf, or orders the children of a node; its `Break` ends the
/// traversal. `revisit` culls a deferred entry, or narrows it to the state of the query.
#[inline(always)]
pub(crate) fn traverse<Q, E: Copy>(
    query: &mut Q,
    root: E,
    mut visit: impl FnMut(&mut Q, E) -> ControlFlow<(), Option<Descent<E>>>,
    revisit: impl Fn(&Q, E) -> Option<E>,
) -> ControlFlow<()> {
    let mut stack = TraversalStack::new(root);
    let mut entry = root;
    loop {
        if let Some(Descent { next, deferred, is_deferred }) = visit(query, entry)? {
            stack.push_if(is_deferred, deferred);
            entry = next;
            continue;
        }
        entry = loop {
            let Some(deferred) = stack.pop() else { return ControlFlow::Continue(()) };
            if let Some(entry) = revisit(query, deferred) {
                break entry;
            }
        };
    }
}

/// Node with its bounds.
pub(crate) type Bounded<N> = (N, Aabb);

/// Visits nodes by rising distance of their bounds. `visit` tests a leaf, or returns the children of a node;
/// `distance` culls bounds by `None`.
pub(crate) fn traverse_by_distance<Q, N: Copy>(
    query: &mut Q,
    root: Bounded<N>,
    mut visit: impl FnMut(&mut Q, Bounded<N>) -> ControlFlow<(), Option<[Bounded<N>; 2]>>,
    distance: impl Fn(&Q, &Aabb) -> Option<f64>,
) -> ControlFlow<()> {
    traverse(
        query,
        root,
        |query, entry| {
            let children = visit(query, entry)?;
            ControlFlow::Continue(
                children.and_then(|pair| Descent::by_key(pair.map(|(_, aabb)| distance(query, &aabb)), pair)),
            )
        },
        |query, entry| distance(query, &entry.1).is_some().then_some(entry),
    )
}
