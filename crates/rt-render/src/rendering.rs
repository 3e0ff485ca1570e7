//! Options, progress and result of a render.

use std::sync::atomic::AtomicBool;

use rt_image::Image;

use crate::{Crop, ErrorEstimate, Share, Statistics, Stopped};

/// Options of a run; none changes a pixel.
#[derive(Clone, Copy, Debug, Default)]
pub struct RunOptions<'a> {
    /// Number of threads; 0 for one per processor.
    pub threads: usize,
    /// Count nodes, primitive tests and hits as well as rays.
    pub count: bool,
    /// Keep the standard error of each pixel and the number of its samples.
    pub maps: bool,
    /// The tiles to render.
    pub share: Share,
    /// May be set at any time, by a signal or another thread: tiles in work are finished, no other is started,
    /// and the render ends as [`Stopped::Interrupted`].
    pub interrupt: Option<&'a AtomicBool>,
}

/// Progress of a render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Camera samples taken.
    pub samples: u64,
    /// Total camera samples; an estimate if time, error or edges decide.
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
    /// Samples of the pixel that has most.
    pub spp: u32,
    /// Estimated root mean square error of the current image, from two passes on.
    pub rmse: Option<f64>,
    /// Distance from the target error, if there is one and an estimate is known.
    pub towards: Option<Towards>,
}

/// Estimated and wanted error of a render that ends by its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Towards {
    /// Relative root mean square error of the image.
    Image {
        /// Current estimate.
        error: f64,
        /// Error at which the render ends.
        target: f64,
    },
    /// Share of the pixels that have reached their error.
    Pixels {
        /// Current share.
        share: f64,
        /// Share at which the render ends.
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
    /// Cause of its end.
    pub stopped: Stopped,
    /// Estimated error; `None` after a single pass, or if all passes are equal.
    pub error: Option<ErrorEstimate>,
    /// Samples per pixel.
    pub samples_per_pixel: SampleRange,
    /// Pixels that have not reached the error, where each has to ([`Criterion::Pixels`](crate::Criterion)).
    pub unconverged: Option<u64>,
    /// With [`RunOptions::maps`], the standard error of each pixel, by channel; infinite after one pass.
    pub standard_error: Option<Image>,
    /// With [`RunOptions::maps`], the samples of each pixel, in all channels.
    pub sample_counts: Option<Image>,
    /// Tiles in which a thread failed, by a defect of this program: they lack samples or are black.
    pub lost: Vec<Crop>,
}

/// Range of samples per pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleRange {
    /// Smallest number of samples of a pixel.
    pub least: u32,
    /// Mean over all pixels.
    pub mean: f64,
    /// Largest number of samples of a pixel.
    pub most: u32,
}
