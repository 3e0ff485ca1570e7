//! Report of a comparison, as a table and as JSON.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use comfy_table::{CellAlignment, Table, presets};
use rt_image::metrics::ImagePair;
use serde_json::{Map, Value, json};

use super::measures::Measures;
use super::pair::{Images, LoadedImage};
use super::verdict::Verdict;
use crate::args::{CompareArgs, HeatMapOf, Metric, name_of};
use crate::error::CliError;

const CHANNELS: [&str; 3] = ["red", "green", "blue"];

#[derive(Debug)]
pub(super) struct Comparison<'a> {
    pub(super) args: &'a CompareArgs,
    pub(super) images: &'a Images,
    pub(super) pair: &'a ImagePair<'a>,
    pub(super) measures: &'a Measures,
    pub(super) heat_map: Option<HeatMap>,
    pub(super) verdict: Verdict,
}

#[derive(Debug)]
pub(super) struct HeatMap {
    pub(super) file: PathBuf,
    pub(super) shows: HeatMapOf,
    /// Value at the end of its scale.
    pub(super) limit: f64,
}

impl Comparison<'_> {
    /// Error if the images differ.
    pub(super) fn failure(&self) -> Option<CliError> {
        let Verdict { metric, value, threshold } = self.verdict;
        let non_finite = self.pair.non_finite().different;
        (non_finite > 0 || metric.is_worse(value, threshold)).then(|| CliError::Different {
            test: self.args.test.clone(),
            reference: self.args.reference.clone(),
            metric: name_of(metric),
            value: distinct_digits(value, threshold),
            threshold,
            non_finite,
        })
    }

    pub(super) fn text(&self) -> String {
        let CompareArgs { test, reference, .. } = self.args;
        let mut lines = vec![
            format!("A {}: {}", test.display(), self.images.test.description()),
            format!("B {}: {}, the reference", reference.display(), self.images.reference.description()),
        ];
        let non_finite = self.pair.non_finite();
        if non_finite.test + non_finite.reference > 0 {
            lines.push(format!(
                "NaN or infinite pixels: {} of A, {} of B, {} of them different; metrics of radiance leave them out",
                non_finite.test, non_finite.reference, non_finite.different
            ));
        }
        lines.extend([String::new(), self.table().to_string(), String::new(), self.largest()]);
        lines.extend(self.heat_map.as_ref().map(HeatMap::legend));
        lines.join("\n") + "\n"
    }

    fn table(&self) -> Table {
        let mut table = Table::new();
        table.load_style(presets::NOTHING);
        table.set_header(["", "all", CHANNELS[0], CHANNELS[1], CHANNELS[2]]);
        for &metric in Metric::value_variants() {
            if let Some(value) = self.measures.value(metric) {
                table.add_row(row(self.title(metric), value, self.measures.channels(metric)));
            }
            if metric == Metric::Bias {
                let bias = &self.measures.bias;
                let errors = bias.channels.map(|channel| channel.standard_error);
                table.add_row(row("  its standard error".to_owned(), bias.all.standard_error, Some(errors)));
            }
        }
        for column in table.column_iter_mut().skip(1) {
            column.set_cell_alignment(CellAlignment::Right);
        }
        table
    }

    fn title(&self, metric: Metric) -> String {
        match (metric, &self.measures.hdr_flip) {
            (Metric::Rmse, _) => "RMSE".to_owned(),
            (Metric::Mae, _) => "MAE".to_owned(),
            (Metric::RelMse, _) => "relMSE".to_owned(),
            (Metric::Max, _) => "largest difference".to_owned(),
            (Metric::Bias, _) => "bias, A - B".to_owned(),
            (Metric::Coverage, _) => "largest difference of coverage".to_owned(),
            (Metric::Psnr, _) => "PSNR in dB, as displayed".to_owned(),
            (Metric::Ssim, _) => "SSIM, as displayed".to_owned(),
            (Metric::Flip, _) => "FLIP, as displayed".to_owned(),
            (Metric::HdrFlip, None) => "HDR-FLIP".to_owned(),
            (Metric::HdrFlip, Some((_, range))) => {
                format!("HDR-FLIP, {} exposures from {:.2} to {:.2} EV", range.count, range.start, range.stop)
            }
        }
    }

    fn largest(&self) -> String {
        let largest = &self.measures.largest;
        if largest.test == largest.reference {
            return "the largest difference is 0".to_owned();
        }
        let radiance = |value: [f64; 3]| value.map(digits).join(" ");
        format!(
            "the largest difference is in the {} of pixel {},{}: A {}, B {}",
            CHANNELS[largest.channel],
            largest.pixel[0],
            largest.pixel[1],
            radiance(largest.test),
            radiance(largest.reference)
        )
    }

    /// JSON report; `compare --help` documents it.
    pub(super) fn json(&self) -> String {
        let Self { args, images, pair, measures, verdict, .. } = self;
        let (largest, non_finite) = (&measures.largest, pair.non_finite());
        let metrics = Metric::value_variants().iter().copied();
        let values: Map<_, _> =
            metrics.clone().map(|metric| (name_of(metric), measures.value(metric).into())).collect();
        let channels: Map<_, _> =
            metrics.filter_map(|metric| Some((name_of(metric), measures.channels(metric)?.to_vec().into()))).collect();
        let report = json!({
            "program": env!("CARGO_PKG_NAME"),
            "version": env!("CARGO_PKG_VERSION"),
            "test": image_json(&args.test, &images.test, non_finite.test),
            "reference": image_json(&args.reference, &images.reference, non_finite.reference),
            "differently_finite": non_finite.different,
            "width": pair.width(),
            "height": pair.height(),
            "metrics": values,
            "channels": channels,
            "bias_standard_error": measures.bias.all.standard_error,
            "largest_difference": {
                "pixel": largest.pixel,
                "channel": CHANNELS[largest.channel],
                "test": largest.test,
                "reference": largest.reference,
            },
            "exposures": measures.hdr_flip.as_ref().map(|(_, range)| range.exposures().collect::<Vec<_>>()),
            "heat_map": self.heat_map.as_ref().map(|map| {
                json!({ "file": map.file.display().to_string(), "shows": name_of(map.shows), "limit": map.limit })
            }),
            "metric": name_of(verdict.metric),
            "threshold": verdict.threshold,
            "different": self.failure().is_some(),
        });
        format!("{report:#}\n")
    }
}

