//! Splits of sets of primitives for the binary trees: the surface area heuristic over binned centroids, and the median. `WideBvh` has
//! its own in `wide/build/binning.rs`.
//!
//! MacDonald and Booth, "Heuristics for ray tracing using space subdivision", 1990; Wald, "On fast Construction of
//! SAH-based Bounding Volume Hierarchies", 2007.

use glam::DVec3;
use rt_math::Aabb;

use crate::traversal::depth_allows_median_split;

/// Maximum number of primitives in a leaf. Larger sets are split whatever the cost, if a split exists.
pub(crate) const MAX_LEAF: usize = 8;

/// Cost of visiting a node relative to that of testing a primitive.
const NODE_COST: f64 = 1.5;

/// Number of bins per axis.
pub(crate) const BINS: usize = 16;

/// Cost of a leaf of `count` primitives, in visits of a node. 0 stands for an inner node.
pub(crate) fn relative_cost(count: u32) -> f64 {
    if count == 0 { 1.0 } else { f64::from(count) / NODE_COST }
}

/// Bounding boxes of one precision.
pub(crate) trait BuildBounds: Copy {
    type Vector: Copy;

    /// Neutral element of [`union`](Self::union).
    const EMPTY: Self;

    fn union(self, other: Self) -> Self;

    /// The smallest box around this one and a point.
    fn include(self, point: Self::Vector) -> Self;

    /// Centre times a constant of the type, which cancels when it is binned.
    fn centroid(&self) -> Self::Vector;

    /// Axis of the largest extent, and whether that is positive.
    fn widest_axis(&self) -> (usize, bool);

    /// Coordinate of a point along an axis.
    fn coordinate(point: Self::Vector, axis: usize) -> f64;

    /// Number of bins per unit of length, if this box is divided evenly on each axis.
    fn bin_scale(&self) -> Self::Vector;

    /// Bin of a point on each axis. NaN, from an axis without extent, is in bin 0.
    fn bin(&self, scale: Self::Vector, point: Self::Vector) -> [usize; 3];
}

impl BuildBounds for Aabb {
    type Vector = DVec3;

    const EMPTY: Self = Self::EMPTY;

    fn union(self, other: Self) -> Self {
        self.union(other)
    }

    fn include(self, point: DVec3) -> Self {
        self.include(point)
    }

    fn centroid(&self) -> DVec3 {
        self.centre()
    }

    fn widest_axis(&self) -> (usize, bool) {
        let extent = self.extent();
        (extent.max_position(), extent.cmpgt(DVec3::ZERO).any())
    }

    fn coordinate(point: DVec3, axis: usize) -> f64 {
        point[axis]
    }

    fn bin_scale(&self) -> DVec3 {
        BINS as f64 / self.extent()
    }

    fn bin(&self, scale: DVec3, point: DVec3) -> [usize; 3] {
        ((point - self.min) * scale).to_array().map(|x| (x as usize).min(BINS - 1))
    }
}

/// Primitive, or part of one, in the set that is split.
pub(crate) trait BuildItem: Copy {
    type Bounds: BuildBounds;

    fn bounds(&self) -> &Self::Bounds;

    fn index(&self) -> u32;
}

impl<B: BuildBounds> BuildItem for (u32, B) {
    type Bounds = B;

    #[inline(always)]
    fn bounds(&self) -> &B {
        &self.1
    }

    #[inline(always)]
    fn index(&self) -> u32 {
        self.0
    }
}

/// Union of all bounds.
pub(crate) fn bounds_of<I: BuildItem>(items: &[I]) -> I::Bounds {
    items.iter().fold(I::Bounds::EMPTY, |all, item| all.union(*item.bounds()))
}

/// Bounds of all centroids.
pub(crate) fn centroid_bounds<I: BuildItem>(items: &[I]) -> I::Bounds {
    items.iter().fold(I::Bounds::EMPTY, |all, item| all.include(item.bounds().centroid()))
}

/// Sorts by centroid along the widest axis of `centroids`, ties by index; keeps the order if all centroids coincide.
/// Returns the size of the first half.
pub(crate) fn median_split<I: BuildItem>(items: &mut [I], centroids: &I::Bounds) -> usize {
    if let (axis, true) = centroids.widest_axis() {
        let key = |(place, item): (usize, &I)| {
            (I::Bounds::coordinate(item.bounds().centroid(), axis), item.index(), place as u32)
        };
        let mut order: Vec<_> = items.iter().enumerate().map(key).collect();
        sort_by_coordinate(&mut order);
        let sorted: Vec<_> = order.iter().map(|&(_, _, place)| items[place as usize]).collect();
        items.copy_from_slice(&sorted);
    }
    items.len() / 2
}

