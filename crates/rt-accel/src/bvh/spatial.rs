//! Spatial splits: planes that cut through primitives.
//!
//! # Why no primitive is lost
//!
//! A reference is the part of a primitive's box on one side of every plane that has cut it. Let a ray pass the own box
//! of a primitive, entering it at `e` as `intersect_primitive` sees it. Some reference is entered no later than `e`: the whole box
//! is (see `node.rs`), and when a plane cuts a reference that is, one of the two parts is. Take a direction in which
//! the left part comes first. It is entered where the whole was, and left where the whole was left or at `leave(s)`, the
//! crossing of the plane, whichever is first. If `e ≤ leave(s)`, the ray passes it. Otherwise `e > leave(s) ≥ enter(s)`,
//! so the right part is entered at `max(e, enter(s)) = e` and left where the whole was. Here `enter(s) ≤ leave(s)`
//! because far planes are seen from an origin that is farther back, and moved outward on either side of `t` = 0. A ray
//! along the plane meets no constraint in it, and passes at least the part that its origin lies in.
//!
//! The parts of a primitive tile space: each has a [`Cell`], bounded by nothing but the planes that have cut it. So a
//! point belongs to exactly one part, by which a search of space visits each primitive once.

use glam::{DVec3, Vec3A};

use super::build::{Parent, Subtree};
use super::node::{Child, NodeBox};
use super::split::{BINS, Bin, Binning, Cut, Item, centroid_box, halve, is_leaf, partition, union};
use crate::bounded_depth::leaves_room_for_halving;

/// References may outnumber primitives by this part of them.
const MOST_REPEATED: f64 = 0.5;

/// Planes are tried only where the boxes of both sides overlap by this part of the area of the whole scene (Stich,
/// Friedrich and Dietrich 2009).
const OVERLAP: f64 = 1e-5;

/// The part of space that is left to a reference by the planes that have cut its primitive, half open: the lower
/// planes belong to it. Relative to the centre of the tree. The least and the greatest `f32` stand for no plane at all,
/// as not every format that trees are saved in knows infinity.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Cell {
    pub(super) min: [f32; 3],
    pub(super) max: [f32; 3],
}

impl Cell {
    pub(crate) const EVERYWHERE: Self = Self { min: [f32::MIN; 3], max: [f32::MAX; 3] };

    /// True if the cell owns a point.
    pub(super) fn owns(&self, point: DVec3, centre: DVec3) -> bool {
        let place = point - centre;
        (0..3).all(|axis| {
            let (min, max) = (self.min[axis], self.max[axis]);
            (min == f32::MIN || f64::from(min) <= place[axis]) && (max == f32::MAX || place[axis] < f64::from(max))
        })
    }

