//! Nodes of eight boxes.

use super::simd::Simd;
use crate::bvh::Aabb32;

/// Child of a node: another node, or a leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(transparent)]
pub(super) struct Child(u32);

impl Child {
    /// Limit of the 28-bit indices of nodes and cache lines.
    pub(super) const LIMIT: usize = 1 << 28;

    pub(super) const fn node(number: u32) -> Self {
        Self(number << 4)
    }

    /// A leaf of 1 to 8 primitives that begins at this cache line.
    pub(super) const fn leaf(line: u32, count: u32) -> Self {
        Self(line << 4 | count)
    }

    /// Index of the node, or of the cache line.
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

    /// Ends a traversal: no node has this child.
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

/// Eight boxes relative to the centre of the tree, rounded outward, and their children. Boxes without a child are
/// empty, and no ray hits them.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(C, align(64))]
pub(super) struct WideNode {
    /// By axis and side: lower x, upper x, lower y, ...
    pub(super) planes: [[f32; 8]; 6],
    pub(super) children: [Child; 8],
}

/// Bytes of a row of planes.
const ROW: usize = size_of::<[f32; 8]>();

/// Byte offset of a row of planes in a [`WideNode`]. Only [`near`](Self::near) creates rows, so it is that of one of six.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row(usize);

impl Row {
    /// Rows of the near planes by axis, for a direction with these sign bits.
    #[inline(always)]
    pub(super) const fn near([x, y, z]: [usize; 3]) -> [Self; 3] {
        [Self((x & 1) * ROW), Self(2 * ROW + (y & 1) * ROW), Self(4 * ROW + (z & 1) * ROW)]
    }

    /// Row of the opposite planes of the same axis.
    #[inline(always)]
    pub(super) const fn opposite(self) -> Self {
        Self(self.0 ^ ROW)
    }

    /// Twice the axis, plus 1 for upper planes.
    #[inline(always)]
    pub(super) const fn index(self) -> usize {
        self.0 / ROW
    }
}

impl WideNode {
    pub(super) const EMPTY: Self = {
        // Finite, as some file formats have no infinity.
        let (low, high) = ([f32::MAX; 8], [f32::MIN; 8]);
        Self { planes: [low, high, low, high, low, high], children: [Child::node(0); 8] }
    };

    #[inline(always)]
    pub(super) fn row<S: Simd>(&self, simd: S, row: Row) -> S::F32x8 {
        debug_assert!(row.0 < size_of_val(&self.planes) && row.0.is_multiple_of(ROW));
        // SAFETY: a `Row` is the offset of one of the six rows.
        simd.load(unsafe { &*self.planes.as_ptr().byte_add(row.0) })
    }

    /// One plane of a row in all lanes.
    #[inline(always)]
    pub(super) fn plane<S: Simd>(&self, simd: S, row: Row, lane: usize) -> S::F32x8 {
        debug_assert!(row.0 < size_of_val(&self.planes) && row.0.is_multiple_of(ROW));
        // SAFETY: a `Row` is the offset of one of the six rows.
        let planes = unsafe { &*self.planes.as_ptr().byte_add(row.0) };
        simd.splat(planes[lane & 7])
    }

    pub(super) fn set(&mut self, lane: usize, bounds: &Aabb32, child: Child) {
        for axis in 0..3 {
            self.planes[2 * axis][lane] = bounds.min[axis];
            self.planes[2 * axis + 1][lane] = bounds.max[axis];
        }
        self.children[lane] = child;
    }

    /// Shifts the indices of child nodes by `first_node`, and of leaves by `first_line`.
    pub(super) fn moved(mut self, first_node: usize, first_line: usize) -> Self {
        for child in &mut self.children {
            let first = if child.is_node() { first_node } else { first_line };
            *child = Child(child.0 + ((first as u32) << 4));
        }
        self
    }

    #[inline(always)]
    pub(super) fn child_bits(&self) -> &[u32; 8] {
        // SAFETY: a child is a word and nothing else.
        unsafe { &*(&raw const self.children).cast() }
    }

    /// Box of a child; `None` for an empty lane.
    pub(super) fn child_box(&self, lane: usize) -> Option<Aabb32> {
        let side = |side: usize| [0, 1, 2].map(|axis| self.planes[2 * axis + side][lane]).into();
        let (min, max): (glam::Vec3A, glam::Vec3A) = (side(0), side(1));
        min.cmple(max).all().then_some(Aabb32 { min, max })
    }

    /// True if lanes without a child equal those of an empty node. Boxes that are slightly inverted or NaN might be
    /// hit.
    pub(super) fn is_empty_elsewhere(&self) -> bool {
        (0..8).all(|lane| {
            self.child_box(lane).is_some()
                || self.planes.iter().zip(&Self::EMPTY.planes).all(|(row, empty)| row[lane] == empty[lane])
        })
    }

    /// Children by lane.
    pub(super) fn lanes(&self) -> impl Iterator<Item = (usize, Child)> + use<> {
        let all: [_; 8] = core::array::from_fn(|lane| self.child_box(lane).map(|_| (lane, self.children[lane])));
        all.into_iter().flatten()
    }

    /// Children with their boxes.
    pub(super) fn children(&self) -> impl Iterator<Item = (Aabb32, Child)> + '_ {
        (0..8).filter_map(|lane| Some((self.child_box(lane)?, self.children[lane])))
    }
}
