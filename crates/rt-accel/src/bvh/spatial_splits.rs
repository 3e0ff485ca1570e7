//! Spatial splits: planes that cut through primitives.
//!
//! # Why no primitive is lost
//!
//! A reference is the part of a primitive's box on one side of every plane that has cut it. Let a ray pass the padded
//! bounds of a primitive, entering it at `e` in the sense of `intersect_primitive`. Some reference is entered no later
//! than `e`, by induction. The whole box is (see `node.rs`). If a plane cuts a reference that is, one of the two parts
//! is. Take a direction in which the left part comes first. It is entered where the whole was, and left where the whole
//! was left or at `leave(s)`, the crossing of the plane, whichever is first. If `e ≤ leave(s)`, the ray passes it.
//! Otherwise `e > leave(s) ≥ enter(s)`, so the right part is entered at `max(e, enter(s)) = e` and left where the whole
//! was. Here `enter(s) ≤ leave(s)` because far planes are seen from an origin that is farther back, and moved outward
//! on either side of `t` = 0. A ray along the plane is not constrained by it, and passes at least the part that its
//! origin lies in.
//!
//! The parts of a primitive tile space: each has a [`SplitCell`], bounded only by the planes that have cut it. So a
//! point belongs to exactly one part, by which a search of space visits each primitive once.

use core::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use glam::{DVec3, Vec3A};

use super::node::{Aabb32, BvhNode};
use crate::binned_sah::{
    BINS, Bin, BuildItem, best_split, bounds_of, centroid_bounds, is_leaf, median_split, partition,
};
use crate::top_down::{Split, Subtree, build_top_down};
use crate::traversal::depth_allows_median_split;

/// Maximum number of additional references, relative to the number of primitives.
const MOST_REPEATED: f64 = 0.5;

/// Minimum overlap of the boxes of both sides for which spatial splits are evaluated, relative to the area of the
/// scene. The α of Stich, Friedrich and Dietrich 2009.
const OVERLAP: f64 = 1e-5;

/// Part of space of a reference, bounded by the planes that have cut its primitive. Half open: the lower planes belong
/// to it. Relative to the centre of the tree. The extreme finite `f32` represent missing planes, because not every
/// serialisation format has infinity.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct SplitCell {
    pub(super) min: [f32; 3],
    pub(super) max: [f32; 3],
}

impl SplitCell {
    pub(crate) const EVERYWHERE: Self = Self { min: [f32::MIN; 3], max: [f32::MAX; 3] };

    /// True if the cell owns a point.
    pub(super) fn owns(&self, point: DVec3, centre: DVec3) -> bool {
        let place = point - centre;
        (0..3).all(|axis| {
            let (min, max) = (self.min[axis], self.max[axis]);
            (min == f32::MIN || f64::from(min) <= place[axis]) && (max == f32::MAX || place[axis] < f64::from(max))
        })
    }

    /// Part of a box in the cell, one step wider, so that it contains points in the planes after any rounding.
    pub(super) fn clip(&self, whole: &Aabb32) -> Aabb32 {
        whole.intersection(Aabb32 {
            min: Vec3A::from_array(self.min.map(f32::next_down)),
            max: Vec3A::from_array(self.max.map(f32::next_up)),
        })
    }

    pub(super) fn cut(&self, axis: usize, plane: f32) -> [Self; 2] {
        let [mut left, mut right] = [*self; 2];
        left.max[axis] = plane;
        right.min[axis] = plane;
        [left, right]
    }
}

/// Cell of a reference to a primitive with several references.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct SplitRef {
    /// Position in the list of all references.
    pub(super) position: u32,
    pub(super) cell: SplitCell,
}

/// Part of a primitive during construction.
#[derive(Clone, Copy)]
struct ClippedRef {
    index: u32,
    bounds: Aabb32,
    /// Bounds of the whole primitive.
    whole: Aabb32,
    cell: SplitCell,
}

impl BuildItem for ClippedRef {
    type Bounds = Aabb32;

    fn bounds(&self) -> &Aabb32 {
        &self.bounds
    }

    fn index(&self) -> u32 {
        self.index
    }
}

impl ClippedRef {
    /// Parts on both sides of a plane that cuts through.
    fn cut(&self, axis: usize, plane: f32) -> [Self; 2] {
        self.cell.cut(axis, plane).map(|cell| Self { bounds: cell.clip(&self.whole), cell, ..*self })
    }
}

/// Set of references that becomes a leaf or a node.
struct BuildRecord {
    refs: Vec<ClippedRef>,
    bounds: Aabb32,
    depth: u32,
}

