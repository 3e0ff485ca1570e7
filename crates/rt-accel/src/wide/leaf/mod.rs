//! What leaves hold: plain numbers side by side, that a filter rules primitives out by, eight at a time.
//!
//! A leaf of n primitives is a block of 32-bit words that begins at a cache line: the header of its kind, then one number
//! of each primitive after the other, then the next number of each, and at last their indices. F64x8 numbers are read at
//! a time; those that belong to what comes after are not looked at.

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
use crate::{bvh::NodeBox, wide::huge_pages::filled};

/// Most primitives in a leaf.
pub(super) const MAX_LEAF: usize = 8;

/// Words in a cache line.
const LINE: usize = 16;

/// Cache lines of the greatest leaf.
const MAX_LINES: usize = 6;

/// Lane of a primitive in its leaf, or of a ray in its packet: less than 8.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Lane(usize);

impl Lane {
    /// The last three bits of a number.
    #[inline(always)]
    pub(super) const fn new(number: usize) -> Self {
        Self(number & 7)
    }

    /// The number.
    #[inline(always)]
    pub(super) const fn index(self) -> usize {
        self.0
    }
}

/// A cache line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(C, align(64))]
pub(super) struct CacheLine([u32; LINE]);

/// What the leaves of a tree hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) enum LeafKind {
    /// The vertices of triangles as they are, which decide; some primitives may be something else.
    Watertight,
    /// The vertices of triangles relative to the centre of the tree, rounded; some primitives may be something else.
    Triangles,
    /// Centres relative to that of the tree, and radii, rounded: of spheres, and of balls around what else there is.
    Spheres,
    /// Boxes relative to the centre of the tree, rounded outward.
    Boxes,
}

/// Vertices are taken as they are if the tree is no farther from the origin than this many of its sizes. Farther off
/// a filter sees better what is relative to the centre.
const NEAR: f64 = 64.0;

/// Of how many spheres, or triangles, one primitive may be something else, for which their leaves still suit.
const MAJORITY_RATIO: u64 = 3;

/// What some primitives are.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct GeometryCounts {
    n_spheres: u64,
    /// Of triangles, those of which copies decide.
    n_watertight: u64,
    n_triangles: u64,
    n_others: u64,
}

impl GeometryCounts {
    /// Of no primitives at all.
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
    /// The most particular kind that suits all primitives, or most of them if those are spheres or triangles.
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

    /// Cache lines of a leaf of so many primitives.
    const fn lines(self, count: usize) -> usize {
        let (header, numbers) = self.shape();
        (header + (numbers + 1) * count).div_ceil(LINE)
    }

    /// Words before the numbers, and numbers of each primitive.
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

/// A leaf to be filled.
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

/// Which primitives leaves that follow each other list.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct LeafOrder {
    /// Primitives, leaf by leaf.
    pub(super) order: Vec<u32>,
    /// How many each leaf has, from 1 to 8.
    pub(super) sizes: Vec<u8>,
    /// Cache lines of all.
    pub(super) n_lines: usize,
}

impl LeafOrder {
    /// Makes a leaf of the primitives from `first` on.
    pub(super) fn close(&mut self, first: usize, kind: LeafKind) -> Child {
        let count = self.order.len() - first;
        let leaf = Child::leaf(self.n_lines as u32, count as u32);
        self.sizes.push(count as u8);
        self.n_lines += kind.lines(count);
        leaf
    }

    /// The primitives of each leaf.
    pub(super) fn leaves(&self) -> impl Iterator<Item = &[u32]> {
        let mut rest = &self.order[..];
        self.sizes.iter().map(move |&size| {
            let (leaf, others) = rest.split_at(usize::from(size));
            rest = others;
            leaf
        })
    }
}

/// What fills leaves.
pub(super) struct LeafWriter<'a, P> {
    pub(super) primitives: &'a P,
    /// Of the tree.
    pub(super) centre: DVec3,
    pub(super) kind: LeafKind,
}

