//! Subtrees that a bundle of rays may hit.

use core::mem::MaybeUninit;
use core::slice;

use super::WideBvh;
use super::filter::LeafTest;
use super::frustum::BundleFrustum;
use super::node::Child;
use super::simd::{Simd, take_lane};

/// Most entry points.
const CAPACITY: usize = 48;

/// A subtree that rays of a bundle may hit.
#[derive(Clone, Copy)]
pub(super) struct EntryPoint {
    pub(super) child: Child,
    /// Node and lane of its box.
    pub(super) node: u32,
    pub(super) lane: u8,
    /// Primitives of a leaf that rays may hit, a bit for each.
    pub(super) mask: u8,
    /// Earliest entry of any ray.
    pub(super) t_near: f32,
}

/// Disjoint subtrees that rays of a bundle may hit, from the nearest to the farthest.
pub(super) struct EntryPoints {
    /// Only the first `len` are written: most streams have no bundle, and clearing all takes longer than a node.
    subtrees: [MaybeUninit<EntryPoint>; CAPACITY],
    len: usize,
}

impl EntryPoints {
    /// No subtrees.
    #[inline(always)]
    pub(super) const fn new() -> Self {
        Self { subtrees: [const { MaybeUninit::uninit() }; CAPACITY], len: 0 }
    }

    #[inline(always)]
    pub(super) fn subtrees(&self) -> &[EntryPoint] {
        // SAFETY: the first `len` entries are within the array, and written.
        unsafe { slice::from_raw_parts(self.subtrees.as_ptr().cast(), self.len) }
    }

    /// Finds the subtrees that the frustum hits, as deep as the capacity allows. Returns the number of nodes visited.
    #[inline(always)]
    pub(super) fn build<S: Simd, F: LeafTest>(&mut self, simd: S, tree: &WideBvh, frustum: &BundleFrustum<S>) -> u64 {
        self.len = 0;
        self.expand::<S, F>(simd, tree, frustum, tree.root);
        let mut n_nodes = 1;
        let mut at = 0;
        // Breadth-first, so that subtrees that do not fit are small.
        while let Some(&EntryPoint { child, .. }) = self.subtrees().get(at) {
            if !child.is_node() || self.len + 7 > CAPACITY {
                at += 1;
                continue;
            }
            self.len -= 1;
            self.subtrees.copy_within(at + 1..=self.len, at);
            self.expand::<S, F>(simd, tree, frustum, child);
            n_nodes += 1;
        }
        // SAFETY: the first `len` entries are within the array, and written.
        let subtrees: &mut [EntryPoint] =
            unsafe { slice::from_raw_parts_mut(self.subtrees.as_mut_ptr().cast(), self.len) };
        sort_by_distance(subtrees);
        n_nodes
    }

    /// Adds the children of a node that the frustum hits.
    #[inline(always)]
    fn expand<S: Simd, F: LeafTest>(&mut self, simd: S, tree: &WideBvh, frustum: &BundleFrustum<S>, parent: Child) {
        let Some(node) = tree.nodes.get(parent.number()) else { return };
        let (mut hit, enter) = frustum.intersect_boxes(simd, |row| node.row(simd, row));
        let enters = simd.to_array(enter);
        while hit != 0 {
            let lane = take_lane(&mut hit);
            let child = node.children[lane];
            let mask = if child.is_node() {
                0
            } else {
                // SAFETY: a child of a node of the tree that is not a node itself.
                let leaf = unsafe { tree.leaves.view(child) };
                F::cull_by_frustum(simd, frustum, leaf)
            };
            if (child.is_node() || mask != 0)
                && let Some(subtree) = self.subtrees.get_mut(self.len)
            {
                let (node, lane, mask) = (parent.number() as u32, lane as u8, mask as u8);
                subtree.write(EntryPoint { child, node, lane, mask, t_near: enters[lane as usize] });
                self.len += 1;
            }
        }
    }
}

/// It is not generic, so that the sort is compiled once.
fn sort_by_distance(subtrees: &mut [EntryPoint]) {
    subtrees.sort_unstable_by(|a, b| a.t_near.total_cmp(&b.t_near));
}
