//! State of a progressive render: its film, and its position in the sequence of passes.

use rt_image::Image;
use serde::{Deserialize, Serialize};

use crate::{
    ContentError, Crop, ShardSpec, Statistics, StopRule, Stopped, TargetError,
    content_checks::{MAX_PASSES, check_count, check_crop, check_length, check_lost, check_number, check_shard_spec},
    error_estimate::ErrorSums,
    film::{
        film_tile::{FilmLayout, FilmTile, rounded, rounded_coverage},
        pixel_estimate::PixelEstimate,
    },
    tile::{tile_count, tiles},
};

/// First pass index of the second stage of adaptive sampling, in seeds.
const SECOND_STAGE: u32 = 1 << 31;

/// State of a progressive render, from which it can resume: all pixel estimates, and the position in the sequence of passes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct PassState {
    pub(crate) layout: FilmLayout,
    spec: ShardSpec,
    mode: PassMode,
    /// All pixels, row by row.
    pub(crate) pixels: Vec<PixelEstimate>,
    pub(crate) statistics: Statistics,
    pub(crate) cursor: PassCursor,
    /// Wall-clock seconds per sample of the last pass.
    pub(crate) seconds_per_sample: f64,
    /// Error of the image after the last pass.
    pub(crate) error: ErrorSums,
    /// Indices of the tiles in which a thread panicked.
    pub(crate) lost: Vec<u32>,
}

/// Rule for the size of passes and their pixels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
enum PassMode {
    /// Passes of the plan.
    Fixed,
    /// Growing passes until a stop rule applies.
    Growing,
    /// Growing passes until the error is reached, or a pixel has a maximum number of samples.
    Target(TargetError, u32),
}

/// Position in the sequence of passes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct PassCursor {
    /// Index of the current or next pass.
    pub(crate) pass: u32,
    /// Samples of a pixel that took all previous passes.
    pub(crate) taken: u32,
    /// Flags of the tiles that have taken the current pass; empty before the first one.
    pub(crate) done_tiles: Vec<bool>,
    pub(crate) stage: RefineStage,
}

impl PassState {
    /// State before the first pass.
    pub(crate) fn new(layout: FilmLayout, spec: ShardSpec, rule: Option<&StopRule>, statistics: Statistics) -> Self {
        let Crop { width, height, .. } = layout.crop;
        Self {
            layout,
            spec,
            mode: PassMode::new(rule),
            pixels: vec![PixelEstimate::default(); width as usize * height as usize],
            statistics,
            cursor: PassCursor::default(),
            seconds_per_sample: 0.0,
            error: ErrorSums::default(),
            lost: Vec::new(),
        }
    }

    /// True if a render of this layout, shard and rule can resume from here.
    pub(crate) fn fits(&self, layout: FilmLayout, spec: ShardSpec, rule: Option<&StopRule>) -> bool {
        self.layout == layout && self.spec == spec && self.mode == PassMode::new(rule)
    }

    /// Checks all numbers of a decoded state.
    pub(crate) fn validate(&self) -> Result<(), ContentError> {
        let Self { layout, spec, mode: _, pixels, statistics, cursor, seconds_per_sample, error, lost } = self;
        let PassCursor { pass, taken, done_tiles, stage } = cursor;
        let crop = layout.crop;
        check_crop(crop)?;
        check_shard_spec(*spec)?;
        let area = crop.width as usize * crop.height as usize;
        let of = || "the image".to_owned();
        check_length("pixels", of, pixels.len(), area)?;
        if !done_tiles.is_empty() {
            check_length("tiles of the pass", of, done_tiles.len(), tile_count(crop))?;
        }
        stage.validate(area)?;
        check_count("the pass", (*pass).into(), MAX_PASSES.into())?;
        // A pixel has at most the passes so far, and in a tile that has taken the current pass one more.
        for (number, tile) in tiles(crop).into_iter().enumerate() {
            let is_done = done_tiles.get(number).copied().unwrap_or(false);
            let (passes, samples) = if is_done { (pass + 1, u32::MAX) } else { (*pass, *taken) };
            let indices = tile.pixels().map(|at| crop.pixel_index(at));
            for (index, pixel) in indices.filter_map(|index| Some((index, pixels.get(index)?))) {
                pixel.validate(index, passes, samples)?;
            }
        }
        check_lost(lost, crop)?;
        statistics.validate()?;
        check_number("the time of a sample in seconds", *seconds_per_sample)?;
        error.validate(area as u64)
    }

    pub(crate) fn film(&self) -> Image {
        let Crop { width, height, .. } = self.layout.crop;
        let mut film = Image::new(width, height, self.layout.transparent);
        for (value, pixel) in film.pixels_mut().iter_mut().zip(&self.pixels) {
            *value = rounded(pixel.mean());
        }
        for (value, pixel) in film.alpha_mut().unwrap_or_default().iter_mut().zip(&self.pixels) {
            *value = rounded_coverage(pixel);
        }
        film
    }

    /// Current pixels of a tile.
    pub(crate) fn film_tile(&self, tile: Crop) -> FilmTile {
        let pixels = tile.pixels().filter_map(|at| self.pixels.get(self.layout.crop.pixel_index(at)));
        FilmTile::new(pixels, self.layout, self.layout.maps)
    }
}

impl PassMode {
    fn new(rule: Option<&StopRule>) -> Self {
        match rule {
            None => Self::Fixed,
            Some(StopRule { target: None, .. }) => Self::Growing,
            Some(StopRule { target: Some(target), max_spp, .. }) => Self::Target(*target, *max_spp),
        }
    }
}

/// Stage of adaptive sampling.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) enum RefineStage {
    /// Passes over all pixels.
    #[default]
    Everywhere,
    /// Passes over active pixels; flags row by row.
    Decide(Vec<bool>),
    /// Second stage with new samples. The fields are the passes of each pixel, and from the first stage the reason for its end
    /// and its number of unconverged pixels.
    Repeat(Vec<u32>, Stopped, u64),
}

impl RefineStage {
    /// Pass index that enters the seed.
    pub(crate) const fn seed_of(&self, pass: u32) -> u32 {
        match self {
            Self::Everywhere | Self::Decide(_) => pass,
            Self::Repeat(..) => SECOND_STAGE | pass,
        }
    }

    /// Checks that lists have one entry per pixel and that pass counts are within their limits.
    pub(crate) fn validate(&self, pixels: usize) -> Result<(), ContentError> {
        let of = || "the image".to_owned();
        match self {
            Self::Everywhere => Ok(()),
            Self::Decide(active) => check_length("active pixels", of, active.len(), pixels),
            Self::Repeat(decided, _, unconverged) => {
                check_length("passes to repeat", of, decided.len(), pixels)?;
                let max = decided.iter().copied().max().unwrap_or(0);
                check_count("passes to repeat", max.into(), MAX_PASSES.into())?;
                check_count("pixels that have not converged", *unconverged, pixels as u64)
            }
        }
    }
}
