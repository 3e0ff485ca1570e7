//! Passes: independent scrambles of the sample pattern, whose differences estimate the error of their mean.
//!
//! ```text
//!   fixed      |  N/M  |  N/M  |  N/M  |  N/M  |                     M passes of each pixel in turn
//!   --time     |1|1| 2 |  4  |    8    |    16    |    16    | …     over the whole image, until time is up
//!   --target-error   4 × 4 | 2 × 8 | 2 × 16 | 2 × 32 | …             tested after each pass, from 16 samples on
//!   ... of pixels    8 × 8 | 8 × 8 | 8 × 16 | 8 × 32 | …             tested each time the count has doubled
//! ```
//!
//! Samples within a pass are correlated, as Sobol' points are. Their variance does not estimate the error of their mean. Whole
//! passes are independent.

use crate::Crop;
use rt_camera::SamplerKind;
use rt_math::random::hash;

/// Default number of passes for a fixed number of samples.
///
/// `stochastic` is true for integrators that sample directions. Two passes estimate their noise. More would estimate it better,
/// but stratify the samples of a pixel less. From 16 samples on, four are taken if two would need more samples, as 2 × 9 for 16
/// samples in square patterns. One is taken if two would double the samples. Other integrators take one pass, which keeps the full
/// stratification at edges.
pub const fn default_passes(pattern: SamplerKind, spp: u32, stochastic: bool) -> u32 {
    let of_two = pattern.round_up(spp.div_ceil(2)).saturating_mul(2);
    let of_four = pattern.round_up(spp.div_ceil(4)).saturating_mul(4);
    match pattern.round_up(spp) {
        _ if !stochastic => 1,
        0..2 => 1,
        16.. if of_four < of_two => 4,
        of_one if of_two / 2 >= of_one => 1,
        _ => 2,
    }
}

/// Seed of a pass; that of the first pass is the seed itself.
pub(crate) fn pass_seed(seed: u64, pass: u32) -> u64 {
    if pass == 0 { seed } else { hash(&[seed, u64::from(pass)]) }
}

/// Samples of a tile in one work item.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PassSpec<'a> {
    /// Index of the first pass.
    pub(crate) first: u32,
    /// Number of passes, at least 1.
    pub(crate) count: u32,
    /// Samples per pixel of each pass.
    pub(crate) spp: u32,
    /// Samples per pass of pixels without an edge, with adaptive sampling in object space.
    pub(crate) simple_spp: Option<u32>,
    /// Pixels to sample; `None` for all.
    pub(crate) pixels: Option<&'a PixelMask>,
}

impl PassSpec<'_> {
    /// Maximum number of samples of a pixel.
    pub(crate) fn samples_per_pixel(&self) -> u64 {
        u64::from(self.count) * u64::from(self.spp)
    }

    /// Maximum number of samples of some tiles.
    pub(crate) fn samples_of(&self, tiles: impl Iterator<Item = Crop>) -> u64 {
        let pixels = |tile: Crop| match self.pixels {
            None => tile.area(),
            Some(_) => self.pixels_of(tile).count() as u64,
        };
        self.samples_per_pixel() * tiles.map(pixels).sum::<u64>()
    }

    /// Sampled pixels of a tile, row by row.
    pub(crate) fn pixels_of(&self, tile: Crop) -> impl Iterator<Item = [u32; 2]> {
        tile.pixels().filter(|&pixel| self.pixels.is_none_or(|mask| mask.contains(pixel)))
    }
}

/// Subset of the pixels of a rectangle of the image.
#[derive(Clone, Debug)]
pub(crate) struct PixelMask {
    area: Crop,
    flags: Vec<bool>,
}

impl PixelMask {
    /// Pixels of a rectangle whose flag, row by row, is set.
    pub(crate) fn new(area: Crop, flags: Vec<bool>) -> Self {
        Self { area, flags }
    }

    /// Number of pixels in the mask.
    pub(crate) fn count(&self) -> usize {
        self.flags.iter().filter(|&&is_set| is_set).count()
    }

    /// True if the mask contains a pixel, in coordinates of the whole image.
    pub(crate) fn contains(&self, pixel: [u32; 2]) -> bool {
        self.flags.get(self.area.pixel_index(pixel)).copied().unwrap_or(false)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_noisy_images_have_several_passes_by_default() {
        for pattern in SamplerKind::ALL {
            assert_eq!(default_passes(pattern, 1024, false), 1);
            assert_eq!(default_passes(pattern, 1, true), 1);
        }
        assert_eq!([2, 15, 16, 1024].map(|spp| default_passes(SamplerKind::Sobol, spp, true)), [2; 4]);
        assert_eq!([4, 8, 16, 64].map(|spp| default_passes(SamplerKind::Jittered, spp, true)), [1, 2, 4, 4]);
        assert_eq!(default_passes(SamplerKind::Jittered, 18, true), 2, "twice nine are eighteen");
    }

    #[test]
    fn the_first_pass_has_the_seed_itself() {
        assert_eq!(pass_seed(42, 0), 42);
        let seeds: std::collections::HashSet<_> =
            (0..100).flat_map(|seed| (0..100).map(move |pass| pass_seed(seed, pass))).collect();
        assert_eq!(seeds.len(), 100 * 100);
    }
}
