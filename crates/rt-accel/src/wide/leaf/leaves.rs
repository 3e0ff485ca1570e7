//! All leaves of a tree, and the copies of primitives in them.

use core::ops::Deref;

use glam::DVec3;
use rt_geometry::{Primitives, padded_bounds};

use super::block::{CacheLine, LINE, LeafMut, LeafView, MAX_LEAF, MAX_LINES};
use super::index_word::IndexWord;
use super::kind::LeafKind;
use super::{boxes, spheres, triangles};
use crate::{bvh::Aabb32, wide::huge_pages::filled, wide::node::Child};

/// Primitives of consecutive leaves.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::wide) struct LeafOrder {
    /// Primitives, leaf by leaf.
    pub(in crate::wide) order: Vec<u32>,
    /// Primitives of each leaf, from 1 to 8.
    pub(in crate::wide) sizes: Vec<u8>,
    /// Total cache lines.
    pub(in crate::wide) n_lines: usize,
}

impl LeafOrder {
    /// Ends a leaf that begins at primitive `first`.
    pub(in crate::wide) fn close(&mut self, first: usize, kind: LeafKind) -> Child {
        let count = self.order.len() - first;
        let leaf = Child::leaf(self.n_lines as u32, count as u32);
        self.sizes.push(count as u8);
        self.n_lines += kind.lines(count);
        leaf
    }

    /// Primitives of each leaf.
    pub(in crate::wide) fn leaves(&self) -> impl Iterator<Item = &[u32]> {
        let mut rest = &self.order[..];
        self.sizes.iter().map(move |&size| {
            let (leaf, others) = rest.split_at(usize::from(size));
            rest = others;
            leaf
        })
    }
}

/// Copies primitives into leaves.
pub(in crate::wide) struct LeafWriter<'a, P> {
    pub(in crate::wide) primitives: &'a P,
    /// Centre of the tree.
    pub(in crate::wide) centre: DVec3,
    pub(in crate::wide) kind: LeafKind,
}

impl<P: Primitives> LeafWriter<'_, P> {
    /// Padded bounds relative to the centre.
    pub(in crate::wide) fn own(&self, index: u32) -> Aabb32 {
        padded_bounds(self.primitives, index).map_or(Aabb32::EMPTY, |own| Aabb32::enclosing(&own, self.centre))
    }

    /// Fills a leaf of 1 to 8 primitives at the start of cleared lines; returns its number of lines.
    fn fill(&self, indices: &[u32], lines: &mut [CacheLine]) -> usize {
        let (header, numbers) = self.kind.shape();
        let count = indices.len();
        let n_lines = self.kind.lines(count);
        let words = CacheLine::words_mut(&mut lines[..n_lines]);
        for (word, &index) in words[header + numbers * count..].iter_mut().zip(indices) {
            *word = IndexWord::new(index).0;
        }
        let mut block = LeafMut { words, count, header };
        match self.kind {
            LeafKind::Watertight => triangles::fill(&mut block, self.primitives, indices, None),
            LeafKind::Triangles => triangles::fill(&mut block, self.primitives, indices, Some(self.centre)),
            LeafKind::Spheres => spheres::fill(&mut block, self.primitives, indices, self.centre),
            LeafKind::Boxes => boxes::fill(&mut block, indices, |index| self.own(index)),
        }
        n_lines
    }
}

/// Indices of the primitives of a leaf.
#[derive(Default)]
pub(in crate::wide) struct LeafIndices {
    indices: [u32; MAX_LEAF],
    count: usize,
}

impl LeafIndices {
    /// The first eight words.
    fn new(words: &[u32]) -> Self {
        let mut all = Self::default();
        for (index, &word) in all.indices.iter_mut().zip(words) {
            *index = IndexWord(word).index();
            all.count += 1;
        }
        all
    }
}

impl Deref for LeafIndices {
    type Target = [u32];

    fn deref(&self) -> &[u32] {
        &self.indices[..self.count]
    }
}

/// All leaves of a tree.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::wide) struct Leaves {
    pub(in crate::wide) kind: LeafKind,
    lines: Vec<CacheLine>,
}

impl Leaves {
    pub(in crate::wide) fn new<P: Primitives>(filling: &LeafWriter<'_, P>, listings: &[LeafOrder]) -> Self {
        // Loads of eight numbers extend beyond the last leaf.
        const SPARE: usize = MAX_LEAF.div_ceil(LINE);
        let nothing = LeafOrder::default();
        let mut parts: Vec<_> = listings.iter().map(|listing| (listing.n_lines, listing)).collect();
        parts.push((SPARE, &nothing));
        let lines = filled(parts, CacheLine::default(), |listing, mut lines| {
            for indices in listing.leaves() {
                let n_lines = filling.fill(indices, lines);
                lines = &mut lines[n_lines..];
            }
        });
        Self { kind: filling.kind, lines }
    }

