//! The tree.

use core::hint::select_unpredictable;

use rt_math::DVec3;

use super::leaf::{CacheLine, Leaves};
use super::node::{Child, WideNode};
use super::simd::{DetectedSimd, SimdLevel};
use super::triangle_list::{MAX_TRIANGLES, TriangleList};

/// Bounding volume hierarchy with eight children per node: the fastest accelerator for all kinds of primitives.
///
/// Conservative filters test eight boxes at a time in `f32`, and eight triangles, spheres or boxes of a leaf
/// ([`PrimitiveGeometry`](rt_geometry::PrimitiveGeometry)). Exact tests in `f64` follow, so that results are bit-identical
/// to brute force. Filters use AVX-512, AVX2 or portable instructions ([`SimdLevel`]), with the same results.
///
/// Wald, Benthin and Boulos, "Getting Rid of Packets", 2008; Ernst and Greiner, "Multi Bounding Volume Hierarchies", 2008.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(remote = "Self"))]
pub struct WideBvh {
    /// The root is the first; all others come after their parents.
    pub(super) nodes: Vec<WideNode>,
    pub(super) leaves: Leaves,
    pub(super) root: Child,
    /// World position of the local origin.
    pub(super) centre: DVec3,
    /// Maximum coordinate relative to the centre.
    pub(super) size: f64,
    pub(super) unbounded: Vec<u32>,
    /// All primitives of a small tree, for streams.
    pub(super) list: Option<TriangleList>,
    /// Number of bounded primitives.
    pub(super) bounded: u32,
    pub(super) n_leaves: usize,
    pub(super) max_depth: u32,
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(super) level: DetectedSimd,
}

impl WideBvh {
    /// Maximum number of triangles of a tree that keeps a list of them, some 200 bytes each. Streams test incoherent rays with the whole
    /// list.
    pub const LIST_CAPACITY: usize = MAX_TRIANGLES;

    /// Instruction set of traversal.
    pub const fn level(&self) -> SimdLevel {
        self.level.level()
    }

    /// Bytes of the tree, on the heap and inline.
    pub(super) fn total_bytes(&self) -> usize {
        size_of::<Self>()
            + self.nodes.capacity() * size_of::<WideNode>()
            + self.leaves.memory()
            + self.unbounded.capacity() * size_of::<u32>()
            + self.list.as_ref().map_or(0, TriangleList::memory)
    }

    /// # Safety
    ///
    /// The child must be a node, and the root or a child of a node of this tree.
    #[inline(always)]
    pub(super) unsafe fn node(&self, child: Child) -> &WideNode {
        debug_assert!(child.is_node() && child.number() < self.nodes.len(), "checked by builders and loaders");
        // SAFETY: as the caller promises; builders and loaders have checked the children of nodes.
        unsafe { self.nodes.get_unchecked(child.number()) }
    }

    /// Memory location of a child.
    #[inline(always)]
    pub(super) fn line(&self, child: Child) -> *const CacheLine {
        let node = self.nodes.as_ptr().wrapping_add(child.number()).cast();
        select_unpredictable(child.is_node(), node, self.leaves.line(child))
    }
}
