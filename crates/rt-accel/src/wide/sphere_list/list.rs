//! The list and its queries.

use rt_geometry::{Hit, PrimitiveGeometry, Primitives, Probe, SphereKernel};
use rt_math::{DVec3, Interval, Ray};

use super::block::{Block, LANES, slot};
use super::projected_ray::{ProjectedRay, inflated_r2};
use crate::ValidationError;
use crate::wide::query::{Output, PrimitiveTester, Tester, TraversalStats};
use crate::wide::ray::RANGE;
use crate::wide::simd::{DetectedSimd, Simd, SimdLevel, WithSimd, take_lane};
use crate::wide::small_set::SmallSet;

/// Fewer spheres are a [`SmallSet`].
const MIN_SPHERES: u32 = SmallSet::CAPACITY as u32 + 1;

/// Blocks that are filtered before any of their spheres is tested exactly.
const GROUP: usize = 32;

/// `f32` values per sphere in a block.
fn numbers(position: DVec3, radius: f64) -> [f32; 4] {
    [position.x as f32, position.y as f32, position.z as f32, inflated_r2(radius)]
}

/// Maximum coordinate of a sphere.
fn reach(position: DVec3, radius: f64) -> f64 {
    position.abs().max_element() + radius
}

/// Spheres without a tree. A conservative filter in `f32` rejects most; the others are tested in `f64` by rising index, so
/// that results and counters are those of [`brute_force`](crate::brute_force).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct SphereList {
    blocks: Vec<Block>,
    count: u32,
    /// World position of the local origin.
    centre: DVec3,
    /// Maximum coordinate relative to the centre.
    size: f64,
    #[cfg_attr(feature = "serde", serde(skip))]
    level: DetectedSimd,
}

/// Centre and radius, `None` for anything but a sphere.
fn sphere<P: Primitives>(primitives: &P, index: u32) -> Option<(DVec3, f64)> {
    let (centre, radius) = match primitives.geometry(index) {
        PrimitiveGeometry::Sphere(centre, radius) | PrimitiveGeometry::ExactSphere(SphereKernel { centre, radius }) => {
            (centre, radius)
        }
        _ => return None,
    };
    (centre.is_finite() && (0.0..f64::INFINITY).contains(&radius)).then_some((centre, radius))
}

impl SphereList {
    /// Lists all primitives. `None` if there are few, if one is not a sphere, or if coordinates are out of the range of
    /// the filter's proof.
    pub(crate) fn of<P: Primitives>(primitives: &P) -> Option<Self> {
        let count = u32::try_from(primitives.len()).ok().filter(|&count| count >= MIN_SPHERES)?;
        let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for index in 0..count {
            let (centre, radius) = sphere(primitives, index)?;
            (min, max) = (min.min(centre - radius), max.max(centre + radius));
        }
        let centre = 0.5 * min + 0.5 * max;
        let mut size = 0.0f64;
        let mut blocks = vec![Block::EMPTY; (count as usize).div_ceil(LANES)];
        for index in 0..count {
            let (position, radius) = sphere(primitives, index)?;
            size = size.max(reach(position - centre, radius));
            let (block, lane) = slot(index);
            blocks.get_mut(block)?.set_sphere(lane, numbers(position - centre, radius));
        }
        if !RANGE.contains(&size) {
            return None;
        }
        Some(Self { blocks, count, centre, size, level: DetectedSimd::default() })
    }

    /// Replaces the instruction set.
    pub(crate) fn with_level(mut self, level: SimdLevel) -> Self {
        self.level = DetectedSimd::new(level);
        self
    }

    /// Checks that the list holds copies of the primitives.
    pub(crate) fn validate<P: Primitives>(&self, primitives: &P) -> Result<(), ValidationError> {
        let fits = |index: u32| {
            let (position, radius) = sphere(primitives, index)?;
            let position = position - self.centre;
            let (block, lane) = slot(index);
            let is_kept = self.blocks.get(block)?.sphere(lane) == numbers(position, radius);
            (is_kept && reach(position, radius) <= self.size).then_some(())
        };
        match (0..self.count).find(|&index| fits(index).is_none()) {
            Some(primitive) => Err(ValidationError::Outside { primitive }),
            None => Ok(()),
        }
    }

    #[cfg(feature = "serde")]
    pub(crate) const fn count(&self) -> u32 {
        self.count
    }

    /// Bytes on the heap.
    pub(crate) fn memory(&self) -> usize {
        self.blocks.capacity() * size_of::<Block>()
    }

