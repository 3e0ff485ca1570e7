//! F64x8 boxes side by side.

use super::simd::Simd;
use crate::bvh::NodeBox;

/// What is behind one box of a node: another node, or a leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(transparent)]
pub(super) struct Child(u32);

impl Child {
    /// Nodes, and cache lines of leaves, are numbered by 28 bits.
    pub(super) const LIMIT: usize = 1 << 28;

    pub(super) const fn node(number: u32) -> Self {
        Self(number << 4)
    }

    /// A leaf of 1 to 8 primitives that begins at this cache line.
    pub(super) const fn leaf(line: u32, count: u32) -> Self {
        Self(line << 4 | count)
    }

    /// The number of the node, or of the cache line.
    #[inline(always)]
    pub(super) const fn number(self) -> usize {
        (self.0 >> 4) as usize
    }

    /// Primitives in the leaf; 0 for a node.
    #[inline(always)]
    pub(super) const fn count(self) -> usize {
        (self.0 & 15) as usize
    }

    #[inline(always)]
    pub(super) const fn is_node(self) -> bool {
        self.0 & 15 == 0
    }

    /// What no node has behind it: there is nothing more to visit.
    pub(super) const NONE: Self = Self(15);

    #[inline(always)]
    pub(super) const fn to_bits(self) -> u32 {
        self.0
    }

    #[inline(always)]
    pub(super) const fn from_bits(bits: u32) -> Self {
        Self(bits)
    }
}

/// F64x8 boxes relative to the centre of the tree, rounded outward, and what is behind them. Boxes that nothing is
/// behind are empty, and no ray passes them.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(C, align(64))]
pub(super) struct Node {
    /// By axis and side: lower x, upper x, lower y, ...
    pub(super) planes: [[f32; 8]; 6],
    pub(super) children: [Child; 8],
}

/// Bytes of a row of planes.
const ROW: usize = size_of::<[f32; 8]>();

/// Row of the planes of a [`Node`]: twice the axis, plus 1 for upper planes. Less than 6, as only [`near`](Self::near) makes
/// rows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row(usize);

impl Row {
    /// Rows of the near planes by axis, for a direction whose components have these sign bits.
    #[inline(always)]
    pub(super) const fn near([x, y, z]: [usize; 3]) -> [Self; 3] {
        [Self(x & 1), Self(2 + (y & 1)), Self(4 + (z & 1))]
    }

    /// Row of the planes on the other side, of the same axis.
    #[inline(always)]
    pub(super) const fn opposite(self) -> Self {
        Self(self.0 ^ 1)
    }

    /// Number of the row.
    #[inline(always)]
    pub(super) const fn index(self) -> usize {
        self.0
    }
}

/// A [`Row`] as the offset in bytes at which it begins in a [`Node`].
#[derive(Clone, Copy, Debug)]
pub(super) struct RowOffset(usize);

impl RowOffset {
    /// Offsets of the rows of [`Row::near`].
    #[inline(always)]
    pub(super) const fn near([x, y, z]: [usize; 3]) -> [Self; 3] {
        [Self((x & 1) * ROW), Self(2 * ROW + (y & 1) * ROW), Self(4 * ROW + (z & 1) * ROW)]
    }

    /// See [`Row::opposite`].
    #[inline(always)]
    pub(super) const fn opposite(self) -> Self {
        Self(self.0 ^ ROW)
    }

    /// The row that begins there.
    #[inline(always)]
    pub(super) const fn row(self) -> Row {
        Row(self.0 / ROW)
    }
}

impl Node {
    pub(super) const EMPTY: Self = {
        // Finite, as some formats of files know no other numbers.
        let (low, high) = ([f32::MAX; 8], [f32::MIN; 8]);
        Self { planes: [low, high, low, high, low, high], children: [Child::node(0); 8] }
    };

    /// F64x8 planes.
    #[inline(always)]
    pub(super) fn row<S: Simd>(&self, simd: S, row: Row) -> S::F32x8 {
        debug_assert!(row.0 < 6);
        // SAFETY: a `Row` is less than 6.
        simd.load(unsafe { self.planes.get_unchecked(row.0) })
    }

    /// [`row`](Self::row) that begins at an offset.
    #[inline(always)]
    pub(super) fn row_at<S: Simd>(&self, simd: S, at: RowOffset) -> S::F32x8 {
        debug_assert!(at.0 < size_of_val(&self.planes) && at.0.is_multiple_of(ROW));
        // SAFETY: a `RowOffset` is where one of the six rows begins.
        simd.load(unsafe { &*self.planes.as_ptr().byte_add(at.0) })
    }

    /// One plane of a row, eight times.
    #[inline(always)]
    pub(super) fn plane<S: Simd>(&self, simd: S, row: Row, lane: usize) -> S::F32x8 {
        debug_assert!(row.0 < 6);
        // SAFETY: a `Row` is less than 6.
        simd.splat(unsafe { self.planes.get_unchecked(row.0) }[lane & 7])
    }

    pub(super) fn set(&mut self, lane: usize, bounds: &NodeBox, child: Child) {
        for axis in 0..3 {
            self.planes[2 * axis][lane] = bounds.min[axis];
            self.planes[2 * axis + 1][lane] = bounds.max[axis];
        }
        self.children[lane] = child;
    }

    /// The same node, where nodes are numbered from `first_node` and cache lines from `first_line`.
    pub(super) fn moved(mut self, first_node: usize, first_line: usize) -> Self {
        for child in &mut self.children {
            let first = if child.is_node() { first_node } else { first_line };
            *child = Child(child.0 + ((first as u32) << 4));
        }
        self
    }

    /// The bits of the children.
    #[inline(always)]
    pub(super) fn child_bits(&self) -> &[u32; 8] {
        // SAFETY: a child is a word and nothing else.
        unsafe { &*(&raw const self.children).cast() }
    }

    /// The box of one child, `None` if there is no such child.
    pub(super) fn child_box(&self, lane: usize) -> Option<NodeBox> {
        let side = |side: usize| [0, 1, 2].map(|axis| self.planes[2 * axis + side][lane]).into();
        let (min, max): (glam::Vec3A, glam::Vec3A) = (side(0), side(1));
        min.cmple(max).all().then_some(NodeBox { min, max })
    }

    /// True if lanes without a child are those of an empty node: numbers that are inverted by little, or are no numbers, might
    /// be passed.
    pub(super) fn is_empty_elsewhere(&self) -> bool {
        (0..8).all(|lane| {
            self.child_box(lane).is_some()
                || self.planes.iter().zip(&Self::EMPTY.planes).all(|(row, empty)| row[lane] == empty[lane])
        })
    }

    /// The children that exist, by lane.
    pub(super) fn lanes(&self) -> impl Iterator<Item = (usize, Child)> + use<> {
        let all: [_; 8] = core::array::from_fn(|lane| self.child_box(lane).map(|_| (lane, self.children[lane])));
        all.into_iter().flatten()
    }

    /// The children that exist, with their boxes.
    pub(super) fn children(&self) -> impl Iterator<Item = (NodeBox, Child)> + '_ {
        (0..8).filter_map(|lane| Some((self.child_box(lane)?, self.children[lane])))
    }
}
