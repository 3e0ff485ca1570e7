//! From primitives to references: what is common to all first, then one by one.

use core::ops::Range;

use glam::DVec3;
use rt_math::{Aabb, Primitives, own_box};

use super::grow::Rules;
use super::in_order;
use super::reference::Reference;
use crate::BuildError;
use crate::bvh::NodeBox;
use crate::own_boxes::{checked_own_box, count};
use crate::wide::leaf::Layouts;
use crate::wide::pages::filled;

/// Primitives that one thread handles at a time.
const RUN: u32 = 16384;

/// What must be known of all primitives before anything can be made of one.
pub(in crate::wide) struct Census {
    /// Primitives without bounds, by rising index.
    pub(in crate::wide) unbounded: Vec<u32>,
    /// Number of the others.
    pub(in crate::wide) bounded: u32,
    /// Union of their own boxes.
    pub(in crate::wide) union: Aabb,
    /// Of the bounded primitives.
    pub(in crate::wide) layouts: Layouts,
}

impl Census {
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

    const EMPTY: Self = Self { unbounded: Vec::new(), bounded: 0, union: Aabb::EMPTY, layouts: Layouts::NONE };

    fn of_run<P: Primitives>(primitives: &P, run: Range<u32>) -> Result<Self, BuildError> {
        let mut all = Self::EMPTY;
        for index in run {
            match checked_own_box(primitives, index)? {
                Some(own) => {
                    all.bounded += 1;
                    all.union = all.union.union(own);
                    all.layouts = all.layouts.and(Layouts::of(&primitives.leaf_layout(index)));
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

/// References to all bounded primitives, to pairs of them where that is no worse, and room for as many.
pub(super) fn references<P: Primitives>(primitives: &P, centre: DVec3, rules: &Rules) -> [Vec<Reference>; 2] {
    let runs: Vec<_> = runs(primitives.len() as u32).collect();
    let mut counts = vec![0; runs.len()];
    // Each run first where it would be if no primitives were joined.
    let parts = runs.into_iter().zip(&mut counts).map(|(run, count)| (run.len(), (run, count))).collect();
    let mut room = filled(parts, Reference::NONE, |(run, count), room| {
        let mut references = Vec::with_capacity(run.len());
        for index in run {
            if let Some(own) = own_box(primitives, index) {
                rules.push(&mut references, Reference::new(NodeBox::outward(&own, centre), index));
            }
        }
        room[..references.len()].copy_from_slice(&references);
        *count = references.len();
    });
    let parts = room.chunks(RUN as usize).zip(counts).map(|(run, count)| (count, &run[..count])).collect();
    let references = filled(parts, Reference::NONE, |from, to| to.copy_from_slice(from));
    room.truncate(references.len());
    [references, room]
}

fn runs(count: u32) -> impl Iterator<Item = Range<u32>> {
    (0..count).step_by(RUN as usize).map(move |first| first..first.saturating_add(RUN).min(count))
}

/// Does the same for all runs of primitives, in order.
fn in_runs<T: Send>(count: u32, each: impl Fn(Range<u32>) -> T + Sync + Send) -> Vec<T> {
    let runs: Vec<_> = runs(count).collect();
    in_order(runs.len(), |run| each(runs[run].clone()))
}
