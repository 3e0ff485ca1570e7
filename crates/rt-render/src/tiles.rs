//! The image cut into tiles: the unit of work of a thread.

/// Side of a tile in pixels.
const SIDE: u32 = 16;

/// A rectangle of pixels, in coordinates of the whole image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Tile {
    pub(crate) x: u32,
    pub(crate) y: u32,
    pub(crate) width: u32,
    pub(crate) height: u32,
}

impl Tile {
    /// The pixels of the tile, row by row.
    pub(crate) fn pixels(&self) -> impl Iterator<Item = [u32; 2]> + Clone + use<> {
        let Self { x, y, width, height } = *self;
        (y..y + height).flat_map(move |row| (x..x + width).map(move |column| [column, row]))
    }
}

/// Cuts the rectangle at (`x`, `y`) into tiles, row by row.
pub(crate) fn tiles(x: u32, y: u32, width: u32, height: u32) -> Vec<Tile> {
    let steps = |length: u32| (0..length).step_by(SIDE as usize);
    steps(height)
        .flat_map(|top| {
            steps(width).map(move |left| Tile {
                x: x + left,
                y: y + top,
                width: SIDE.min(width - left),
                height: SIDE.min(height - top),
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_each_pixel_once() {
        for (x, y, width, height) in [(0, 0, 1, 1), (3, 5, 16, 17), (0, 0, 100, 33), (7, 0, 1, 65), (0, 2, 64, 1)] {
            let mut seen = vec![0; (width * height) as usize];
            for [column, row] in tiles(x, y, width, height).iter().flat_map(Tile::pixels) {
                seen[((row - y) * width + (column - x)) as usize] += 1;
            }
            assert!(seen.iter().all(|&count| count == 1), "{width}×{height} at {x},{y}");
        }
    }
}
