//! Cuts a large set in two on several threads, with the same result as on one.

use rayon::prelude::*;

use super::binning::{BestSplit, Bins, SplitPlane};
use super::reference::PrimRef;
use super::top_down::{BuildConfig, PrimInfo, Set, scatter};
use crate::bvh::NodeBox;

/// References that one thread handles at a time.
const CHUNK: usize = 16384;

/// Sets of fewer references are not worth the effort.
pub(super) const LARGE: usize = 4 * CHUNK;

/// One chunk, and where its references go.
struct Move<'a> {
    from: &'a [PrimRef],
    to: [&'a mut [PrimRef]; 2],
}

/// As [`Set::split`]: bins may be filled in any order, and references keep theirs.
pub(super) fn split<'a>(set: Set<'a>, config: &BuildConfig) -> [Set<'a>; 2] {
    let Some(binning) = set.binning(config) else { return set.halve() };
    let fill = |chunk: &[PrimRef]| {
        let mut bins = Bins::new();
        bins.reset(binning);
        bins.add(chunk);
        bins
    };
    let parts: Vec<_> = set.references.par_chunks(CHUNK).map(fill).collect();
    let mut bins = Bins::new();
    bins.reset(binning);
    parts.iter().for_each(|part| bins.merge(part));
    let Some(BestSplit { cut, middle, bounds }) = bins.best_split(config.unit) else { return set.halve() };
    let centroids = partition(set.references, set.room, middle, &cut, &parts);
    set.exchange(middle, [0, 1].map(|side| PrimInfo { bounds: bounds[side], centroids: centroids[side] }))
}

fn partition(from: &[PrimRef], to: &mut [PrimRef], middle: usize, cut: &SplitPlane, parts: &[Bins]) -> [NodeBox; 2] {
    let (mut left, mut right) = to.split_at_mut(middle);
    let mut moves = Vec::with_capacity(parts.len());
    for (from, bins) in from.chunks(CHUNK).zip(parts) {
        let on_left = bins.left_of(cut);
        let (to_left, left_rest) = left.split_at_mut(on_left);
        let (to_right, right_rest) = right.split_at_mut(from.len() - on_left);
        (left, right) = (left_rest, right_rest);
        moves.push(Move { from, to: [to_left, to_right] });
    }
    moves
        .into_par_iter()
        .map(|Move { from, to }| scatter(from, cut, to))
        .reduce(|| [NodeBox::EMPTY; 2], |a, b| [a[0].union(b[0]), a[1].union(b[1])])
}

impl PrimInfo {
    /// As [`PrimInfo::of`], on several threads.
    pub(super) fn of_many(references: &[PrimRef]) -> Self {
        references.par_chunks(CHUNK).map(Self::of).reduce(|| Self::EMPTY, Self::union)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wide::build::binning::{Axes, NormalizedArea};
    use crate::{wide::build::leaf_policy::LeafPolicy, wide::build::reference::Run, wide::build::tests::soup};

    #[test]
    fn chunks_are_cut_as_the_whole_is() {
        let cut = |in_chunks: bool, axes| {
            let mut references = soup(LARGE as u32 + 12_345, 9, 1.0);
            let (mut room, mut order) = (vec![PrimRef::NONE; references.len()], vec![Run::default(); references.len()]);
            let extent = PrimInfo::of(&references);
            assert_eq!(PrimInfo::of_many(&references), extent);
            let config = BuildConfig {
                unit: NormalizedArea::new(&extent.bounds),
                axes,
                leaf_policy: LeafPolicy::STRICT,
                pairs: true,
                max_leaf: 8,
            };
            let set =
                Set { references: &mut references, room: &mut room, order: &mut order, first: 0, extent, depth: 0 };
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
