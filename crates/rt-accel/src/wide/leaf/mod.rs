//! Leaves: copies of primitives for conservative tests, eight at a time.
//!
//! A leaf of n primitives is a block of 32-bit words, aligned to a cache line: a header, then each number of all
//! primitives (structure of arrays), then their indices. Loads of eight numbers may read beyond a row; these lanes are
//! masked.

mod boxes;
mod spheres;
mod triangles;

use glam::DVec3;
use rt_geometry::{Hit, PrimitiveGeometry, Primitives, padded_bounds};
use rt_math::{Interval, Ray};

pub(super) use boxes::BoxTest;
pub(super) use spheres::SphereTest;
pub(super) use triangles::{TriangleTest, coordinates, corner};

use super::WideBvh;
use super::frustum::BundleFrustum;
use super::node::Child;
use super::packet_rays::{F64x8, RayPacket, SpanLanes};
use super::query::{Output, PrimitiveTester};
use super::ray::{RayF32, RayF64x4, SLACK};
use super::simd::Simd;
use crate::{bvh::Aabb32, wide::huge_pages::filled};

/// Maximum primitives in a leaf.
pub(super) const MAX_LEAF: usize = 8;

/// Words in a cache line.
const LINE: usize = 16;

/// Cache lines of the largest leaf.
const MAX_LINES: usize = 6;

/// Lane of a primitive in its leaf, or of a ray in its packet: less than 8.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Lane(usize);

impl Lane {
    /// Uses the last three bits of a number.
    #[inline(always)]
    pub(super) const fn new(number: usize) -> Self {
        Self(number & 7)
    }

    #[inline(always)]
    pub(super) const fn index(self) -> usize {
        self.0
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(C, align(64))]
pub(super) struct CacheLine([u32; LINE]);

/// Kind of copies in the leaves of a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) enum LeafKind {
    /// Exact vertices of triangles, for exact tests; some primitives may be of other types.
    Watertight,
    /// Vertices of triangles relative to the centre of the tree, rounded; some primitives may be of other types.
    Triangles,
    /// Rounded centres, relative to that of the tree, and radii; other primitives have bounding spheres.
    Spheres,
    /// Boxes relative to the centre of the tree, rounded outward.
    Boxes,
}

/// Leaves hold exact vertices up to this distance of the tree from the origin, in sizes of the tree. Farther away,
/// vertices relative to the centre lose fewer digits.
const NEAR: f64 = 64.0;

/// Minimum ratio of triangles, or spheres, to all other primitives of a tree with leaves of that kind.
const MAJORITY_RATIO: u64 = 3;

/// Number of primitives by kind of geometry.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct GeometryCounts {
    n_spheres: u64,
    /// Triangles with exact copies.
    n_watertight: u64,
    n_triangles: u64,
    n_others: u64,
}

impl GeometryCounts {
    pub(super) const NONE: Self = Self { n_spheres: 0, n_watertight: 0, n_triangles: 0, n_others: 0 };

    #[inline(always)]
    pub(super) const fn of(layout: &PrimitiveGeometry) -> Self {
        let n_spheres = matches!(layout, PrimitiveGeometry::Sphere(..) | PrimitiveGeometry::ExactSphere(_)) as u64;
        let n_watertight = matches!(layout, PrimitiveGeometry::ExactTriangle(_)) as u64;
        let n_triangles = matches!(layout, PrimitiveGeometry::Triangle(_)) as u64 + n_watertight;
        Self { n_spheres, n_watertight, n_triangles, n_others: 1 - n_spheres - n_triangles }
    }

    #[inline(always)]
    pub(super) const fn and(self, other: Self) -> Self {
        Self {
            n_spheres: self.n_spheres + other.n_spheres,
            n_watertight: self.n_watertight + other.n_watertight,
            n_triangles: self.n_triangles + other.n_triangles,
            n_others: self.n_others + other.n_others,
        }
    }
}

