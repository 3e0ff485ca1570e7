//! Arguments of `compare`.

use std::path::PathBuf;

use clap::{Args, ValueHint};

use super::memory::MemoryArgs;
use super::picture::DevelopmentArgs;
use super::values::{self, choice};

/// Arguments of `compare`.
#[derive(Debug, Args)]
pub(crate) struct CompareArgs {
    /// Image under test: .png, .jpg, .exr, .hdr or .pfm, or - for standard input
    #[arg(value_name = "A", value_hint = ValueHint::FilePath)]
    pub(crate) test: PathBuf,

    /// Reference that it is compared with: .png, .jpg, .exr, .hdr or .pfm, or - for standard input
    #[arg(value_name = "B", value_hint = ValueHint::FilePath)]
    pub(crate) reference: PathBuf,

    /// Metric that decides whether the images differ (exit code 1)
    #[arg(long, value_name = "NAME", value_parser = choice(Metric::ALL, Metric::name), default_value = "rmse")]
    pub(crate) metric: Metric,

    /// How bad the metric may be; by default what it is for equal images
    #[arg(long, value_name = "X", value_parser = values::finite, allow_negative_numbers = true)]
    pub(crate) threshold: Option<f64>,

    /// The same as --metric rmse --threshold X
    #[arg(long, value_name = "X", value_parser = values::finite, conflicts_with_all = ["metric", "threshold"])]
    pub(crate) max_rmse: Option<f64>,

    /// Print JSON instead of a table
    #[arg(long, long_help = JSON_HELP)]
    pub(crate) json: bool,

    /// Pixels that a viewer sees in one degree, for FLIP; by default as on a 4K screen 0.7 m wide, from 0.7 m away
    #[arg(long, value_name = "N", value_parser = values::pixels_per_degree)]
    pub(crate) pixels_per_degree: Option<f64>,

    #[command(flatten)]
    pub(crate) heat_map: HeatMapArgs,

    #[command(flatten)]
    pub(crate) development: DevelopmentArgs,

    #[command(flatten)]
    pub(crate) memory: MemoryArgs,
}

/// A picture of the differences.
#[derive(Debug, Args)]
#[command(next_help_heading = "Heat map")]
pub(crate) struct HeatMapArgs {
    /// Picture of the differences to write: .png or .jpg, or - for standard output. Its colours are explained in the report
    #[arg(long = "heat-map", value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) file: Option<PathBuf>,

    /// What it shows: the signed error of radiance, or what a viewer sees of it
    #[arg(
        long = "heat-map-of",
        value_name = "NAME",
        value_parser = choice(HeatMapOf::ALL, HeatMapOf::name),
        default_value = "error",
        requires = "file"
    )]
    pub(crate) shows: HeatMapOf,

    /// Value at the end of the colour scale; by default the 99.9th percentile of errors, and 1 for FLIP
    #[arg(long = "heat-map-scale", value_name = "X", value_parser = values::positive, requires = "file")]
    pub(crate) scale: Option<f64>,
}

/// What may decide whether two images differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Metric {
    Rmse,
    Mae,
    RelMse,
    Max,
    Bias,
    Coverage,
    Psnr,
    Ssim,
    Flip,
    HdrFlip,
}

impl Metric {
    pub(crate) const ALL: [Self; 10] = [
        Self::Rmse,
        Self::Mae,
        Self::RelMse,
        Self::Max,
        Self::Bias,
        Self::Coverage,
        Self::Psnr,
        Self::Ssim,
        Self::Flip,
        Self::HdrFlip,
    ];

    /// The name that users type.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Rmse => "rmse",
            Self::Mae => "mae",
            Self::RelMse => "relmse",
            Self::Max => "max",
            Self::Bias => "bias",
            Self::Coverage => "coverage",
            Self::Psnr => "psnr",
            Self::Ssim => "ssim",
            Self::Flip => "flip",
            Self::HdrFlip => "hdr-flip",
        }
    }

    /// Its value for equal images, than which none is better.
    pub(crate) const fn best(self) -> f64 {
        match self {
            Self::Psnr => f64::INFINITY,
            Self::Ssim => 1.0,
            _ => 0.0,
        }
    }

    /// True if the value is on the bad side of the threshold, as NaN always is.
    pub(crate) fn is_worse(self, value: f64, threshold: f64) -> bool {
        match self {
            Self::Psnr | Self::Ssim => !(value >= threshold),
            Self::Bias => !(value.abs() <= threshold),
            _ => !(value <= threshold),
        }
    }
}

/// What a heat map shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum HeatMapOf {
    Error,
    Flip,
    HdrFlip,
}

impl HeatMapOf {
    pub(crate) const ALL: [Self; 3] = [Self::Error, Self::Flip, Self::HdrFlip];

    /// The name that users type.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Error => "error",
            Self::Flip => "flip",
            Self::HdrFlip => "hdr-flip",
        }
    }
}

pub(super) const COMPARE_HELP: &str = "\
Measure how much an image A differs from a reference B of the same size

Of linear radiance: RMSE, MAE (mean absolute error), relMSE (mean of (A - B)^2 / (B^2 + 0.01)), bias (mean of A - B, with the \
standard error that independent noise gives it), the largest difference, and that of coverage. Pixels that are NaN or \
infinite in one of the images are left out and counted; if they are not the same in the other one, the images differ.

Of the developed signal, from 0 to 1: PSNR in decibels, and SSIM (Wang et al. 2004). Of the light that the display then shows: \
FLIP (Andersson et al. 2020), from 0 to 1, what a viewer sees who alternates between the images. --exposure and --tone develop; \
HDR-FLIP (Andersson et al. 2021) tries the exposures that fit the reference.

PNG and JPEG are taken to be encoded in sRGB and are turned into linear light. Beside such an image, one of linear \
radiance is first developed to bytes as `develop` does, dithered unless --dither is none, so that a picture and its .exr are \
found equal.

The exit code is 1 if --metric is worse than --threshold: above it, or below it for psnr and ssim.";

const JSON_HELP: &str = "\
Print JSON instead of a table

`metrics` holds the value of each metric by the name that --metric has for it, over all channels: null if it is infinite or cannot \
be computed. `channels` has red, green and blue where a metric is known for each. `largest_difference` tells `pixel` (column, \
row), `channel`, and the radiance there. `test` and `reference` tell of each file whether it was `developed` to match the other, and \
how many pixels are `not_finite`; `differently_finite` counts those that are so in different ways. `exposures` are those of HDR-FLIP \
in stops. `different` is what the exit code tells.";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_images_are_never_worse_and_nan_always_is() {
        for metric in Metric::ALL {
            assert!(!metric.is_worse(metric.best(), metric.best()), "{metric:?}");
            assert!(metric.is_worse(f64::NAN, metric.best()), "{metric:?}");
        }
        assert!(Metric::Rmse.is_worse(0.2, 0.1) && !Metric::Rmse.is_worse(0.1, 0.1));
        assert!(Metric::Psnr.is_worse(30.0, 40.0) && !Metric::Psnr.is_worse(40.0, 30.0));
        assert!(Metric::Bias.is_worse(-0.2, 0.1) && !Metric::Bias.is_worse(-0.1, 0.1));
        assert!(Metric::Ssim.is_worse(0.9, 1.0) && !Metric::Ssim.is_worse(0.9, 0.9));
    }
}
