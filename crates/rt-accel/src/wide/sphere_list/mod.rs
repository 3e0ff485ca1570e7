//! Primitives without a tree: spheres side by side in the order of their indices, eight at a time.

mod projected_ray;

use rt_geometry::{
    Hit, PrimitiveGeometry, Primitives, Probe, SphereKernel, intersect_primitive_uncounted,
    occludes_primitive_uncounted,
};
use rt_math::{DVec3, Interval, Ray};

use super::query::take_lane;
use super::ray::RANGE;
use super::simd::{DetectedSimd, Simd, SimdLevel, WithSimd};
use super::small_set::SmallSet;
use crate::{ValidationError, brute_force};
use projected_ray::{Seen, swollen};

/// Fewer are a [`SmallSet`].
const FEWEST: u32 = SmallSet::MOST as u32 + 1;

/// Spheres to a block.
const LANES: usize = 8;

/// Blocks that are looked through before any of their spheres is decided about.
const GROUP: usize = 32;

/// F64x8 spheres relative to the centre of the list.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(C, align(64))]
struct Block {
    /// By axis.
    centres: [[f32; LANES]; 3],
    /// Squares of radii, a little enlarged.
    swollen: [f32; LANES],
}

impl Block {
    /// Spheres that nothing passes.
    const EMPTY: Self = Self { centres: [[0.0; LANES]; 3], swollen: [f32::MIN; LANES] };

    const fn sphere(&self, lane: usize) -> [f32; 4] {
        let [x, y, z] = &self.centres;
        [x[lane], y[lane], z[lane], self.swollen[lane]]
    }

    const fn set_sphere(&mut self, lane: usize, [x, y, z, swollen]: [f32; 4]) {
        self.centres[0][lane] = x;
        self.centres[1][lane] = y;
        self.centres[2][lane] = z;
        self.swollen[lane] = swollen;
    }
}

/// Block and lane of a sphere.
const fn place(index: u32) -> (usize, usize) {
    (index as usize / LANES, index as usize % LANES)
}

/// What a block keeps of a sphere.
fn numbers(position: DVec3, radius: f64) -> [f32; 4] {
    [position.x as f32, position.y as f32, position.z as f32, swollen(radius)]
}

/// The greatest coordinate of a sphere.
fn reach(position: DVec3, radius: f64) -> f64 {
    position.abs().max_element() + radius
}

/// Spheres without a tree. A filter in `f32` rules out those that a ray misses; the others are decided in `f64` by rising
/// index, so that answers and counts are those of [`brute_force`].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct SphereList {
    blocks: Vec<Block>,
    count: u32,
    /// World position that the spheres are relative to.
    centre: DVec3,
    /// Greatest coordinate relative to the centre.
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
    /// The list of all primitives; `None` if it would gain nothing: if there are few, if one is no sphere, or if their
    /// coordinates are out of the range that the filter is proven for.
    pub(crate) fn of<P: Primitives>(primitives: &P) -> Option<Self> {
        let count = u32::try_from(primitives.len()).ok().filter(|&count| count >= FEWEST)?;
        let (mut least, mut greatest) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for index in 0..count {
            let (centre, radius) = sphere(primitives, index)?;
            (least, greatest) = (least.min(centre - radius), greatest.max(centre + radius));
        }
        let centre = 0.5 * least + 0.5 * greatest;
        let mut size = 0.0f64;
        let mut blocks = vec![Block::EMPTY; (count as usize).div_ceil(LANES)];
        for index in 0..count {
            let (position, radius) = sphere(primitives, index)?;
            size = size.max(reach(position - centre, radius));
            let (block, lane) = place(index);
            blocks.get_mut(block)?.set_sphere(lane, numbers(position - centre, radius));
        }
        if !RANGE.contains(&size) {
            return None;
        }
        Some(Self { blocks, count, centre, size, level: DetectedSimd::default() })
    }

    /// The same list, asked by other instructions.
    pub(crate) fn with_level(mut self, level: SimdLevel) -> Self {
        self.level = DetectedSimd::new(level);
        self
    }

    /// Checks that it holds the primitives as they are.
    pub(crate) fn check<P: Primitives>(&self, primitives: &P) -> Result<(), ValidationError> {
        let fits = |index: u32| {
            let (position, radius) = sphere(primitives, index)?;
            let position = position - self.centre;
            let (block, lane) = place(index);
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

    /// True if there are as many blocks as the spheres need, with nothing in the lanes that are left over.
    #[cfg(feature = "serde")]
    pub(crate) fn is_whole(&self) -> bool {
        let is_nothing = |lane| self.blocks.last().is_some_and(|last| last.sphere(lane) == Block::EMPTY.sphere(lane));
        let (full, lanes) = place(self.count);
        self.blocks.len() == full + usize::from(lanes > 0) && (lanes == 0 || (lanes..LANES).all(is_nothing))
    }

    /// Not generic, so that it is compiled once and not by all who ask.
    #[inline(never)]
    fn ask_first(&self, query: &mut Query<'_, Option<Hit>>, ray: &Ray, span: Interval) {
        self.level.dispatch(FirstHit { list: self, query }, ray, span);
    }

    /// As `ask_first`.
    #[inline(never)]
    fn ask_any(&self, query: &mut Query<'_, bool>, ray: &Ray, span: Interval) {
        self.level.dispatch(AnyHit { list: self, query }, ray, span);
    }

    pub(crate) fn closest<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        ray: &Ray,
        span: Interval,
        probe: &mut S,
    ) -> Option<Hit> {
        let mut asked = Asked { primitives, probe };
        let mut query = Query { tester: &mut asked, outcome: None };
        self.ask_first(&mut query, ray, span);
        match query.outcome {
            Some(outcome) => outcome.counted_by(probe),
            None => brute_force::closest(primitives, ray, span, probe),
        }
    }

    pub(crate) fn occluded<P: Primitives, S: Probe>(
        &self,
        primitives: &P,
        ray: &Ray,
        span: Interval,
        probe: &mut S,
    ) -> bool {
        let mut asked = Asked { primitives, probe };
        let mut query = Query { tester: &mut asked, outcome: None };
        self.ask_any(&mut query, ray, span);
        match query.outcome {
            Some(outcome) => outcome.counted_by(probe),
            None => brute_force::occluded(primitives, ray, span, probe),
        }
    }
}

