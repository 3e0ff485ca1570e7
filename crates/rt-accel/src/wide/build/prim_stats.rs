//! References to primitives: statistics of all first, then one reference for each.

use core::ops::Range;

use glam::DVec3;
use rt_geometry::{Primitives, padded_bounds};
use rt_math::Aabb;

use super::config::BuildConfig;
use super::prim_ref::PrimRef;
use crate::parallel_for::parallel_map;
use crate::prim_bounds::{checked_padded_bounds, count};
use crate::{BuildError, bvh::Aabb32, wide::huge_pages::filled, wide::leaf::GeometryCounts};

/// Primitives per task.
const RUN: u32 = 16384;

/// Statistics of all primitives.
pub(in crate::wide) struct PrimStats {
    /// Primitives without bounds, by rising index.
    pub(in crate::wide) unbounded: Vec<u32>,
    /// Number of bounded primitives.
    pub(in crate::wide) bounded: u32,
    /// Union of the padded bounds.
    pub(in crate::wide) union: Aabb,
    /// Counts of the bounded primitives.
    pub(in crate::wide) layouts: GeometryCounts,
}

impl PrimStats {
    /// # Errors
    ///
    /// [`BuildError`] of the first primitive whose bounds are NaN, inverted or infinite, or if there are too many.
    pub(in crate::wide) fn of<P: Primitives>(primitives: &P) -> Result<Self, BuildError> {
        let count = count(primitives)?;
        let mut all = Self::EMPTY;
        for part in in_runs(count, |run| Self::of_run(primitives, run)) {
            let Self { unbounded, bounded, union, layouts } = part?;
            all.unbounded.extend(unbounded);
            all.bounded += bounded;
            all.union = all.union.union(union);
            all.layouts = all.layouts.and(layouts);
        }
        Ok(all)
    }

    const EMPTY: Self = Self { unbounded: Vec::new(), bounded: 0, union: Aabb::EMPTY, layouts: GeometryCounts::NONE };

    fn of_run<P: Primitives>(primitives: &P, run: Range<u32>) -> Result<Self, BuildError> {
        let mut all = Self::EMPTY;
        for index in run {
            match checked_padded_bounds(primitives, index)? {
                Some(own) => {
                    all.bounded += 1;
                    all.union = all.union.union(own);
                    all.layouts = all.layouts.and(GeometryCounts::of(&primitives.geometry(index)));
                }
                None => all.unbounded.push(index),
            }
        }
        Ok(all)
    }

    /// Centre of the tree.
    pub(in crate::wide) fn centre(&self) -> DVec3 {
        if self.bounded == 0 { DVec3::ZERO } else { self.union.centre() }
    }

    /// Bounds of all, relative to the centre.
    pub(in crate::wide) fn extent(&self) -> Aabb32 {
        Aabb32::enclosing(&self.union, self.centre())
    }

    /// Maximum coordinate relative to the centre.
    pub(in crate::wide) fn size(&self) -> f64 {
        if self.bounded == 0 { 0.0 } else { self.extent().max_abs() }
    }
}

/// Input of the top-down build.
pub(super) struct Gathered {
    pub(super) references: Vec<PrimRef>,
    /// Scratch space of the same length, with arbitrary content.
    pub(super) scratch: Vec<PrimRef>,
}

/// References to all bounded primitives, merged in pairs where that costs no more.
pub(super) fn references<P: Primitives>(primitives: &P, centre: DVec3, config: &BuildConfig) -> Gathered {
    let count = primitives.len() as u32;
    let mut counts = vec![0; count.div_ceil(RUN) as usize];
    // Each task first writes where its references belong without merging.
    let runs = counts.iter_mut().enumerate().map(|(at, n)| (run(at, count), n));
    let parts = runs.map(|(run, n)| (run.len(), (run, n))).collect();
    let mut scratch = filled(parts, PrimRef::NONE, |(run, count), scratch| {
        let mut references = Vec::with_capacity(run.len());
        for index in run {
            if let Some(own) = padded_bounds(primitives, index) {
                config.push(&mut references, PrimRef::new(Aabb32::enclosing(&own, centre), index));
            }
        }
        scratch[..references.len()].copy_from_slice(&references);
        *count = references.len();
    });
    let parts = scratch.chunks(RUN as usize).zip(counts).map(|(run, count)| (count, &run[..count])).collect();
    let references = filled(parts, PrimRef::NONE, |from, to| to.copy_from_slice(from));
    scratch.truncate(references.len());
    scratch.shrink_to_fit();
    Gathered { references, scratch }
}

/// Range of a task.
fn run(at: usize, count: u32) -> Range<u32> {
    let first = at as u32 * RUN;
    first..first.saturating_add(RUN).min(count)
}

/// Maps all ranges of primitives, in order.
fn in_runs<T: Send>(count: u32, each: impl Fn(Range<u32>) -> T + Sync) -> Vec<T> {
    parallel_map(count.div_ceil(RUN) as usize, |at| each(run(at, count)))
}

#[cfg(test)]
mod tests {
    use rt_geometry::Hit;
    use rt_math::{Interval, Ray};

    use super::*;
    use crate::{wide::BuildParams, wide::build::prim_ref::PrimRange};

    /// Unit cubes in a row, in pairs but for the last. Every seventh has no bounds, and none of the second range has.
    struct Cubes(u32);

    impl Primitives for Cubes {
        fn len(&self) -> usize {
            self.0 as usize
        }

        fn bounds(&self, index: u32) -> Option<Aabb> {
            let is_bounded = index % 7 != 3 && index / RUN != 1;
            let corner = DVec3::X * f64::from(index / 2) * 2.0;
            is_bounded.then(|| Aabb::new(corner, corner + DVec3::ONE))
        }

        fn intersect(&self, _: u32, _: &Ray, _: Interval) -> Option<Hit> {
            None
        }
    }

    #[test]
    fn all_bounded_primitives_are_gathered_in_order_and_neighbours_in_pairs() {
        for count in [0, 1, RUN - 1, RUN, 3 * RUN + 5] {
            let cubes = Cubes(count);
            let config = BuildConfig::new(&PrimStats::of(&cubes).expect("few cubes").extent(), &BuildParams::default());
            let Gathered { references, scratch } = references(&cubes, DVec3::ZERO, &config);
            let mut expected: Vec<PrimRange> = Vec::new();
            for first in (0..count).filter(|&index| cubes.bounds(index).is_some()) {
                match expected.last_mut() {
                    Some(last) if first % 2 == 1 && *last == (PrimRange { first: first - 1, count: 1 }) => {
                        last.count = 2
                    }
                    _ => expected.push(PrimRange { first, count: 1 }),
                }
            }
            assert!(references.iter().map(PrimRef::run).eq(expected));
            assert_eq!(scratch.len(), references.len());
        }
    }
}
