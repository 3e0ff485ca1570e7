//! TileResult tiles: what a render makes, what is kept of it, and what machines share out among each other.
//!
//! ```text
//!   share 1 of 3:  ▓░░▓░░▓░░      share 2 of 3:  ░▓░░▓░░▓░      join:  every tile once, or which is missing or doubled
//! ```
//!
//! A tile is rendered whole by one machine, so that a picture of many parts has the bits of one.

use std::collections::{BTreeMap, BTreeSet};

use rt_image::Image;
use rt_math::Rgb;
use serde::{Deserialize, Deserializer, Serialize, de::Error as _};

use crate::{
    ContentError, Crop, RenderPlan, Rendering, RunOptions, SampleRange, Share, Statistics, Stopped,
    content::{check_count, check_crop, check_length, check_lost, check_share},
    error_estimate::ErrorSums,
    tile_job::TileResult,
    tiles::{Tile, tile, tile_count, tile_number},
};

/// Common header of all parts of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Frame {
    pub(crate) crop: Crop,
    pub(crate) transparent: bool,
    /// Passes whose differences tell the error.
    pub(crate) passes_differ: bool,
    /// Standard errors are kept.
    pub(crate) maps: bool,
    /// Nodes and tests are counted.
    pub(crate) count: bool,
}

impl Frame {
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

/// Pixels of a tile, rounded to `f32`, row by row.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct TilePixels {
    pub(crate) pixels: Vec<[f32; 3]>,
    /// Empty unless the picture is transparent.
    pub(crate) alpha: Vec<f32>,
    /// Empty after a single pass, and unless requested.
    pub(crate) standard_errors: Vec<[f32; 3]>,
    /// Samples of each pixel; empty if all have as many.
    pub(crate) counts: Vec<u32>,
    /// Samples of the pixel that has fewest, and of the one that has most.
    pub(crate) range: [u32; 2],
    /// Samples of all pixels.
    pub(crate) samples: u64,
    pub(crate) error: ErrorSums,
}

impl TilePixels {
    /// Rounds a tile whose pixels, if nothing else is said, have `samples_per_pixel`.
    pub(crate) fn new(finished: &TileResult, samples_per_pixel: u32, maps: bool) -> Self {
        let least = finished.counts.iter().copied().min().unwrap_or(samples_per_pixel);
        let most = finished.counts.iter().copied().max().unwrap_or(samples_per_pixel);
        let variances = if maps { &finished.variances[..] } else { &[] };
        Self {
            pixels: finished.pixels.iter().copied().map(rounded).collect(),
            alpha: finished.alpha.iter().map(|coverage| coverage.clamp(0.0, 1.0) as f32).collect(),
            standard_errors: variances.iter().map(|variance| rounded(variance.map(f64::sqrt))).collect(),
            counts: if least == most { Vec::new() } else { finished.counts.clone() },
            range: [least, most],
            samples: finished.samples,
            error: finished.error,
        }
    }

    /// Samples of each pixel, in all channels.
    fn counts_of_pixels(&self) -> Vec<[f32; 3]> {
        let same = if self.counts.is_empty() { self.pixels.len() } else { 0 };
        let counts = self.counts.iter().copied().chain(core::iter::repeat_n(self.range[0], same));
        counts.map(|count| [count as f32; 3]).collect()
    }

    /// Checks that each list has a value for each pixel, and that the sample counts agree. Radiance may be anything that a film
    /// may hold.
    fn validate(&self, number: u32, tile: Tile, frame: &Frame) -> Result<(), ContentError> {
        let area = tile.area() as usize;
        let check = |list, found, expected| check_length(list, || format!("tile {number}"), found, expected);
        let optional = |found: usize| if found == 0 { 0 } else { area };
        check("radiance", self.pixels.len(), area)?;
        check("coverage", self.alpha.len(), if frame.transparent { area } else { 0 })?;
        check("standard errors", self.standard_errors.len(), optional(self.standard_errors.len()))?;
        check("sample counts", self.counts.len(), optional(self.counts.len()))?;
        if let Some(&coverage) = self.alpha.iter().find(|coverage| !(0.0..=1.0).contains(*coverage)) {
            return Err(ContentError::Number { name: "a coverage", value: coverage.into() });
        }
        let [least, most] = self.range;
        let (found, sum) = match (self.counts.iter().min(), self.counts.iter().max()) {
            (Some(&min), Some(&max)) => ([min, max], self.counts.iter().copied().map(u64::from).sum()),
            _ => ([least; 2], u64::from(least) * area as u64),
        };
        if found != [least, most] || sum != self.samples {
            return Err(ContentError::Samples(number));
        }
        self.error.validate(area as u64)
    }
}

