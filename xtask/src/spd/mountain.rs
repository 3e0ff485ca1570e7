//! A fractal mountain under four spheres of glass.

use rt_math::{
    DVec3,
    random::{hash, unit},
};

use super::nff::{Fill, Nff, NffView};

/// Displacement of a height relative to the distance of its two neighbours.
const ROUGHNESS: f64 = 0.42;

/// A square of 4^size cells, each cut in two triangles, and four spheres of glass: 2 · 4^size + 4 objects. Heights are
/// by random midpoint displacement (Fournier, Fussell and Carpenter, "Computer Rendering of Stochastic Models", CACM
/// 25(6), 1982).
///
/// The paper gives the numbers of objects; the heights are ours.
pub(super) fn mountain(size: u32) -> Nff {
    let view = NffView { from: DVec3::new(-1.7, -1.3, 1.25), at: DVec3::new(0.0, 0.0, 0.12), up: DVec3::Z };
    let mut file = Nff::new(&format!("mountain, size {size}"), &view, &[DVec3::new(-10.0, 5.0, 12.0)]);
    let cells = 1usize << size;
    let heights = heights(size);
    let corner = |x: usize, y: usize| {
        let [across, along] = [x, y].map(|i| 2.0 * i as f64 / cells as f64 - 1.0);
        DVec3::new(across, along, heights[y * (cells + 1) + x])
    };
    file.fill(&Fill::matte([0.45, 0.38, 0.3], 1.0));
    for (y, x) in (0..cells).flat_map(|y| (0..cells).map(move |x| (y, x))) {
        let [a, b, c, d] = [corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)];
        file.polygon(&[a, b, c]);
        file.polygon(&[a, c, d]);
    }
    file.fill(&Fill { specular: 0.15, shine: 200.0, transmittance: 0.8, ior: 1.5, ..Fill::matte([1.0; 3], 0.05) });
    for (x, y) in [(-0.9, -0.75), (-0.35, -0.85), (-0.85, -0.15), (-0.4, -0.35)] {
        file.sphere(DVec3::new(x, y, 0.62), 0.17);
    }
    file
}

/// Heights of the corners of 2^size by 2^size cells, row by row. Squares are halved from the whole down: first the
/// midpoints of their edges, then their centres.
fn heights(size: u32) -> Vec<f64> {
    let cells = 1usize << size;
    let row = cells + 1;
    let mut heights = vec![0.0; row * row];
    let random =
        |x: usize, y: usize| 2.0 * unit(hash(&[x as u64 * 1024 / cells as u64, y as u64 * 1024 / cells as u64])) - 1.0;
    heights[cells * row + cells] = 0.3;
    heights[cells] = 0.1;
    let mut step = cells;
    while step > 1 {
        let half = step / 2;
        let displacement = |x: usize, y: usize| random(x, y) * ROUGHNESS * step as f64 / cells as f64;
        for (y, x) in (0..=cells).step_by(step).flat_map(|y| (half..cells).step_by(step).map(move |x| (y, x))) {
            heights[y * row + x] =
                (heights[y * row + x - half] + heights[y * row + x + half]) / 2.0 + displacement(x, y);
        }
        for (x, y) in (0..=cells).step_by(step).flat_map(|x| (half..cells).step_by(step).map(move |y| (x, y))) {
            heights[y * row + x] =
                (heights[(y - half) * row + x] + heights[(y + half) * row + x]) / 2.0 + displacement(x, y);
        }
        for (y, x) in (half..cells).step_by(step).flat_map(|y| (half..cells).step_by(step).map(move |x| (y, x))) {
            let sides = [y * row + x - half, y * row + x + half, (y - half) * row + x, (y + half) * row + x];
            heights[y * row + x] = sides.map(|i| heights[i]).iter().sum::<f64>() / 4.0 + displacement(x, y);
        }
        step = half;
    }
    heights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_finer_mountain_has_the_heights_of_a_coarser_one() {
        let (coarse, fine) = (heights(3), heights(5));
        for (y, x) in (0..=8).flat_map(|y| (0..=8).map(move |x| (y, x))) {
            assert_eq!(coarse[y * 9 + x], fine[4 * y * 33 + 4 * x]);
        }
        assert!(fine.iter().any(|height| *height > 0.2));
    }
}
