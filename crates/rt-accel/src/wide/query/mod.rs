//! What a ray is sent for: its first hit, or any.

mod any_hit;
mod closest_hit;

use core::ops::ControlFlow;

use rt_geometry::{Hit, SphereKernel};
use rt_math::{Interval, Ray};

pub(super) use any_hit::AnyHit;
pub(super) use closest_hit::FirstHit;

use super::WideBvh;
use super::batch::Ground;
use super::leaf::{FilterTRange, Lane, LeafTest, RayF64};
use super::node::Child;
use super::packet_rays::{PACKET, RayPacket};
use super::ray::RayF32;
use super::simd::Simd;
use super::single_ray::Query;

/// Decides about what the filters leave: the caller's primitives, behind one call.
pub(super) trait PrimitiveTester {
    /// The hit on a primitive within the span.
    fn closest(&mut self, index: u32, ray: &Ray, span: Interval) -> Option<Hit>;
    /// True if the primitive blocks the ray within the span.
    fn occluded(&mut self, index: u32, ray: &Ray, span: Interval) -> bool;
    /// The primitive's numbers, if it is one about which a structure may decide by them.
    fn round(&mut self, index: u32) -> Option<SphereKernel>;
    /// True if the primitive is a structure, which answers several rays faster together.
    fn is_structure(&mut self, index: u32) -> bool;
    /// As [`closest`](Self::closest), for several rays: `hits[i]` answers `rays[i]`.
    fn closest_together(&mut self, index: u32, rays: &[(Ray, Interval)], hits: &mut [Option<Hit>]);
    /// As [`occluded`](Self::occluded), for several rays: `blocked[i]` answers `rays[i]`.
    fn occluded_together(&mut self, index: u32, rays: &[(Ray, Interval)], blocked: &mut [bool]);
    /// The first hit on primitives without bounds.
    fn closest_unbounded(&mut self, ray: &Ray, span: Interval) -> Option<Hit>;
    /// True if a primitive without bounds blocks the ray.
    fn occluded_unbounded(&mut self, ray: &Ray, span: Interval) -> bool;
    /// The first hit on bounded primitives, by a walk that needs no filters.
    fn closest_unfiltered(&mut self, ray: &Ray, span: Interval) -> Option<Hit>;
    /// True if bounded primitives block the ray, by a walk that needs no filters.
    fn occluded_unfiltered(&mut self, ray: &Ray, span: Interval) -> bool;
}

/// A ray on its way, prepared for boxes and for the primitives of leaves.
pub(super) struct TravRay<'r, S: Simd, F> {
    pub(super) ray: RayF64<'r, S>,
    pub(super) boxes: RayF32,
    pub(super) min: f32,
    pub(super) filter: F,
}

impl<'r, S: Simd, F: LeafTest> TravRay<'r, S, F> {
    /// `None` where the filters are not proven.
    #[inline(always)]
    pub(super) fn new(simd: S, tree: &WideBvh, ray: &'r Ray, span: Interval) -> Option<Self> {
        let ray = RayF64::new(simd, ray);
        let boxes = RayF32::new(simd, &ray.lanes, span, tree.centre, tree.size)?;
        let span = FilterTRange::new(simd, span);
        Some(Self { min: span.min(), filter: F::new(simd, &ray, &boxes, span, tree), ray, boxes })
    }
}

/// The lowest lane of a mask that is not 0, which loses it.
#[inline(always)]
pub(super) fn take_lane(mask: &mut u32) -> usize {
    let lane = mask.trailing_zeros() as usize;
    *mask &= *mask - 1;
    lane & 7
}

/// What a ray is sent for, and what it has found of it.
pub(super) trait Goal: Sized {
    /// True if what is nearer should be visited first.
    const ORDERED: bool;
    /// What is found in the end.
    type Answer: Copy + Default;

