//! Cost of a splitting plane: the surface area heuristic (MacDonald and Booth 1990).

use glam::DVec3;
use rt_math::Aabb;

/// Minimum extent of a cell on an axis relative to its longest one, so that flat cells have proportions.
const THINNEST: f64 = 1.0 / (1u64 << 40) as f64;

/// Cost of visiting a node relative to that of testing a primitive.
const NODE_COST: f64 = 1.0;

/// Bonus for cutting off empty space (Wald and Havran 2006): this fraction of the cost, times the fraction of the cell
/// that is cut off. A fixed bonus would favour slivers.
const EMPTY_BONUS: f64 = 0.5;

/// Proportions of a box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SahCost {
    /// Indexed by axis: area of the two perpendicular faces, relative to that of all six.
    ends: DVec3,
}

impl SahCost {
    /// `None` if the cell is a point. Extents are halved to avoid overflow.
    pub(crate) fn of(cell: &Aabb) -> Option<Self> {
        let half = cell.max * 0.5 - cell.min * 0.5;
        let longest = half.max_element();
        if !(longest > 0.0) {
            return None;
        }
        let extent = (half / longest).max(DVec3::splat(THINNEST));
        let ends = DVec3::new(extent.y * extent.z, extent.z * extent.x, extent.x * extent.y);
        Some(Self { ends: ends / ends.element_sum() })
    }

    /// Ratio of the surface area of a part to that of the whole (a mean over all rays: Santaló 1976). The part has the
    /// same outline in direction `normal`, of unit length, and `fraction` of the extent along it. Exact for parts of a
    /// box between axis-aligned planes.
    fn probability(&self, normal: DVec3, fraction: f64) -> f64 {
        // The outline of a box has the summed area of those of its faces.
        let outline = self.ends.dot(normal.abs());
        outline + fraction * (1.0 - outline)
    }

    /// Expected cost of a ray through the cell, after a split at right angles to `normal`. One side has `fraction` of
    /// the cell and `below` primitives, the other has `above` primitives. A leaf costs 1 per primitive.
    pub(crate) fn cost(&self, normal: DVec3, fraction: f64, below: f64, above: f64) -> f64 {
        let cut_off = if below == 0.0 {
            fraction
        } else if above == 0.0 {
            1.0 - fraction
        } else {
            0.0
        };
        let tests = self.probability(normal, fraction) * below + self.probability(normal, 1.0 - fraction) * above;
        (1.0 - EMPTY_BONUS * cut_off) * (NODE_COST + tests)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_of_boxes_have_their_area() {
        let shape = SahCost::of(&Aabb::new(DVec3::ZERO, DVec3::new(2.0, 1.0, 1.0))).expect("a box");
        assert!((shape.probability(DVec3::X, 0.5) - 0.6).abs() < 1e-15, "6 of 10");
        assert!((shape.probability(DVec3::NEG_Y, 0.5) - 0.7).abs() < 1e-15, "7 of 10");
        assert!((shape.probability(DVec3::Z, 1.0) - 1.0).abs() < 1e-15);
        let cube = SahCost::of(&Aabb::new(DVec3::ZERO, DVec3::ONE)).expect("a box");
        let prism = (3.0 + 2f64.sqrt()) / 6.0;
        assert!((cube.probability(DVec3::new(1.0, 1.0, 0.0).normalize(), 0.5) - prism).abs() < 1e-15);
    }

    #[test]
    fn halving_pays_and_slivers_do_not() {
        let cube = SahCost::of(&Aabb::new(DVec3::ZERO, DVec3::ONE)).expect("a box");
        assert!(cube.cost(DVec3::X, 0.5, 10.0, 10.0) < 20.0);
        assert!(cube.cost(DVec3::X, 0.5, 2.0, 2.0) < 4.0 && cube.cost(DVec3::X, 0.5, 1.0, 1.0) > 2.0);
        assert!(cube.cost(DVec3::X, 0.5, 0.0, 20.0) < cube.cost(DVec3::X, 0.5, 1.0, 19.0), "empty space");
        assert_eq!(cube.cost(DVec3::X, 0.3, 0.0, 20.0), cube.cost(DVec3::X, 0.7, 20.0, 0.0));
        assert!(cube.cost(DVec3::X, 1e-9, 0.0, 20.0) > 20.0, "a sliver");
    }

    #[test]
    fn flat_cells_and_extreme_ones_have_a_shape() {
        let half = |cell: Aabb| SahCost::of(&cell).map(|shape| shape.probability(DVec3::X, 0.5));
        assert_eq!(half(Aabb::new(DVec3::ONE, DVec3::ONE)), None);
        let about_half = |p: Option<f64>| p.is_some_and(|p| (p - 0.5).abs() < 1e-11);
        assert!(about_half(half(Aabb::new(DVec3::ZERO, DVec3::X))), "a line");
        assert!(about_half(half(Aabb::new(DVec3::ZERO, DVec3::new(5e-320, 0.0, 5e-320)))), "a sheet");
        assert!(half(Aabb::new(DVec3::MIN, DVec3::MAX)).is_some_and(|p| (p - 2.0 / 3.0).abs() < 1e-15));
    }
}
