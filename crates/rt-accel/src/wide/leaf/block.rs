//! Cache lines of leaves, and the words of one leaf, for writing and for reading.

use super::index_word::IndexWord;
use crate::wide::simd::Simd;

/// Maximum primitives in a leaf.
pub(in crate::wide) const MAX_LEAF: usize = 8;

/// Words in a cache line.
pub(super) const LINE: usize = 16;

/// Cache lines of the largest leaf.
pub(super) const MAX_LINES: usize = 6;

/// Lane of a primitive in its leaf, or of a ray in its packet: less than 8.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::wide) struct Lane(usize);

impl Lane {
    /// Uses the last three bits of a number.
    #[inline(always)]
    pub(in crate::wide) const fn new(number: usize) -> Self {
        Self(number & 7)
    }

    #[inline(always)]
    pub(in crate::wide) const fn index(self) -> usize {
        self.0
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(C, align(64))]
pub(in crate::wide) struct CacheLine([u32; LINE]);

impl CacheLine {
    #[inline(always)]
    pub(super) fn words(lines: &[Self]) -> &[u32] {
        // SAFETY: a line is sixteen words and nothing else.
        unsafe { core::slice::from_raw_parts(lines.as_ptr().cast(), lines.len() * LINE) }
    }

    pub(super) fn words_mut(lines: &mut [Self]) -> &mut [u32] {
        // SAFETY: a line is sixteen words and nothing else, and may hold any.
        unsafe { core::slice::from_raw_parts_mut(lines.as_mut_ptr().cast(), lines.len() * LINE) }
    }
}

/// A leaf under construction.
pub(super) struct LeafMut<'a> {
    pub(super) words: &'a mut [u32],
    pub(super) count: usize,
    pub(super) header: usize,
}

impl LeafMut<'_> {
    pub(super) fn set(&mut self, number: usize, lane: usize, value: f32) {
        self.words[self.header + number * self.count + lane] = value.to_bits();
    }

    pub(super) fn set_header(&mut self, word: usize, value: f32) {
        self.words[word] = value.to_bits();
    }
}

/// A leaf for reading; [`Leaves::contain`] holds for it.
#[derive(Clone, Copy)]
pub(in crate::wide) struct LeafView<'a> {
    pub(super) words: &'a [u32],
    pub(super) first: usize,
    pub(in crate::wide) count: usize,
}

impl LeafView<'_> {
    /// # Safety
    ///
    /// With the header and the numbers of the leaf's kind, `at` must be less than `header + numbers·count + 8`.
    #[inline(always)]
    unsafe fn word(&self, at: usize) -> u32 {
        debug_assert!(self.first + at < self.words.len());
        // SAFETY: `Leaves::contain` holds, and the caller promises the rest.
        unsafe { *self.words.get_unchecked(self.first + at) }
    }

    /// # Safety
    ///
    /// See [`word`](Self::word).
    #[inline(always)]
    pub(in crate::wide) unsafe fn number(&self, at: usize) -> f32 {
        // SAFETY: as the caller promises.
        f32::from_bits(unsafe { self.word(at) })
    }

    /// Index of a primitive.
    ///
    /// # Safety
    ///
    /// See [`word`](Self::word).
    #[inline(always)]
    pub(in crate::wide) unsafe fn index(&self, at: usize) -> u32 {
        // SAFETY: as the caller promises.
        IndexWord(unsafe { self.word(at) }).index()
    }

    /// Eight numbers, the first `count` of which belong to the primitives.
    ///
    /// # Safety
    ///
    /// With the header and the numbers of the leaf's kind, `at` must be at most `header + numbers·count`.
    #[inline(always)]
    pub(in crate::wide) unsafe fn lanes<S: Simd>(&self, simd: S, at: usize) -> S::F32x8 {
        debug_assert!(self.first + at + 8 <= self.words.len());
        // SAFETY: as in `word`; eight words follow, and any word is an `f32`.
        simd.load(unsafe { &*self.words.as_ptr().add(self.first + at).cast() })
    }

    /// A bit for each primitive.
    #[inline(always)]
    pub(in crate::wide) fn mask(&self) -> u32 {
        (1 << self.count) - 1
    }
}