/// Some tiles of a picture, or all of them, finished; to be kept, joined with others, and made a picture of.
///
/// Whatever is deserialized has gone through [`validate`](Self::validate); [`UncheckedPart`] tells the reason of a refusal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(remote = "Self")]
pub struct Part {
    pub(crate) frame: Frame,
    pub(crate) share: Share,
    /// Those that are finished, by number.
    pub(crate) tiles: BTreeMap<u32, TilePixels>,
    pub(crate) statistics: Statistics,
    pub(crate) stopped: Stopped,
    pub(crate) unconverged: Option<u64>,
    /// Numbers of the tiles in which a worker failed.
    pub(crate) lost: Vec<u32>,
}

/// A part as it was decoded, of which no number has been checked.
#[derive(Debug)]
pub struct UncheckedPart(Part);

impl UncheckedPart {
    /// The part, once all of its numbers are checked.
    ///
    /// # Errors
    /// [`ContentError`] with the first number that cannot be right.
    pub fn check(self) -> Result<Part, ContentError> {
        self.0.validate()?;
        Ok(self.0)
    }
}

impl<'de> Deserialize<'de> for UncheckedPart {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        decode_unchecked(deserializer).map(Self)
    }
}

impl<'de> Deserialize<'de> for Part {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let part = decode_unchecked(deserializer)?;
        part.validate().map_err(D::Error::custom)?;
        Ok(part)
    }
}

impl Serialize for Part {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        // The function that serde derives, not this one.
        Part::serialize(self, serializer)
    }
}

/// A part of which no number has been checked.
pub(crate) fn decode_unchecked<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Part, D::Error> {
    // The function that serde derives, not that of the trait.
    Part::deserialize(deserializer)
}

/// Why parts do not make a picture.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum JoinError {
    /// There are no parts.
    #[error("there are no parts to join")]
    Nothing,
    /// A number of the part cannot be right, or is too large together with those of the parts before; with its place in the list,
    /// from 0 on.
    #[error("part number {}: {}", .0 + 1, .1)]
    Damaged(usize, ContentError),
    /// A part belongs to another picture; with its place in the list, from 0 on.
    #[error("part number {} is of another size, or was made with other options", .0 + 1)]
    Foreign(usize),
    /// A part was made of another number of shares than the first; with its place in the list, from 0 on.
    #[error("part number {} is one of {} shares, and the first is one of {}", .part + 1, .count, .expected)]
    Shares {
        /// Which.
        part: usize,
        /// Shares that it is one of.
        count: u32,
        /// Shares that the first is one of.
        expected: u32,
    },
    /// Two parts are the same share; with their places in the list, from 0 on.
    #[error("parts number {} and {} are the same share", .0 + 1, .1 + 1)]
    Doubled(usize, usize),
    /// The part lacks some of the tiles of its share: it was interrupted, or a worker failed.
    #[error("part number {} lacks {} of its tiles; finish it with --resume, or render it again", .part + 1, .missing)]
    Unfinished {
        /// Which.
        part: usize,
        /// Tiles that it lacks.
        missing: usize,
    },
    /// Shares are missing: their numbers, from 0 on.
    #[error("{}", missing(.0, *.1))]
    Missing(Vec<u32>, u32),
}