/// Sorts coordinates, indices and places. It is not generic, so that the sort is compiled once.
fn sort_by_coordinate(order: &mut [(f64, u32, u32)]) {
    order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
}

/// Moves the items for which `is_left` holds to the front, in a fixed order, and counts them.
pub(crate) fn partition<I>(items: &mut [I], is_left: impl Fn(&I) -> bool) -> usize {
    let (mut left, mut right) = (0, items.len());
    loop {
        while left < right && is_left(&items[left]) {
            left += 1;
        }
        while left < right && !is_left(&items[right - 1]) {
            right -= 1;
        }
        if left >= right {
            return left;
        }
        items.swap(left, right - 1);
    }
}

/// Bounds and number of the primitives in a bin.
#[derive(Clone, Copy)]
pub(crate) struct Bin<B> {
    pub(crate) bounds: B,
    pub(crate) count: u32,
}

impl<B: BuildBounds> Bin<B> {
    pub(crate) const EMPTY: Self = Self { bounds: B::EMPTY, count: 0 };

    #[inline(always)]
    pub(crate) fn merge(self, other: &Self) -> Self {
        Self { bounds: self.bounds.union(other.bounds), count: self.count + other.count }
    }
}

/// Split between two bins.
pub(crate) struct BinnedSplit<B: BuildBounds> {
    centroids: B,
    scale: B::Vector,
    axis: usize,
    /// First bin on the right.
    bin: usize,
    /// Area times number of primitives, summed over both sides.
    pub(crate) cost: f64,
    pub(crate) bounds: [B; 2],
}

impl<B: BuildBounds> BinnedSplit<B> {
    /// The cheapest split with primitives on both sides, the first one in order of axes and bins on a tie.
    fn best<I: BuildItem<Bounds = B>>(items: &[I], centroids: &B, cost: impl Fn(&Bin<B>) -> f64) -> Option<Self> {
        let scale = centroids.bin_scale();
        let mut bins = [[Bin::EMPTY; BINS]; 3];
        for item in items {
            let bounds = *item.bounds();
            let bin = centroids.bin(scale, bounds.centroid());
            for axis in 0..3 {
                let bin = &mut bins[axis][bin[axis]];
                *bin = bin.merge(&Bin { bounds, count: 1 });
            }
        }
        let mut best: Option<Self> = None;
        for (axis, bins) in bins.iter().enumerate() {
            let mut right_of = [Bin::EMPTY; BINS];
            for bin in (0..BINS - 1).rev() {
                right_of[bin] = right_of[bin + 1].merge(&bins[bin + 1]);
            }
            let mut left = Bin::EMPTY;
            for bin in 0..BINS - 1 {
                left = left.merge(&bins[bin]);
                let right = &right_of[bin];
                if left.count == 0 || right.count == 0 {
                    continue;
                }
                let (cost, bounds) = (cost(&left) + cost(right), [left.bounds, right.bounds]);
                if best.as_ref().is_none_or(|best| cost < best.cost) {
                    best = Some(Self { centroids: *centroids, scale, axis, bin: bin + 1, cost, bounds });
                }
            }
        }
        best
    }

    #[inline(always)]
    pub(crate) fn is_left<I: BuildItem<Bounds = B>>(&self, item: &I) -> bool {
        self.centroids.bin(self.scale, item.bounds().centroid())[self.axis] < self.bin
    }
}

/// True if a set whose bounds have this area costs no more as a leaf than after a split of cost `split_cost`.
pub(crate) fn is_leaf(count: usize, area: f64, split_cost: Option<f64>) -> bool {
    let leaf_cost = count as f64 * area;
    count <= MAX_LEAF && split_cost.is_none_or(|cost| leaf_cost <= NODE_COST * area + cost)
}

