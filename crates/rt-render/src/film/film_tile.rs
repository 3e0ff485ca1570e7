//! Finished pixels of a tile, and the layout of the film that they belong to.

use rt_math::Rgb;
use serde::{Deserialize, Serialize};

use super::pixel_estimate::PixelEstimate;
use crate::{ContentError, Crop, RenderPlan, RunOptions, content_checks::check_length, error_estimate::ErrorSums};

/// Layout of a film: its area and optional channels. Shards that are merged have the same layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct FilmLayout {
    pub(crate) crop: Crop,
    pub(crate) transparent: bool,
    /// True if passes differ, so that they estimate the error.
    pub(crate) passes_differ: bool,
    /// True for images of standard errors and sample counts as well.
    pub(crate) maps: bool,
    /// True if traversal steps and primitive tests are counted.
    pub(crate) count: bool,
}

impl FilmLayout {
    pub(crate) fn new(plan: &RenderPlan<'_>, options: &RunOptions<'_>) -> Self {
        Self {
            crop: plan.frame.crop,
            transparent: plan.frame.transparent,
            passes_differ: plan.passes_differ(),
            maps: options.maps,
            count: options.count,
        }
    }
}

/// Pixels of a finished tile, row by row, rounded to the precision of the image.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct FilmTile {
    pub(crate) pixels: Vec<[f32; 3]>,
    /// Empty unless the image is transparent.
    pub(crate) alpha: Vec<f32>,
    /// Empty unless requested. Infinite, or empty as well, after a single pass.
    pub(crate) standard_errors: Vec<[f32; 3]>,
    /// Samples of each pixel; empty if all have the same number.
    pub(crate) counts: Vec<u32>,
    /// Minimum and maximum number of samples of a pixel.
    pub(crate) range: [u32; 2],
    /// Samples of all pixels.
    pub(crate) samples: u64,
    pub(crate) error: ErrorSums,
}

impl FilmTile {
    /// Rounds the pixels of a tile. With `has_errors`, standard errors are kept: infinite for pixels of fewer than two passes.
    pub(crate) fn new<'p>(
        pixels: impl IntoIterator<Item = &'p PixelEstimate, IntoIter: Clone>,
        layout: FilmLayout,
        has_errors: bool,
    ) -> Self {
        let pixels = pixels.into_iter();
        let counts: Vec<_> = pixels.clone().map(PixelEstimate::samples).collect();
        let range = [counts.iter().copied().min(), counts.iter().copied().max()].map(Option::unwrap_or_default);
        let standard_error = |pixel: &PixelEstimate| match pixel.variance() {
            Some(variance) => rounded(variance.map(f64::sqrt)),
            None => [f32::INFINITY; 3],
        };
        let optional = |is_kept: bool| pixels.clone().filter(move |_| is_kept);
        Self {
            pixels: pixels.clone().map(|pixel| rounded(pixel.mean())).collect(),
            alpha: optional(layout.transparent).map(rounded_coverage).collect(),
            standard_errors: optional(has_errors).map(standard_error).collect(),
            samples: counts.iter().copied().map(u64::from).sum(),
            counts: if range[0] == range[1] { Vec::new() } else { counts },
            range,
            error: ErrorSums::of(pixels),
        }
    }

    /// Sample count of each pixel, equal in all channels.
    pub(crate) fn counts_of_pixels(&self) -> Vec<[f32; 3]> {
        let same = if self.counts.is_empty() { self.pixels.len() } else { 0 };
        let counts = self.counts.iter().copied().chain(core::iter::repeat_n(self.range[0], same));
        counts.map(|count| [count as f32; 3]).collect()
    }

    /// Checks the lengths of all lists and the consistency of the sample counts. All `f32` values are valid radiance.
    pub(crate) fn validate(&self, number: u32, tile: Crop, layout: &FilmLayout) -> Result<(), ContentError> {
        let area = tile.area() as usize;
        let check = |list, found, expected| check_length(list, || format!("tile {number}"), found, expected);
        let optional = |found: usize| if found == 0 { 0 } else { area };
        check("radiance", self.pixels.len(), area)?;
        check("coverage", self.alpha.len(), if layout.transparent { area } else { 0 })?;
        check("standard errors", self.standard_errors.len(), optional(self.standard_errors.len()))?;
        check("sample counts", self.counts.len(), optional(self.counts.len()))?;
        if let Some(&coverage) = self.alpha.iter().find(|coverage| !(0.0..=1.0).contains(*coverage)) {
            return Err(ContentError::Number { name: "a coverage", value: coverage.into() });
        }
        let [min, max] = self.range;
        let (found, sum) = match (self.counts.iter().min(), self.counts.iter().max()) {
            (Some(&first), Some(&last)) => ([first, last], self.counts.iter().copied().map(u64::from).sum()),
            _ => ([min; 2], u64::from(min) * area as u64),
        };
        if found != [min, max] || sum != self.samples {
            return Err(ContentError::Samples(number));
        }
        self.error.validate(area as u64)
    }
}

/// Rounds radiance to the precision of an image.
pub(crate) fn rounded(value: Rgb) -> [f32; 3] {
    value.to_array().map(|component| component as f32)
}

/// Rounds coverage to the precision of an image. Negative lobes of a filter can take it out of [0, 1].
pub(crate) fn rounded_coverage(pixel: &PixelEstimate) -> f32 {
    pixel.coverage().clamp(0.0, 1.0) as f32
}