fn image_json(path: &Path, image: &LoadedImage, non_finite: u64) -> Value {
    json!({
        "file": path.display().to_string(),
        "format": image.format.extensions().first(),
        "developed": image.developed,
        "non_finite": non_finite,
    })
}

impl HeatMap {
    fn legend(&self) -> String {
        let limit = digits(self.limit);
        let scale = match self.shows {
            HeatMapOf::Error if self.limit == 0.0 => {
                "A - B in the channel that differs most; white 0 everywhere, green NaN or infinite in A or B".to_owned()
            }
            HeatMapOf::Error => format!(
                "A - B in the channel that differs most; blue -{limit} or less, white 0, red {limit} or more, \
                 green NaN or infinite in A or B"
            ),
            HeatMapOf::Flip => format!("FLIP; black 0, violet, orange, pale yellow {limit} or more"),
            HeatMapOf::HdrFlip => format!("HDR-FLIP; black 0, violet, orange, pale yellow {limit} or more"),
        };
        format!("{} shows {scale}", self.file.display())
    }
}

fn row(title: String, all: f64, channels: Option<[f64; 3]>) -> Vec<String> {
    [title, digits(all)].into_iter().chain(channels.into_iter().flatten().map(digits)).collect()
}

/// Number with six significant digits, or with all of them if the six equal the threshold.
fn distinct_digits(value: f64, threshold: f64) -> String {
    let rounded = digits(value);
    if rounded.parse() == Ok(threshold) { value.to_string() } else { rounded }
}

/// Number with six significant digits.
fn digits(value: f64) -> String {
    match value.abs() {
        0.0 => "0".to_owned(),
        magnitude if !magnitude.is_finite() => value.to_string(),
        magnitude if !(1e-4..1e6).contains(&magnitude) => format!("{value:.5e}"),
        magnitude => {
            let whole = (magnitude as u64).checked_ilog10().map_or(0, |power| power + 1);
            format!("{value:.*}", 6 - whole as usize)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{digits, distinct_digits};

    #[test]
    fn numbers_have_six_digits() {
        for (value, text) in [
            (0.0, "0"),
            (-0.0, "0"),
            (1.0, "1.00000"),
            (-0.123_456_78, "-0.123457"),
            (123.456_78, "123.457"),
            (999_999.4, "999999"),
            (1e6, "1.00000e6"),
            (1e-5, "1.00000e-5"),
            (f64::INFINITY, "inf"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(digits(value), text);
        }
        assert_eq!(distinct_digits(0.085_489_012_885, 0.01), "0.085489");
        assert_eq!(distinct_digits(0.010_000_000_1, 0.01), "0.0100000001");
    }
}
