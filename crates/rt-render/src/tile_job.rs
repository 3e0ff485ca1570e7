//! Work item of a thread, and its result: one tile of the image.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crate::{
    Crop, Statistics,
    film::pixel_estimate::PixelEstimate,
    first_hit_layers::{FirstHitLayer, TileChannel},
    passes::{PassSpec, PixelMask},
};

/// A tile that takes longer after an interrupt is abandoned.
const MAX_DELAY: Duration = Duration::from_secs(1);

/// Work item of a thread.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TileJob<'a> {
    pub(crate) tile: Crop,
    pub(crate) pass_spec: &'a PassSpec<'a>,
    /// Pixels without an edge, with adaptive sampling in object space; `None` until the tile is started.
    pub(crate) simple: Option<&'a PixelMask>,
    /// True once the render shall end.
    pub(crate) interrupt: Option<&'a AtomicBool>,
    /// Layers to compute with the image.
    pub(crate) layers: &'a [FirstHitLayer],
}

impl<'a> TileJob<'a> {
    pub(crate) const fn new(tile: Crop, pass_spec: &'a PassSpec<'a>, interrupt: Option<&'a AtomicBool>) -> Self {
        Self { tile, pass_spec, simple: None, interrupt, layers: &[] }
    }

    /// True if the interrupt was first seen, as `since` notes, longer ago than a tile may take to end.
    pub(crate) fn is_overdue(&self, since: &mut Option<Instant>) -> bool {
        self.interrupt.is_some_and(|interrupt| interrupt.load(Ordering::Relaxed))
            && since.get_or_insert_with(Instant::now).elapsed() > MAX_DELAY
    }

    pub(crate) fn is_simple(&self, pixel: [u32; 2]) -> bool {
        self.simple.is_some_and(|simple| simple.contains(pixel))
    }

    /// Samples per pass of a pixel.
    pub(crate) fn spp_of(&self, pixel: [u32; 2]) -> u32 {
        self.pass_spec.simple_spp.filter(|_| self.is_simple(pixel)).unwrap_or(self.pass_spec.spp)
    }

    /// Samples of a pixel in all passes.
    pub(crate) fn samples_of(&self, pixel: [u32; 2]) -> u32 {
        self.spp_of(pixel).saturating_mul(self.pass_spec.count)
    }
}

/// Rendered pixels of a tile with its counters.
pub(crate) struct TileResult {
    pub(crate) tile: Crop,
    /// Accumulators of the sampled pixels, row by row. The film rounds them.
    pub(crate) pixels: Vec<PixelEstimate>,
    /// Counts of the tile, without times.
    pub(crate) statistics: Statistics,
    /// Channels of the layers; empty if none are computed with the image.
    pub(crate) layers: Vec<TileChannel>,
    /// True if pixels are missing, because of an interrupt.
    pub(crate) is_abandoned: bool,
}

impl TileResult {
    /// Result without pixels.
    pub(crate) fn new(job: &TileJob<'_>) -> Self {
        let tile = job.tile;
        let count = tile.width as usize * tile.height as usize;
        let simple_pixels = job.simple.map_or(0, |simple| simple.count() as u64);
        Self {
            tile,
            pixels: Vec::with_capacity(count),
            statistics: Statistics { simple_pixels, ..Statistics::default() },
            layers: Vec::new(),
            is_abandoned: false,
        }
    }

    /// Appends the next sampled pixel of the tile.
    pub(crate) fn push(&mut self, pixel: PixelEstimate) {
        self.statistics.samples += u64::from(pixel.samples());
        self.pixels.push(pixel);
    }
}
