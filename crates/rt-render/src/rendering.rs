//! Options, progress and result of a render.

use std::sync::atomic::AtomicBool;

use rt_image::Image;

use crate::{Crop, ErrorEstimate, FilmLayers, FirstHitLayer, ShardSpec, Statistics, Stopped};

/// Options of a run; none changes a pixel.
#[derive(Clone, Copy, Debug, Default)]
pub struct RunOptions<'a> {
    /// Number of threads; 0 for one per processor.
    pub threads: usize,
    /// Count nodes, primitive tests and hits, not only rays.
    pub count: bool,
    /// Keep the standard error and the sample count of each pixel.
    pub maps: bool,
    /// Tiles to render.
    pub shard: ShardSpec,
    /// Flag that interrupts the render; a signal handler or another thread may set it at any time. Tiles in progress are
    /// finished, and the render ends as [`Stopped::Interrupted`].
    pub interrupt: Option<&'a AtomicBool>,
    /// Layers to compute with the image.
    pub layers: &'a [FirstHitLayer],
}

/// Progress of a render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Camera samples taken.
    pub samples: u64,
    /// Total camera samples; an estimate with a stop rule or adaptive sampling.
    pub total_samples: u64,
    /// Rays traced so far, of all kinds.
    pub rays: u64,
    /// Progress of a progressive render.
    pub pass: Option<PassProgress>,
}

/// Progress of a progressive render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PassProgress {
    /// Passes finished.
    pub finished: u32,
    /// Samples of the current pass that are still to be taken. A pass is always finished.
    pub samples_left: u64,
    /// Maximum number of samples of a pixel.
    pub spp: u32,
    /// Estimated root mean square error of the current image, from two passes on.
    pub rmse: Option<f64>,
    /// Estimated and target error, if both are known.
    pub error_progress: Option<ErrorProgress>,
}

/// Estimated and target error of a render with a target error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ErrorProgress {
    /// Relative root mean square error of the image.
    Image {
        /// Current estimate.
        error: f64,
        /// Error at which the render ends.
        target: f64,
    },
    /// Fraction of converged pixels.
    Pixels {
        /// Current fraction.
        share: f64,
        /// Fraction at which the render ends.
        target: f64,
    },
}

/// A finished render.
#[derive(Clone, Debug)]
pub struct Rendering {
    /// Image in linear radiance.
    pub film: Image,
    /// Counts and times.
    pub statistics: Statistics,
    /// Reason for its end.
    pub stopped: Stopped,
    /// Estimated error; `None` after a single pass, or if all passes are equal.
    pub error: Option<ErrorEstimate>,
    /// Samples per pixel.
    pub samples_per_pixel: SampleRange,
    /// Number of unconverged pixels, with [`Criterion::Pixels`](crate::Criterion).
    pub unconverged: Option<u64>,
    /// Standard error of each pixel, by channel, with [`RunOptions::maps`]; infinite after one pass.
    pub standard_error: Option<Image>,
    /// Number of samples of each pixel, in all channels, with [`RunOptions::maps`].
    pub sample_counts: Option<Image>,
    /// Layers of [`RunOptions::layers`], if any; [`complete_layers`](crate::RenderPlan::complete_layers) computes missing values.
    pub layers: Option<FilmLayers>,
    /// Tiles in which a thread panicked, by a defect of this program: they lack samples or are black.
    pub lost: Vec<Crop>,
}

/// Range of samples per pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleRange {
    /// Smallest number of samples of a pixel.
    pub min: u32,
    /// Mean over all pixels.
    pub mean: f64,
    /// Largest number of samples of a pixel.
    pub max: u32,
}