/// Builds the tree, and the cells of split primitives by rising position.
pub(super) fn build(items: &[(u32, Aabb32)]) -> (Subtree<BvhNode>, Vec<SplitRef>) {
    let bounds = bounds_of(items);
    let whole_ref = |&(index, whole): &_| ClippedRef { index, bounds: whole, whole, cell: SplitCell::EVERYWHERE };
    let spare = AtomicUsize::new((items.len() as f64 * MOST_REPEATED) as usize);
    let min_overlap = bounds.half_area() * OVERLAP;
    let cells = Mutex::new(Vec::new());
    let task = BuildRecord { refs: items.iter().map(whole_ref).collect(), bounds, depth: 0 };
    let tree = build_top_down(task, &|task: BuildRecord, indices| {
        let depth = task.depth + 1;
        match split(task.refs, &task.bounds, task.depth, &spare, min_overlap) {
            Ok((sides, bounds)) => {
                let [left, right] = sides;
                let tasks = [
                    BuildRecord { refs: left, bounds: bounds[0], depth },
                    BuildRecord { refs: right, bounds: bounds[1], depth },
                ];
                Some(Split { payload: bounds, tasks, is_large: false })
            }
            Err(leaf) => {
                let mut cells = cells.lock().unwrap_or_else(PoisonError::into_inner);
                for ClippedRef { index, cell, .. } in leaf {
                    if cell != SplitCell::EVERYWHERE {
                        cells.push(SplitRef { position: indices.len() as u32, cell });
                    }
                    indices.push(index);
                }
                None
            }
        }
    });
    let mut cells = cells.into_inner().unwrap_or_else(PoisonError::into_inner);
    cells.shrink_to_fit();
    (tree, cells)
}

/// Two sets of references and their bounds.
type Sides = ([Vec<ClippedRef>; 2], [Aabb32; 2]);

/// The cheapest split of a set, or the set itself where a leaf costs no more. Uses up `spare` references.
fn split(
    mut refs: Vec<ClippedRef>,
    bounds: &Aabb32,
    depth: u32,
    spare: &AtomicUsize,
    min_overlap: f64,
) -> Result<Sides, Vec<ClippedRef>> {
    let centroids = centroid_bounds(&refs);
    let binned = best_split(&refs, &centroids, depth, bin_cost);
    let mut plane = None;
    if refs.len() > 1 && depth_allows_median_split(refs.len(), depth) {
        let overlap = binned.as_ref().map(|split| split.bounds[0].intersection(split.bounds[1]));
        if overlap.is_none_or(|overlap| proper_half_area(&overlap) > min_overlap) {
            plane = SpatialSplit::best(&refs, bounds, spare.load(Ordering::Relaxed));
        }
    }
    let costs = [binned.as_ref().map(|split| split.cost), plane.as_ref().map(|plane| plane.cost)];
    if is_leaf(refs.len(), bounds.half_area(), costs.into_iter().flatten().reduce(f64::min)) {
        return Err(refs);
    }
    if let Some(plane) = plane.filter(|plane| binned.as_ref().is_none_or(|split| plane.cost < split.cost)) {
        let sides = plane.divide(&refs);
        spare.fetch_sub(sides[0].len() + sides[1].len() - refs.len(), Ordering::Relaxed);
        let bounds = sides.each_ref().map(|side| bounds_of(side));
        return Ok((sides, bounds));
    }
    let (middle, bounds) = match binned {
        Some(split) => (partition(&mut refs, |item| split.is_left(item)), Some(split.bounds)),
        None => (median_split(&mut refs, &centroids), None),
    };
    let right = refs.split_off(middle);
    let bounds = bounds.unwrap_or_else(|| [bounds_of(&refs), bounds_of(&right)]);
    Ok(([refs, right], bounds))
}

/// Area times number of primitives.
pub(super) fn bin_cost(bin: &Bin<Aabb32>) -> f64 {
    bin.bounds.half_area() * f64::from(bin.count)
}

/// Half of the surface area, 0 for an empty box.
fn proper_half_area(bounds: &Aabb32) -> f64 {
    if bounds.min.cmple(bounds.max).all() { bounds.half_area() } else { 0.0 }
}

/// Candidate plane.
struct SpatialSplit {
    axis: usize,
    place: f32,
    /// Area times number of references, summed over both sides.
    cost: f64,
}

/// Side of a plane that contains a box; `None` if the plane cuts it.
fn side(bounds: &Aabb32, axis: usize, place: f32) -> Option<usize> {
    if bounds.min[axis] >= place {
        Some(1)
    } else if bounds.max[axis] <= place {
        Some(0)
    } else {
        None
    }
}

impl SpatialSplit {
    /// The cheapest of the planes that divide `bounds` evenly. Both sides must have fewer references than the set, and
    /// at most `spare` of them may be repeated.
    fn best(refs: &[ClippedRef], bounds: &Aabb32, spare: usize) -> Option<Self> {
        let mut best: Option<Self> = None;
        for axis in 0..3 {
            let step = (bounds.max[axis] - bounds.min[axis]) / BINS as f32;
            let planes: [f32; BINS - 1] = core::array::from_fn(|i| bounds.min[axis] + step * (i + 1) as f32);
            if !(step > 0.0 && step.is_finite()) {
                continue;
            }
            let Sweep { left, right } = Sweep::over(refs, axis, &planes);
            for (i, &place) in planes.iter().enumerate() {
                let counts = [left[i].count, right[i].count].map(|count| count as usize);
                let n = refs.len();
                let is_allowed =
                    counts.iter().all(|&count| 0 < count && count < n) && counts[0] + counts[1] <= n + spare;
                let cost = bin_cost(&left[i]) + bin_cost(&right[i]);
                if is_allowed && best.as_ref().is_none_or(|best| cost < best.cost) {
                    best = Some(Self { axis, place, cost });
                }
            }
        }
        best
    }

