//! How probably a ray through a cell also meets a part of it.

use glam::DVec3;
use rt_math::Aabb;

/// An axis on which a cell has no extent counts as having this part of its longest one, so that its other extents
/// still count.
const THINNEST: f64 = 1.0 / (1u64 << 40) as f64;

/// The proportions of a box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shape {
    /// By axis: the area of the two faces at right angles to it, relative to that of all six.
    ends: DVec3,
}

impl Shape {
    /// `None` if the cell is a point. Extents are halved against overflow.
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

    /// The ratio of the surface area of a part to that of the whole (a mean over all rays: Santaló 1976), where the
    /// part has the same outline in direction `normal`, of unit length, and `fraction` of the extent along it. Exact for
    /// the parts of a box at right angles to an axis.
    pub(crate) fn probability(&self, normal: DVec3, fraction: f64) -> f64 {
        // The area of the outline of a box is the sum of those of its faces.
        let outline = self.ends.dot(normal.abs());
        outline + fraction * (1.0 - outline)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_of_boxes_have_their_area() {
        let shape = Shape::of(&Aabb::new(DVec3::ZERO, DVec3::new(2.0, 1.0, 1.0))).expect("a box");
        assert!((shape.probability(DVec3::X, 0.5) - 0.6).abs() < 1e-15, "6 of 10");
        assert!((shape.probability(DVec3::NEG_Y, 0.5) - 0.7).abs() < 1e-15, "7 of 10");
        assert!((shape.probability(DVec3::Z, 1.0) - 1.0).abs() < 1e-15);
        let cube = Shape::of(&Aabb::new(DVec3::ZERO, DVec3::ONE)).expect("a box");
        let prism = (3.0 + 2f64.sqrt()) / 6.0;
        assert!((cube.probability(DVec3::new(1.0, 1.0, 0.0).normalize(), 0.5) - prism).abs() < 1e-15);
    }

    #[test]
    fn flat_cells_and_extreme_ones_have_a_shape() {
        let half = |cell: Aabb| Shape::of(&cell).map(|shape| shape.probability(DVec3::X, 0.5));
        assert_eq!(half(Aabb::new(DVec3::ONE, DVec3::ONE)), None);
        let about_half = |p: Option<f64>| p.is_some_and(|p| (p - 0.5).abs() < 1e-11);
        assert!(about_half(half(Aabb::new(DVec3::ZERO, DVec3::X))), "a line");
        assert!(about_half(half(Aabb::new(DVec3::ZERO, DVec3::new(5e-320, 0.0, 5e-320)))), "a sheet");
        assert!(half(Aabb::new(DVec3::MIN, DVec3::MAX)).is_some_and(|p| (p - 2.0 / 3.0).abs() < 1e-15));
    }
}
