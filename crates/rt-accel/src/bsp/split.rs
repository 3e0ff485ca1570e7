//! Selection of splitting planes: the best candidate by the surface area heuristic.

use glam::DVec3;
use rt_geometry::Primitives;
use rt_math::Aabb;
use rt_math::random::hash;

use super::candidates::{self, Candidate};
use super::plane::Plane;
use crate::space_partition::{SahCost, SplitHeuristic, SplitPlane, Task};
use crate::traversal::depth_allows_median_split;

/// Number of primitives that propose planes.
const N_PROPOSERS: usize = 8;

/// Number of primitives that planes are evaluated on.
const SAMPLE: usize = 256;

/// Splits by the surface area heuristic, and as evenly as candidates allow once the remaining depth is needed for this.
pub(crate) struct SampledPlanes<'p, P> {
    pub(crate) primitives: &'p P,
}

impl<P: Primitives> SplitHeuristic<Plane> for SampledPlanes<'_, P> {
    fn find_split(&self, boxes: &[(u32, Aabb)], task: &Task<Plane>) -> Option<Plane> {
        let count = task.items.len();
        if count < 2 {
            return None;
        }
        let step = count.div_ceil(SAMPLE);
        let sample: Vec<_> = task.items.iter().step_by(step).map(|&item| boxes[item as usize].1).collect();
        // Twice the levels of exact median splits, as splits will not be exact.
        let by_area = depth_allows_median_split(count, task.depth + count.ilog2());
        let weight = count as f64 / sample.len() as f64;
        let mut search = CandidateSearch {
            shape: SahCost::of(&task.cell)?,
            by_area,
            cell: &task.cell,
            sample_points: sample_points(task),
            sample,
            weight,
            cost: count as f64,
            best: None,
        };
        let proposer = |k: usize| {
            let place = if count <= N_PROPOSERS { k % count } else { hash(&[task.path, k as u64]) as usize % count };
            &boxes[task.items[place] as usize]
        };
        for k in 0..N_PROPOSERS.min(count) {
            let (index, own) = proposer(k);
            let neighbour = proposer(k + 1).1.centre();
            candidates::for_each(self.primitives.geometry(*index), own, neighbour, |candidate| {
                search.evaluate(&candidate)
            });
        }
        search.best
    }
}

/// Search for the best plane.
struct CandidateSearch<'t> {
    shape: SahCost,
    by_area: bool,
    cell: &'t Aabb,
    /// Sample points in the cell.
    sample_points: Vec<DVec3>,
    sample: Vec<Aabb>,
    /// Number of primitives per sampled one.
    weight: f64,
    /// Upper bound of the cost: that of a leaf, later that of the best plane.
    cost: f64,
    best: Option<Plane>,
}

impl CandidateSearch<'_> {
    fn evaluate(&mut self, candidate: &Candidate) {
        let plane = &candidate.plane;
        if !plane.is_valid() {
            return;
        }
        let fraction = if candidate.is_axial {
            let [low, high] = Plane::heights(plane.normal, self.cell);
            // Halves, as the extent may overflow.
            (plane.offset * 0.5 - low * 0.5) / (high * 0.5 - low * 0.5)
        } else {
            let n_below = self.sample_points.iter().filter(|&&place| !plane.is_above(place)).count();
            n_below as f64 / self.sample_points.len() as f64
        };
        if !(fraction > 0.0 && fraction < 1.0) {
            return;
        }
        let mut counts = [0u32; 2];
        for own in &self.sample {
            let [below, above] = plane.classify(own);
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

/// Number of points that estimate volumes of parts of a cell.
const N_SAMPLE_POINTS: u32 = 32;

/// Evenly distributed points in the bounds of a cell, filtered to those within the cell. An additive recurrence with
/// powers of the root of `x⁴ = x + 1` (Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018).
fn sample_points(task: &Task<Plane>) -> Vec<DVec3> {
    const STEP: DVec3 = DVec3::new(0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_970_3);
    let Aabb { min, max } = task.cell;
    (0..N_SAMPLE_POINTS)
        .map(|k| (DVec3::splat(0.5) + STEP * f64::from(k)).fract())
        .map(|weight| min * (1.0 - weight) + max * weight)
        .filter(|&place| task.clip_planes.iter().all(|(plane, is_above)| plane.is_above(place) == *is_above))
        .collect()
}
