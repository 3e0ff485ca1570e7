//! Where to cut a set of boxes in two: the surface area heuristic for any volume.

use core::iter::once;

use glam::DVec3;
use rt_math::Aabb;

use super::volume::BoundingVolume;
use crate::bounded_depth::leaves_room_for_halving;
use crate::tree::{Cut, Item, halve, partition};

/// Most primitives in a leaf, unless there are that few in all.
pub(super) const MAX_LEAF: usize = 8;

/// Cost of visiting a node relative to that of testing a primitive.
const NODE_COST: f64 = 1.5;

const BINS: usize = 16;

/// Reorders `items` and cuts them in two, or returns `None` where they should be a leaf.
///
/// As for boxes (MacDonald and Booth 1990, Wald 2007), with the measure of the volume in the place of the area of the
/// box: the volume around what is in the bins on either side, which stands for the volume around the primitives. Where
/// there is no such cut, because all centres coincide, and where these have used up the depth that halving needs, the
/// set is halved.
pub(super) fn split<V: BoundingVolume>(items: &mut [Item], measure: &f64, depth: u32) -> Option<Cut<[V; 2], f64>> {
    if items.len() < 2 {
        return None;
    }
    let centres = Aabb::from_points(items.iter().map(|(_, own)| own.centre()));
    let best =
        if leaves_room_for_halving(items.len(), depth) { Binning::new(&centres).best_border::<V>(items) } else { None };
    if items.len() <= MAX_LEAF {
        let leaf_cost = items.len() as f64 * measure;
        if best.as_ref().is_none_or(|border| leaf_cost <= NODE_COST * measure + border.cost) {
            return None;
        }
    }
    let middle = match best {
        Some(border) => partition(items, |(_, own)| border.binning.bin(own)[border.axis] < border.bin),
        None => halve(items, &centres),
    };
    let content = [&items[..middle], &items[middle..]].map(around::<V>);
    Some(Cut { middle, content, sides: content.map(|volume| volume.measure()) })
}

/// The volume around all items.
pub(super) fn around<V: BoundingVolume>(items: &[Item]) -> V {
    V::around(items.iter().map(|&(_, own)| own))
}

/// The map from centres to bins.
#[derive(Clone, Copy)]
struct Binning {
    least: DVec3,
    scale: DVec3,
}

/// The place between two bins.
struct Border {
    binning: Binning,
    axis: usize,
    /// First bin on the right.
    bin: usize,
    /// Measure times number of primitives, summed over both sides.
    cost: f64,
}

#[derive(Clone, Copy)]
struct Bin {
    bounds: Aabb,
    count: usize,
}

impl Bin {
    const EMPTY: Self = Self { bounds: Aabb::EMPTY, count: 0 };

    fn merge(self, other: &Self) -> Self {
        Self { bounds: self.bounds.union(other.bounds), count: self.count + other.count }
    }

    fn cost<V: BoundingVolume>(&self) -> f64 {
        V::around(once(self.bounds)).measure() * self.count as f64
    }
}

impl Binning {
    fn new(centres: &Aabb) -> Self {
        Self { least: centres.min, scale: BINS as f64 / centres.extent() }
    }

    /// The bin of a box on each axis. A NaN, where all centres coincide on an axis, is bin 0.
    fn bin(&self, own: &Aabb) -> [usize; 3] {
        let position = (own.centre() - self.least) * self.scale;
        position.to_array().map(|x| (x as usize).min(BINS - 1))
    }

    /// The cheapest border with primitives on both sides; the first one in order of axes and bins where several are.
    fn best_border<V: BoundingVolume>(&self, items: &[Item]) -> Option<Border> {
        let mut bins = [[Bin::EMPTY; BINS]; 3];
        for (_, own) in items {
            let place = self.bin(own);
            for axis in 0..3 {
                let bin = &mut bins[axis][place[axis]];
                *bin = bin.merge(&Bin { bounds: *own, count: 1 });
            }
        }
        let mut best: Option<Border> = None;
        for (axis, bins) in bins.iter().enumerate() {
            let mut right_of = [Bin::EMPTY; BINS];
            for bin in (0..BINS - 1).rev() {
                right_of[bin] = right_of[bin + 1].merge(&bins[bin + 1]);
            }
            let mut left = Bin::EMPTY;
            for bin in 1..BINS {
                left = left.merge(&bins[bin - 1]);
                let right = right_of[bin - 1];
                // Next to an empty bin the cut is the one before.
                if bins[bin - 1].count == 0 || right.count == 0 {
                    continue;
                }
                let cost = left.cost::<V>() + right.cost::<V>();
                if cost < best.as_ref().map_or(f64::INFINITY, |best| best.cost) {
                    best = Some(Border { binning: *self, axis, bin, cost });
                }
            }
        }
        best
    }
}
