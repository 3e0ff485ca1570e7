//! Shards of an image, which several machines render.
//!
//! ```text
//!   shard 1 of 3:  ▓░░▓░░▓░░      shard 2 of 3:  ░▓░░▓░░▓░      shard 3 of 3:  ░░▓░░▓░░▓
//! ```
//!
//! One machine renders all samples of a tile. The merged image is bit-identical to that of a single machine.

use std::collections::{BTreeMap, BTreeSet};

use rt_image::Image;
use serde::{Deserialize, Deserializer, Serialize, de::Error as _};

use crate::{
    ContentError, Crop, Rendering, SampleRange, ShardSpec, Statistics, Stopped,
    content_checks::{check_count, check_crop, check_lost, check_shard_spec},
    error_estimate::ErrorSums,
    film::film_tile::{FilmLayout, FilmTile},
    first_hit_layers::FilmLayers,
    tile::{tile, tile_count, tile_number},
};

/// Film of a shard of an image, with its statistics. Shards are written to files and merged to the whole image.
///
/// Deserialisation runs [`validate`](Self::validate); [`UncheckedShard`] reports the reason of an error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(remote = "Self")]
pub struct Shard {
    pub(crate) layout: FilmLayout,
    pub(crate) spec: ShardSpec,
    /// Finished tiles by index.
    pub(crate) tiles: BTreeMap<u32, FilmTile>,
    pub(crate) statistics: Statistics,
    pub(crate) stopped: Stopped,
    pub(crate) unconverged: Option<u64>,
    /// Indices of the tiles in which a thread panicked.
    pub(crate) lost: Vec<u32>,
    /// Requested layers of the tiles that this run has rendered.
    #[serde(skip)]
    pub(crate) layers: Option<FilmLayers>,
}

/// Decoded shard, not yet validated.
#[derive(Debug)]
pub struct UncheckedShard(Shard);

impl UncheckedShard {
    /// Validates the shard.
    ///
    /// # Errors
    /// [`ContentError`] for the first invalid number.
    pub fn check(self) -> Result<Shard, ContentError> {
        self.0.validate()?;
        Ok(self.0)
    }
}

impl<'de> Deserialize<'de> for UncheckedShard {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        decode_unchecked(deserializer).map(Self)
    }
}

impl<'de> Deserialize<'de> for Shard {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let shard = decode_unchecked(deserializer)?;
        shard.validate().map_err(D::Error::custom)?;
        Ok(shard)
    }
}

impl Serialize for Shard {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        // Calls the inherent function that serde derives, not this one.
        Shard::serialize(self, serializer)
    }
}

/// Decodes a shard without validation.
pub(crate) fn decode_unchecked<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Shard, D::Error> {
    // Calls the inherent function that serde derives, not the method of the trait.
    Shard::deserialize(deserializer)
}

/// Reason that shards cannot be merged.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MergeError {
    /// There are no shards.
    #[error("no shards are given; give at least one")]
    Nothing,
    /// A number of the shard is invalid, or its sum with the shards before it; with the index in the list.
    #[error("shard number {}: {}", .0 + 1, .1)]
    Damaged(usize, ContentError),
    /// A shard has another layout than the first; with its index in the list.
    #[error("shard number {} is of another size, or was made with other options; render all shards with the same options", .0 + 1)]
    Foreign(usize),
    /// A shard belongs to another number of shards than the first.
    #[error("shard number {} is one of {} shards, but the first is one of {}; merge shards of one render", .shard + 1, .count, .expected)]
    ShardCounts {
        /// Index in the list.
        shard: usize,
        /// Its number of shards.
        count: u32,
        /// Number of shards of the first shard.
        expected: u32,
    },
    /// Two are the same shard; with their indices in the list.
    #[error("shards number {} and {} are the same shard; remove one of them", .0 + 1, .1 + 1)]
    Doubled(usize, usize),
    /// It lacks tiles: it was interrupted, or a thread panicked.
    #[error("shard number {} lacks {} of its tiles; finish it with --resume, or render it again", .shard + 1, .missing)]
    Unfinished {
        /// Index in the list.
        shard: usize,
        /// Number of missing tiles.
        missing: usize,
    },
    /// Shards are missing; with their indices and the number of shards.
    #[error("{}", missing(.0, *.1))]
    Missing(Vec<u32>, u32),
}