impl<P: Primitives> LeafWriter<'_, P> {
    /// The own box, relative to the centre.
    pub(super) fn own(&self, index: u32) -> NodeBox {
        padded_bounds(self.primitives, index).map_or(NodeBox::EMPTY, |own| NodeBox::outward(&own, self.centre))
    }

    /// Fills the first of these lines, which are empty, with a leaf of 1 to 8 primitives; returns how many it takes.
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
    /// All leaves that are listed, one after the other.
    pub(super) fn new<P: Primitives>(filling: &LeafWriter<'_, P>, listings: &[LeafOrder]) -> Self {
        // Filters read eight numbers at the end of the last leaf as well.
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

    /// True if the leaf holds the numbers of the primitives that it lists.
    pub(super) fn fits<P: Primitives>(&self, leaf: Child, filling: &LeafWriter<'_, P>) -> bool {
        let mut anew = [CacheLine::default(); MAX_LINES];
        let n_lines = filling.fill(self.indices(leaf), &mut anew);
        self.lines[leaf.number()..].starts_with(&anew[..n_lines])
    }

    /// Fills a leaf with the numbers of its primitives as they are now.
    pub(super) fn refill<P: Primitives>(&mut self, leaf: Child, filling: &LeafWriter<'_, P>) {
        let mut anew = [CacheLine::default(); MAX_LINES];
        let n_lines = filling.fill(self.indices(leaf), &mut anew);
        self.lines[leaf.number()..][..n_lines].copy_from_slice(&anew[..n_lines]);
    }

    pub(super) fn memory(&self) -> usize {
        self.lines.capacity() * size_of::<CacheLine>()
    }

    /// The indices in a leaf, which ends within the list.
    #[inline]
    pub(super) fn indices(&self, leaf: Child) -> &[u32] {
        let (header, numbers) = self.kind.shape();
        let first = leaf.number() * LINE + header + numbers * leaf.count();
        self.words().get(first..first + leaf.count()).unwrap_or(&[])
    }

    /// True if all that filters may read of this leaf is there.
    pub(super) fn contain(&self, leaf: Child) -> bool {
        lines_contain(self.lines.len(), self.kind, leaf)
    }

    /// Most primitives that leaves in these lines can list.
    pub(super) const fn most_primitives(&self) -> u64 {
        self.lines.len() as u64 * LINE as u64
    }

    #[inline(always)]
    fn words(&self) -> &[u32] {
        CacheLine::words(&self.lines)
    }

    /// Where a leaf begins.
    #[inline(always)]
    pub(super) fn line(&self, leaf: Child) -> *const CacheLine {
        self.lines.as_ptr().wrapping_add(leaf.number())
    }

    /// Words of a leaf, for filters of the kind of these leaves.
    ///
    /// # Safety
    ///
    /// [`contain`](Self::contain) must be true of the leaf, as it is of all that builders have made and loaders have checked.
    #[inline(always)]
    pub(super) unsafe fn view(&self, leaf: Child) -> LeafView<'_> {
        debug_assert!(self.contain(leaf), "leaves are checked when they are made and when they are loaded");
        LeafView { words: self.words(), first: leaf.number() * LINE, count: leaf.count() }
    }
}

/// True if lines of this number contain all that filters may read of a leaf: eight words from any number on.
///
/// The end is computed with 64 bits. It would wrap with 32, as the number of a line has 28 bits and a line has 16 words.
fn lines_contain(n_lines: usize, kind: LeafKind, leaf: Child) -> bool {
    let (header, numbers) = kind.shape();
    let words = header + numbers * leaf.count() + MAX_LEAF;
    let end = leaf.number() as u64 * LINE as u64 + words as u64;
    (1..=MAX_LEAF).contains(&leaf.count()) && end <= n_lines as u64 * LINE as u64
}

/// A leaf to be read. Made only of leaves that [`Leaves::contain`].
#[derive(Clone, Copy)]
pub(super) struct LeafView<'a> {
    words: &'a [u32],
    first: usize,
    pub(super) count: usize,
}

impl LeafView<'_> {
    /// Word `at` of the leaf.
    ///
    /// # Safety
    ///
    /// With the header and the numbers of the leaf's kind, `at` must be less than `header + numbers·count + 8`.
    #[inline(always)]
    unsafe fn word(&self, at: usize) -> u32 {
        debug_assert!(self.first + at < self.words.len());
        // SAFETY: the leaf is one that `Leaves::contain`, and the caller keeps to it.
        unsafe { *self.words.get_unchecked(self.first + at) }
    }

    /// Word `at` of the leaf as a number.
    ///
    /// # Safety
    ///
    /// See [`word`](Self::word).
    #[inline(always)]
    unsafe fn number(&self, at: usize) -> f32 {
        // SAFETY: as the caller promises.
        f32::from_bits(unsafe { self.word(at) })
    }

    /// F64x8 numbers from word `at` of the leaf on, of which the first `count` are those asked for.
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

/// What a filter says about the primitives of a leaf, a bit for each.
pub(super) struct HitBounds<S: Simd> {
    /// Not missed for sure.
    pub(super) possible: u32,
    /// Hit for sure, within the span and first at a `t` between `near` and `far`.
    pub(super) certain: u32,
    /// Bounds of `t`; meaningful for `certain` hits.
    pub(super) t_min: S::F32x8,
    pub(super) t_max: S::F32x8,
}

/// The span of a query, as filters see it.
#[derive(Clone, Copy)]
pub(super) struct FilterTRange {
    /// Between the first two a number is neither certainly before nor certainly after the begin; what is not after the third
    /// is within the whole span.
    numbers: [f32; 4],
}

