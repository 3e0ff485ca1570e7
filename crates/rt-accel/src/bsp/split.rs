//! Where to cut a part of space: the best of some planes, by the surface area heuristic.

use rt_math::random::hash;
use rt_math::{Aabb, Primitives};

use super::candidates::{self, Candidate};
use super::plane::Plane;
use crate::bounded_depth::leaves_room_for_halving;
use crate::partition::{Chooser, Cut, Shape, Task};

/// Cost of visiting a node relative to that of testing a primitive.
const NODE_COST: f64 = 1.5;

/// What cutting off empty space is worth beyond the tests it saves: so much of the cost, times the part cut off.
const EMPTY_BONUS: f64 = 0.5;

/// Primitives that are asked for planes.
const ADVISERS: usize = 8;

/// Primitives that planes are tried on.
const SAMPLE: usize = 256;

/// Cuts by the surface area heuristic, and as evenly as candidates allow once those cuts have used up the depth that
/// this needs.
pub(super) struct Sampled<'p, P> {
    pub(super) primitives: &'p P,
}

impl<P: Primitives> Chooser<Plane> for Sampled<'_, P> {
    fn choose(&self, boxes: &[(u32, Aabb)], task: &Task) -> Option<Plane> {
        let count = task.items.len();
        if count < 2 {
            return None;
        }
        let step = count.div_ceil(SAMPLE);
        let sample: Vec<_> = task.items.iter().step_by(step).map(|&item| boxes[item as usize].1).collect();
        // Twice the levels of exact halving, as it will not be exact.
        let by_area = leaves_room_for_halving(count * count, task.depth);
        let weight = count as f64 / sample.len() as f64;
        let mut search = Search {
            shape: Shape::of(&task.cell)?,
            by_area,
            cell: &task.cell,
            sample,
            weight,
            cost: count as f64,
            best: None,
        };
        let adviser = |k: usize| {
            let place = if count <= ADVISERS { k % count } else { hash(&[task.path, k as u64]) as usize % count };
            &boxes[task.items[place] as usize]
        };
        for k in 0..ADVISERS.min(count) {
            let (index, own) = adviser(k);
            let neighbour = adviser(k + 1).1.centre();
            candidates::for_each(self.primitives.leaf_layout(*index), own, neighbour, |candidate| {
                search.consider(&candidate)
            });
        }
        search.best
    }
}

/// The search for the best plane.
struct Search<'t> {
    shape: Shape,
    by_area: bool,
    cell: &'t Aabb,
    sample: Vec<Aabb>,
    /// How many primitives one of the sample stands for.
    weight: f64,
    /// What a plane has to stay below: the cost of a leaf, later of the best plane.
    cost: f64,
    best: Option<Plane>,
}

impl Search<'_> {
    fn consider(&mut self, candidate: &Candidate) {
        let plane = &candidate.plane;
        let [low, high] = Plane::heights(plane.normal, self.cell);
        // Halves, as the extent may be too large to be a number.
        let fraction = (plane.offset * 0.5 - low * 0.5) / (high * 0.5 - low * 0.5);
        if !(plane.is_sound() && fraction > 0.0 && fraction < 1.0) {
            return;
        }
        let mut counts = [0u32; 2];
        for own in &self.sample {
            let [below, above] = plane.sides(own);
            counts[0] += u32::from(below);
            counts[1] += u32::from(above);
        }
        // A plane that leaves a side with everything could be chosen again and again below, unless the cell there is
        // known to be smaller.
        if !candidate.is_axial && counts.iter().any(|&count| count as usize == self.sample.len()) {
            return;
        }
        let [below, above] = counts.map(|count| f64::from(count) * self.weight);
        let cost = if self.by_area {
            let cut_off = match counts {
                [0, _] => fraction,
                [_, 0] => 1.0 - fraction,
                _ => 0.0,
            };
            let expected = self.shape.probability(plane.normal, fraction) * below
                + self.shape.probability(plane.normal, 1.0 - fraction) * above;
            (1.0 - EMPTY_BONUS * cut_off) * (NODE_COST + expected)
        } else {
            below.max(above)
        };
        if cost < self.cost {
            self.cost = cost;
            self.best = Some(*plane);
        }
    }
}