/// Lists missing shards, the first 20 by index.
fn missing(specs: &[u32], count: u32) -> String {
    const NAMED: usize = 20;
    let named: Vec<_> = specs.iter().take(NAMED).map(|spec| format!("{}/{count}", spec + 1)).collect();
    let more = specs.len().saturating_sub(NAMED);
    let and = if more > 0 { format!(", and {more} more") } else { String::new() };
    format!("{} of {count} shards are missing: {}{and}; render them", specs.len(), named.join(", "))
}

impl Shard {
    /// True if a render of this layout and choice of tiles can resume from here.
    pub(crate) fn fits(&self, layout: FilmLayout, spec: ShardSpec) -> bool {
        self.layout == layout && self.spec == spec
    }

    /// Shard without finished tiles.
    pub(crate) fn empty(layout: FilmLayout, spec: ShardSpec, statistics: Statistics) -> Self {
        Self {
            layout,
            spec,
            tiles: BTreeMap::new(),
            statistics,
            stopped: Stopped::Interrupted,
            unconverged: None,
            lost: Vec::new(),
            layers: None,
        }
    }

    /// Index of the shard, and number of shards.
    pub const fn spec(&self) -> ShardSpec {
        self.spec
    }

    /// Bytes of the images of [`into_rendering`](Self::into_rendering): radiance, alpha, standard errors and sample counts.
    pub fn rendering_bytes(&self) -> u64 {
        let Crop { width, height, .. } = self.layout.crop;
        let bytes_per_pixel = 12 + if self.layout.transparent { 4 } else { 0 } + if self.layout.maps { 24 } else { 0 };
        (u64::from(width) * u64::from(height)).saturating_mul(bytes_per_pixel)
    }

    /// Cause of the end of its render.
    pub const fn stopped(&self) -> Stopped {
        self.stopped
    }

    /// Number of unfinished tiles of the shard: those not rendered before an interruption, and those in which a thread panicked.
    /// After an interruption between passes over the image, no tile counts as finished.
    pub fn missing_tiles(&self) -> usize {
        let all = self.spec.tile_count(tile_count(self.layout.crop));
        let lost: BTreeSet<_> = self.lost.iter().collect();
        let finished = self.tiles.keys().filter(|number| !lost.contains(number)).count();
        let is_between_passes = self.stopped == Stopped::Interrupted && finished == all;
        if is_between_passes { all } else { all.saturating_sub(finished) }
    }

    /// Checks all numbers that a decoded file can have wrong. All other functions rely on them.
    ///
    /// # Errors
    /// [`ContentError`] for the first invalid number.
    pub fn validate(&self) -> Result<(), ContentError> {
        let Self { layout, spec, tiles, statistics, stopped: _, unconverged, lost, layers: _ } = self;
        let crop = layout.crop;
        check_crop(crop)?;
        check_shard_spec(*spec)?;
        let mut samples = 0_u64;
        for (&number, pixels) in tiles {
            if !spec.holds(number as usize) || number as usize >= tile_count(crop) {
                return Err(ContentError::Tile(number));
            }
            pixels.validate(number, tile(crop, number as usize), layout)?;
            samples = samples.saturating_add(pixels.samples);
        }
        check_lost(lost, crop)?;
        let mut known = BTreeSet::new();
        if let Some(&number) = lost.iter().find(|number| !known.insert(**number)) {
            return Err(ContentError::Repeated(number));
        }
        statistics.validate()?;
        // The statistics also count the samples of the first stage of adaptive sampling, which are discarded.
        check_count("samples of all tiles", samples, statistics.samples)?;
        let pixels = u64::from(crop.width) * u64::from(crop.height);
        check_count("pixels that have not converged", unconverged.unwrap_or(0), pixels)
    }

