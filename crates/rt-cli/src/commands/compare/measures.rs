//! All metrics of a pair of images.

use rt_image::metrics::{
    Bias, ErrorMap, ExposureRange, Flip, ImagePair, LargestDifference, PerChannel, bias, coverage_difference,
    largest_difference, mean_absolute_error, mean_squared_error, psnr, relative_mean_squared_error, signed_error, ssim,
};

use super::pair::Images;
use crate::args::{CompareArgs, Metric};
use crate::error::CliError;

#[derive(Debug)]
pub(super) struct Measures {
    pub(super) mean_squared: PerChannel,
    pub(super) mean_absolute: PerChannel,
    pub(super) relative: PerChannel,
    pub(super) bias: Bias,
    pub(super) largest: LargestDifference,
    /// `None` if neither image has coverage.
    pub(super) coverage: Option<f64>,
    pub(super) psnr: f64,
    /// `None` for small images.
    pub(super) ssim: Option<f64>,
    pub(super) signed_error: ErrorMap,
    pub(super) flip: ErrorMap,
    /// `None` for tone-mapped images.
    pub(super) hdr_flip: Option<(ErrorMap, ExposureRange)>,
}

impl Measures {
    pub(super) fn new(pair: &ImagePair<'_>, images: &Images, args: &CompareArgs) -> Result<Self, CliError> {
        let flip = match args.pixels_per_degree {
            Some(number) => Flip::new(number).map_err(|error| CliError::Usage(error.to_string()))?,
            None => Flip::default(),
        };
        let development = &images.development;
        let hdr_flip = images.are_radiance().then(|| {
            let exposures = ExposureRange::fitting(pair.reference());
            (flip.hdr(pair, &exposures), exposures)
        });
        Ok(Self {
            mean_squared: mean_squared_error(pair),
            mean_absolute: mean_absolute_error(pair),
            relative: relative_mean_squared_error(pair),
            bias: bias(pair),
            largest: largest_difference(pair),
            coverage: coverage_difference(pair),
            psnr: psnr(pair, development),
            ssim: ssim(pair, development),
            signed_error: signed_error(pair),
            flip: flip.ldr(pair, development),
            hdr_flip,
        })
    }

    /// Metric over all channels; `None` if it cannot be computed.
    pub(super) fn value(&self, metric: Metric) -> Option<f64> {
        match metric {
            Metric::Rmse => Some(self.mean_squared.mean().sqrt()),
            Metric::Mae => Some(self.mean_absolute.mean()),
            Metric::RelMse => Some(self.relative.mean()),
            Metric::Max => Some(self.largest.difference().abs()),
            Metric::Bias => Some(self.bias.all.mean),
            Metric::Coverage => self.coverage,
            Metric::Psnr => Some(self.psnr),
            Metric::Ssim => self.ssim,
            Metric::Flip => Some(self.flip.mean()),
            Metric::HdrFlip => self.hdr_flip.as_ref().map(|(map, _)| map.mean()),
        }
    }

    /// Metric in red, green and blue; `None` if it is not defined per channel.
    pub(super) fn channels(&self, metric: Metric) -> Option<[f64; 3]> {
        match metric {
            Metric::Rmse => Some(self.mean_squared.map(f64::sqrt).to_array()),
            Metric::Mae => Some(self.mean_absolute.to_array()),
            Metric::RelMse => Some(self.relative.to_array()),
            Metric::Bias => Some(self.bias.channels.map(|channel| channel.mean)),
            _ => None,
        }
    }
}
