//! Where to cut a part of space: the surface area heuristic at the faces of own boxes.
//!
//! Along an axis the numbers of boxes below and above a plane change at faces only, and between two faces the cost is a
//! linear function of the plane. So the best plane of such a gap is next to one of its ends: just past the last face
//! before, or just before the first face after, where it touches neither box (planes *in* a face would leave the box on
//! both sides). In small parts all gaps are looked at; in large ones those between bins, whose ends are still faces.

use glam::DVec3;
use rt_math::Aabb;

use super::plane::{Axis, AxisPlane};
use crate::bounded_depth::leaves_room_for_halving;
use crate::partition::{Chooser, Shape, Task};

/// Cost of visiting a node relative to that of testing a primitive.
const NODE_COST: f64 = 1.0;

/// What cutting off empty space is worth beyond the tests it saves (Wald and Havran 2006): so much of the cost, times
/// the part of the extent that is cut off. A fixed bonus would pay for slivers.
const EMPTY_BONUS: f64 = 0.5;

/// From this number of boxes on, bins are looked at and not all faces.
const MIN_BINNED: usize = 32;

const BINS: usize = 32;

/// Cuts by the surface area heuristic (MacDonald and Booth 1990), and evenly once those cuts have used up the depth
/// that halving needs.
pub(super) struct SurfaceArea;

impl Chooser<AxisPlane> for SurfaceArea {
    fn choose(&self, boxes: &[(u32, Aabb)], task: &Task) -> Option<AxisPlane> {
        let count = task.items.len();
        let faces = |axis: Axis| {
            let axis = axis as usize;
            task.items.iter().map(move |&item| {
                let own = &boxes[item as usize].1;
                (own.min[axis], own.max[axis])
            })
        };
        if leaves_room_for_halving(count, task.depth) {
            let mut search = Search::new(task, Objective::Area(Shape::of(&task.cell)?));
            for axis in Axis::ALL {
                if count < MIN_BINNED { search.sweep(axis, faces(axis)) } else { search.bin(axis, faces(axis)) }
            }
            search.best
        } else {
            let mut search = Search::new(task, Objective::Balance);
            Axis::ALL.into_iter().for_each(|axis| search.sweep(axis, faces(axis)));
            search.best
        }
    }
}

/// What makes a cut good.
enum Objective {
    /// Few tests expected for a ray through the cell.
    Area(Shape),
    /// Few boxes on the fuller side.
    Balance,
}

/// The search for the best cut.
struct Search<'t> {
    cell: &'t Aabb,
    count: u32,
    objective: Objective,
    /// What a cut has to stay below: the cost of a leaf, later of the best cut.
    cost: f64,
    best: Option<AxisPlane>,
}

impl<'t> Search<'t> {
    fn new(task: &'t Task, objective: Objective) -> Self {
        let count = task.items.len() as u32;
        Self { cell: &task.cell, count, objective, cost: f64::from(count), best: None }
    }

    /// Looks at the two planes at the ends of a gap between faces, where so many boxes have begun and so many ended.
    /// The ends of the cell are no faces.
    fn gap(&mut self, axis: Axis, last: f64, first: f64, begun: u32, ended: u32) {
        let (min, max) = (self.cell.min[axis as usize], self.cell.max[axis as usize]);
        let planes = [(last > min, last.next_up()), (first < max, first.next_down())];
        for (is_face, position) in planes {
            if is_face && min < position && position < max {
                self.consider(AxisPlane { position, axis }, begun, self.count - ended);
            }
        }
    }

    fn consider(&mut self, plane: AxisPlane, below: u32, above: u32) {
        let cost = match &self.objective {
            Objective::Area(shape) => {
                let (min, max) = (self.cell.min[plane.axis as usize], self.cell.max[plane.axis as usize]);
                // Halves, as the extent may be too large to be a number.
                let fraction = (plane.position * 0.5 - min * 0.5) / (max * 0.5 - min * 0.5);
                let normal = DVec3::AXES[plane.axis as usize];
                let expected = shape.probability(normal, fraction) * f64::from(below)
                    + shape.probability(normal, 1.0 - fraction) * f64::from(above);
                let cut_off = match (below, above) {
                    (0, _) => fraction,
                    (_, 0) => 1.0 - fraction,
                    _ => 0.0,
                };
                (1.0 - EMPTY_BONUS * cut_off) * (NODE_COST + expected)
            }
            Objective::Balance => f64::from(below.max(above)),
        };
        if cost < self.cost {
            self.cost = cost;
            self.best = Some(plane);
        }
    }

    /// Looks at all gaps.
    fn sweep(&mut self, axis: Axis, faces: impl ExactSizeIterator<Item = (f64, f64)>) {
        let (mut starts, mut ends): (Vec<_>, Vec<_>) = faces.unzip();
        starts.sort_unstable_by(f64::total_cmp);
        ends.sort_unstable_by(f64::total_cmp);
        let (min, max) = (self.cell.min[axis as usize], self.cell.max[axis as usize]);
        let (mut begun, mut ended, mut last) = (0, 0, min);
        loop {
            while begun < starts.len() && starts[begun] <= last {
                begun += 1;
            }
            while ended < ends.len() && ends[ended] <= last {
                ended += 1;
            }
            let next = |faces: &[f64], place: usize| faces.get(place).copied().unwrap_or(max);
            let first = next(&starts, begun).min(next(&ends, ended)).min(max);
            self.gap(axis, last, first, begun as u32, ended as u32);
            if first >= max {
                return;
            }
            last = first;
        }
    }

    /// Looks at the gaps between equal bins.
    fn bin(&mut self, axis: Axis, faces: impl Iterator<Item = (f64, f64)>) {
        let (min, max) = (self.cell.min[axis as usize], self.cell.max[axis as usize]);
        // Monotone whatever the extent, as the cast of NaN is 0; if it is infinite, there is one bin.
        let scale = BINS as f64 / (max - min);
        let place = |x: f64| (((x - min) * scale) as usize).min(BINS - 1);
        let mut bins = [Bin::EMPTY; BINS];
        let (mut begun, mut ended) = (0, 0);
        for (start, end) in faces {
            if start <= min {
                begun += 1;
            } else if start < max {
                let bin = &mut bins[place(start)];
                bin.starts += 1;
                bin.include(start);
            }
            if end <= min {
                ended += 1;
            } else if end < max {
                let bin = &mut bins[place(end)];
                bin.ends += 1;
                bin.include(end);
            }
        }
        let mut last = min;
        for bin in bins.iter().filter(|bin| bin.first <= bin.last) {
            self.gap(axis, last, bin.first, begun, ended);
            begun += bin.starts;
            ended += bin.ends;
            last = bin.last;
        }
        self.gap(axis, last, max, begun, ended);
    }
}

/// The faces within an interval of coordinates.
#[derive(Clone, Copy)]
struct Bin {
    starts: u32,
    ends: u32,
    first: f64,
    last: f64,
}

impl Bin {
    const EMPTY: Self = Self { starts: 0, ends: 0, first: f64::INFINITY, last: f64::NEG_INFINITY };

    #[inline(always)]
    fn include(&mut self, face: f64) {
        self.first = self.first.min(face);
        self.last = self.last.max(face);
    }
}
