//! No tree is deeper than a small number, so that a walk needs a stack of fixed size and never allocates.

/// Deepest leaf of any tree; the root has depth 0.
pub(crate) const MAX_DEPTH: u32 = 60;

/// True if halving a set of `count` can still end in single items after an arbitrarily lopsided cut at this depth.
pub(crate) fn leaves_room_for_halving(count: usize, depth: u32) -> bool {
    depth + 1 + count.next_power_of_two().ilog2() <= MAX_DEPTH
}

/// Children that were put off: one at most on every level of a binary tree.
pub(crate) struct Stack<T> {
    entries: [T; STACK],
    len: usize,
}

/// A power of two, so that the remainder is a mask.
const STACK: usize = (MAX_DEPTH as usize).next_power_of_two();

impl<T: Copy> Stack<T> {
    pub(crate) fn new(filler: T) -> Self {
        Self { entries: [filler; STACK], len: 0 }
    }

    /// Pushes the entry if `wanted`, without a branch: which boxes are hit cannot be predicted.
    #[inline(always)]
    pub(crate) fn push_if(&mut self, wanted: bool, entry: T) {
        debug_assert!(self.len < STACK, "the tree is deeper than its builder promises");
        self.entries[self.len % STACK] = entry;
        self.len += usize::from(wanted);
    }

    #[inline(always)]
    pub(crate) fn pop(&mut self) -> Option<T> {
        self.len = self.len.checked_sub(1)?;
        Some(self.entries[self.len % STACK])
    }
}
