//! Numbers that the lecture gives for its Cornell box.

use rt_math::random::permute;
use serde::{Deserialize, Serialize};

/// Width and height of its image in pixels.
pub(super) const SIZE: u32 = 2048;
/// Strata along each side of a pixel, with one jittered sample in each.
pub(super) const STRATA: u32 = 317;
/// Primary rays of a pixel.
pub(super) const SPP: u32 = STRATA * STRATA;
/// Primary rays of the image: 4.2 · 10¹¹.
pub(super) const PRIMARY_RAYS: u64 = SIZE as u64 * SIZE as u64 * SPP as u64;
/// Rays of all kinds, as the lecture has it: the tera in tera-ray.
pub(super) const RAYS: f64 = 1e12;
/// Two years of one processor, in seconds.
pub(super) const SECONDS: f64 = 2.0 * 365.25 * 86_400.0;

/// Side of a tile in pixels.
const SIDE: u32 = 2;
/// Tiles of the image.
pub(super) const TILES: u32 = (SIZE / SIDE) * (SIZE / SIDE);
pub(super) const TILE_PIXELS: u32 = SIDE * SIDE;
/// Chooses the order of the tiles.
const SEED: u64 = 317;

/// A square of pixels of the lecture's image, by its upper left corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Tile {
    x: u32,
    y: u32,
}

impl Tile {
    /// The tiles in random order, each once: those that come first are a fair sample of the image, and all together are the
    /// image. `None` after the last.
    pub(super) fn nth(index: usize) -> Option<Self> {
        let index = u32::try_from(index).ok().filter(|&index| index < TILES)?;
        let place = permute(index, TILES, SEED);
        Some(Self { x: SIDE * (place % (SIZE / SIDE)), y: SIDE * (place / (SIZE / SIDE)) })
    }

    /// Value of the renderer's `--crop`.
    pub(super) fn crop(self) -> String {
        format!("{},{},{SIDE},{SIDE}", self.x, self.y)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn the_image_is_the_lectures() {
        assert_eq!(PRIMARY_RAYS, 421_481_414_656);
        assert_eq!(TILES * TILE_PIXELS, SIZE * SIZE);
    }

    #[test]
    fn the_tiles_are_the_image() {
        let tiles: HashSet<(u32, u32)> = (0..).map_while(Tile::nth).map(|tile| (tile.x, tile.y)).collect();
        assert_eq!(tiles.len(), TILES as usize);
        assert!(tiles.iter().all(|&(x, y)| x % SIDE == 0 && y % SIDE == 0 && x < SIZE && y < SIZE));
        assert_eq!(Tile::nth(TILES as usize), None);
    }

    #[test]
    fn the_first_tiles_come_from_everywhere() {
        let quarters = (0..64).filter_map(Tile::nth).map(|tile| (tile.x < SIZE / 2, tile.y < SIZE / 2));
        let mut counts = [0; 4];
        quarters.for_each(|(left, top)| counts[usize::from(left) + 2 * usize::from(top)] += 1);
        // Each expects 16 with a standard deviation of 3.5.
        assert!(counts.iter().all(|count| (5..=27).contains(count)), "{counts:?}");
    }
}
