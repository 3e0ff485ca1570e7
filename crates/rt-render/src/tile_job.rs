//! A tile of the image as a job of a thread, and its result.

use rt_geometry::Counters;
use rt_math::Rgb;
use rt_shading::ShadingCounts;

use crate::{
    error_estimate::ErrorSums,
    estimate::PixelEstimate,
    passes::{PassSpec, PixelMask},
    tiles::Tile,
};

/// Work item of a thread.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TileJob<'a> {
    pub(crate) tile: Tile,
    pub(crate) pass_spec: &'a PassSpec<'a>,
    /// Pixels without an edge, with adaptive sampling in object space; set when the tile is started.
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

/// A rendered tile: its pixels row by row, without the masked ones.
pub(crate) struct TileResult {
    pub(crate) tile: Tile,
    /// Radiance, not yet rounded to what a film holds.
    pub(crate) pixels: Vec<Rgb>,
    /// Coverage; empty unless the plan asks for it.
    pub(crate) alpha: Vec<f64>,
    with_alpha: bool,
    with_counts: bool,
    /// Squares of standard errors; empty after a single pass.
    pub(crate) variances: Vec<Rgb>,
    /// Samples of each pixel; empty where all have the same number.
    pub(crate) counts: Vec<u32>,
    /// Samples of all pixels.
    pub(crate) samples: u64,
    /// Pixels that show no edge.
    pub(crate) simple_pixels: u64,
    pub(crate) error: ErrorSums,
    pub(crate) counters: Counters,
    /// Samples that met a surface.
    pub(crate) camera_hits: u64,
    pub(crate) primary_rays_spared: u64,
    pub(crate) shading: ShadingCounts,
    pub(crate) bad_samples: u64,
}

impl TileResult {
    /// A tile without its pixels.
    pub(crate) fn new(job: &TileJob<'_>, with_alpha: bool) -> Self {
        let tile = job.tile;
        let count = tile.width as usize * tile.height as usize;
        let room = |needed: bool| if needed { count } else { 0 };
        Self {
            tile,
            pixels: Vec::with_capacity(count),
            alpha: Vec::with_capacity(room(with_alpha)),
            with_alpha,
            with_counts: job.simple.is_some(),
            variances: Vec::with_capacity(room(job.pass_spec.count > 1)),
            counts: Vec::with_capacity(room(job.simple.is_some())),
            samples: 0,
            simple_pixels: job.simple.map_or(0, |simple| simple.count() as u64),
            error: ErrorSums::default(),
            counters: Counters::default(),
            camera_hits: 0,
            primary_rays_spared: 0,
            shading: ShadingCounts::default(),
            bad_samples: 0,
        }
    }

    /// Adds the next pixel of the tile.
    pub(crate) fn push(&mut self, pixel: &PixelEstimate) {
        self.pixels.push(pixel.mean());
        if self.with_alpha {
            self.alpha.push(pixel.coverage());
        }
        self.variances.extend(pixel.variance());
        self.samples += u64::from(pixel.samples());
        if self.with_counts {
            self.counts.push(pixel.samples());
        }
        self.error.add(pixel);
    }
}
