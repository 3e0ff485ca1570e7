//! Where to cut a set of boxes in two: the surface area heuristic over bins of centroids.

use core::cmp::Ordering;

use glam::Vec3A;

use super::node::NodeBox;
use crate::bounded_depth::leaves_room_for_halving;

/// Most primitives in a leaf, unless there are that few in all.
pub(super) const MAX_LEAF: usize = 8;

/// Cost of visiting a node relative to that of testing a primitive.
const NODE_COST: f64 = 1.5;

/// What is expected of a leaf of so many primitives, or of a node if there are none, in visits of a node.
pub(super) fn cost(count: u32) -> f64 {
    if count == 0 { 1.0 } else { f64::from(count) / NODE_COST }
}

pub(super) const BINS: usize = 16;

/// One primitive while the tree grows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item {
    pub(super) bounds: NodeBox,
    pub(super) index: u32,
}

impl AsRef<Self> for Item {
    #[inline(always)]
    fn as_ref(&self) -> &Self {
        self
    }
}

impl Item {
    /// Twice the centre of the box, which orders items just as well.
    #[inline(always)]
    fn centroid(&self) -> Vec3A {
        self.bounds.min + self.bounds.max
    }
}

/// Two halves of a set: the first `middle` items, and the others.
pub(super) struct Split {
    pub(super) middle: usize,
    pub(super) bounds: [NodeBox; 2],
}

/// How a set of primitives is cut in two.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SplitMethod {
    /// Into equal halves, at the median centre along the widest axis (Kay and Kajiya 1986): the fastest to build, and
    /// the slowest to trace unless primitives are evenly spread.
    Median,
    /// Where the surface area heuristic (MacDonald and Booth 1990) is least, over bins (Wald 2007).
    #[default]
    SurfaceArea,
    /// As the one before, but where the boxes of both sides would overlap, a plane may cut through primitives, which
    /// are then listed on both sides (Stich, Friedrich and Dietrich, "Spatial Splits in Bounding Volume Hierarchies",
    /// 2009). Slower to build, on one thread, and up to half as many references more; worth it where large primitives
    /// reach through many small ones.
    Spatial,
}

/// Reorders `items` and cuts them in two, or returns `None` where they should be a leaf.
///
/// The surface area heuristic (MacDonald and Booth 1990) is evaluated at the borders of 16 bins on each axis (Wald
/// 2007). Where it finds no cut, because all centroids coincide, and where its cuts have used up the depth that
/// halving needs, the set is halved.
pub(super) fn split(items: &mut [Item], bounds: &NodeBox, depth: u32, method: SplitMethod) -> Option<Split> {
    if items.len() < 2 {
        return None;
    }
    let centroids = centroid_box(items);
    let by_area = method != SplitMethod::Median && leaves_room_for_halving(items.len(), depth);
    let cut = if by_area { Binning::new(&centroids).best_cut(items) } else { None };
    if is_leaf(items.len(), bounds, cut.as_ref().map(|cut| cut.cost)) {
        return None;
    }
    Some(match cut {
        Some(cut) => {
            let middle = partition(items, |item| cut.binning.bin(item)[cut.axis] < cut.bin);
            Split { middle, bounds: cut.bounds }
        }
        None => halve(items, &centroids),
    })
}

/// True if a set is better left whole than cut at this cost: area times number of primitives, summed over both sides.
pub(super) fn is_leaf(count: usize, bounds: &NodeBox, cut_cost: Option<f64>) -> bool {
    let leaf_cost = count as f64 * bounds.half_area();
    count <= MAX_LEAF && cut_cost.is_none_or(|cost| leaf_cost <= NODE_COST * bounds.half_area() + cost)
}

/// The box around all centroids, on the scale of [`Item::centroid`].
pub(super) fn centroid_box<T: AsRef<Item>>(items: &[T]) -> NodeBox {
    items
        .iter()
        .map(|item| item.as_ref().centroid())
        .fold(NodeBox::EMPTY, |all, c| NodeBox { min: all.min.min(c), max: all.max.max(c) })
}

/// Cuts at the median centroid of the widest axis; by order alone if all centroids coincide.
pub(super) fn halve<T: AsRef<Item>>(items: &mut [T], centroids: &NodeBox) -> Split {
    let extent = centroids.max - centroids.min;
    if extent.cmpgt(Vec3A::ZERO).any() {
        let axis = extent.max_position();
        items.sort_unstable_by(|a, b| {
            let (a, b) = (a.as_ref(), b.as_ref());
            let by_place = a.centroid()[axis].total_cmp(&b.centroid()[axis]);
            if by_place == Ordering::Equal { a.index.cmp(&b.index) } else { by_place }
        });
    }
    let middle = items.len() / 2;
    let (left, right) = items.split_at(middle);
    Split { middle, bounds: [left, right].map(union) }
}

/// The box around all items.
pub(super) fn union<T: AsRef<Item>>(items: &[T]) -> NodeBox {
    items.iter().fold(NodeBox::EMPTY, |all, item| all.union(item.as_ref().bounds))
}

/// Moves the items for which `is_left` holds to the front, in a fixed order, and counts them.
pub(super) fn partition<T: AsRef<Item>>(items: &mut [T], is_left: impl Fn(&Item) -> bool) -> usize {
    let (mut left, mut right) = (0, items.len());
    loop {
        while left < right && is_left(items[left].as_ref()) {
            left += 1;
        }
        while left < right && !is_left(items[right - 1].as_ref()) {
            right -= 1;
        }
        if left >= right {
            return left;
        }
        items.swap(left, right - 1);
    }
}

/// The map from centroids to bins.
#[derive(Clone, Copy)]
pub(super) struct Binning {
    least: Vec3A,
    scale: Vec3A,
}

