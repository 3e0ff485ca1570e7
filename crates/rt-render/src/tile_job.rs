//! Work item of a thread, and its result: one tile of the image.

use rt_geometry::Counters;
use rt_shading::ShadingCounts;

use crate::{
    estimate::PixelEstimate,
    passes::{PassSpec, PixelMask},
    tiles::Tile,
};

/// Work item of a thread.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TileJob<'a> {
    pub(crate) tile: Tile,
    pub(crate) pass_spec: &'a PassSpec<'a>,
    /// Pixels without an edge, with adaptive sampling in object space; `None` until the tile is started.
    pub(crate) simple: Option<&'a PixelMask>,
}

impl<'a> TileJob<'a> {
    pub(crate) const fn new(tile: Tile, pass_spec: &'a PassSpec<'a>) -> Self {
        Self { tile, pass_spec, simple: None }
    }

    pub(crate) fn is_simple(&self, pixel: [u32; 2]) -> bool {
        self.simple.is_some_and(|simple| simple.contains(pixel))
    }

    /// Samples per pass of a pixel.
    pub(crate) fn spp_of(&self, pixel: [u32; 2]) -> u32 {
        self.pass_spec.simple_spp.filter(|_| self.is_simple(pixel)).unwrap_or(self.pass_spec.spp)
    }
}

/// Rendered pixels of a tile with its counters.
pub(crate) struct TileResult {
    pub(crate) tile: Tile,
    /// Accumulators of the sampled pixels, row by row. The film rounds them.
    pub(crate) pixels: Vec<PixelEstimate>,
    /// Number of samples of all pixels.
    pub(crate) samples: u64,
    /// Number of pixels without an edge.
    pub(crate) simple_pixels: u64,
    pub(crate) counters: Counters,
    /// Number of samples that hit a surface.
    pub(crate) camera_hits: u64,
    pub(crate) primary_rays_skipped: u64,
    pub(crate) shading: ShadingCounts,
    pub(crate) bad_samples: u64,
}

impl TileResult {
    /// Result without pixels.
    pub(crate) fn new(job: &TileJob<'_>) -> Self {
        let tile = job.tile;
        let count = tile.width as usize * tile.height as usize;
        Self {
            tile,
            pixels: Vec::with_capacity(count),
            samples: 0,
            simple_pixels: job.simple.map_or(0, |simple| simple.count() as u64),
            counters: Counters::default(),
            camera_hits: 0,
            primary_rays_skipped: 0,
            shading: ShadingCounts::default(),
            bad_samples: 0,
        }
    }

    /// Appends the next sampled pixel of the tile.
    pub(crate) fn push(&mut self, pixel: PixelEstimate) {
        self.samples += u64::from(pixel.samples());
        self.pixels.push(pixel);
    }
}