/// The shares that are missing, the first few by number.
fn missing(shares: &[u32], count: u32) -> String {
    const NAMED: usize = 20;
    let named: Vec<_> = shares.iter().take(NAMED).map(|share| format!("{}/{count}", share + 1)).collect();
    let more = shares.len().saturating_sub(NAMED);
    let and = if more > 0 { format!(", and {more} more") } else { String::new() };
    format!("{} of {count} shares missing: {}{and}", shares.len(), named.join(", "))
}

impl Part {
    /// A part of which nothing is finished.
    pub(crate) fn empty(frame: Frame, share: Share, statistics: Statistics) -> Self {
        Self {
            frame,
            share,
            tiles: BTreeMap::new(),
            statistics,
            stopped: Stopped::Interrupted,
            unconverged: None,
            lost: Vec::new(),
        }
    }

    /// The share of the picture that this is.
    pub const fn share(&self) -> Share {
        self.share
    }

    /// Bytes of the picture that [`into_rendering`](Self::into_rendering) makes: film, coverage, maps of errors and sample counts.
    pub fn rendering_bytes(&self) -> u64 {
        let Crop { width, height, .. } = self.frame.crop;
        let each = 12 + if self.frame.transparent { 4 } else { 0 } + if self.frame.maps { 24 } else { 0 };
        (u64::from(width) * u64::from(height)).saturating_mul(each)
    }

    /// Cause of the end of its render.
    pub const fn stopped(&self) -> Stopped {
        self.stopped
    }

    /// Tiles of its share that are not finished: some of them if a worker failed or the render was interrupted, and all if that
    /// happened between passes over all of them.
    pub fn missing_tiles(&self) -> usize {
        let all = self.share.pieces(tile_count(self.frame.crop));
        let lost: BTreeSet<_> = self.lost.iter().collect();
        let finished = self.tiles.keys().filter(|number| !lost.contains(number)).count();
        let is_between_passes = self.stopped == Stopped::Interrupted && finished == all;
        if is_between_passes { all } else { all.saturating_sub(finished) }
    }

    /// Checks every number that a file may have got wrong, so that nothing else needs to.
    ///
    /// # Errors
    /// [`ContentError`] with the first number that cannot be right.
    pub fn validate(&self) -> Result<(), ContentError> {
        let Self { frame, share, tiles, statistics, stopped: _, unconverged, lost } = self;
        let crop = frame.crop;
        check_crop(crop)?;
        check_share(*share)?;
        let mut samples = 0_u64;
        for (&number, pixels) in tiles {
            if !share.holds(number as usize) || number as usize >= tile_count(crop) {
                return Err(ContentError::Tile(number));
            }
            pixels.validate(number, tile(crop, number as usize), frame)?;
            samples = samples.saturating_add(pixels.samples);
        }
        check_lost(lost, crop)?;
        let mut known = BTreeSet::new();
        if let Some(&number) = lost.iter().find(|number| !known.insert(**number)) {
            return Err(ContentError::Repeated(number));
        }
        statistics.validate()?;
        // Samples that only decided how many to take are in the statistics alone.
        check_count("the number of samples of all tiles", samples, statistics.samples)?;
        let pixels = u64::from(crop.width) * u64::from(crop.height);
        check_count("the number of pixels that have not converged", unconverged.unwrap_or(0), pixels)
    }

    /// Joins all shares of a picture, in any order.
    ///
    /// # Errors
    /// [`JoinError`] says which part is missing, doubled, unfinished, or of another picture. Whether parts are of the same
    /// scene is for the caller to know.
    pub fn join(parts: Vec<Self>) -> Result<Self, JoinError> {
        let (frame, count) = parts.first().map(|first| (first.frame, first.share.count())).ok_or(JoinError::Nothing)?;
        let mut holder = BTreeMap::new();
        for (number, part) in parts.iter().enumerate() {
            part.validate().map_err(|error| JoinError::Damaged(number, error))?;
            if part.frame != frame {
                return Err(JoinError::Foreign(number));
            }
            if part.share.count() != count {
                return Err(JoinError::Shares { part: number, count: part.share.count(), expected: count });
            }
            if let Some(other) = holder.insert(part.share.index(), number) {
                return Err(JoinError::Doubled(other, number));
            }
            match part.missing_tiles() {
                0 => {}
                missing => return Err(JoinError::Unfinished { part: number, missing }),
            }
        }
        if holder.len() < count as usize {
            return Err(JoinError::Missing((0..count).filter(|share| !holder.contains_key(share)).collect(), count));
        }
        let mut parts = parts.into_iter().enumerate();
        let (_, mut joined) = parts.next().ok_or(JoinError::Nothing)?;
        for (number, part) in parts {
            joined.tiles.extend(part.tiles);
            // No sum of two checked counts overflows, and the result is checked before the next is added.
            joined.statistics.join(&part.statistics);
            joined.statistics.validate().map_err(|error| JoinError::Damaged(number, error))?;
            joined.lost.extend(part.lost);
        }
        joined.share = Share::ALL;
        Ok(joined)
    }