/// Decides about what the filter leaves: the caller's primitives, behind one call.
trait PrimitiveTester {
    /// The hit on a sphere within the span.
    fn closest(&mut self, index: u32, ray: &Ray, span: Interval) -> Option<Hit>;
    /// True if the sphere blocks the ray within the span.
    fn occluded(&mut self, index: u32, ray: &Ray, span: Interval) -> bool;
}

/// The primitives of a query, and who counts.
struct Asked<'a, P, S> {
    primitives: &'a P,
    probe: &'a mut S,
}

impl<P: Primitives, S: Probe> PrimitiveTester for Asked<'_, P, S> {
    fn closest(&mut self, index: u32, ray: &Ray, span: Interval) -> Option<Hit> {
        intersect_primitive_uncounted(self.primitives, index, ray, span, self.probe)
    }

    fn occluded(&mut self, index: u32, ray: &Ray, span: Interval) -> bool {
        occludes_primitive_uncounted(self.primitives, index, ray, span, self.probe)
    }
}

/// Who decides, and where it is written what comes of it.
struct Query<'q, A> {
    tester: &'q mut dyn PrimitiveTester,
    /// `None` where the filter is not proven.
    outcome: Option<Outcome<A>>,
}

/// An answer, and the work for it that nobody has counted yet.
struct Outcome<A> {
    tests: u32,
    hits: u64,
    answer: A,
}

impl<A> Outcome<A> {
    fn counted_by<S: Probe>(self, probe: &mut S) -> A {
        probe.work(0, u64::from(self.tests), self.hits);
        self.answer
    }
}

/// The first block of a mask that is not 0, and its place; the mask loses it.
#[inline(always)]
fn take_block<'b>(mask: &mut u64, blocks: &'b [Block]) -> Option<(usize, &'b Block)> {
    let at = mask.trailing_zeros() as usize;
    *mask &= mask.wrapping_sub(1);
    blocks.get(at).map(|block| (at, block))
}

/// Finds the first hit.
struct FirstHit<'q, 'j> {
    list: &'q SphereList,
    query: &'q mut Query<'j, Option<Hit>>,
}

impl WithSimd<&Ray, Interval> for FirstHit<'_, '_> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S, ray: &Ray, mut span: Interval) {
        let Self { list, query } = self;
        let Some(seen) = Seen::new(ray, span, list.centre, list.size) else { return };
        let [begin, _] = seen.around(span.min);
        let [_, mut end] = seen.around(span.max);
        let mut best: Option<Hit> = None;
        for (group, blocks) in list.blocks.chunks(GROUP).enumerate() {
            let mut passed = seen.passed_blocks(simd, blocks);
            while let Some((at, block)) = take_block(&mut passed, blocks) {
                let mut maybe = seen.met(simd, block, [begin, end]);
                while maybe != 0 {
                    let index = ((group * GROUP + at) * LANES + take_lane(&mut maybe)) as u32;
                    if let Some(hit) = query.tester.closest(index, ray, span)
                        && best.is_none_or(|best| hit.precedes(&best))
                    {
                        span.max = hit.t;
                        [_, end] = seen.around(hit.t);
                        best = Some(hit);
                    }
                }
            }
        }
        query.outcome = Some(Outcome { tests: list.count, hits: 0, answer: best });
    }
}

/// Finds the first by index that blocks the ray.
struct AnyHit<'q, 'j> {
    list: &'q SphereList,
    query: &'q mut Query<'j, bool>,
}

impl WithSimd<&Ray, Interval> for AnyHit<'_, '_> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S, ray: &Ray, span: Interval) {
        let Self { list, query } = self;
        let Some(seen) = Seen::new(ray, span, list.centre, list.size) else { return };
        let [begin, end] = [seen.around(span.min), seen.around(span.max)];
        for (group, blocks) in list.blocks.chunks(GROUP).enumerate() {
            let mut passed = seen.passed_blocks(simd, blocks);
            while let Some((at, block)) = take_block(&mut passed, blocks) {
                let mut maybe = seen.met(simd, block, [begin[0], end[1]]);
                if maybe == 0 {
                    continue;
                }
                let sure = seen.met_for_sure(simd, block, [begin[1], end[0]]);
                while maybe != 0 {
                    let lane = take_lane(&mut maybe);
                    let index = ((group * GROUP + at) * LANES + lane) as u32;
                    let is_sure = sure >> lane & 1 == 1;
                    if is_sure || query.tester.occluded(index, ray, span) {
                        query.outcome = Some(Outcome { tests: index + 1, hits: u64::from(is_sure), answer: true });
                        return;
                    }
                }
            }
        }
        query.outcome = Some(Outcome { tests: list.count, hits: 0, answer: false });
    }
}
