//! The surface area heuristic for any bounding volume.

use core::iter::once;

use super::volume::BoundingVolume;
use crate::binned_sah::{Bin, best_split, centroid_bounds, split_set};
use crate::prim_bounds::Item;
use crate::top_down::SliceSplit;

/// Splits by the surface area heuristic (MacDonald and Booth 1990, Wald 2007). The measure of the volume around the
/// bins of a side replaces the area of a box.
pub(super) fn split<V: BoundingVolume>(
    items: &mut [Item],
    measure: &f64,
    depth: u32,
) -> Option<SliceSplit<[V; 2], f64>> {
    let centroids = centroid_bounds(items);
    // The measure of a volume is never NaN.
    let cost = |bin: &Bin<_>| V::around(once(bin.bounds)).measure() * f64::from(bin.count);
    let best = best_split(items, &centroids, depth, cost).filter(|best| best.cost < f64::INFINITY);
    let (middle, _) = split_set(items, &centroids, *measure, best)?;
    let payload = [&items[..middle], &items[middle..]].map(around::<V>);
    Some(SliceSplit { middle, payload, states: payload.map(|volume| volume.measure()) })
}

/// Volume around all items.
pub(super) fn around<V: BoundingVolume>(items: &[Item]) -> V {
    V::around(items.iter().map(|&(_, own)| own))
}