/// A cut between two bins.
pub(super) struct Cut {
    pub(super) binning: Binning,
    pub(super) axis: usize,
    /// First bin on the right.
    pub(super) bin: usize,
    /// Area times number of primitives, summed over both sides.
    pub(super) cost: f64,
    pub(super) bounds: [NodeBox; 2],
}

#[derive(Clone, Copy)]
pub(super) struct Bin {
    pub(super) bounds: NodeBox,
    pub(super) count: u32,
}

impl Bin {
    pub(super) const EMPTY: Self = Self { bounds: NodeBox::EMPTY, count: 0 };

    #[inline(always)]
    pub(super) fn merge(self, other: &Self) -> Self {
        Self { bounds: self.bounds.union(other.bounds), count: self.count + other.count }
    }

    pub(super) fn cost(&self) -> f64 {
        self.bounds.half_area() * f64::from(self.count)
    }
}

impl Binning {
    pub(super) fn new(centroids: &NodeBox) -> Self {
        Self { least: centroids.min, scale: Vec3A::splat(BINS as f32) / (centroids.max - centroids.min) }
    }

    /// The bin of an item on each axis. A NaN, where all centroids coincide on an axis, is bin 0.
    #[inline(always)]
    pub(super) fn bin(&self, item: &Item) -> [usize; 3] {
        let position = (item.centroid() - self.least) * self.scale;
        position.to_array().map(|x| (x as usize).min(BINS - 1))
    }

    /// The cheapest cut with primitives on both sides; the first one in order of axes and bins where several are.
    pub(super) fn best_cut<T: AsRef<Item>>(&self, items: &[T]) -> Option<Cut> {
        let mut bins = [[Bin::EMPTY; BINS]; 3];
        for item in items {
            let item = item.as_ref();
            let place = self.bin(item);
            for axis in 0..3 {
                let bin = &mut bins[axis][place[axis]];
                *bin = bin.merge(&Bin { bounds: item.bounds, count: 1 });
            }
        }
        let mut best: Option<Cut> = None;
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
                let cost = left.cost() + right.cost();
                if best.as_ref().is_none_or(|best| cost < best.cost) {
                    best = Some(Cut { binning: *self, axis, bin: bin + 1, cost, bounds: [left.bounds, right.bounds] });
                }
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn item(index: u32, x: f32) -> Item {
        let min = Vec3A::new(x, 0.0, 0.0);
        Item { bounds: NodeBox { min, max: min + 0.5 }, index }
    }

    fn order(items: &[Item]) -> Vec<u32> {
        items.iter().map(|item| item.index).collect()
    }

    #[test]
    fn clusters_are_separated() {
        let mut items: Vec<_> = [0.0, 100.0, 1.0, 101.0, 2.0, 3.0].iter().zip(0..).map(|(&x, i)| item(i, x)).collect();
        let split =
            split(&mut items, &NodeBox { min: Vec3A::ZERO, max: Vec3A::splat(101.5) }, 0, SplitMethod::SurfaceArea)
                .expect("a split");
        assert_eq!(split.middle, 4);
        assert_eq!((split.bounds[0].max.x, split.bounds[1].min.x), (3.5, 100.0));
    }

    #[test]
    fn overlapping_items_are_a_leaf() {
        let mut items: Vec<_> = (0..4).map(|i| item(i, 0.01 * i as f32)).collect();
        let bounds = union(&items);
        assert!(split(&mut items, &bounds, 0, SplitMethod::SurfaceArea).is_none());
    }

    #[test]
    fn lopsided_sets_are_halved_when_depth_runs_out() {
        let lopsided = || (0..1000).map(|i| item(i, if i == 0 { 1e6 } else { i as f32 })).collect::<Vec<_>>();
        let mut items = lopsided();
        let bounds = union(&items);
        assert_eq!(
            split(&mut items, &bounds, 49, SplitMethod::SurfaceArea).map(|split| split.middle),
            Some(999),
            "2¹⁰ items fit below 50"
        );
        let mut items = lopsided();
        assert_eq!(split(&mut items, &bounds, 50, SplitMethod::SurfaceArea).map(|split| split.middle), Some(500));
        assert_eq!(order(&items)[..3], [1, 2, 3]);
        assert_eq!(order(&items)[999], 0);
    }

    #[test]
    fn coinciding_centroids_are_halved_in_order() {
        let mut items: Vec<_> = (0..20).map(|i| item(i, 3.0)).collect();
        let bounds = union(&items);
        assert_eq!(split(&mut items, &bounds, 0, SplitMethod::SurfaceArea).map(|split| split.middle), Some(10));
        assert_eq!(order(&items), (0..20).collect::<Vec<_>>());
    }

    #[test]
    fn infinite_extents_are_halved() {
        let mut items: Vec<_> =
            (0..20).map(|i| item(i, [f32::NEG_INFINITY, 0.0, f32::INFINITY][i as usize % 3])).collect();
        let bounds = union(&items);
        assert_eq!(split(&mut items, &bounds, 0, SplitMethod::SurfaceArea).map(|split| split.middle), Some(10));
    }

    #[test]
    fn partition_keeps_every_item() {
        for pattern in 0u32..256 {
            let mut items: Vec<_> = (0..8).map(|i| item(i, 0.0)).collect();
            let is_left = |item: &Item| pattern >> item.index & 1 == 1;
            let middle = partition(&mut items, is_left);
            assert_eq!(middle, pattern.count_ones() as usize);
            assert!(items[..middle].iter().all(is_left) && !items[middle..].iter().any(is_left));
            let mut all = order(&items);
            all.sort_unstable();
            assert_eq!(all, (0..8).collect::<Vec<_>>());
        }
    }
}
