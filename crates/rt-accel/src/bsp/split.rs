//! Where to cut a part of space: the best of some planes, by the surface area heuristic.

use glam::DVec3;
use rt_geometry::Primitives;
use rt_math::Aabb;
use rt_math::random::hash;

use super::candidates::{self, Candidate};
use super::plane::Plane;
use crate::bounded_depth::leaves_room_for_halving;
use crate::partition::{Chooser, Cut, Shape, Task};

/// Primitives that are asked for planes.
const ADVISERS: usize = 8;

/// Primitives that planes are tried on.
const SAMPLE: usize = 256;

/// Cuts by the surface area heuristic, and as evenly as candidates allow once those cuts have used up the depth that
/// this needs.
pub(crate) struct Sampled<'p, P> {
    pub(crate) primitives: &'p P,
}

impl<P: Primitives> Chooser<Plane> for Sampled<'_, P> {
    fn choose(&self, boxes: &[(u32, Aabb)], task: &Task<Plane>) -> Option<Plane> {
        let count = task.items.len();
        if count < 2 {
            return None;
        }
        let step = count.div_ceil(SAMPLE);
        let sample: Vec<_> = task.items.iter().step_by(step).map(|&item| boxes[item as usize].1).collect();
        // Twice the levels of exact halving, as it will not be exact.
        let by_area = leaves_room_for_halving(count, task.depth + count.ilog2());
        let weight = count as f64 / sample.len() as f64;
        let mut search = Search {
            shape: Shape::of(&task.cell)?,
            by_area,
            cell: &task.cell,
            places: places(task),
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
            candidates::for_each(self.primitives.geometry(*index), own, neighbour, |candidate| {
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
    /// Points all over the cell.
    places: Vec<DVec3>,
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
        if !plane.is_sound() {
            return;
        }
        let fraction = if candidate.is_axial {
            let [low, high] = Plane::heights(plane.normal, self.cell);
            // Halves, as the extent may be too large to be a number.
            (plane.offset * 0.5 - low * 0.5) / (high * 0.5 - low * 0.5)
        } else {
            let n_below = self.places.iter().filter(|&&place| !plane.is_above(place)).count();
            n_below as f64 / self.places.len() as f64
        };
        if !(fraction > 0.0 && fraction < 1.0) {
            return;
        }
        let mut counts = [0u32; 2];
        for own in &self.sample {
            let [below, above] = plane.sides(own);
            counts[0] += u32::from(below);
            counts[1] += u32::from(above);
        }
        let [below, above] = counts.map(|count| f64::from(count) * self.weight);
        let cost = if self.by_area { self.shape.cost(plane.normal, fraction, below, above) } else { below.max(above) };
        if cost < self.cost {
            self.cost = cost;
            self.best = Some(*plane);
        }
    }
}

/// Points that tell how large a part of a cell is.
const PLACES: u32 = 32;

/// Points spread evenly over the box around a cell, those within the cell: an additive recurrence with powers of the
/// root of `x⁴ = x + 1` (Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018).
fn places(task: &Task<Plane>) -> Vec<DVec3> {
    const STEP: DVec3 = DVec3::new(0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_970_3);
    let Aabb { min, max } = task.cell;
    (0..PLACES)
        .map(|k| (DVec3::splat(0.5) + STEP * f64::from(k)).fract())
        .map(|weight| min * (1.0 - weight) + max * weight)
        .filter(|&place| task.walls.iter().all(|(plane, is_above)| plane.is_above(place) == *is_above))
        .collect()
}
