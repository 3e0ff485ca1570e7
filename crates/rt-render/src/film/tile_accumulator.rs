//! Film accumulation of a tile: samples into passes, and passes into pixels.

use rt_shading::RadianceSample;

use super::{pixel_accumulator::PixelAccumulator, pixel_estimate::PixelEstimate};
use crate::tile_job::TileResult;

/// Accumulates samples into passes, and passes into the pixels of a tile.
pub(crate) struct TileAccumulator<N> {
    pub(crate) finished: TileResult,
    pixel: PixelAccumulator,
    estimate: PixelEstimate,
    /// Remaining samples of the pass.
    remaining: u32,
    /// Samples per pass of this pixel.
    spp: u32,
    /// Samples per pass of the following pixels.
    next: N,
    passes: u32,
}

impl<N: Iterator<Item = u32>> TileAccumulator<N> {
    pub(crate) fn new(finished: TileResult, pixel: PixelAccumulator, mut next: N, passes: u32) -> Self {
        let spp = next.next().unwrap_or(0);
        Self { finished, pixel, estimate: PixelEstimate::default(), remaining: spp, spp, next, passes }
    }

    /// Adds the next sample, with its filter weight.
    #[inline]
    pub(crate) fn add(&mut self, sample: &RadianceSample, weight: f64) {
        self.pixel.add(sample, weight);
        self.remaining -= 1;
        if self.remaining == 0 {
            self.finish_pass();
        }
    }

    fn finish_pass(&mut self) {
        self.finished.statistics.bad_samples += self.pixel.bad_samples();
        let (radiance, coverage) = self.pixel.mean();
        self.estimate.add(radiance, coverage, self.spp);
        self.pixel = self.pixel.cleared();
        if self.estimate.passes() == self.passes {
            self.finished.push(core::mem::take(&mut self.estimate));
            self.spp = self.next.next().unwrap_or(0);
        }
        self.remaining = self.spp;
    }
}
