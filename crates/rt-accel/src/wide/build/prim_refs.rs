//! From primitives to references: what is common to all first, then one by one.

use core::ops::Range;

use glam::DVec3;
use rt_geometry::{Primitives, padded_bounds};
use rt_math::Aabb;

use super::in_order;
use super::reference::PrimRef;
use super::top_down::BuildConfig;
use crate::own_boxes::{checked_own_box, count};
use crate::{BuildError, bvh::NodeBox, wide::huge_pages::filled, wide::leaf::GeometryCounts};

/// Primitives that one thread handles at a time.
const RUN: u32 = 16384;

/// What must be known of all primitives before anything can be made of one.
pub(in crate::wide) struct PrimStats {
    /// Primitives without bounds, by rising index.
    pub(in crate::wide) unbounded: Vec<u32>,
    /// Number of the others.
    pub(in crate::wide) bounded: u32,
    /// Union of their own boxes.
    pub(in crate::wide) union: Aabb,
    /// Of the bounded primitives.
    pub(in crate::wide) layouts: GeometryCounts,
}

impl PrimStats {
    /// Looks at all primitives once.
    ///
    /// # Errors
    ///
    /// [`BuildError`] of the first primitive whose bounds are NaN, inverted or infinite, or if they are too many.
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
            match checked_own_box(primitives, index)? {
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

    /// The centre of the tree.
    pub(in crate::wide) fn centre(&self) -> DVec3 {
        if self.bounded == 0 { DVec3::ZERO } else { self.union.centre() }
    }

    /// A box around all, relative to the centre.
    pub(in crate::wide) fn extent(&self) -> NodeBox {
        NodeBox::outward(&self.union, self.centre())
    }

    /// The greatest coordinate relative to the centre.
    pub(in crate::wide) fn size(&self) -> f64 {
        if self.bounded == 0 { 0.0 } else { self.extent().max_abs() }
    }
}

/// What a tree grows over.
pub(super) struct Gathered {
    pub(super) references: Vec<PrimRef>,
    /// Room for as many. What is in it means nothing.
    pub(super) room: Vec<PrimRef>,
}

/// References to all bounded primitives, to pairs of them where that is no worse.
pub(super) fn references<P: Primitives>(primitives: &P, centre: DVec3, config: &BuildConfig) -> Gathered {
    let count = primitives.len() as u32;
    let mut counts = vec![0; count.div_ceil(RUN) as usize];
    // Each run first where it would be if no primitives were joined.
    let runs = counts.iter_mut().enumerate().map(|(at, n)| (run(at, count), n));
    let parts = runs.map(|(run, n)| (run.len(), (run, n))).collect();
    let mut room = filled(parts, PrimRef::NONE, |(run, count), room| {
        let mut references = Vec::with_capacity(run.len());
        for index in run {
            if let Some(own) = padded_bounds(primitives, index) {
                config.push(&mut references, PrimRef::new(NodeBox::outward(&own, centre), index));
            }
        }
        room[..references.len()].copy_from_slice(&references);
        *count = references.len();
    });
    let parts = room.chunks(RUN as usize).zip(counts).map(|(run, count)| (count, &run[..count])).collect();
    let references = filled(parts, PrimRef::NONE, |from, to| to.copy_from_slice(from));
    room.truncate(references.len());
    room.shrink_to_fit();
    Gathered { references, room }
}

/// The primitives of a run, of so many.
fn run(at: usize, count: u32) -> Range<u32> {
    let first = at as u32 * RUN;
    first..first.saturating_add(RUN).min(count)
}

/// Does the same for all runs of primitives, in order.
fn in_runs<T: Send>(count: u32, each: impl Fn(Range<u32>) -> T + Sync + Send) -> Vec<T> {
    in_order(count.div_ceil(RUN) as usize, |at| each(run(at, count)))
}

#[cfg(test)]
mod tests {
    use rt_geometry::Hit;
    use rt_math::{Interval, Ray};

    use super::*;
    use crate::{wide::BuildParams, wide::build::reference::Run};

    /// Unit cubes in a row, two of each but for the last; every seventh has no bounds, and none of the second run has.
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
            let Gathered { references, room } = references(&cubes, DVec3::ZERO, &config);
            let mut expected: Vec<Run> = Vec::new();
            for first in (0..count).filter(|&index| cubes.bounds(index).is_some()) {
                match expected.last_mut() {
                    Some(last) if first % 2 == 1 && *last == (Run { first: first - 1, count: 1 }) => last.count = 2,
                    _ => expected.push(Run { first, count: 1 }),
                }
            }
            assert!(references.iter().map(PrimRef::run).eq(expected));
            assert_eq!(room.len(), references.len());
        }
    }
}
