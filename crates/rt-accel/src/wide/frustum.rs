//! Many rays that go the same way, as one: a shaft that contains them all, and the few subtrees that it can meet.
//!
//! # Why nothing is lost
//!
//! Let `q` be the origin of a ray relative to the centre of the tree and `v = 1/d` on some axis; take `v > 0`, as for
//! `v < 0` all signs turn around. The shaft computes `fl((p − Q)·n)` for near planes `p`, where `Q` is at least 2⁻²² sizes
//! of the tree beyond all `q`, and `n` at most the least of all `v`, made smaller by 2⁻²². Where `p − q` is positive this is
//! no more than `τ·(1 − 2⁻²²)·(1 + 2⁻²⁴)³`, less than what an own box computes ([`ray`](super::ray)); where it is not, the
//! product is negative, and spans begin at 0 or later. Far planes are the mirror image. Directions that are nearly zero
//! are limited as those of single rays are, and times of leaving are long enough for the same reason.
//!
//! Reshetov, Soupikov and Hurley, "Multi-Level Ray Tracing Algorithm", 2005, and Wald, Boulos and Shirley, "Ray Tracing
//! Deformable Scenes using Dynamic Bounding Volume Hierarchies", 2007, find entry points and cull by intervals.

use rt_math::{Aabb, DVec3, Interval, Ray};

use super::WideBvh;
use super::leaf::LeafTest;
use super::node::{Child, Row};
use super::packet_rays::signs;
use super::query::take_lane;
use super::ray::{FARTHEST, RANGE, SLACK, STEEPEST, round_down, round_up};
use super::simd::Simd;
use crate::bvh::NodeBox;

/// Own boxes are wider than primitives by less than this part of how far the centre of the tree is from the origin.
const OF_OFFSET: f32 = 1.0 / (1u64 << 38) as f32;

/// Most subtrees of a cut.
const CAPACITY: usize = 48;

/// A part of space that contains all rays of a bundle, which pass boxes through the same sides.
pub(super) struct BundleFrustum<S: Simd> {
    near_origin: [S::F32x8; 3],
    near_scale: [S::F32x8; 3],
    far_origin: [S::F32x8; 3],
    far_scale: [S::F32x8; 3],
    near_row: [Row; 3],
    min: S::F32x8,
    max: S::F32x8,
    /// Greatest coordinate of the centre of the tree, or more.
    offset: f32,
}

impl<S: Simd> BundleFrustum<S> {
    /// Around rays of the same [`signs`]. Filters are proven for each by itself, and those for which they are not may be
    /// left out. `None` if the rays are out of proportion.
    #[inline(always)]
    pub(super) fn around(simd: S, tree: &WideBvh, rays: &[(Ray, Interval)]) -> Option<Self> {
        let (first, _) = rays.first()?;
        let signs = signs(first.direction);
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (mut slowest, mut fastest) = (DVec3::INFINITY, DVec3::ZERO);
        let (mut begin, mut end) = (f64::INFINITY, 0.0f64);
        let mut nothing = DVec3::ZERO;
        for (ray, span) in rays {
            let speed = ray.direction.abs();
            (low, high) = (low.min(ray.origin), high.max(ray.origin));
            (slowest, fastest) = (slowest.min(speed), fastest.max(speed));
            (begin, end) = (begin.min(span.min), end.max(span.max));
            // What is not finite makes a NaN of this.
            nothing += (ray.origin + ray.direction) * 0.0;
        }
        let (low, high) = (low - tree.centre, high - tree.centre);
        let filter_applies = RANGE.contains(&fastest.max_element())
            & RANGE.contains(&slowest.max_element())
            & RANGE.contains(&tree.size)
            & (low.abs().max(high.abs()).max_element() <= FARTHEST * tree.size)
            & (begin >= 0.0)
            & (nothing == DVec3::ZERO);
        if !filter_applies {
            return None;
        }
        let pad = DVec3::splat(tree.size * SLACK);
        let outline = NodeBox::outward(&Aabb::new(low - pad, high + pad), DVec3::ZERO);
        let least = fastest.max(DVec3::splat(fastest.max_element() / STEEPEST)).recip() * (1.0 - SLACK);
        let greatest = slowest.max(DVec3::splat(slowest.max_element() / STEEPEST)).recip() * (1.0 + SLACK);
        let mut this = Self {
            near_origin: [simd.splat(0.0); 3],
            near_scale: [simd.splat(0.0); 3],
            far_origin: [simd.splat(0.0); 3],
            far_scale: [simd.splat(0.0); 3],
            near_row: Row::near([0, 1, 2].map(|axis| (signs >> axis & 1) as usize)),
            min: simd.splat(round_down(begin)),
            max: simd.splat(round_up(end)),
            offset: round_up(tree.centre.abs().max_element()),
        };
        for axis in 0..3 {
            let is_negative = signs >> axis & 1 != 0;
            let (low, high) = (outline.min[axis], outline.max[axis]);
            let (near, far, sign) = if is_negative { (low, high, -1.0) } else { (high, low, 1.0) };
            this.near_origin[axis] = simd.splat(near);
            this.far_origin[axis] = simd.splat(far);
            this.near_scale[axis] = simd.splat((sign * least[axis]) as f32);
            this.far_scale[axis] = simd.splat((sign * greatest[axis]) as f32);
        }
        Some(this)
    }