impl LeafKind {
    /// Most specific kind that suits all primitives, or a large majority of triangles or spheres.
    pub(super) fn of(layouts: GeometryCounts, centre: DVec3, size: f64) -> Self {
        let GeometryCounts { n_spheres, n_watertight, n_triangles, n_others } = layouts;
        let n = n_spheres + n_triangles + n_others;
        let are_most = |same_octant_prefix: u64| (n - same_octant_prefix) * MAJORITY_RATIO <= same_octant_prefix;
        if are_most(n_spheres) {
            Self::Spheres
        } else if are_most(n_watertight) && centre.abs().max_element() <= NEAR * size {
            Self::Watertight
        } else if are_most(n_triangles) {
            Self::Triangles
        } else {
            Self::Boxes
        }
    }

    const fn lines(self, count: usize) -> usize {
        let (header, numbers) = self.shape();
        (header + (numbers + 1) * count).div_ceil(LINE)
    }

    /// Words of the header, and numbers per primitive.
    const fn shape(self) -> (usize, usize) {
        match self {
            Self::Watertight | Self::Triangles => (triangles::HEADER, triangles::NUMBERS),
            Self::Spheres => (spheres::HEADER, spheres::NUMBERS),
            Self::Boxes => (0, boxes::NUMBERS),
        }
    }
}

/// All leaves of a tree.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Leaves {
    pub(super) kind: LeafKind,
    lines: Vec<CacheLine>,
}

impl CacheLine {
    #[inline(always)]
    fn words(lines: &[Self]) -> &[u32] {
        // SAFETY: a line is sixteen words and nothing else.
        unsafe { core::slice::from_raw_parts(lines.as_ptr().cast(), lines.len() * LINE) }
    }

    fn words_mut(lines: &mut [Self]) -> &mut [u32] {
        // SAFETY: a line is sixteen words and nothing else, and may hold any.
        unsafe { core::slice::from_raw_parts_mut(lines.as_mut_ptr().cast(), lines.len() * LINE) }
    }
}

/// A leaf under construction.
struct LeafMut<'a> {
    words: &'a mut [u32],
    count: usize,
    header: usize,
}

impl LeafMut<'_> {
    fn set(&mut self, number: usize, lane: usize, value: f32) {
        self.words[self.header + number * self.count + lane] = value.to_bits();
    }

    fn set_header(&mut self, word: usize, value: f32) {
        self.words[word] = value.to_bits();
    }
}

/// Primitives of consecutive leaves.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct LeafOrder {
    /// Primitives, leaf by leaf.
    pub(super) order: Vec<u32>,
    /// Primitives of each leaf, from 1 to 8.
    pub(super) sizes: Vec<u8>,
    /// Total cache lines.
    pub(super) n_lines: usize,
}

impl LeafOrder {
    /// Ends a leaf that begins at primitive `first`.
    pub(super) fn close(&mut self, first: usize, kind: LeafKind) -> Child {
        let count = self.order.len() - first;
        let leaf = Child::leaf(self.n_lines as u32, count as u32);
        self.sizes.push(count as u8);
        self.n_lines += kind.lines(count);
        leaf
    }

    /// Primitives of each leaf.
    pub(super) fn leaves(&self) -> impl Iterator<Item = &[u32]> {
        let mut rest = &self.order[..];
        self.sizes.iter().map(move |&size| {
            let (leaf, others) = rest.split_at(usize::from(size));
            rest = others;
            leaf
        })
    }
}

/// Copies primitives into leaves.
pub(super) struct LeafWriter<'a, P> {
    pub(super) primitives: &'a P,
    /// Centre of the tree.
    pub(super) centre: DVec3,
    pub(super) kind: LeafKind,
}