    /// True if the number of blocks fits the spheres, and lanes without a sphere are empty.
    #[cfg(feature = "serde")]
    pub(crate) fn is_whole(&self) -> bool {
        let is_unused = |lane| self.blocks.last().is_some_and(|last| last.sphere(lane) == Block::EMPTY.sphere(lane));
        let (full, lanes) = slot(self.count);
        self.blocks.len() == full + usize::from(lanes > 0) && (lanes == 0 || (lanes..LANES).all(is_unused))
    }

    /// Traces one ray.
    pub(crate) fn trace<O: ListQuery, P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        ray: &Ray,
        span: Interval,
        probe: &mut S,
    ) -> O
    where
        for<'a> Tester<'a, P, S>: PrimitiveTester<O>,
    {
        let mut tester = Tester { primitives, probe };
        let mut context = ListContext { tester: &mut tester, stats: TraversalStats::default(), output: O::default() };
        O::trace_list(self, &mut context, ray, span);
        let ListContext { stats, output, .. } = context;
        stats.add_to(tester.probe);
        output
    }
}

/// Inputs and outputs of a query for one ray.
pub(crate) struct ListContext<'q, O> {
    tester: &'q mut dyn PrimitiveTester<O>,
    stats: TraversalStats,
    output: O,
}

/// The first block of a mask that is not 0, which is removed from it, and its position.
#[inline(always)]
fn take_block<'b>(mask: &mut u64, blocks: &'b [Block]) -> Option<(usize, &'b Block)> {
    let at = mask.trailing_zeros() as usize;
    *mask &= mask.wrapping_sub(1);
    blocks.get(at).map(|block| (at, block))
}

/// Traces one ray through a list.
struct ListTraversal<'q, 'j, O> {
    list: &'q SphereList,
    context: &'q mut ListContext<'j, O>,
}

/// Queries of a list.
pub(crate) trait ListQuery: Output {
    /// Traces one ray. Compiled once here, and not in every crate that traces rays.
    fn trace_list(list: &SphereList, context: &mut ListContext<'_, Self>, ray: &Ray, span: Interval);
}

impl ListQuery for Option<Hit> {
    #[inline(never)]
    fn trace_list(list: &SphereList, context: &mut ListContext<'_, Self>, ray: &Ray, span: Interval) {
        list.level.dispatch(ListTraversal { list, context }, ray, span);
    }
}

impl ListQuery for bool {
    #[inline(never)]
    fn trace_list(list: &SphereList, context: &mut ListContext<'_, Self>, ray: &Ray, span: Interval) {
        list.level.dispatch(ListTraversal { list, context }, ray, span);
    }
}

impl<O: Output> WithSimd<&Ray, Interval> for ListTraversal<'_, '_, O> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S, ray: &Ray, mut span: Interval) {
        let Self { list, context: ListContext { tester, stats, output } } = self;
        let Some(projected) = ProjectedRay::new(ray, span, list.centre, list.size) else {
            *output = tester.brute_force(ray, span);
            return;
        };
        let [begin, mut end] = [projected.interval_at(span.min), projected.interval_at(span.max)];
        for (group, blocks) in list.blocks.chunks(GROUP).enumerate() {
            let mut hit = projected.hit_blocks(simd, blocks);
            while let Some((at, block)) = take_block(&mut hit, blocks) {
                let mut possible = projected.possible_hits(simd, block, [begin[0], end[1]]);
                if possible == 0 {
                    continue;
                }
                let certain = if O::ANY_HIT { projected.certain_hits(simd, block, [begin[1], end[0]]) } else { 0 };
                while possible != 0 {
                    let lane = take_lane(&mut possible);
                    let index = ((group * GROUP + at) * LANES + lane) as u32;
                    let is_certain = certain >> lane & 1 == 1;
                    let result = if is_certain { O::HIT } else { tester.test(index, ray, span) };
                    if O::ANY_HIT && result.to_hit().is_some() {
                        (stats.tests, stats.hits) = (u64::from(index) + 1, u64::from(is_certain));
                        *output = result;
                        return;
                    }
                    if let Some(hit) = result.to_hit()
                        && output.to_hit().is_none_or(|closest| hit.precedes(&closest))
                    {
                        span.max = hit.t;
                        end = projected.interval_at(hit.t);
                        *output = result;
                    }
                }
            }
        }
        stats.tests = u64::from(list.count);
    }
}
