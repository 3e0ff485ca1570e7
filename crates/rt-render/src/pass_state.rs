//! State of a render pass by pass: all that it needs to go on.

use rt_image::Image;
use serde::{Deserialize, Serialize};

use crate::{
    ContentError, Crop, Share, Statistics, StopRule, Stopped, TargetError,
    content::{MAX_PASSES, check_count, check_crop, check_length, check_lost, check_number, check_share},
    error_estimate::ErrorSums,
    estimate::PixelEstimate,
    part::{Frame, TilePixels, rounded},
    tiles::{Tile, tile_count, tiles},
};

/// First pass number of the second stage, whose samples decide nothing.
const SECOND_STAGE: u32 = 1 << 31;

/// Pixels and position of a render pass by pass.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct PassState {
    pub(crate) frame: Frame,
    share: Share,
    mode: PassMode,
    /// All pixels, row by row.
    pub(crate) pixels: Vec<PixelEstimate>,
    pub(crate) statistics: Statistics,
    pub(crate) cursor: PassCursor,
    /// Wall-clock seconds per sample of the last pass.
    pub(crate) seconds_per_sample: f64,
    /// Error of the image after the last pass.
    pub(crate) error: ErrorSums,
    /// Numbers of the tiles in which a thread failed.
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
    /// Number of the current or next pass.
    pub(crate) pass: u32,
    /// Samples of a pixel that took all previous passes.
    pub(crate) taken: u32,
    /// Flags of the tiles that have taken the current pass; empty before the first one.
    pub(crate) begun: Vec<bool>,
    pub(crate) stage: RefineStage,
}

impl PassState {
    /// State before the first pass.
    pub(crate) fn new(frame: Frame, share: Share, rule: Option<&StopRule>, statistics: Statistics) -> Self {
        let Crop { width, height, .. } = frame.crop;
        Self {
            frame,
            share,
            mode: PassMode::new(rule),
            pixels: vec![PixelEstimate::default(); width as usize * height as usize],
            statistics,
            cursor: PassCursor::default(),
            seconds_per_sample: 0.0,
            error: ErrorSums::default(),
            lost: Vec::new(),
        }
    }

    /// True if a render of this kind can go on from here.
    pub(crate) fn fits(&self, frame: Frame, share: Share, rule: Option<&StopRule>) -> bool {
        self.frame == frame && self.share == share && self.mode == PassMode::new(rule)
    }

    /// Checks all numbers of a decoded state.
    pub(crate) fn validate(&self) -> Result<(), ContentError> {
        let Self { frame, share, mode: _, pixels, statistics, cursor, seconds_per_sample, error, lost } = self;
        let PassCursor { pass, taken, begun, stage } = cursor;
        let crop = frame.crop;
        check_crop(crop)?;
        check_share(*share)?;
        let area = crop.width as usize * crop.height as usize;
        let of = || "the picture".to_owned();
        check_length("pixels", of, pixels.len(), area)?;
        if !begun.is_empty() {
            check_length("tiles of the pass", of, begun.len(), tile_count(crop))?;
        }
        stage.validate(area)?;
        check_count("the number of the pass", (*pass).into(), MAX_PASSES.into())?;
        // A pixel has taken the passes so far, or fewer, and in a tile that has begun the next one perhaps that as well.
        for (number, tile) in tiles(crop).into_iter().enumerate() {
            let has_begun = begun.get(number).copied().unwrap_or(false);
            let (passes, samples) = if has_begun { (pass + 1, u32::MAX) } else { (*pass, *taken) };
            let indices = tile.pixels().map(|at| pixel_index(crop, at));
            for (index, pixel) in indices.filter_map(|index| Some((index, pixels.get(index)?))) {
                pixel.validate(index, passes, samples)?;
            }
        }
        check_lost(lost, crop)?;
        statistics.validate()?;
        check_number("the time of a sample in seconds", *seconds_per_sample)?;
        error.validate(area as u64)
    }

    /// Current image.
    pub(crate) fn film(&self) -> Image {
        let Crop { width, height, .. } = self.frame.crop;
        let mut film = Image::new(width, height, self.frame.transparent);
        for (cursor, pixel) in film.pixels_mut().iter_mut().zip(&self.pixels) {
            *cursor = rounded(pixel.mean());
        }
        for (cursor, pixel) in film.alpha_mut().unwrap_or_default().iter_mut().zip(&self.pixels) {
            *cursor = rounded_coverage(pixel);
        }
        film
    }

    /// Current pixels of a tile.
    pub(crate) fn tile_pixels(&self, tile: Tile) -> TilePixels {
        let Frame { crop, transparent, maps, .. } = self.frame;
        let pixels = || tile.pixels().filter_map(move |at| self.pixels.get(pixel_index(crop, at)));
        let counts: Vec<_> = pixels().map(PixelEstimate::samples).collect();
        let range = [counts.iter().copied().min(), counts.iter().copied().max()].map(Option::unwrap_or_default);
        let standard_error = |pixel: &PixelEstimate| match pixel.variance() {
            Some(variance) => rounded(variance.map(f64::sqrt)),
            None => [f32::INFINITY; 3],
        };
        let mut error = ErrorSums::default();
        pixels().for_each(|pixel| error.add(pixel));
        TilePixels {
            pixels: pixels().map(|pixel| rounded(pixel.mean())).collect(),
            alpha: pixels().filter(|_| transparent).map(rounded_coverage).collect(),
            standard_errors: pixels().filter(|_| maps).map(standard_error).collect(),
            samples: counts.iter().copied().map(u64::from).sum(),
            counts: if range[0] == range[1] { Vec::new() } else { counts },
            range,
            error,
        }
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

/// Stage of adaptive sampling: samples that decide, or samples of the image.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) enum RefineStage {
    /// Passes over all pixels.
    #[default]
    Everywhere,
    /// Passes over active pixels; flags row by row.
    Decide(Vec<bool>),
    /// New samples: the decided number of passes of each pixel, the cause of the decision's end, and the number of unconverged pixels.
    Repeat(Vec<u32>, Stopped, u64),
}

impl RefineStage {
    /// Seed number of a pass.
    pub(crate) const fn seed_of(&self, pass: u32) -> u32 {
        match self {
            Self::Everywhere | Self::Decide(_) => pass,
            Self::Repeat(..) => SECOND_STAGE | pass,
        }
    }

    /// Checks that there is an entry for each of so many pixels, and that no count of passes is beyond all limits.
    pub(crate) fn validate(&self, pixels: usize) -> Result<(), ContentError> {
        let of = || "the picture".to_owned();
        match self {
            Self::Everywhere => Ok(()),
            Self::Decide(active) => check_length("active pixels", of, active.len(), pixels),
            Self::Repeat(decided, _, unconverged) => {
                check_length("passes to repeat", of, decided.len(), pixels)?;
                let most = decided.iter().copied().max().unwrap_or(0);
                check_count("the number of passes to repeat", most.into(), MAX_PASSES.into())?;
                check_count("the number of pixels that have not converged", *unconverged, pixels as u64)
            }
        }
    }
}

/// Index of a pixel of the image in a crop.
pub(crate) const fn pixel_index(crop: Crop, [x, y]: [u32; 2]) -> usize {
    (y - crop.y) as usize * crop.width as usize + (x - crop.x) as usize
}

fn rounded_coverage(pixel: &PixelEstimate) -> f32 {
    pixel.coverage().clamp(0.0, 1.0) as f32
}