    /// Sends one ray. Not generic where it is implemented, so that it is compiled once and not by all who ask.
    fn walk(tree: &WideBvh, query: &mut Query<'_, Self::Answer>, ray: &Ray, span: Interval);

    /// Sends many rays, as [`walk`](Self::walk) sends one.
    fn fly(tree: &WideBvh, ground: &mut Ground<'_>, rays: &[(Ray, Interval)], answers: &mut [Self::Answer]);

    /// Nothing has been found yet.
    fn new(span: Interval) -> Self;

    /// Asks the primitives without bounds; breaks if nothing else matters.
    fn visit_unbounded(&mut self, tester: &mut dyn PrimitiveTester, ray: &Ray) -> ControlFlow<()>;

    /// Walks without filters.
    fn visit_unfiltered(&mut self, tester: &mut dyn PrimitiveTester, ray: &Ray);

    /// What is entered after this does not matter; negative if nothing matters.
    fn limit(&self) -> f32;

    /// Visits a leaf; breaks if nothing else matters.
    ///
    /// # Safety
    ///
    /// The leaf must be one of the tree, and the filter that of the kind of its leaves.
    unsafe fn visit<S: Simd, F: LeafTest>(
        &mut self,
        simd: S,
        tree: &WideBvh,
        tester: &mut dyn PrimitiveTester,
        trav: &TravRay<'_, S, F>,
        leaf: Child,
    ) -> ControlFlow<()>;

    /// Considers one primitive that the filter has not ruled out, and between what it is hit if that is sure.
    ///
    /// # Safety
    ///
    /// See [`visit`](Self::visit).
    #[expect(clippy::too_many_arguments, reason = "as `visit`, for one primitive")]
    unsafe fn consider<S: Simd, F: LeafTest>(
        &mut self,
        simd: S,
        tree: &WideBvh,
        tester: &mut dyn PrimitiveTester,
        ray: &Ray,
        leaf: Child,
        lane: Lane,
        sure: Option<[f32; 2]>,
    );

    /// The span within which something may still matter.
    fn span(&self) -> Interval;

    /// Asks a structure for several rays.
    fn ask_together(
        tester: &mut dyn PrimitiveTester,
        index: u32,
        rays: &[(Ray, Interval)],
        answers: &mut [Self::Answer],
    );

    /// Considers what somebody else has found within the span.
    fn take(&mut self, found: Self::Answer);

    /// Decides about what has been put off, and writes what has been found where it is wanted: an answer that is moved on as a
    /// whole would wait until all its numbers are in memory.
    fn finish<S: Simd, F: LeafTest>(
        &mut self,
        simd: S,
        tree: &WideBvh,
        tester: &mut dyn PrimitiveTester,
        ray: &RayF64<'_, S>,
        answer: &mut Self::Answer,
    );

    /// What eight rays of a packet have found side by side.
    type Found<S: Simd>;

    /// Nothing has been found yet.
    fn nothing<S: Simd>(simd: S) -> Self::Found<S>;

    /// Takes into account what some of eight rays certainly hit, and between what, and lowers their limits. Returns those of
    /// the rays that are to [`consider`](Self::consider) it one by one.
    fn find<S: Simd>(
        found: &mut Self::Found<S>,
        simd: S,
        place: Place,
        sure: u32,
        bounds: [S::F32x8; 2],
        limits: &mut S::F32x8,
    ) -> u32;

    /// Forgets what others have beaten: what is hit after the limits for sure.
    #[inline(always)]
    fn forget<S: Simd>(_: &mut Self::Found<S>, _: S, _: S::F32x8) {}

    /// Decides about what eight rays have found side by side, and writes an answer for each; returns the hits that no judge has
    /// counted.
    fn settle<S: Simd, F: LeafTest>(
        found: &Self::Found<S>,
        simd: S,
        tree: &WideBvh,
        tester: &mut dyn PrimitiveTester,
        across: &RayPacket<S>,
        rays: &[(Ray, Interval); PACKET],
        answers: &mut [Self::Answer; PACKET],
    ) -> u64;

    /// What blocks one of eight rays, if that is all that they were sent to find out.
    #[inline(always)]
    fn found_blocker<S: Simd>(_: &Self::Found<S>) -> Option<Place> {
        None
    }

    /// Nothing that is entered after this matters any longer.
    fn lower(&mut self, limit: f32);

    /// Hits that no judge has counted.
    fn uncounted_hits(&self) -> u64;

    /// What blocks the ray, if that is all that it was sent to find out, and it was found in a leaf.
    #[inline(always)]
    fn blocker(&self) -> Option<Place> {
        None
    }

    /// What has been found so far.
    fn answer(&self) -> Self::Answer;
}

/// A primitive, by where it is in the tree that a query is about.
#[derive(Clone, Copy)]
pub(super) struct Place {
    leaf: Child,
    lane: Lane,
}

impl Place {
    /// Reads nothing yet.
    ///
    /// # Safety
    ///
    /// The child must be a leaf of the tree with which the place is used.
    #[inline(always)]
    pub(super) const unsafe fn new(leaf: Child, lane: Lane) -> Self {
        Self { leaf, lane }
    }

    /// A leaf of the tree.
    #[inline(always)]
    pub(super) const fn leaf(self) -> Child {
        self.leaf
    }

    /// Lane of the primitive in the leaf.
    #[inline(always)]
    pub(super) const fn lane(self) -> Lane {
        self.lane
    }
}