    fn divide(&self, refs: &[ClippedRef]) -> [Vec<ClippedRef>; 2] {
        let mut sides = [Vec::new(), Vec::new()];
        for prim_ref in refs {
            match side(&prim_ref.bounds, self.axis, self.place) {
                Some(side) => sides[side].push(*prim_ref),
                None => {
                    for (side, part) in sides.iter_mut().zip(prim_ref.cut(self.axis, self.place)) {
                        side.push(part);
                    }
                }
            }
        }
        sides
    }
}

/// Bounds and number of references on both sides of each plane.
struct Sweep {
    left: [Bin<Aabb32>; BINS - 1],
    right: [Bin<Aabb32>; BINS - 1],
}

impl Sweep {
    fn over(refs: &[ClippedRef], axis: usize, planes: &[f32; BINS - 1]) -> Self {
        // Slabs between planes hold parts of references; counts are of references that begin or end in a slab.
        let mut slabs = [Aabb32::EMPTY; BINS];
        let [mut begin, mut end] = [[0u32; BINS]; 2];
        for prim_ref in refs {
            let bounds = prim_ref.bounds;
            let first = planes.partition_point(|&plane| side(&bounds, axis, plane) == Some(1));
            let last = planes.partition_point(|&plane| side(&bounds, axis, plane) != Some(0)).max(first);
            begin[first] += 1;
            end[last] += 1;
            for (slab, whole) in slabs.iter_mut().enumerate().take(last + 1).skip(first) {
                let mut part = bounds;
                if slab > first {
                    part.min[axis] = planes[slab - 1];
                }
                if slab < last {
                    part.max[axis] = planes[slab];
                }
                *whole = whole.union(part);
            }
        }
        let mut sweep = Self { left: [Bin::EMPTY; BINS - 1], right: [Bin::EMPTY; BINS - 1] };
        let mut sum = Bin::EMPTY;
        for i in 0..BINS - 1 {
            sum = sum.merge(&Bin { bounds: slabs[i], count: begin[i] });
            sweep.left[i] = sum;
        }
        let mut sum = Bin::EMPTY;
        for i in (0..BINS - 1).rev() {
            sum = sum.merge(&Bin { bounds: slabs[i + 1], count: end[i + 1] });
            sweep.right[i] = sum;
        }
        sweep
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Long boxes that cross: `n` along x and `n` along y.
    fn lattice(n: u32) -> Vec<(u32, Aabb32)> {
        let item = |index: u32| {
            let at = (index / 2) as f32;
            let (long, thin) = (Vec3A::new(n as f32, 0.5, 0.5), Vec3A::new(0.5, n as f32, 0.5));
            let (min, size) = if index.is_multiple_of(2) { (Vec3A::Y * at, long) } else { (Vec3A::X * at, thin) };
            (index, Aabb32 { min, max: min + size })
        };
        (0..2 * n).map(item).collect()
    }

    #[test]
    fn crossing_boxes_are_cut_within_the_allowance() {
        let items = lattice(64);
        let (tree, _) = build(&items);
        assert!(tree.indices.len() > items.len() + 20, "{} references", tree.indices.len());
        assert!(tree.indices.len() <= items.len() + items.len() / 2);
        let listed: std::collections::BTreeSet<_> = tree.indices.iter().collect();
        assert_eq!(listed.len(), items.len());
    }

    #[test]
    fn boxes_apart_are_not_cut() {
        let items: Vec<_> = (0..1000u32)
            .map(|index| {
                let min = Vec3A::new((index % 10) as f32, (index / 10 % 10) as f32, (index / 100) as f32);
                (index, Aabb32 { min, max: min + 0.5 })
            })
            .collect();
        assert_eq!(build(&items).1, []);
    }

    #[test]
    fn each_point_belongs_to_one_cell_of_a_primitive() {
        let items = lattice(32);
        let (tree, split_refs) = build(&items);
        let cells = |index: u32| {
            let of_primitive = split_refs.iter().filter(|split_ref| tree.indices[split_ref.position as usize] == index);
            of_primitive.map(|split_ref| split_ref.cell).collect::<Vec<_>>()
        };
        let cut: Vec<_> = (0..64).map(cells).filter(|cells| !cells.is_empty()).collect();
        assert!(cut.len() > 5);
        for cells in cut {
            let planes: Vec<_> = cells.iter().flat_map(|cell| cell.min.into_iter().chain(cell.max)).collect();
            for &x in planes.iter().filter(|plane| plane.abs() < f32::MAX) {
                for point in [DVec3::new(f64::from(x), 0.25, 0.0), DVec3::new(0.25, f64::from(x), 1.0)] {
                    assert_eq!(cells.iter().filter(|cell| cell.owns(point, DVec3::ZERO)).count(), 1, "{point}");
                }
            }
        }
    }
}
