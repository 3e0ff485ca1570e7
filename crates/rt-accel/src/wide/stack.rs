//! What a walk has put off, in memory that is not cleared first: clearing it would take as long as a few nodes.

use core::mem::MaybeUninit;

use super::STACK;
use super::node::Child;

/// Children that were put off, with the `t` at which their boxes are entered.
pub(super) struct Stack {
    entries: [MaybeUninit<u64>; STACK],
    pub(super) len: usize,
}

impl Stack {
    #[inline(always)]
    pub(super) const fn new() -> Self {
        Self { entries: [const { MaybeUninit::uninit() }; STACK], len: 0 }
    }

    /// The sort key of a child: numbers that are not negative compare as their bits do.
    #[inline(always)]
    pub(super) fn key(enter: f32, child: Child) -> u64 {
        u64::from(enter.to_bits()) << 32 | u64::from(child.to_bits())
    }

    #[inline(always)]
    pub(super) fn put(&mut self, at: usize, key: u64) {
        debug_assert!(at < STACK, "the tree is deeper than its builder promises");
        // SAFETY: nodes put off seven children at most, and no tree is deeper than a seventh of the stack.
        unsafe { self.entries.get_unchecked_mut(at).write(key) };
    }

    #[inline(always)]
    pub(super) fn get(&self, at: usize) -> u64 {
        debug_assert!(at <= self.len);
        // SAFETY: entries below `len` have been written, and so has the one that was popped last.
        unsafe { self.entries.get_unchecked(at).assume_init() }
    }

    #[inline(always)]
    pub(super) fn push(&mut self, key: u64) {
        self.put(self.len, key);
        self.len += 1;
    }

    /// The child put off last that is entered at or before `limit`.
    #[inline(always)]
    pub(super) fn pop(&mut self, limit: f32) -> Option<Child> {
        while self.len > 0 {
            self.len -= 1;
            let key = self.get(self.len);
            if f32::from_bits((key >> 32) as u32) <= limit {
                return Some(Child::from_bits(key as u32));
            }
        }
        None
    }

    /// Inserts a key into those since `first`, which fall towards the end, so that the nearest is popped first.
    #[inline(always)]
    pub(super) fn insert(&mut self, first: usize, key: u64) {
        let mut place = self.len;
        self.push(key);
        while place > first && self.get(place - 1) < key {
            let moved = self.get(place - 1);
            self.put(place, moved);
            place -= 1;
        }
        self.put(place, key);
    }
}
