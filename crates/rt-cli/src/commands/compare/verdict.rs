//! The metric behind the exit code.

use super::measures::Measures;
use crate::args::{CompareArgs, Metric, name_of};
use crate::error::{CliError, usage};

/// Metric of the exit code.
#[derive(Clone, Copy, Debug)]
pub(super) struct Verdict {
    pub(super) metric: Metric,
    pub(super) value: f64,
    pub(super) threshold: f64,
}

pub(super) fn verdict(args: &CompareArgs, measures: &Measures) -> Result<Verdict, CliError> {
    let (metric, threshold) = match args.max_rmse {
        Some(threshold) => (Metric::Rmse, threshold),
        None => (args.metric, args.threshold.unwrap_or(args.metric.best())),
    };
    if threshold < 0.0 && !matches!(metric, Metric::Psnr | Metric::Ssim) {
        return usage(format!(
            "--threshold {threshold}: {} is never negative; give a number from 0 up",
            name_of(metric)
        ));
    }
    // Without a threshold, images are equal only if their coverage is.
    let is_exact = args.threshold.is_none() && args.max_rmse.is_none();
    let coverage = measures.value(Metric::Coverage).filter(|coverage| is_exact && *coverage > 0.0);
    match (measures.value(metric), coverage) {
        (Some(value), Some(coverage)) if !metric.is_worse(value, threshold) => {
            Ok(Verdict { metric: Metric::Coverage, value: coverage, threshold: 0.0 })
        }
        (Some(value), _) => Ok(Verdict { metric, value, threshold }),
        (None, _) if metric == Metric::Coverage => usage("--metric coverage requires an image with an alpha channel"),
        (None, _) => usage(format!("--metric {} requires images of at least 11x11 pixels", name_of(metric))),
    }
}