    /// True if the leaf equals a copy of its primitives.
    pub(in crate::wide) fn fits<P: Primitives>(&self, leaf: Child, filling: &LeafWriter<'_, P>) -> bool {
        let mut anew = [CacheLine::default(); MAX_LINES];
        let n_lines = filling.fill(&self.indices(leaf), &mut anew);
        self.lines[leaf.number()..].starts_with(&anew[..n_lines])
    }

    /// Copies the primitives of a leaf again.
    pub(in crate::wide) fn refill<P: Primitives>(&mut self, leaf: Child, filling: &LeafWriter<'_, P>) {
        let mut anew = [CacheLine::default(); MAX_LINES];
        let n_lines = filling.fill(&self.indices(leaf), &mut anew);
        self.lines[leaf.number()..][..n_lines].copy_from_slice(&anew[..n_lines]);
    }

    pub(in crate::wide) fn memory(&self) -> usize {
        self.lines.capacity() * size_of::<CacheLine>()
    }

    /// Primitives of a leaf that lies within the lines.
    #[inline]
    pub(in crate::wide) fn indices(&self, leaf: Child) -> LeafIndices {
        let (header, numbers) = self.kind.shape();
        let first = leaf.number() * LINE + header + numbers * leaf.count();
        LeafIndices::new(self.words().get(first..first + leaf.count()).unwrap_or(&[]))
    }

    /// True if all words that filters read of the leaf exist.
    pub(in crate::wide) fn contain(&self, leaf: Child) -> bool {
        lines_contain(self.lines.len(), self.kind, leaf)
    }

    /// Upper bound of primitives in all leaves.
    pub(in crate::wide) const fn most_primitives(&self) -> u64 {
        self.lines.len() as u64 * LINE as u64
    }

    #[inline(always)]
    fn words(&self) -> &[u32] {
        CacheLine::words(&self.lines)
    }

    /// Address of a leaf.
    #[inline(always)]
    pub(in crate::wide) fn line(&self, leaf: Child) -> *const CacheLine {
        self.lines.as_ptr().wrapping_add(leaf.number())
    }

    /// # Safety
    ///
    /// [`contain`](Self::contain) must be true of the leaf, as builders and loaders check.
    #[inline(always)]
    pub(in crate::wide) unsafe fn view(&self, leaf: Child) -> LeafView<'_> {
        debug_assert!(self.contain(leaf), "leaves are checked when they are made and when they are loaded");
        LeafView { words: self.words(), first: leaf.number() * LINE, count: leaf.count() }
    }
}

/// True if all words that filters read of a leaf exist: eight from any number on.
///
/// The end is computed with 64 bits. It would wrap with 32, as a line has 16 words and its index 28 bits.
fn lines_contain(n_lines: usize, kind: LeafKind, leaf: Child) -> bool {
    let (header, numbers) = kind.shape();
    let words = header + numbers * leaf.count() + MAX_LEAF;
    let end = leaf.number() as u64 * LINE as u64 + words as u64;
    (1..=MAX_LEAF).contains(&leaf.count()) && end <= n_lines as u64 * LINE as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On 32 bits the end of such a leaf wrapped, so that a saved tree passed validation and was read out of bounds.
    #[test]
    fn a_leaf_whose_end_wraps_at_32_bits_is_not_contained() {
        for kind in [LeafKind::Watertight, LeafKind::Triangles, LeafKind::Spheres, LeafKind::Boxes] {
            for count in 1..=MAX_LEAF {
                let (header, numbers) = kind.shape();
                let last = Child::leaf(Child::LIMIT as u32 - 1, count as u32);
                let words = header + numbers * count + MAX_LEAF;
                let wrapped = (last.number() as u32).wrapping_mul(LINE as u32).wrapping_add(words as u32);
                // A leaf of less than a line does not reach 2³².
                assert_eq!(wrapped < 1000, words >= LINE, "{kind:?} of {count}: {wrapped}");
                assert!(!lines_contain(1000, kind, last), "{kind:?} of {count}");
                assert!(lines_contain(Child::LIMIT + MAX_LINES, kind, last), "{kind:?} of {count}: it is there");
            }
        }
    }
}