    /// By how much boxes around what a leaf holds are widened, so that they contain the own boxes; `greatest` is the
    /// greatest number of which they are made.
    #[inline(always)]
    pub(super) fn margin(&self, greatest: f32) -> f32 {
        greatest * SLACK as f32 + self.offset * OF_OFFSET
    }

    #[inline(always)]
    fn near(&self, simd: S, axis: usize, planes: S::F32x8) -> S::F32x8 {
        simd.mul(simd.sub(planes, self.near_origin[axis]), self.near_scale[axis])
    }

    #[inline(always)]
    fn far(&self, simd: S, axis: usize, planes: S::F32x8) -> S::F32x8 {
        simd.mul(simd.sub(planes, self.far_origin[axis]), self.far_scale[axis])
    }

    /// A bit for each of eight boxes that rays may pass, and where they enter these first; `planes` returns a row.
    #[inline(always)]
    pub(super) fn passes(&self, simd: S, planes: impl Fn(Row) -> S::F32x8) -> (u32, S::F32x8) {
        let [x, y, z] = self.near_row;
        let (enter_x, leave_x) = (self.near(simd, 0, planes(x)), self.far(simd, 0, planes(x.opposite())));
        let (enter_y, leave_y) = (self.near(simd, 1, planes(y)), self.far(simd, 1, planes(y.opposite())));
        let (enter_z, leave_z) = (self.near(simd, 2, planes(z)), self.far(simd, 2, planes(z.opposite())));
        let enter = simd.max(simd.max(enter_x, enter_y), simd.max(enter_z, self.min));
        let leave = simd.min(simd.min(leave_x, leave_y), simd.min(leave_z, self.max));
        (simd.le(enter, leave), enter)
    }
}

/// How many of the rays, from the first on, pass boxes through the same sides.
#[inline(always)]
pub(super) fn same_octant_prefix(rays: &[(Ray, Interval)]) -> usize {
    let Some((first, _)) = rays.first() else { return 0 };
    let signs_of_first = signs(first.direction);
    rays.iter().position(|(ray, _)| signs(ray.direction) != signs_of_first).unwrap_or(rays.len())
}

/// A subtree that rays of a shaft may meet.
#[derive(Clone, Copy)]
pub(super) struct Subtree {
    pub(super) child: Child,
    /// Its box is that of a lane of this node.
    pub(super) node: u32,
    pub(super) lane: u8,
    /// Of a leaf, the primitives that rays may meet, a bit for each.
    pub(super) mask: u8,
    /// No ray enters it before.
    pub(super) enter: f32,
}

/// What rays of a shaft may meet of a tree: subtrees that have nothing in common, from the nearest to the farthest.
pub(super) struct Cut {
    subtrees: [Subtree; CAPACITY],
    len: usize,
}

impl Cut {
    /// Through nothing.
    pub(super) const NONE: Self = {
        let nothing = Subtree { child: Child::NONE, node: 0, lane: 0, mask: 0, enter: 0.0 };
        Self { subtrees: [nothing; CAPACITY], len: 0 }
    };

    pub(super) fn subtrees(&self) -> &[Subtree] {
        self.subtrees.get(..self.len).unwrap_or(&[])
    }

    /// Looks for what the shaft may meet, as deep as there is room. Returns how many nodes it has looked at.
    #[inline(always)]
    pub(super) fn make<S: Simd, F: LeafTest>(&mut self, simd: S, tree: &WideBvh, shaft: &BundleFrustum<S>) -> u64 {
        self.len = 0;
        self.open::<S, F>(simd, tree, shaft, tree.root);
        let mut n_nodes = 1;
        let mut at = 0;
        // From the nearest to the farthest level, so that what there is no room for is small.
        while let Some(&Subtree { child, .. }) = self.subtrees().get(at) {
            if !child.is_node() || self.len + 7 > CAPACITY {
                at += 1;
                continue;
            }
            self.len -= 1;
            self.subtrees.copy_within(at + 1..=self.len, at);
            self.open::<S, F>(simd, tree, shaft, child);
            n_nodes += 1;
        }
        let len = self.len;
        if let Some(subtrees) = self.subtrees.get_mut(..len) {
            subtrees.sort_unstable_by(|a, b| a.enter.total_cmp(&b.enter));
        }
        n_nodes
    }

    /// Adds what is behind the boxes of a node that the shaft meets.
    #[inline(always)]
    fn open<S: Simd, F: LeafTest>(&mut self, simd: S, tree: &WideBvh, shaft: &BundleFrustum<S>, parent: Child) {
        let Some(node) = tree.nodes.get(parent.number()) else { return };
        let (mut passed, enter) = shaft.passes(simd, |row| node.row(simd, row));
        let enters = simd.to_array(enter);
        while passed != 0 {
            let lane = take_lane(&mut passed);
            let child = node.children[lane];
            let mask = if child.is_node() {
                0
            } else {
                {
                    // SAFETY: a child of a node of the tree, and no node.
                    F::cull_by_frustum(simd, shaft, unsafe { tree.leaves.view(child) })
                }
            };
            if (child.is_node() || mask != 0)
                && let Some(place) = self.subtrees.get_mut(self.len)
            {
                let (node, lane, mask) = (parent.number() as u32, lane as u8, mask as u8);
                *place = Subtree { child, node, lane, mask, enter: enters[lane as usize] };
                self.len += 1;
            }
        }
    }
}
