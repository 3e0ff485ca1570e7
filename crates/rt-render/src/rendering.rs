//! Options, progress and result of a render.

use std::sync::atomic::AtomicBool;

use rt_image::Image;

use crate::{Crop, ErrorEstimate, Share, Statistics, Stopped};

/// How to run a plan; none of it changes what a pixel shows.
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
    /// May be set at any time, by a signal or another thread: the tiles that are being rendered are finished, no other is begun,
    /// and the render ends as [`Stopped::Interrupted`].
    pub interrupt: Option<&'a AtomicBool>,
}

/// How far a render has come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Camera samples taken.
    pub samples: u64,
    /// Camera samples in all; a guess where time, error or edges decide.
    pub total_samples: u64,
    /// Rays traced so far, of all kinds.
    pub rays: u64,
    /// Where a progressive render stands.
    pub pass: Option<PassProgress>,
}

/// Where a progressive render stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PassProgress {
    /// Passes finished.
    pub finished: u32,
    /// Samples of the pixel that has most.
    pub spp: u32,
    /// Estimated root mean square error of the picture so far, from two passes on.
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
    /// The picture, in linear radiance.
    pub film: Image,
    /// What it took.
    pub statistics: Statistics,
    /// What ended it.
    pub stopped: Stopped,
    /// How far it is from the truth; `None` if there was but one pass, or all are the same.
    pub error: Option<ErrorEstimate>,
    /// Samples that the pixels of the picture are made of.
    pub samples_per_pixel: SampleRange,
    /// Pixels that have not reached the error, where each has to ([`Criterion::Pixels`](crate::Criterion)).
    pub unconverged: Option<u64>,
    /// With [`RunOptions::maps`], the standard error of each pixel, by channel; infinite after one pass.
    pub standard_error: Option<Image>,
    /// With [`RunOptions::maps`], the samples of each pixel, in all channels.
    pub sample_counts: Option<Image>,
    /// What a worker has failed at, by a defect of this program: these tiles lack some of their samples, or are black.
    pub lost: Vec<Crop>,
}

/// Samples of the pixels of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleRange {
    /// Of the pixel that has fewest.
    pub least: u32,
    /// Of all pixels.
    pub mean: f64,
    /// Of the pixel that has most.
    pub most: u32,
}
