//! Tiles of the image, which are small crops: the units of work of a thread.

use crate::Crop;

/// Side of a tile in pixels.
const SIDE: u32 = 16;

/// Tiles of a crop, row by row.
pub(crate) fn tiles(crop: Crop) -> Vec<Crop> {
    (0..tile_count(crop)).map(|number| tile(crop, number)).collect()
}

/// Tile of a crop by its number, which must be less than [`tile_count`].
pub(crate) fn tile(crop: Crop, number: usize) -> Crop {
    let columns = crop.width.div_ceil(SIDE) as usize;
    let [left, top] = [number % columns, number / columns].map(|steps| steps as u32 * SIDE);
    Crop { x: crop.x + left, y: crop.y + top, width: SIDE.min(crop.width - left), height: SIDE.min(crop.height - top) }
}

pub(crate) const fn tile_count(crop: Crop) -> usize {
    crop.width.div_ceil(SIDE) as usize * crop.height.div_ceil(SIDE) as usize
}

pub(crate) const fn tile_number(crop: Crop, tile: Crop) -> usize {
    ((tile.y - crop.y) / SIDE) as usize * crop.width.div_ceil(SIDE) as usize + ((tile.x - crop.x) / SIDE) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_each_pixel_once() {
        for (x, y, width, height) in [(0, 0, 1, 1), (3, 5, 16, 17), (0, 0, 100, 33), (7, 0, 1, 65), (0, 2, 64, 1)] {
            let mut seen = vec![0; (width * height) as usize];
            let crop = Crop { x, y, width, height };
            let all = tiles(crop);
            for [column, row] in all.iter().flat_map(Crop::pixels) {
                seen[((row - y) * width + (column - x)) as usize] += 1;
            }
            assert_eq!(all.len(), tile_count(crop));
            assert!(all.iter().enumerate().all(|(number, tile)| tile_number(crop, *tile) == number));
            assert!(seen.iter().all(|&count| count == 1), "{width}×{height} at {x},{y}");
        }
    }
}