/// The cheapest binned split, unless it could leave too little depth for median splits.
pub(crate) fn best_split<I: BuildItem>(
    items: &[I],
    centroids: &I::Bounds,
    depth: u32,
    cost: impl Fn(&Bin<I::Bounds>) -> f64,
) -> Option<BinnedSplit<I::Bounds>> {
    let is_allowed = items.len() > 1 && depth_allows_median_split(items.len(), depth);
    if is_allowed { BinnedSplit::best(items, centroids, cost) } else { None }
}

/// Reorders `items` by `best`, or at the median without one. Returns the number of items on the left and the bounds of
/// both sides, or `None` where a leaf costs no more.
pub(crate) fn split_set<I: BuildItem>(
    items: &mut [I],
    centroids: &I::Bounds,
    area: f64,
    best: Option<BinnedSplit<I::Bounds>>,
) -> Option<(usize, [I::Bounds; 2])> {
    if is_leaf(items.len(), area, best.as_ref().map(|best| best.cost)) {
        return None;
    }
    Some(match best {
        Some(best) => (partition(items, |item| best.is_left(item)), best.bounds),
        None => {
            let middle = median_split(items, centroids);
            (middle, [bounds_of(&items[..middle]), bounds_of(&items[middle..])])
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    type Item = (u32, Aabb);

    fn item(index: u32, x: f64) -> Item {
        let min = DVec3::new(x, 0.0, 0.0);
        (index, Aabb::new(min, min + 0.5))
    }

    fn order(items: &[Item]) -> Vec<u32> {
        items.iter().map(|item| item.0).collect()
    }

    fn split(items: &mut [Item], depth: u32) -> Option<(usize, [Aabb; 2])> {
        let centroids = centroid_bounds(items);
        let best = best_split(items, &centroids, depth, |bin| bin.bounds.surface_area() * f64::from(bin.count));
        split_set(items, &centroids, bounds_of(items).surface_area(), best)
    }

    fn middle(items: &mut [Item], depth: u32) -> Option<usize> {
        split(items, depth).map(|(middle, _)| middle)
    }

    #[test]
    fn clusters_are_separated() {
        let mut items: Vec<_> = [0.0, 100.0, 1.0, 101.0, 2.0, 3.0].iter().zip(0..).map(|(&x, i)| item(i, x)).collect();
        let (middle, bounds) = split(&mut items, 0).expect("a split");
        assert_eq!(middle, 4);
        assert_eq!((bounds[0].max.x, bounds[1].min.x), (3.5, 100.0));
    }

    #[test]
    fn overlapping_items_are_a_leaf() {
        let mut items: Vec<_> = (0..4).map(|i| item(i, 0.01 * f64::from(i))).collect();
        assert!(split(&mut items, 0).is_none());
    }

    #[test]
    fn lopsided_sets_are_halved_when_depth_runs_out() {
        let lopsided = || (0..1000).map(|i| item(i, if i == 0 { 1e6 } else { f64::from(i) })).collect::<Vec<_>>();
        assert_eq!(middle(&mut lopsided(), 49), Some(999), "2¹⁰ items fit below 50");
        let mut items = lopsided();
        assert_eq!(middle(&mut items, 50), Some(500));
        assert_eq!(order(&items)[..3], [1, 2, 3]);
        assert_eq!(order(&items)[999], 0);
    }

    #[test]
    fn coinciding_centroids_are_halved_in_order() {
        let mut items: Vec<_> = (0..20).map(|i| item(i, 3.0)).collect();
        assert_eq!(middle(&mut items, 0), Some(10));
        assert_eq!(order(&items), (0..20).collect::<Vec<_>>());
    }

    #[test]
    fn infinite_extents_are_halved() {
        let mut items: Vec<_> =
            (0..20).map(|i| item(i, [f64::NEG_INFINITY, 0.0, f64::INFINITY][i as usize % 3])).collect();
        assert_eq!(middle(&mut items, 0), Some(10));
    }

    #[test]
    fn partition_keeps_every_item() {
        for pattern in 0u32..256 {
            let mut items: Vec<_> = (0..8).map(|i| item(i, 0.0)).collect();
            let is_left = |item: &Item| pattern >> item.0 & 1 == 1;
            let middle = partition(&mut items, is_left);
            assert_eq!(middle, pattern.count_ones() as usize);
            assert!(items[..middle].iter().all(is_left) && !items[middle..].iter().any(is_left));
            let mut all = order(&items);
            all.sort_unstable();
            assert_eq!(all, (0..8).collect::<Vec<_>>());
        }
    }
}
