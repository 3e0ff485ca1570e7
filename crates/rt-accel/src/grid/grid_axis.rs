//! One axis of the grid.
//!
//! # Why no primitive is skipped
//!
//! Let a primitive that is hit have the padded bounds `[a, b]` on this axis, and let the ray enter that box at `τ`. At
//! `τ` the ray is within a few roundings of the box on every axis. The traversal, in product form, is at `τ` in a cell
//! with planes `[p, q]`. The ray is within a few roundings of these as well. Let `reach` be the sum of the magnitudes
//! of the ray's origin and the grid's coordinates. Both distances are bounded by 32 unit roundoffs of `reach`, errors
//! of the start and of the insertion included. So `[a, b]` and `[p, q]` touch when both are widened by that. Primitives
//! are inserted widened by [`WIDENING`] of a cell, so that the cell lists the primitive if `32 u · reach` is less.
//! [`GridAxis::resolves`] requires three times that in half of the widening. Rays that fail, which start some 10⁹ cells
//! away, are tested against every primitive.
//!
//! The proof assumes a finite `τ`. It is finite where the ray leaves the bounds of the grid at a finite parameter. Rays
//! whose inverse direction is infinite on this axis count as not moving; the slab test keeps them to boxes that contain
//! their origin's coordinate.
//!
//! The outermost cells reach to infinity, so that rounding cannot push a ray out of the grid before it has left the
//! bounds. An axis of one cell has no planes and nothing to prove.

use core::ops::RangeInclusive;

use rt_math::float::UNIT_ROUNDOFF;

/// Widening of inserted boxes on each side, in cells.
const WIDENING: f64 = 1.0 / 256.0;

/// Minimum size of a cell relative to the largest coordinate, so that rays from well outside are resolved.
const FINEST: f64 = 1.0 / (1u64 << 32) as f64;

/// Equal cells along one coordinate.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct GridAxis {
    min: f64,
    cell: f64,
    pub(super) cells: u32,
    /// Largest magnitude of a coordinate in the grid.
    magnitude: f64,
}

impl GridAxis {
    /// Divides `[min, max]` into about `wanted` cells: at least 1, and no more than coordinates can distinguish.
    pub(super) fn new(min: f64, max: f64, wanted: u32) -> Self {
        let extent = max - min;
        let magnitude = min.abs().max(max.abs());
        // Products with smaller cells would underflow.
        let smallest = (magnitude * FINEST).max(f64::MIN_POSITIVE / UNIT_ROUNDOFF);
        // The cast saturates.
        let finest = if extent.is_finite() { (extent / smallest) as u32 } else { 1 };
        let cells = wanted.min(finest).max(1);
        Self { min, cell: extent / f64::from(cells), cells, magnitude }
    }

    /// True for a positive number of cells without NaN.
    #[cfg(feature = "serde")]
    pub(super) fn is_valid(&self) -> bool {
        self.cells > 0 && self.cell >= 0.0 && !self.min.is_nan() && self.magnitude >= 0.0
    }

    /// Coordinate of the lower plane of cell `index`: a product, so that errors do not accumulate.
    #[inline(always)]
    pub(super) fn plane(&self, index: u32) -> f64 {
        self.min + f64::from(index) * self.cell
    }

    /// The cell at coordinate `x`, or the outermost one on its side; 0 for NaN.
    #[inline(always)]
    pub(super) fn index(&self, x: f64) -> u32 {
        (((x - self.min) / self.cell) as u32).min(self.cells - 1)
    }

    /// The cells that list a box.
    pub(super) fn insertion_range(&self, min: f64, max: f64) -> RangeInclusive<u32> {
        let widening = self.cell * WIDENING;
        self.index(min - widening)..=self.index(max + widening)
    }

    /// The cells that a box touches, found without division.
    pub(super) fn touched_range(&self, min: f64, max: f64) -> RangeInclusive<u32> {
        let planes_where = |is_before: &dyn Fn(f64) -> bool| {
            let (mut low, mut high) = (0, self.cells - 1);
            while low < high {
                let middle = low + (high - low).div_ceil(2);
                if is_before(self.plane(middle)) {
                    low = middle;
                } else {
                    high = middle - 1;
                }
            }
            low
        };
        planes_where(&|plane| plane < min)..=planes_where(&|plane| plane <= max)
    }

    /// True if the traversal of a ray with this origin and direction certainly visits the cells of its hits.
    #[inline(always)]
    pub(super) fn resolves(&self, origin: f64, direction: f64) -> bool {
        if self.cells == 1 {
            return true;
        }
        let reach = origin.abs() + self.magnitude;
        // The second term is the underflow of tiny parameters.
        96.0 * UNIT_ROUNDOFF * reach + f64::MIN_POSITIVE * direction.abs() <= 0.5 * WIDENING * self.cell
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_and_indices_agree() {
        let axis = GridAxis::new(-1.0, 3.0, 8);
        assert_eq!(axis.cells, 8);
        assert_eq!((axis.plane(0), axis.plane(8)), (-1.0, 3.0));
        assert_eq!(
            [-9.0, -1.0, -0.75, -0.5, 2.99, 3.0, 1e300, f64::NAN].map(|x| axis.index(x)),
            [0, 0, 0, 1, 7, 7, 7, 0]
        );
    }

    #[test]
    fn cells_touching_a_box_list_it() {
        let axis = GridAxis::new(1e5, 1e5 + 7.0, 100);
        for i in 0..100 {
            let (min, max) = (axis.plane(i).next_up(), axis.plane(i + 1));
            assert_eq!(axis.touched_range(min, max), i..=(i + 1).min(99));
            let listed = axis.insertion_range(min, max);
            assert!(*listed.start() <= i && *listed.end() >= (i + 1).min(99), "cell {i}: {listed:?}");
        }
    }

    #[test]
    fn degenerate_extents_have_one_cell() {
        assert_eq!(GridAxis::new(0.0, 0.0, 50).cells, 1);
        assert_eq!(GridAxis::new(1e7, 1e7 + 1e-9, 50).cells, 1);
        assert_eq!(GridAxis::new(f64::MIN, f64::MAX, 50).cells, 1);
        assert_eq!(GridAxis::new(f64::INFINITY, f64::NEG_INFINITY, 50).cells, 1, "the bounds of nothing");
        assert_eq!(GridAxis::new(0.0, 1.0, 0).cells, 1);
    }

    #[test]
    fn distant_and_extreme_rays_are_not_resolved() {
        let axis = GridAxis::new(0.0, 1.0, 10);
        assert!(axis.resolves(0.5, 1.0) && axis.resolves(1e6, -0.0));
        assert!(!axis.resolves(1e15, 1.0), "too far");
        assert!(!axis.resolves(0.5, f64::MAX), "parameters underflow");
        assert!(!axis.resolves(f64::NAN, 1.0) && !axis.resolves(0.5, f64::NAN));
    }
}