    /// Merges all shards of an image, in any order. The caller must ensure that all shards show the same scene.
    ///
    /// # Errors
    /// [`MergeError`] names the shard that is missing, duplicated, unfinished, or of another image.
    pub fn merge(shards: Vec<Self>) -> Result<Self, MergeError> {
        let (layout, count) =
            shards.first().map(|first| (first.layout, first.spec.count())).ok_or(MergeError::Nothing)?;
        let mut shard_of_spec = BTreeMap::new();
        for (number, shard) in shards.iter().enumerate() {
            shard.validate().map_err(|error| MergeError::Damaged(number, error))?;
            if shard.layout != layout {
                return Err(MergeError::Foreign(number));
            }
            if shard.spec.count() != count {
                return Err(MergeError::ShardCounts { shard: number, count: shard.spec.count(), expected: count });
            }
            if let Some(other) = shard_of_spec.insert(shard.spec.index(), number) {
                return Err(MergeError::Doubled(other, number));
            }
            match shard.missing_tiles() {
                0 => {}
                missing => return Err(MergeError::Unfinished { shard: number, missing }),
            }
        }
        if shard_of_spec.len() < count as usize {
            return Err(MergeError::Missing(
                (0..count).filter(|spec| !shard_of_spec.contains_key(spec)).collect(),
                count,
            ));
        }
        let mut shards = shards.into_iter().enumerate();
        let (_, mut merged) = shards.next().ok_or(MergeError::Nothing)?;
        for (number, shard) in shards {
            merged.tiles.extend(shard.tiles);
            // The sum of two valid counts does not overflow. It is validated before the next one is added.
            merged.statistics.join(&shard.statistics);
            merged.statistics.validate().map_err(|error| MergeError::Damaged(number, error))?;
            merged.lost.extend(shard.lost);
        }
        merged.spec = ShardSpec::ALL;
        Ok(merged)
    }

    /// Film tile, if it is finished.
    pub(crate) fn tile(&self, tile: Crop) -> Option<&FilmTile> {
        self.tiles.get(&(tile_number(self.layout.crop, tile) as u32))
    }

    /// Current image; unfinished tiles are black.
    pub(crate) fn film(&self) -> Image {
        let Crop { width, height, .. } = self.layout.crop;
        let mut film = Image::new(width, height, self.layout.transparent);
        self.tiles.iter().for_each(|(&number, finished)| self.draw(number, finished, &mut film));
        film
    }

    /// Image, statistics and error estimate of the shard; unfinished tiles are black. After an interruption, layers leave them out.
    pub fn into_rendering(mut self) -> Rendering {
        let Crop { width, height, .. } = self.layout.crop;
        let finished = || self.tiles.values();
        let min = finished().map(|tile| tile.range[0]).min().unwrap_or(0);
        let max = finished().map(|tile| tile.range[1]).max().unwrap_or(0);
        let pixels = finished().map(|tile| tile.pixels.len()).sum::<usize>();
        let mean = finished().map(|tile| tile.samples).sum::<u64>() as f64 / pixels.max(1) as f64;
        let error = ErrorSums::merged(finished().map(|tile| tile.error)).estimate();
        let mut film = Image::new(width, height, self.layout.transparent);
        if let (Some(layers), Stopped::Interrupted) = (&mut self.layers, self.stopped) {
            layers.leave_out(|number| !self.tiles.contains_key(&(number as u32)));
        }
        let constant = |value: f32| {
            let mut map = Image::new(width, height, false);
            map.pixels_mut().fill([value; 3]);
            map
        };
        let mut maps = self.layout.maps.then(|| (constant(f32::INFINITY), constant(0.0)));
        // Free each tile after copying it: film tiles and image together then take little more memory than one of them.
        while let Some((number, finished)) = self.tiles.pop_last() {
            self.draw(number, &finished, &mut film);
            if let Some((errors, counts)) = &mut maps {
                self.copy_tile(number, &finished.standard_errors, errors.pixels_mut());
                self.copy_tile(number, &finished.counts_of_pixels(), counts.pixels_mut());
            }
        }
        let (standard_error, sample_counts) = maps.unzip();
        Rendering {
            film,
            statistics: self.statistics,
            stopped: self.stopped,
            error: error.filter(|_| self.layout.passes_differ),
            samples_per_pixel: SampleRange { min, mean, max },
            unconverged: self.unconverged,
            standard_error,
            sample_counts,
            layers: self.layers,
            lost: self.lost.iter().map(|&number| tile(self.layout.crop, number as usize)).collect(),
        }
    }

    /// Copies the radiance and coverage of a tile into the image.
    fn draw(&self, number: u32, finished: &FilmTile, film: &mut Image) {
        self.copy_tile(number, &finished.pixels, film.pixels_mut());
        self.copy_tile(number, &finished.alpha, film.alpha_mut().unwrap_or_default());
    }

    /// Copies the values of a tile into the image. An empty list changes no pixel.
    fn copy_tile<T: Copy>(&self, number: u32, values: &[T], image: &mut [T]) {
        let crop = self.layout.crop;
        for (at, &value) in tile(crop, number as usize).pixels().zip(values) {
            image[crop.pixel_index(at)] = value;
        }
    }
}
