//! Selection of splitting planes: the surface area heuristic at the faces of padded bounds.
//!
//! Along an axis the numbers of boxes below and above a plane change at faces only, and between two faces the cost has
//! no minimum. So the best plane of such a gap is next to one of its ends. That is just past the last face before, or
//! just before the first face after. There it touches neither box, while a plane *in* a face would leave the box on
//! both sides. In small parts all gaps are evaluated; in large ones those between bins, whose ends are still faces.

use glam::DVec3;
use rt_math::Aabb;

use super::plane::AxisPlane;
use crate::axis::Axis;
use crate::space_partition::{SahCost, SplitHeuristic, Task};
use crate::traversal::depth_allows_median_split;

/// Minimum number of boxes for binning; fewer are swept.
const MIN_BINNED: usize = 32;

const BINS: usize = 32;

/// Splits by the surface area heuristic (MacDonald and Booth 1990), and evenly once the remaining depth is needed for
/// median splits.
pub(crate) struct SahSplit;

impl SplitHeuristic<AxisPlane> for SahSplit {
    fn find_split(&self, boxes: &[(u32, Aabb)], task: &Task<AxisPlane>) -> Option<AxisPlane> {
        let count = task.items.len();
        let faces = |axis: Axis| {
            let axis = axis as usize;
            task.items.iter().map(move |&item| {
                let own = &boxes[item as usize].1;
                (own.min[axis], own.max[axis])
            })
        };
        if depth_allows_median_split(count, task.depth) {
            let mut search = PlaneSearch::new(task, Objective::Area(SahCost::of(&task.cell)?));
            for axis in Axis::ALL {
                if count < MIN_BINNED { search.sweep(axis, faces(axis)) } else { search.bin(axis, faces(axis)) }
            }
            search.best
        } else {
            let mut search = PlaneSearch::new(task, Objective::Balance);
            Axis::ALL.into_iter().for_each(|axis| search.sweep(axis, faces(axis)));
            search.best
        }
    }
}

/// Quantity to minimise.
enum Objective {
    /// Expected cost of a ray through the cell.
    Area(SahCost),
    /// Number of boxes on the fuller side.
    Balance,
}

/// Search for the best plane.
struct PlaneSearch<'t> {
    cell: &'t Aabb,
    count: u32,
    objective: Objective,
    /// Upper bound of the cost: that of a leaf, later that of the best plane.
    cost: f64,
    best: Option<AxisPlane>,
}

impl<'t> PlaneSearch<'t> {
    fn new(task: &'t Task<AxisPlane>, objective: Objective) -> Self {
        let count = task.items.len() as u32;
        Self { cell: &task.cell, count, objective, cost: f64::from(count), best: None }
    }

    /// Evaluates the two planes at the ends of a gap between faces, with the numbers of boxes that have begun and
    /// ended. The ends of the cell are not faces.
    fn evaluate_gap(&mut self, axis: Axis, last: f64, first: f64, begun: u32, ended: u32) {
        let (min, max) = (self.cell.min[axis as usize], self.cell.max[axis as usize]);
        let planes = [(last > min, last.next_up()), (first < max, first.next_down())];
        for (is_face, position) in planes {
            if is_face && min < position && position < max {
                self.evaluate(AxisPlane { position, axis }, begun, self.count - ended);
            }
        }
    }

    fn evaluate(&mut self, plane: AxisPlane, below: u32, above: u32) {
        let cost = match &self.objective {
            Objective::Area(shape) => {
                let (min, max) = (self.cell.min[plane.axis as usize], self.cell.max[plane.axis as usize]);
                // Halves, as the extent may overflow.
                let fraction = (plane.position * 0.5 - min * 0.5) / (max * 0.5 - min * 0.5);
                shape.cost(DVec3::AXES[plane.axis as usize], fraction, f64::from(below), f64::from(above))
            }
            Objective::Balance => f64::from(below.max(above)),
        };
        if cost < self.cost {
            self.cost = cost;
            self.best = Some(plane);
        }
    }

    /// Evaluates all gaps.
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
            self.evaluate_gap(axis, last, first, begun as u32, ended as u32);
            if first >= max {
                return;
            }
            last = first;
        }
    }

    /// Evaluates the gaps between equal bins.
    fn bin(&mut self, axis: Axis, faces: impl Iterator<Item = (f64, f64)>) {
        let (min, max) = (self.cell.min[axis as usize], self.cell.max[axis as usize]);
        // Monotone for any extent: if it is infinite, there is one bin, as the cast of NaN is 0. The inverse of a
        // denormal extent would be infinite.
        let extent = max - min;
        let place = |x: f64| (((x - min) / extent * BINS as f64) as usize).min(BINS - 1);
        let mut bins = [FaceBin::EMPTY; BINS];
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
            self.evaluate_gap(axis, last, bin.first, begun, ended);
            begun += bin.starts;
            ended += bin.ends;
            last = bin.last;
        }
        self.evaluate_gap(axis, last, max, begun, ended);
    }
}

/// Faces within an interval of coordinates.
#[derive(Clone, Copy)]
struct FaceBin {
    starts: u32,
    ends: u32,
    first: f64,
    last: f64,
}

