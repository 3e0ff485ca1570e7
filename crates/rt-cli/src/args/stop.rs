//! When a render has enough, and what is told of its pixels.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use rt_render::{Criterion, StopRule, TargetError};

use super::values;

/// What ends a render other than a fixed number of samples.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "How much")]
pub(crate) struct StopArgs {
    /// Render pass after pass for as long as this: 10s, 1.5min, 2h
    ///
    /// A pass begins only if it can be expected to be over in time. Loading and writing are not counted.
    #[arg(long, value_name = "TIME", value_parser = values::time, conflicts_with = "passes", allow_hyphen_values = true)]
    pub(crate) time: Option<Duration>,

    /// Render until the relative error of the image is at most this, such as 1%, or at 4096 samples per pixel (--spp)
    ///
    /// The error is the relative root mean square error, estimated from the differences of independent passes:
    ///
    ///   sqrt(mean of v) / (mean of m)
    ///
    /// m is the radiance of a pixel in a channel, v the variance of its mean, and both means are over all pixels and channels. All
    /// pixels take the same number of samples, and the error is tested after each pass, from 16 samples on. The result has a 95 %
    /// interval. Images of fewer than 1024 pixels are made of new samples, as with --two-stage.
    #[arg(long, value_name = "PERCENT", value_parser = values::percentage, conflicts_with = "passes", allow_hyphen_values = true)]
    pub(crate) target_error: Option<f64>,

    /// Require --target-error of this share of the pixels, such as 99%, each by itself, rather than of the image
    ///
    /// A pixel has to be within the error of its radiance plus 0.01 with a confidence of 95 %, in each channel, and is tested at
    /// 64, 128, 256, ... samples. Pixels that have reached it take no more samples, which biases them, noisy ones by some
    /// per cent of their radiance; --two-stage removes the bias.
    #[arg(long, value_name = "PERCENT", value_parser = values::share_of_pixels, requires = "target_error", allow_hyphen_values = true)]
    pub(crate) target_error_pixels: Option<f64>,

    /// Make the picture of new samples, as many as --target-error needed
    ///
    /// Samples that decide when there is enough are biased by the decision, if little. This takes twice the time and is not.
    #[arg(long, requires = "target_error")]
    pub(crate) two_stage: bool,
}

impl StopArgs {
    /// The rule, if there is one, with the most samples of a pixel.
    pub(crate) fn rule(&self, spp: Option<u32>) -> Option<StopRule> {
        let criterion = self.target_error_pixels.map_or(Criterion::Image, |share| Criterion::Pixels { share });
        let two_stage = self.two_stage;
        let target = self.target_error.map(|relative| TargetError { relative, criterion, two_stage });
        let cap = if target.is_some() { StopRule::DEFAULT_MAX_SPP_OF_TARGET } else { StopRule::DEFAULT_MAX_SPP };
        let max_spp = spp.unwrap_or(cap);
        (self.time.is_some() || target.is_some()).then_some(StopRule { time: self.time, target, max_spp })
    }
}

/// What can be told of a pixel beside its radiance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Aov {
    /// Standard error of each channel.
    Variance,
    /// Samples taken.
    Samples,
}

impl Aov {
    pub(crate) const ALL: [Self; 2] = [Self::Variance, Self::Samples];

    /// The name that users type.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Variance => "variance",
            Self::Samples => "samples",
        }
    }
}

/// `NAME=FILE`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct AovArg {
    pub(crate) aov: Aov,
    pub(crate) file: PathBuf,
}

pub(super) const AOV_HELP: &str = "\
Write what is known of each pixel beside its radiance: `variance` or `samples`, to any format

`variance=FILE` holds the standard error of each channel, the square root of the variance of the mean of all passes, in units of \
radiance; it takes at least two passes, and is infinite after one. `samples=FILE` holds the number of samples, in all channels. \
In .exr, .hdr and .pfm, the numbers are as they are; a .png or .jpg shows them relative to the largest of the image, from \
black to white. Can be given more than once.";
