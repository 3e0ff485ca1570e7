//! Traversal stack in uninitialised memory: clearing it would take as long as several nodes.

use core::mem::MaybeUninit;

use super::node::Child;
use crate::traversal::MAX_DEPTH;

/// Entries of a traversal stack: seven deferred children on every level, and one to spare.
pub(super) const STACK: usize = 7 * MAX_DEPTH as usize + 8;

/// Memory of a stack, reused from ray to ray.
pub(super) struct StackStorage([MaybeUninit<u64>; STACK]);

impl StackStorage {
    #[inline(always)]
    pub(super) const fn new() -> Self {
        Self([const { MaybeUninit::uninit() }; STACK])
    }
}

/// Deferred children with the `t` at entry. Separate from its memory, so that the length stays in a register.
pub(super) struct ChildStack<'r> {
    entries: &'r mut [MaybeUninit<u64>; STACK],
    /// Entries below it are written.
    len: usize,
}

impl<'r> ChildStack<'r> {
    #[inline(always)]
    pub(super) const fn new(storage: &'r mut StackStorage) -> Self {
        Self { entries: &mut storage.0, len: 0 }
    }

    /// Sort key of a child: bits of non-negative numbers compare as the numbers do.
    #[inline(always)]
    pub(super) fn key(enter: f32, child: Child) -> u64 {
        u64::from(enter.to_bits()) << 32 | u64::from(child.to_bits())
    }

    #[inline(always)]
    pub(super) const fn len(&self) -> usize {
        self.len
    }

    /// # Safety
    ///
    /// All entries below `len` must be written.
    #[inline(always)]
    pub(super) const unsafe fn set_len(&mut self, len: usize) {
        self.len = len;
    }

    /// Writes an entry.
    ///
    /// # Safety
    ///
    /// `at` must be less than [`STACK`]. This holds while each node pushes at most seven children, as no tree is deeper
    /// than a seventh of the stack.
    #[inline(always)]
    pub(super) unsafe fn put(&mut self, at: usize, key: u64) {
        debug_assert!(at < STACK, "the tree is deeper than its builder promises");
        // SAFETY: as the caller promises.
        unsafe { self.entries.get_unchecked_mut(at).write(key) };
    }

    /// Reads an entry.
    ///
    /// # Safety
    ///
    /// `at` must be less than the number of entries, or that of the entry popped last.
    #[inline(always)]
    pub(super) unsafe fn get(&self, at: usize) -> u64 {
        debug_assert!(at <= self.len);
        // SAFETY: entries below `len` have been written, and so has the one that was popped last.
        unsafe { self.entries.get_unchecked(at).assume_init() }
    }

    /// # Safety
    ///
    /// There must be fewer entries than [`STACK`], as for [`put`](Self::put).
    #[inline(always)]
    pub(super) unsafe fn push(&mut self, key: u64) {
        // SAFETY: as the caller promises.
        unsafe { self.put(self.len, key) };
        self.len += 1;
    }

    #[inline(always)]
    pub(super) fn pop(&mut self) -> Option<Child> {
        self.len = self.len.checked_sub(1)?;
        // SAFETY: the entry popped just now.
        Some(Child::from_bits(unsafe { self.get(self.len) } as u32))
    }

    /// Pops the last child that is entered at or before `t_max`.
    #[inline(always)]
    pub(super) fn pop_before(&mut self, t_max: f32) -> Option<Child> {
        while self.len > 0 {
            self.len -= 1;
            // SAFETY: the entry popped just now.
            let key = unsafe { self.get(self.len) };
            if f32::from_bits((key >> 32) as u32) <= t_max {
                return Some(Child::from_bits(key as u32));
            }
        }
        None
    }

    /// Inserts a key into the descending ones from `first` on, so that the nearest is popped first.
    ///
    /// # Safety
    ///
    /// See [`push`](Self::push).
    #[inline(always)]
    pub(super) unsafe fn insert(&mut self, first: usize, key: u64) {
        let mut place = self.len;
        // SAFETY: there is space, as the caller promises; all positions are less than `len`.
        unsafe {
            self.push(key);
            while place > first && self.get(place - 1) < key {
                let moved = self.get(place - 1);
                self.put(place, moved);
                place -= 1;
            }
            self.put(place, key);
        }
    }
}