impl FaceBin {
    const EMPTY: Self = Self { starts: 0, ends: 0, first: f64::INFINITY, last: f64::NEG_INFINITY };

    #[inline(always)]
    fn include(&mut self, face: f64) {
        self.first = self.first.min(face);
        self.last = self.last.max(face);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space_partition::SplitPlane;
    use rt_math::random::{hash, unit};

    fn task(boxes: &[(u32, Aabb)], depth: u32) -> Task<AxisPlane> {
        let cell = boxes.iter().fold(Aabb::EMPTY, |all, (_, own)| all.union(*own));
        Task {
            items: (0..boxes.len() as u32).collect(),
            cell,
            clip_planes: Vec::new(),
            depth,
            path: 1,
            budget: 1 << 20,
        }
    }

    fn row(places: impl IntoIterator<Item = f64>) -> Vec<(u32, Aabb)> {
        let at = |x: f64| Aabb::new(DVec3::new(x, 0.0, 0.0), DVec3::new(x + 1.0, 1.0, 1.0));
        (0..).zip(places).map(|(index, x)| (index, at(x))).collect()
    }

    fn counts(boxes: &[(u32, Aabb)], plane: &AxisPlane) -> [usize; 2] {
        [0, 1].map(|side| boxes.iter().filter(|(_, own)| plane.classify(own)[side]).count())
    }

    #[test]
    fn clusters_are_parted_next_to_a_face_that_is_left_whole() {
        for n in [4, 100] {
            let step = |i: u32| f64::from(i) * 2.0 / f64::from(n);
            let boxes = row((0..n).map(step).chain((0..n).map(|i| 50.0 + step(i))));
            let plane = SahSplit.find_split(&boxes, &task(&boxes, 0)).expect("two clusters");
            let position = plane.position;
            let last = boxes[n as usize - 1].1.max.x;
            assert!(position == last.next_up() || position == 50f64.next_down(), "{plane:?}");
            assert_eq!(counts(&boxes, &plane), [n as usize; 2]);
        }
    }

    #[test]
    fn empty_space_is_cut_off_at_the_last_face_before_it() {
        let boxes = row((0..40).map(|i| f64::from(i) * 0.01));
        let wide = Task { cell: Aabb::new(DVec3::ZERO, DVec3::new(100.0, 1.0, 1.0)), ..task(&boxes, 0) };
        let plane = SahSplit.find_split(&boxes, &wide).expect("emptiness");
        let position = plane.position;
        assert_eq!((plane.axis, position), (Axis::X, boxes[39].1.max.x.next_up()));
    }

    #[test]
    fn what_cannot_be_parted_is_not_cut() {
        for n in [1, 2, 31, 1000] {
            let same = row((0..n).map(|_| 3.0));
            assert_eq!(SahSplit.find_split(&same, &task(&same, 0)), None);
            assert_eq!(SahSplit.find_split(&same, &task(&same, 59)), None);
        }
        assert_eq!(SahSplit.find_split(&[], &task(&[], 0)), None);
    }

    #[test]
    fn lopsided_sets_are_halved_when_depth_runs_out() {
        let boxes = row([1e6].into_iter().chain((0..1000).map(|i| 2.0 * f64::from(i))));
        let sides_at = |depth| SahSplit.find_split(&boxes, &task(&boxes, depth)).map(|plane| counts(&boxes, &plane));
        assert_eq!(sides_at(0), Some([1000, 1]));
        assert_eq!(sides_at(55), Some([500, 501]));
    }

    /// The counts of a search are those of the boxes.
    #[test]
    fn bins_are_nearly_as_good_as_all_faces() {
        for seed in 0..50 {
            let draw = |i: u64, k: u64| unit(hash(&[seed, i, k]));
            let vector = |i, k| DVec3::new(draw(i, k), draw(i, k + 1), draw(i, k + 2) * draw(i, k + 6));
            let boxes: Vec<_> = (0..300)
                .map(|i| (i as u32, vector(i, 0)))
                .map(|(i, p)| (i, Aabb::new(p, p + 0.2 * vector(i.into(), 3))))
                .collect();
            let task = task(&boxes, 0);
            let best = |by_bins: bool| {
                let mut search = PlaneSearch::new(&task, Objective::Area(SahCost::of(&task.cell).expect("a box")));
                for axis in Axis::ALL {
                    let faces = boxes.iter().map(|(_, own)| (own.min[axis as usize], own.max[axis as usize]));
                    if by_bins { search.bin(axis, faces) } else { search.sweep(axis, faces) }
                }
                let plane = search.best.expect("a cut");
                let [below, above] = counts(&boxes, &plane).map(|count| count as u32);
                let mut again = PlaneSearch::new(&task, search.objective);
                again.evaluate(plane, below, above);
                assert_eq!(again.cost, search.cost, "{plane:?}");
                search.cost
            };
            let (binned, swept) = (best(true), best(false));
            assert!(swept <= binned && binned < 1.05 * swept, "{binned} {swept}");
        }
    }
}
