//! Checks of decoded shards and checkpoints: numbers that would overflow, or that contradict each other.
//!
//! The hash at the end of a file detects damage. It does not detect crafted files, as it has no key.

use rt_image::Image;

use crate::{Crop, ShardSpec, tile::tile_count};

/// Maximum of counts in the statistics of a shard or checkpoint, and of their sums over all shards of an image. Adding a few of
/// them does not overflow.
pub(crate) const MAX_COUNT: u64 = 1 << 60;

/// Largest number of threads of all machines together.
pub(crate) const MAX_THREADS: u64 = 1 << 30;

/// Largest index of a pass. The next higher bit marks the second stage of adaptive sampling.
pub(crate) const MAX_PASSES: u32 = (1 << 31) - 1;

/// First invalid number of a decoded shard or checkpoint.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ContentError {
    /// The rendered area is empty, or exceeds [`Image::MAX_PIXELS`].
    #[error("the area of {}x{} pixels at {},{} is empty or too large", .0.width, .0.height, .0.x, .0.y)]
    Crop(Crop),
    /// The shard does not exist; with its index and the number of shards.
    #[error("shard {0} of {1} does not exist")]
    ShardSpec(u32, u32),
    /// A tile lies outside of the image or the shard; with its number.
    #[error("tile {0} lies outside of the image or shard")]
    Tile(u32),
    /// A tile is listed twice; with its number.
    #[error("tile {0} is listed twice")]
    Repeated(u32),
    /// A list does not have an entry for each pixel or tile.
    #[error("{list} of {of} has {found} entries rather than {expected}")]
    Length {
        /// Name of the list.
        list: &'static str,
        /// Object that the list describes.
        of: String,
        /// Number of its entries.
        found: usize,
        /// Number of pixels or tiles.
        expected: usize,
    },
    /// The sample counts of a tile contradict each other; with its number.
    #[error("the sample counts of tile {0} contradict each other")]
    Samples(u32),
    /// The sample or pass count of a pixel exceeds the total of all passes so far; with its index.
    #[error("pixel {0} has more samples than the passes so far took")]
    Pixel(usize),
    /// A count exceeds its limit, or the counts of all shards together do.
    #[error("the number of {name} is {value}; it must be at most {max}")]
    Count {
        /// Name of the count.
        name: &'static str,
        /// The count.
        value: u64,
        /// Its limit.
        max: u64,
    },
    /// A number is NaN, infinite, negative, or beyond its range.
    #[error("{name} is {value}; it must be finite and not negative")]
    Number {
        /// Name of the number.
        name: &'static str,
        /// The number.
        value: f64,
    },
}

/// Checks the size of an image, before any other size is computed from it.
pub(crate) fn check_crop(crop: Crop) -> Result<(), ContentError> {
    let Crop { x, y, width, height } = crop;
    let fits = width > 0
        && height > 0
        && x.checked_add(width).is_some()
        && y.checked_add(height).is_some()
        && u64::from(width) * u64::from(height) <= Image::MAX_PIXELS;
    if fits { Ok(()) } else { Err(ContentError::Crop(crop)) }
}

pub(crate) fn check_shard_spec(spec: ShardSpec) -> Result<(), ContentError> {
    match ShardSpec::new(spec.index(), spec.count()) {
        Some(_) => Ok(()),
        None => Err(ContentError::ShardSpec(spec.index(), spec.count())),
    }
}

/// Checks the numbers of tiles in which a thread panicked. The crop must have been checked.
pub(crate) fn check_lost(lost: &[u32], crop: Crop) -> Result<(), ContentError> {
    match lost.iter().find(|&&number| number as usize >= tile_count(crop)) {
        Some(&number) => Err(ContentError::Tile(number)),
        None => Ok(()),
    }
}

pub(crate) fn check_length(
    list: &'static str,
    of: impl FnOnce() -> String,
    found: usize,
    expected: usize,
) -> Result<(), ContentError> {
    if found == expected { Ok(()) } else { Err(ContentError::Length { list, of: of(), found, expected }) }
}

/// Checks that a count does not exceed its limit.
pub(crate) fn check_count(name: &'static str, value: u64, max: u64) -> Result<(), ContentError> {
    if value <= max { Ok(()) } else { Err(ContentError::Count { name, value, max }) }
}

/// Checks that a number is finite and not negative.
pub(crate) fn check_number(name: &'static str, value: f64) -> Result<(), ContentError> {
    if (0.0..=f64::MAX).contains(&value) { Ok(()) } else { Err(ContentError::Number { name, value }) }
}
