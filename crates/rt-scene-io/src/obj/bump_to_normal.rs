//! Height maps to normal maps.
//!
//! MTL files do not specify the height of the greys of a bump map. Here white is above black by [`HEIGHT`] of the image's
//! width, times `-bm`, at any resolution.

use rt_shading::Bitmap;

/// From black to white, in widths of the image.
const HEIGHT: f32 = 1.0 / 16.0;

/// True if the pixels are heights rather than normals: all of them are grey.
pub(super) fn is_height(bitmap: &Bitmap) -> bool {
    bitmap.pixels.iter().all(|[r, g, b]| r == g && g == b)
}

/// Replaces heights by the normals of the surface that they describe, in the encoding of normal maps: 0 to 1 for −1 to 1.
/// The first component is along u, the second along v, which rises from the lowest row to the topmost.
pub(super) fn normals_from_heights(bitmap: &mut Bitmap, clamp: bool) {
    let (width, height) = (bitmap.width as usize, bitmap.height as usize);
    let heights: Vec<f32> = bitmap.pixels.iter().map(|pixel| pixel[0] * HEIGHT * width as f32).collect();
    let before = |i: usize, count: usize| {
        if i > 0 {
            i - 1
        } else if clamp {
            0
        } else {
            count - 1
        }
    };
    let after = |i: usize, count: usize| {
        if i + 1 < count {
            i + 1
        } else if clamp {
            i
        } else {
            0
        }
    };
    for y in 0..height {
        for x in 0..width {
            let at = |x: usize, y: usize| heights[y * width + x];
            let along_u = (at(after(x, width), y) - at(before(x, width), y)) / 2.0;
            let along_v = (at(x, before(y, height)) - at(x, after(y, height))) / 2.0;
            let length = (along_u * along_u + along_v * along_v + 1.0).sqrt();
            bitmap.pixels[y * width + x] = [-along_u, -along_v, 1.0].map(|part| 0.5 + 0.5 * part / length);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn normals(width: u32, heights: &[f32], clamp: bool) -> Vec<[f32; 3]> {
        let pixels: Vec<[f32; 3]> = heights.iter().map(|&h| [h; 3]).collect();
        let mut bitmap = Bitmap::opaque(width, heights.len() as u32 / width, pixels);
        assert!(is_height(&bitmap));
        normals_from_heights(&mut bitmap, clamp);
        bitmap.pixels.iter().map(|pixel| pixel.map(|part| 2.0 * part - 1.0)).collect()
    }

    #[test]
    fn a_ramp_leans_against_the_way_up() {
        // In an image of width 16, the height from black to white equals the width of a pixel.
        let rising = normals(16, &[0.0, 1.0, 2.0].repeat(6)[..16], true);
        let steep = 0.5_f32.sqrt();
        assert!((rising[1][0] + steep).abs() < 1e-6 && (rising[1][2] - steep).abs() < 1e-6, "{rising:?}");
        assert_eq!(rising[1][1], 0.0);
        // The topmost row is the highest: v rises towards it.
        let column: Vec<f32> = [2.0, 1.0, 0.0].iter().flat_map(|&h| [h; 16]).collect();
        let upward = normals(16, &column, true)[16..].to_vec();
        assert!((upward[0][1] + steep).abs() < 1e-6 && upward[0][0] == 0.0, "{upward:?}");
    }

    #[test]
    fn edges_are_flat_or_meet_their_opposite() {
        assert_eq!(normals(1, &[0.5], false), [[0.0, 0.0, 1.0]]);
        let repeated = normals(4, &[0.0, 0.0, 0.0, 1.0], false);
        assert!(repeated[0][0] > 0.0 && repeated[1][0] == 0.0 && repeated[2][0] < 0.0, "{repeated:?}");
        assert_eq!(normals(4, &[0.0, 0.0, 0.0, 1.0], true)[0], [0.0, 0.0, 1.0]);
    }

    #[test]
    fn colours_are_normals() {
        assert!(!is_height(&Bitmap::opaque(1, 1, vec![[0.5, 0.5, 1.0]])));
    }
}
