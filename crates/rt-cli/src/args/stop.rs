//! Stop rules.

use std::time::Duration;

use clap::Args;
use rt_render::{Criterion, StopRule, TargetError};

use super::values;

/// Stop rules other than a fixed number of samples.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Sampling")]
pub(crate) struct StopArgs {
    /// Stop after this time, such as 10s, 1.5min, 1h30m or 1d
    ///
    /// A pass starts only if it is expected to finish in time. Loading and writing are not counted.
    #[arg(long, value_name = "TIME", value_parser = values::time, conflicts_with = "passes", allow_hyphen_values = true)]
    pub(crate) time: Option<Duration>,

    /// Stop at this relative error of the image, such as 1%, or at --spp samples [default of --spp: 4096]
    ///
    /// The error is the relative root mean square error, estimated from the differences of independent passes:
    ///
    ///   sqrt(mean of v) / (mean of m)
    ///
    /// For a pixel and a channel, m is the estimated radiance and v the variance of that estimate. Both means are over all pixels
    /// and channels. All pixels take the same number of samples. The error is tested after each pass, from 16 samples on, or
    /// at --spp if that is less. It is reported with a 95 % confidence interval. Images of fewer than 1024 pixels are rendered
    /// again, as with --two-stage.
    #[arg(long, value_name = "PERCENT", value_parser = values::percentage, conflicts_with = "passes", allow_hyphen_values = true)]
    pub(crate) target_error: Option<f64>,

    /// Require --target-error of this share of the pixels, such as 99%, instead of the whole image
    ///
    /// A pixel has converged if its error in each channel is below --target-error times (radiance + 0.01), with 95 % confidence.
    /// Pixels are tested at 64, 128, 256, ... samples, and take no more samples once converged. This biases them, noisy ones by
    /// some per cent of their radiance; --two-stage removes the bias.
    #[arg(long, value_name = "PERCENT", value_parser = values::share_of_pixels, requires = "target_error", allow_hyphen_values = true)]
    pub(crate) target_error_pixels: Option<f64>,

    /// Render the image again with as many new samples as --target-error needed
    ///
    /// A stop rule slightly biases the samples that it tests. The second render is unbiased, and doubles the time.
    #[arg(long, requires = "target_error")]
    pub(crate) two_stage: bool,
}

impl StopArgs {
    /// Stop rule with a cap of `spp` samples per pixel, if time or error ends the render.
    pub(crate) fn rule(&self, spp: Option<u32>) -> Option<StopRule> {
        let criterion = self.target_error_pixels.map_or(Criterion::Image, |share| Criterion::Pixels { share });
        let two_stage = self.two_stage;
        let target = self.target_error.map(|relative| TargetError { relative, criterion, two_stage });
        let cap = if target.is_some() { StopRule::DEFAULT_MAX_SPP_OF_TARGET } else { StopRule::DEFAULT_MAX_SPP };
        let max_spp = spp.unwrap_or(cap);
        (self.time.is_some() || target.is_some()).then_some(StopRule { time: self.time, target, max_spp })
    }
}