impl<P: Primitives> LeafWriter<'_, P> {
    /// Padded bounds relative to the centre.
    pub(super) fn own(&self, index: u32) -> Aabb32 {
        padded_bounds(self.primitives, index).map_or(Aabb32::EMPTY, |own| Aabb32::enclosing(&own, self.centre))
    }

    /// Fills a leaf of 1 to 8 primitives at the start of cleared lines; returns its number of lines.
    fn fill(&self, indices: &[u32], lines: &mut [CacheLine]) -> usize {
        let (header, numbers) = self.kind.shape();
        let count = indices.len();
        let n_lines = self.kind.lines(count);
        let words = CacheLine::words_mut(&mut lines[..n_lines]);
        words[header + numbers * count..][..count].copy_from_slice(indices);
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

impl Leaves {
    pub(super) fn new<P: Primitives>(filling: &LeafWriter<'_, P>, listings: &[LeafOrder]) -> Self {
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
    pub(super) fn fits<P: Primitives>(&self, leaf: Child, filling: &LeafWriter<'_, P>) -> bool {
        let mut anew = [CacheLine::default(); MAX_LINES];
        let n_lines = filling.fill(self.indices(leaf), &mut anew);
        self.lines[leaf.number()..].starts_with(&anew[..n_lines])
    }

    /// Copies the primitives of a leaf again.
    pub(super) fn refill<P: Primitives>(&mut self, leaf: Child, filling: &LeafWriter<'_, P>) {
        let mut anew = [CacheLine::default(); MAX_LINES];
        let n_lines = filling.fill(self.indices(leaf), &mut anew);
        self.lines[leaf.number()..][..n_lines].copy_from_slice(&anew[..n_lines]);
    }

    pub(super) fn memory(&self) -> usize {
        self.lines.capacity() * size_of::<CacheLine>()
    }

    /// Primitives of a leaf that lies within the lines.
    #[inline]
    pub(super) fn indices(&self, leaf: Child) -> &[u32] {
        let (header, numbers) = self.kind.shape();
        let first = leaf.number() * LINE + header + numbers * leaf.count();
        self.words().get(first..first + leaf.count()).unwrap_or(&[])
    }

    /// True if all words that filters read of the leaf exist.
    pub(super) fn contain(&self, leaf: Child) -> bool {
        lines_contain(self.lines.len(), self.kind, leaf)
    }

    /// Upper bound of primitives in all leaves.
    pub(super) const fn most_primitives(&self) -> u64 {
        self.lines.len() as u64 * LINE as u64
    }

    #[inline(always)]
    fn words(&self) -> &[u32] {
        CacheLine::words(&self.lines)
    }

    /// Address of a leaf.
    #[inline(always)]
    pub(super) fn line(&self, leaf: Child) -> *const CacheLine {
        self.lines.as_ptr().wrapping_add(leaf.number())
    }

    /// # Safety
    ///
    /// [`contain`](Self::contain) must be true of the leaf, as builders and loaders check.
    #[inline(always)]
    pub(super) unsafe fn view(&self, leaf: Child) -> LeafView<'_> {
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

/// A leaf for reading; [`Leaves::contain`] holds for it.
#[derive(Clone, Copy)]
pub(super) struct LeafView<'a> {
    words: &'a [u32],
    first: usize,
    pub(super) count: usize,
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
    unsafe fn number(&self, at: usize) -> f32 {
        // SAFETY: as the caller promises.
        f32::from_bits(unsafe { self.word(at) })
    }

    /// Eight numbers, the first `count` of which belong to the primitives.
    ///
    /// # Safety
    ///
    /// With the header and the numbers of the leaf's kind, `at` must be at most `header + numbers·count`.
    #[inline(always)]
    unsafe fn lanes<S: Simd>(&self, simd: S, at: usize) -> S::F32x8 {
        debug_assert!(self.first + at + 8 <= self.words.len());
        // SAFETY: as in `word`; eight words follow, and any word is an `f32`.
        simd.load(unsafe { &*self.words.as_ptr().add(self.first + at).cast() })
    }

    /// A bit for each primitive.
    #[inline(always)]
    fn mask(&self) -> u32 {
        (1 << self.count) - 1
    }
}

/// Result of a conservative test, a bit for each primitive or ray.
pub(super) struct HitBounds<S: Simd> {
    /// Not certainly missed.
    pub(super) possible: u32,
    /// Certainly hit within the span, closest between `t_min` and `t_max`.
    pub(super) certain: u32,
    /// Bounds of `t`; meaningful for `certain` hits.
    pub(super) t_min: S::F32x8,
    pub(super) t_max: S::F32x8,
}

/// Span of a query, rounded for filters.
#[derive(Clone, Copy)]
pub(super) struct FilterTRange {
    /// Begin rounded down and up, end rounded down; the fourth is spare.
    numbers: [f32; 4],
}

impl FilterTRange {
    /// Applies [`round_down`](super::ray::round_down) and [`round_up`](super::ray::round_up) to a span of non-negative
    /// numbers.
    #[inline(always)]
    pub(super) fn new<S: Simd>(simd: S, span: Interval) -> Self {
        let Interval { min, max } = span;
        let (below, above, tiny) = (1.0 - SLACK, 1.0 + SLACK, f64::from(f32::MIN_POSITIVE));
        let numbers = simd.mul_f64(simd.f64x4([min, min, max, max]), simd.f64x4([below, above, below, below]));
        let numbers = simd.sub_f64(numbers, simd.f64x4([tiny, -tiny, tiny, tiny]));
        Self { numbers: simd.to_f32(simd.max_f64(numbers, simd.f64x4([0.0; 4]))) }
    }

    /// Begin, rounded down.
    #[inline(always)]
    pub(super) const fn min(&self) -> f32 {
        self.numbers[0]
    }

    #[inline(always)]
    fn splat<S: Simd>(&self, simd: S) -> SpanLanes<S> {
        let [at_most_min, at_least_min, at_most_max, _] = self.numbers;
        SpanLanes { min: [simd.splat(at_most_min), simd.splat(at_least_min)], max: simd.splat(at_most_max) }
    }
}

/// A ray prepared for exact tests.
pub(super) struct RayF64<'r, S: Simd> {
    pub(super) ray: &'r Ray,
    pub(super) lanes: RayF64x4<S>,
    /// Axis of the largest direction component.
    pub(super) axis: usize,
    /// Shear in the first two lanes; equals that of [`WatertightRay`](rt_geometry::WatertightRay).
    pub(super) shear: S::F64x4,
    /// Equals the scale of [`WatertightRay`](rt_geometry::WatertightRay).
    pub(super) scale: f64,
}

impl<'r, S: Simd> RayF64<'r, S> {
    #[inline(always)]
    pub(super) fn new(simd: S, ray: &'r Ray) -> Self {
        let lanes = RayF64x4::new(simd, ray);
        let axis = simd.max_axis(simd.abs_f64(lanes.direction));
        let [_, _, scale, _] = simd.to_f64_array(simd.rotate_axis_last(lanes.inverse, axis));
        let shear = simd.mul_f64(simd.rotate_axis_last(lanes.direction, axis), simd.f64x4([scale; 4]));
        Self { ray, lanes, axis, shear, scale }
    }

    /// Axes in the order x, y, z of the ray's space.
    #[inline(always)]
    pub(super) fn axes(&self) -> [usize; 3] {
        AXES[self.axis & 3]
    }
}

/// Cyclic order of axes by the last; the fourth row is spare, so that two bits index the table.
const AXES: [[usize; 3]; 4] = [[1, 2, 0], [2, 0, 1], [0, 1, 2], [0, 1, 2]];

/// Conservative `f32` test of leaves. Rejects most primitives and forwards the rest to the exact `f64` test.
pub(super) trait LeafTest: Copy {
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
        unsafe { leaf.word(Self::HEADER + Self::NUMBERS * leaf.count + lane.index()) }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wide::ray::{round_down, round_up};
    use crate::wide::simd::{DetectedSimd, SimdLevel, WithSimd};

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

    struct Make<'a>(&'a mut [f32; 4]);

    impl WithSimd<Interval, ()> for Make<'_> {
        #[inline(always)]
        fn run<S: Simd>(self, simd: S, span: Interval, (): ()) {
            *self.0 = FilterTRange::new(simd, span).numbers;
        }
    }

    #[test]
    fn spans_are_rounded_to_the_safe_side() {
        for t in [0.0, 5e-324, 1e-45, 1e-40, 1.2e-38, 1e-20, 0.1, 1.0 / 3.0, 1.0, 16_777_217.0, 3e38, f64::INFINITY] {
            for &level in SimdLevel::ALL {
                let mut numbers = [0.0; 4];
                DetectedSimd::new(level).dispatch(Make(&mut numbers), Interval::new(t, t), ());
                let [at_most_min, at_least_min, at_most_max, _] = numbers;
                assert_eq!([at_most_min, at_most_max], [round_down(t); 2], "{t}");
                assert!(f64::from(at_most_min) <= t && t <= f64::from(at_least_min), "{t}: {numbers:?}");
                assert!(f64::from(round_down(t)) <= t && t <= f64::from(round_up(t)), "{t}");
            }
        }
    }
}