    /// The part of a box in the cell, a step wider, so that it contains what lies in the planes after any rounding.
    pub(super) fn clip(&self, whole: &NodeBox) -> NodeBox {
        whole.intersection(NodeBox {
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

/// The cell of a reference to a primitive that has several.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Piece {
    /// Place of the reference in the list of all.
    pub(super) position: u32,
    pub(super) cell: Cell,
}

/// A part of a primitive while the tree grows.
#[derive(Clone, Copy)]
struct Reference {
    item: Item,
    whole: NodeBox,
    cell: Cell,
}

impl AsRef<Item> for Reference {
    fn as_ref(&self) -> &Item {
        &self.item
    }
}

impl Reference {
    /// The parts on both sides of a plane that cuts through.
    fn cut(&self, axis: usize, plane: f32) -> [Self; 2] {
        self.cell.cut(axis, plane).map(|cell| {
            let bounds = cell.clip(&self.whole);
            Self { item: Item { bounds, ..self.item }, cell, ..*self }
        })
    }
}

/// A tree, and what its leaves list.
pub(super) struct SpatialTree {
    pub(super) subtree: Subtree,
    pub(super) indices: Vec<u32>,
    /// By rising position.
    pub(super) pieces: Vec<Piece>,
}

struct Task {
    references: Vec<Reference>,
    bounds: NodeBox,
    depth: u32,
    parent: Parent,
}

/// Grows the tree over `items`, which must not be empty.
pub(super) fn build(items: &[Item]) -> SpatialTree {
    let bounds = union(items);
    let references = items.iter().map(|&item| Reference { item, whole: item.bounds, cell: Cell::EVERYWHERE }).collect();
    let mut tree =
        SpatialTree { subtree: Subtree::new(), indices: Vec::with_capacity(items.len()), pieces: Vec::new() };
    let mut spare = (items.len() as f64 * MOST_REPEATED) as usize;
    let least_overlap = bounds.half_area() * OVERLAP;
    let mut pending = vec![Task { references, bounds, depth: 0, parent: Parent::None }];
    while let Some(task) = pending.pop() {
        let Task { references, bounds, depth, parent } = task;
        match split(references, &bounds, depth, &mut spare, least_overlap) {
            Err(references) => tree.leaf(&references, parent, depth),
            Ok(([left, right], bounds)) => {
                let [left_of, right_of] = tree.subtree.attach_node(parent, bounds);
                let depth = depth + 1;
                pending.push(Task { references: right, bounds: bounds[1], depth, parent: right_of });
                pending.push(Task { references: left, bounds: bounds[0], depth, parent: left_of });
            }
        }
    }
    tree
}

impl SpatialTree {
    fn leaf(&mut self, references: &[Reference], parent: Parent, depth: u32) {
        let first = self.indices.len() as u32;
        for reference in references {
            if reference.cell != Cell::EVERYWHERE {
                self.pieces.push(Piece { position: self.indices.len() as u32, cell: reference.cell });
            }
            self.indices.push(reference.item.index);
        }
        self.subtree.attach_leaf(parent, Child::leaf(first, references.len() as u32), depth);
    }
}

/// Two sets of references and the boxes around them.
type Sides = ([Vec<Reference>; 2], [NodeBox; 2]);

/// The cheapest way to cut a set in two, or the set as it is where it should be a leaf. Uses up `spare` references.
fn split(
    mut references: Vec<Reference>,
    bounds: &NodeBox,
    depth: u32,
    spare: &mut usize,
    least_overlap: f64,
) -> Result<Sides, Vec<Reference>> {
    let centroids = centroid_box(&references);
    let (mut cut, mut plane) = (None, None);
    if references.len() > 1 && leaves_room_for_halving(references.len(), depth) {
        cut = Binning::new(&centroids).best_cut(&references);
        let overlap = |cut: &Cut| cut.bounds[0].intersection(cut.bounds[1]);
        if cut.as_ref().is_none_or(|cut| proper_half_area(&overlap(cut)) > least_overlap) {
            plane = Plane::best(&references, bounds, *spare);
        }
    }
    let costs = [cut.as_ref().map(|cut| cut.cost), plane.as_ref().map(|plane| plane.cost)];
    if references.len() < 2 || is_leaf(references.len(), bounds, costs.into_iter().flatten().reduce(f64::min)) {
        return Err(references);
    }
    if let Some(plane) = plane.filter(|plane| cut.as_ref().is_none_or(|cut| plane.cost < cut.cost)) {
        let sides = plane.divide(&references);
        *spare -= sides[0].len() + sides[1].len() - references.len();
        let bounds = sides.each_ref().map(|side| union(side));
        return Ok((sides, bounds));
    }
    let (middle, bounds) = match cut {
        Some(cut) => (partition(&mut references, |item| cut.binning.bin(item)[cut.axis] < cut.bin), cut.bounds),
        None => {
            let halves = halve(&mut references, &centroids);
            (halves.middle, halves.bounds)
        }
    };
    let right = references.split_off(middle);
    Ok(([references, right], bounds))
}

/// Half of the surface area, 0 for an empty box.
fn proper_half_area(bounds: &NodeBox) -> f64 {
    if bounds.min.cmple(bounds.max).all() { bounds.half_area() } else { 0.0 }
}

/// A plane to cut at.
struct Plane {
    axis: usize,
    place: f32,
    /// Area times number of references, summed over both sides.
    cost: f64,
}

/// On which side of a plane a box lies; `None` if the plane cuts through it.
fn side(bounds: &NodeBox, axis: usize, place: f32) -> Option<usize> {
    if bounds.min[axis] >= place {
        Some(1)
    } else if bounds.max[axis] <= place {
        Some(0)
    } else {
        None
    }
}

impl Plane {
    /// The cheapest of the planes that divide `bounds` evenly, if it leaves both sides with fewer references than there
    /// are, and repeats at most `spare` of them.
    fn best(references: &[Reference], bounds: &NodeBox, spare: usize) -> Option<Self> {
        let mut best: Option<Self> = None;
        for axis in 0..3 {
            let step = (bounds.max[axis] - bounds.min[axis]) / BINS as f32;
            let planes: [f32; BINS - 1] = core::array::from_fn(|i| bounds.min[axis] + step * (i + 1) as f32);
            if !(step > 0.0 && step.is_finite()) {
                continue;
            }
            let Sweep { left, right } = Sweep::over(references, axis, &planes);
            for (i, &place) in planes.iter().enumerate() {
                let counts = [left[i].count, right[i].count].map(|count| count as usize);
                let n = references.len();
                let is_allowed =
                    counts.iter().all(|&count| 0 < count && count < n) && counts[0] + counts[1] <= n + spare;
                let cost = left[i].cost() + right[i].cost();
                if is_allowed && best.as_ref().is_none_or(|best| cost < best.cost) {
                    best = Some(Self { axis, place, cost });
                }
            }
        }
        best
    }

    fn divide(&self, references: &[Reference]) -> [Vec<Reference>; 2] {
        let mut sides = [Vec::new(), Vec::new()];
        for reference in references {
            match side(&reference.item.bounds, self.axis, self.place) {
                Some(side) => sides[side].push(*reference),
                None => {
                    for (side, part) in sides.iter_mut().zip(reference.cut(self.axis, self.place)) {
                        side.push(part);
                    }
                }
            }
        }
        sides
    }
}

/// What lies on both sides of each of a row of planes.
struct Sweep {
    left: [Bin; BINS - 1],
    right: [Bin; BINS - 1],
}

impl Sweep {
    fn over(references: &[Reference], axis: usize, planes: &[f32; BINS - 1]) -> Self {
        // The slab between two planes holds parts of references; counts are of those that begin or end in it.
        let mut slabs = [NodeBox::EMPTY; BINS];
        let [mut begin, mut end] = [[0u32; BINS]; 2];
        for reference in references {
            let bounds = reference.item.bounds;
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
    fn lattice(n: u32) -> Vec<Item> {
        let item = |index: u32| {
            let at = (index / 2) as f32;
            let (long, thin) = (Vec3A::new(n as f32, 0.5, 0.5), Vec3A::new(0.5, n as f32, 0.5));
            let (min, size) = if index.is_multiple_of(2) { (Vec3A::Y * at, long) } else { (Vec3A::X * at, thin) };
            Item { bounds: NodeBox { min, max: min + size }, index }
        };
        (0..2 * n).map(item).collect()
    }

    #[test]
    fn crossing_boxes_are_cut_within_the_allowance() {
        let items = lattice(64);
        let tree = build(&items);
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
                Item { bounds: NodeBox { min, max: min + 0.5 }, index }
            })
            .collect();
        assert_eq!(build(&items).pieces, []);
    }

    #[test]
    fn each_point_belongs_to_one_cell_of_a_primitive() {
        let items = lattice(32);
        let tree = build(&items);
        let cells = |index: u32| {
            let pieces = tree.pieces.iter().filter(|piece| tree.indices[piece.position as usize] == index);
            pieces.map(|piece| piece.cell).collect::<Vec<_>>()
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
