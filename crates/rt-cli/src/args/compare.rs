//! Arguments of `compare`.

use std::path::PathBuf;

use clap::{Args, ValueEnum, ValueHint};

use super::image::DevelopmentArgs;
use super::memory::MemoryArgs;
use super::values;

#[derive(Debug, Args)]
#[command(mut_args(DevelopmentArgs::without_scene))]
pub(crate) struct CompareArgs {
    /// Test image: .png, .jpg, .exr, .hdr, .pfm, or - for standard input
    #[arg(value_name = "A", value_hint = ValueHint::FilePath)]
    pub(crate) test: PathBuf,

    /// Reference image: .png, .jpg, .exr, .hdr, .pfm, or - for standard input
    #[arg(value_name = "B", value_hint = ValueHint::FilePath)]
    pub(crate) reference: PathBuf,

    /// Choose the metric of the exit code
    #[arg(long, value_name = "NAME", value_enum, default_value = "rmse")]
    pub(crate) metric: Metric,

    /// Accept metric values up to this one (down to it for psnr and ssim) [default: value of equal images]
    #[arg(long, value_name = "X", value_parser = values::finite, allow_negative_numbers = true)]
    pub(crate) threshold: Option<f64>,

    /// Accept an RMSE up to X; same as --metric rmse --threshold X
    #[arg(long, value_name = "X", value_parser = values::non_negative, allow_negative_numbers = true, conflicts_with_all = ["metric", "threshold"])]
    pub(crate) max_rmse: Option<f64>,

    /// Print JSON instead of a table
    #[arg(long, long_help = JSON_HELP)]
    pub(crate) json: bool,

    /// Set the pixels per degree for FLIP [default: 67, a 4K screen 0.7 m wide at 0.7 m]
    #[arg(long, value_name = "N", value_parser = values::pixels_per_degree, allow_negative_numbers = true)]
    pub(crate) pixels_per_degree: Option<f64>,

    #[command(flatten)]
    pub(crate) heat_map: HeatMapArgs,

    #[command(flatten)]
    pub(crate) development: DevelopmentArgs,

    #[command(flatten)]
    pub(crate) memory: MemoryArgs,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Heat map")]
pub(crate) struct HeatMapArgs {
    /// Write an image of the differences: .png, .jpg, or -; the report explains its colours
    #[arg(long = "heat-map", value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) file: Option<PathBuf>,

    /// Choose the quantity of the heat map: the signed error of radiance, or the visible difference
    #[arg(long = "heat-map-of", value_name = "NAME", value_enum, default_value = "error", requires = "file")]
    pub(crate) shows: HeatMapOf,

    /// Set the value at the end of the colour scale [default: 99.9th percentile of errors; 1 for FLIP]
    #[arg(long = "heat-map-scale", value_name = "X", value_parser = values::positive, allow_negative_numbers = true, requires = "file")]
    pub(crate) scale: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Metric {
    Rmse,
    Mae,
    #[value(name = "relmse")]
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
    /// Best value: that of equal images.
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

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum HeatMapOf {
    Error,
    Flip,
    HdrFlip,
}

pub(super) const COMPARE_HELP: &str = "\
Measure the difference of image A from reference image B of the same size

Linear radiance: RMSE, MAE (mean absolute error), relMSE (mean of (A - B)^2 / (B^2 + 0.01)), bias (mean of A - B, with its standard \
error for independent noise), largest difference, largest difference of coverage. Pixels that are NaN or infinite in one of the images \
are excluded and counted. Such a pixel counts as a difference unless both images have the same value.

Tone-mapped signal, 0 to 1: PSNR in decibels, SSIM (Wang et al. 2004). Displayed light: FLIP (Andersson et al. 2020), 0 to 1, the \
difference seen when alternating between the images. --exposure and --tone set the tone mapping; HDR-FLIP (Andersson et al. 2021) \
samples the exposures that fit the reference.

PNG and JPEG are decoded from sRGB to linear light. If only one image is PNG or JPEG, the other one is first tone-mapped to bytes, as \
by `develop`, so that a .png and its .exr compare equal. This includes dithering, unless --dither off is given. \
Crops differ: they are dithered like their part of the full image. So do images of scenes with another `film.encoding` than sRGB.

The exit code is 1 if --metric is worse than --threshold: above it, or below it for psnr and ssim. Without a threshold, coverage must \
be equal as well.";

const JSON_HELP: &str = "\
Print JSON instead of a table

`metrics` holds each metric by its --metric name over all channels: null if infinite or not computable. `channels` has red, green and \
blue where a metric has them. `largest_difference` has the `pixel` (column, row), the `channel`, and the radiance of both images. \
`test` and `reference` state whether the file was `developed` to match the other one, and its `non_finite` pixels; \
`differently_finite` counts those that differ. `exposures` are those of HDR-FLIP in stops. `different` matches the exit code.";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_images_are_never_worse_and_nan_always_is() {
        for &metric in Metric::value_variants() {
            assert!(!metric.is_worse(metric.best(), metric.best()), "{metric:?}");
            assert!(metric.is_worse(f64::NAN, metric.best()), "{metric:?}");
        }
        assert!(Metric::Rmse.is_worse(0.2, 0.1) && !Metric::Rmse.is_worse(0.1, 0.1));
        assert!(Metric::Psnr.is_worse(30.0, 40.0) && !Metric::Psnr.is_worse(40.0, 30.0));
        assert!(Metric::Bias.is_worse(-0.2, 0.1) && !Metric::Bias.is_worse(-0.1, 0.1));
        assert!(Metric::Ssim.is_worse(0.9, 1.0) && !Metric::Ssim.is_worse(0.9, 0.9));
    }
}
