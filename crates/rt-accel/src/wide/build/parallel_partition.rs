//! Splits a large range on several threads, with the result of one thread.

use super::binning::{BestSplit, BinSplit, Bins};
use super::config::BuildConfig;
use super::prim_ref::PrimRef;
use super::top_down::{BuildRange, PrimInfo, scatter};
use crate::bvh::Aabb32;
use crate::parallel_for::{parallel_for_each, parallel_map};

/// References per task.
const CHUNK: usize = 16384;

/// Minimum references of a parallel split.
pub(super) const LARGE: usize = 4 * CHUNK;

/// A chunk and the destinations of its references.
struct Move<'a> {
    from: &'a [PrimRef],
    to: [&'a mut [PrimRef]; 2],
}

/// Parallel version of [`BuildRange::split`]. Bins may be filled in any order, and references keep theirs.
pub(super) fn split<'a>(set: BuildRange<'a>, config: &BuildConfig) -> [BuildRange<'a>; 2] {
    let Some(binning) = set.binning(config) else { return set.halve() };
    let parts = map_chunks(set.references, |chunk| {
        let mut bins = Bins::new();
        bins.reset(binning);
        bins.add(chunk);
        bins
    });
    let mut bins = Bins::new();
    bins.reset(binning);
    parts.iter().for_each(|part| bins.merge(part));
    let Some(BestSplit { cut, middle, bounds }) = bins.best_split(config.unit) else { return set.halve() };
    let centroids = partition(set.references, set.scratch, middle, &cut, &parts);
    set.exchange(middle, [0, 1].map(|side| PrimInfo { bounds: bounds[side], centroids: centroids[side] }))
}

fn partition(from: &[PrimRef], to: &mut [PrimRef], middle: usize, cut: &BinSplit, parts: &[Bins]) -> [Aabb32; 2] {
    let (mut left, mut right) = to.split_at_mut(middle);
    let mut moves = Vec::with_capacity(parts.len());
    for (from, bins) in from.chunks(CHUNK).zip(parts) {
        let on_left = bins.left_of(cut);
        let (to_left, left_rest) = left.split_at_mut(on_left);
        let (to_right, right_rest) = right.split_at_mut(from.len() - on_left);
        (left, right) = (left_rest, right_rest);
        moves.push(Move { from, to: [to_left, to_right] });
    }
    let mut centroids = vec![[Aabb32::EMPTY; 2]; moves.len()];
    let tasks = moves.into_iter().zip(&mut centroids).collect();
    parallel_for_each(tasks, |(Move { from, to }, centroids)| *centroids = scatter(from, cut, to));
    centroids.iter().fold([Aabb32::EMPTY; 2], |a, b| [a[0].union(b[0]), a[1].union(b[1])])
}

/// Results of a function for all chunks of references, in order.
fn map_chunks<R: Send>(references: &[PrimRef], each: impl Fn(&[PrimRef]) -> R + Sync) -> Vec<R> {
    let chunk = |i: usize| &references[i * CHUNK..references.len().min((i + 1) * CHUNK)];
    parallel_map(references.len().div_ceil(CHUNK), |i| each(chunk(i)))
}

impl PrimInfo {
    /// Parallel version of [`PrimInfo::of`].
    pub(super) fn of_many(references: &[PrimRef]) -> Self {
        if references.len() <= CHUNK {
            return Self::of(references);
        }
        map_chunks(references, Self::of).into_iter().fold(Self::EMPTY, Self::union)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wide::build::binning::{Axes, NormalizedArea};
    use crate::{wide::build::leaf_policy::LeafPolicy, wide::build::prim_ref::PrimRange, wide::build::tests::soup};

    #[test]
    fn chunks_are_cut_as_the_whole_is() {
        let cut = |in_chunks: bool, axes| {
            let mut references = soup(LARGE as u32 + 12_345, 9, 1.0);
            let (mut scratch, mut order) =
                (vec![PrimRef::NONE; references.len()], vec![PrimRange::default(); references.len()]);
            let extent = PrimInfo::of(&references);
            assert_eq!(PrimInfo::of_many(&references), extent);
            let config = BuildConfig {
                unit: NormalizedArea::new(&extent.bounds),
                axes,
                leaf_policy: LeafPolicy::STRICT,
                pairs: true,
                max_leaf: 8,
            };
            let set = BuildRange {
                references: &mut references,
                scratch: &mut scratch,
                order: &mut order,
                first: 0,
                extent,
                depth: 0,
            };
            let sides = if in_chunks { split(set, &config) } else { set.split(&config, &mut Bins::new()) };
            sides.map(|side| {
                let indices: Vec<_> = side.references.iter().map(PrimRef::index).collect();
                (side.first, side.depth, side.extent, indices)
            })
        };
        for axes in [Axes::All, Axes::Widest] {
            let [left, right] = cut(true, axes);
            assert!(left.3.len() > 100 && right.3.len() > 100 && left.3.is_sorted());
            assert_eq!([left, right], cut(false, axes));
        }
    }
}
