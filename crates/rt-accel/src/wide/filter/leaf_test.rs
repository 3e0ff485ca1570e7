//! Interface of the filters.

use rt_geometry::Hit;
use rt_math::Interval;

use crate::wide::WideBvh;
use crate::wide::f64x8::F64x8;
use crate::wide::frustum::BundleFrustum;
use crate::wide::leaf::{Lane, LeafView};
use crate::wide::query::{Output, PrimitiveTester};
use crate::wide::ray::RayF32;
use crate::wide::ray_f64::RayF64;
use crate::wide::ray_packet::RayPacket;
use crate::wide::simd::Simd;
use crate::wide::t_range::FilterTRange;

/// Result of a conservative test, a bit for each primitive or ray.
pub(in crate::wide) struct HitBounds<S: Simd> {
    /// Not certainly missed.
    pub(in crate::wide) possible: u32,
    /// Certainly hit within the span, closest between `t_min` and `t_max`.
    pub(in crate::wide) certain: u32,
    /// Bounds of `t`; meaningful for `certain` hits.
    pub(in crate::wide) t_min: S::F32x8,
    pub(in crate::wide) t_max: S::F32x8,
}

/// Conservative `f32` test of leaves. Rejects most primitives and forwards the rest to the exact `f64` test.
pub(in crate::wide) trait LeafTest: Copy {
    /// True if the leaf holds an exact copy, so that the primitive is tested, and its hits are counted, without the
    /// tester.
    #[inline(always)]
    fn is_exact(_: LeafView<'_>, _: Lane) -> bool {
        false
    }

    /// Prepares one ray.
    fn new<S: Simd>(simd: S, ray: &RayF64<'_, S>, boxes: &RayF32, span: FilterTRange, tree: &WideBvh) -> Self;

    /// Tests the primitives of a leaf; hits after `t_max` are misses.
    fn test<S: Simd>(&self, simd: S, leaf: LeafView<'_>, t_max: f32) -> HitBounds<S>;

    /// Eight rays prepared for this test.
    type Packet<S: Simd>;

    /// Prepares a packet.
    fn packet<S: Simd>(simd: S, rays: &RayPacket<S>, tree: &WideBvh) -> Self::Packet<S>;

    /// Tests one primitive of a leaf with eight rays, a bit for each.
    fn test_packet<S: Simd>(
        simd: S,
        filters: &Self::Packet<S>,
        leaf: LeafView<'_>,
        lane: Lane,
        t_max: S::F32x8,
    ) -> HitBounds<S>;

    /// Words of the header.
    const HEADER: usize;

    /// Numbers per primitive.
    const NUMBERS: usize;

    /// True for leaves of spheres.
    const IS_SPHERE: bool = false;

    /// Primitives of a leaf that rays in a frustum may hit, a bit for each.
    #[inline(always)]
    fn cull_by_frustum<S: Simd>(_: S, _: &BundleFrustum<S>, leaf: LeafView<'_>) -> u32 {
        leaf.mask()
    }

    /// Index of a primitive.
    #[inline(always)]
    fn index(leaf: LeafView<'_>, lane: Lane) -> u32 {
        // SAFETY: indices follow the numbers of the leaf's kind, and the lane is less than 8.
        unsafe { leaf.index(Self::HEADER + Self::NUMBERS * leaf.count + lane.index()) }
    }

    /// Exact hit within the span, if the leaf holds an exact copy. Skips all rejections where the hit is `CERTAIN`.
    #[inline(always)]
    fn exact_hit<S: Simd, const CERTAIN: bool>(
        _: S,
        _: LeafView<'_>,
        _: Lane,
        _: &RayF64<'_, S>,
        _: Interval,
    ) -> Option<Hit> {
        None
    }

    /// `t` and barycentric coordinates by ray, for rays of a packet that share the axes of the first and certainly hit
    /// an exact copy. Meaningless for others.
    #[inline(always)]
    fn exact_packet_hits<S: Simd>(simd: S, _: LeafView<'_>, _: Lane, _: &RayPacket<S>) -> [F64x8<S>; 3] {
        [F64x8::splat(simd, 0.0); 3]
    }

    /// Intersects a primitive exactly within the span, from the leaf or by the tester.
    #[inline(always)]
    fn intersect<S: Simd, O: Output>(
        simd: S,
        leaf: LeafView<'_>,
        lane: Lane,
        ray: &RayF64<'_, S>,
        span: Interval,
        tester: &mut dyn PrimitiveTester<O>,
    ) -> O {
        if Self::is_exact(leaf, lane) {
            O::from_hit(Self::exact_hit::<S, false>(simd, leaf, lane, ray, span))
        } else {
            tester.test(Self::index(leaf, lane), ray.ray, span)
        }
    }
}