impl FilterTRange {
    /// Of a span that does not begin before 0: as [`round_down`](super::ray::round_down) and
    /// [`round_up`](super::ray::round_up) have it, side by side.
    #[inline(always)]
    pub(super) fn new<S: Simd>(simd: S, span: Interval) -> Self {
        let Interval { min, max } = span;
        let (below, above, tiny) = (1.0 - SLACK, 1.0 + SLACK, f64::from(f32::MIN_POSITIVE));
        let numbers = simd.mul_f64(simd.f64x4([min, min, max, max]), simd.f64x4([below, above, below, below]));
        let numbers = simd.sub_f64(numbers, simd.f64x4([tiny, -tiny, tiny, tiny]));
        Self { numbers: simd.to_f32(simd.max_f64(numbers, simd.f64x4([0.0; 4]))) }
    }

    /// Not after the begin.
    #[inline(always)]
    pub(super) const fn min(&self) -> f32 {
        self.numbers[0]
    }

    /// The same eight times.
    #[inline(always)]
    fn splat<S: Simd>(&self, simd: S) -> SpanLanes<S> {
        let [at_most_min, at_least_min, at_most_max, _] = self.numbers;
        SpanLanes { min: [simd.splat(at_most_min), simd.splat(at_least_min)], max: simd.splat(at_most_max) }
    }
}

/// A ray, prepared for those who decide.
pub(super) struct RayF64<'r, S: Simd> {
    pub(super) ray: &'r Ray,
    pub(super) lanes: RayF64x4<S>,
    /// Along which the ray is steepest.
    pub(super) axis: usize,
    /// The first two: as [`WatertightRay`](rt_geometry::WatertightRay) has them.
    pub(super) shear: S::F64x4,
    /// As [`WatertightRay`](rt_geometry::WatertightRay) has it.
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

    /// The axes in the order x, y, z of the ray's own space.
    #[inline(always)]
    pub(super) fn axes(&self) -> [usize; 3] {
        AXES[self.axis & 3]
    }
}

/// Axes by the last of them, in cyclic order; the fourth is spare, so that two bits are a number of the list.
const AXES: [[usize; 3]; 4] = [[1, 2, 0], [2, 0, 1], [0, 1, 2], [0, 1, 2]];

/// BuildConfig primitives out, and sees to it that somebody decides about the others.
pub(super) trait LeafTest: Copy {
    /// True if the leaf holds all that it takes to decide about this primitive, so that nobody else is asked, or counts the hits.
    #[inline(always)]
    fn is_exact(_: LeafView<'_>, _: Lane) -> bool {
        false
    }

    /// Prepares a ray, of which it is handed what others have prepared.
    fn new<S: Simd>(simd: S, ray: &RayF64<'_, S>, boxes: &RayF32, span: FilterTRange, tree: &WideBvh) -> Self;

    /// Judges the primitives of a leaf; what is hit after `t_max` is missed.
    fn test<S: Simd>(&self, simd: S, leaf: LeafView<'_>, t_max: f32) -> HitBounds<S>;

    /// The filters of eight rays, a lane each.
    type Packet<S: Simd>;

    /// Prepares eight rays.
    fn packet<S: Simd>(simd: S, rays: &RayPacket<S>, tree: &WideBvh) -> Self::Packet<S>;

    /// Judges one primitive of a leaf for eight rays: the bits are those of rays.
    fn test_packet<S: Simd>(
        simd: S,
        filters: &Self::Packet<S>,
        leaf: LeafView<'_>,
        lane: Lane,
        t_max: S::F32x8,
    ) -> HitBounds<S>;

    /// True if leaves hold spheres.
    const IS_SPHERE: bool = false;

    /// The primitives of a leaf that rays of a shaft may meet, a bit for each; all, unless a filter knows better.
    #[inline(always)]
    fn cull_by_frustum<S: Simd>(_: S, _: &BundleFrustum<S>, leaf: LeafView<'_>) -> u32 {
        leaf.mask()
    }

    /// The index of a primitive.
    fn index(leaf: LeafView<'_>, lane: Lane) -> u32;

    /// Decides where a primitive is hit within the span, where leaves hold all that it takes. What would rule it out need
    /// not be looked at where the hit is `CERTAIN`.
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

    /// As [`exact_hit`](Self::exact_hit) for rays of a packet, of those whose own space it is and for which the hit is certain:
    /// `t`, and as much of the second and third vertex. Meaningless for the others.
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

    /// On 32 bits the end of such a leaf wrapped, so that a saved tree with it passed the check and was read out of bounds.
    #[test]
    fn a_leaf_whose_end_wraps_at_32_bits_is_not_contained() {
        for kind in [LeafKind::Watertight, LeafKind::Triangles, LeafKind::Spheres, LeafKind::Boxes] {
            for count in 1..=MAX_LEAF {
                let (header, numbers) = kind.shape();
                let last = Child::leaf(Child::LIMIT as u32 - 1, count as u32);
                let words = header + numbers * count + MAX_LEAF;
                let wrapped = (last.number() as u32).wrapping_mul(LINE as u32).wrapping_add(words as u32);
                // Less than a line does not reach 2³².
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
