//! Resolution of a grid.

use glam::DVec3;
use rt_math::transcendental::cbrt;

/// Cells per primitive. Traversal is cheap compared with tests, so that there may be more cells than primitives. Wald
/// et al., "Ray Tracing Animated Scenes using Coherent Grid Traversal", 2006, recommend 4 to 8.
const DENSITY: u64 = 6;

/// Maximum number of cells: 256 MiB of offsets.
pub(super) const MAX_CELLS: u64 = 1 << 26;

/// Number of cells for this number of primitives.
pub(super) fn suitable_cells(primitives: usize) -> u64 {
    (DENSITY * primitives as u64).clamp(1, MAX_CELLS)
}

/// Number of nearly cubical cells along each axis, at most `cells` in total. Axes shorter than such a cube have one
/// cell, and the others share the remaining factor.
pub(super) fn cubical(extent: DVec3, cells: u64) -> [u32; 3] {
    let longest = extent.max_element();
    // Only proportions matter; without a finite extent there are none.
    let relative = (extent / longest).to_array().map(|x| if x.is_finite() { x } else { 0.0 });
    let mut is_divided = relative.map(|extent| extent > 0.0);
    loop {
        let volume: f64 = (0..3).filter(|&axis| is_divided[axis]).map(|axis| relative[axis]).product();
        let side = match is_divided.iter().filter(|&&divided| divided).count() {
            0 => return [1; 3],
            1 => volume / cells as f64,
            2 => (volume / cells as f64).sqrt(),
            _ => cbrt(volume / cells as f64),
        };
        let Some(short) = (0..3).find(|&axis| is_divided[axis] && relative[axis] < side) else {
            return core::array::from_fn(
                |axis| {
                    if is_divided[axis] { ((relative[axis] / side) as u32).max(1) } else { 1 }
                },
            );
        };
        is_divided[short] = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_cubes_where_the_extent_allows() {
        assert_eq!(cubical(DVec3::new(1.0, 2.0, 4.0), 8 * 64), [4, 8, 16]);
        assert_eq!(cubical(DVec3::new(1.0, 0.0, 1.0), 100), [10, 1, 10]);
        assert_eq!(cubical(DVec3::new(1.0, 1e-12, 1e-9), 100), [100, 1, 1]);
        assert_eq!(cubical(DVec3::splat(1e-200), 27), [3; 3]);
        assert_eq!(cubical(DVec3::splat(1e300), 27), [3; 3]);
        assert_eq!(cubical(DVec3::ZERO, 27), [1; 3]);
        assert_eq!(cubical(DVec3::INFINITY, 27), [1; 3]);
        assert_eq!(cubical(DVec3::NEG_INFINITY, 27), [1; 3], "the extent of nothing");
    }

    #[test]
    fn there_are_never_more_cells_than_wanted() {
        for i in 0..1000u64 {
            let draw = |k| rt_math::random::unit(rt_math::random::hash(&[i, k]));
            let extent = DVec3::new(draw(0), draw(1) * draw(1), draw(2) * draw(2) * draw(2));
            let product: u64 = cubical(extent, 1 + i * i).iter().map(|&n| u64::from(n)).product();
            assert!(product <= 1 + i * i, "{product} cells, not {}", 1 + i * i);
        }
    }
}