    /// The pixels of a tile, if it is finished.
    pub(crate) fn tile(&self, tile: Tile) -> Option<&TilePixels> {
        self.tiles.get(&(tile_number(self.frame.crop, tile) as u32))
    }

    /// The picture so far; black where no tile is finished.
    pub(crate) fn film(&self) -> Image {
        let Crop { width, height, .. } = self.frame.crop;
        let mut film = Image::new(width, height, self.frame.transparent);
        for (&number, finished) in &self.tiles {
            self.place(number, &finished.pixels, film.pixels_mut());
            if let Some(alpha) = film.alpha_mut() {
                self.place(number, &finished.alpha, alpha);
            }
        }
        film
    }

    /// The picture that the part makes, and what there is to say of it; black where no tile is finished.
    pub fn into_rendering(mut self) -> Rendering {
        let Crop { width, height, .. } = self.frame.crop;
        let finished = || self.tiles.values();
        let least = finished().map(|tile| tile.range[0]).min().unwrap_or(0);
        let most = finished().map(|tile| tile.range[1]).max().unwrap_or(0);
        let pixels = finished().map(|tile| tile.pixels.len()).sum::<usize>();
        let mean = finished().map(|tile| tile.samples).sum::<u64>() as f64 / pixels.max(1) as f64;
        let error = ErrorSums::joined(finished().map(|tile| tile.error)).estimate();
        let mut film = Image::new(width, height, self.frame.transparent);
        let constant = |value: f32| {
            let mut film = Image::new(width, height, false);
            film.pixels_mut().fill([value; 3]);
            film
        };
        let mut maps = self.frame.maps.then(|| (constant(f32::INFINITY), constant(0.0)));
        // From the last on, each tile gives its memory back when it is copied, so that the picture is not there twice.
        while let Some((number, finished)) = self.tiles.pop_last() {
            self.place(number, &finished.pixels, film.pixels_mut());
            if let Some(alpha) = film.alpha_mut() {
                self.place(number, &finished.alpha, alpha);
            }
            if let Some((errors, counts)) = &mut maps {
                self.place(number, &finished.standard_errors, errors.pixels_mut());
                self.place(number, &finished.counts_of_pixels(), counts.pixels_mut());
            }
        }
        let (standard_error, sample_counts) = maps.unzip();
        Rendering {
            film,
            statistics: self.statistics,
            stopped: self.stopped,
            error: error.filter(|_| self.frame.passes_differ),
            samples_per_pixel: SampleRange { least, mean, most },
            unconverged: self.unconverged,
            standard_error,
            sample_counts,
            lost: self.lost.iter().map(|&number| tile(self.frame.crop, number as usize).into()).collect(),
        }
    }

    /// Copies values of the pixels of a tile, if there are any, into the image.
    fn place<T: Copy>(&self, number: u32, values: &[T], image: &mut [T]) {
        let crop = self.frame.crop;
        for ([x, y], &value) in tile(crop, number as usize).pixels().zip(values) {
            image[(y - crop.y) as usize * crop.width as usize + (x - crop.x) as usize] = value;
        }
    }
}

/// Rounds radiance to the precision of an image.
pub(crate) fn rounded(value: Rgb) -> [f32; 3] {
    value.to_array().map(|component| component as f32)
}
