//! Arguments of `converge`.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueEnum, ValueHint};

use super::image::DevelopmentArgs;
use super::input::InputArgs;
use super::raw_options::{RawOptions, variable_option};
use super::values;

/// Maximum of `render --spp`.
const MAX_SPP: u32 = 1 << 31;

#[derive(Debug, Args)]
#[command(mut_arg("passes", |arg| arg.help("Split the samples into N independent passes [default: 1]")))]
pub(crate) struct ConvergeArgs {
    #[command(flatten)]
    pub(crate) input: InputArgs,

    /// Write to this directory [default: SCENE-converge]
    ///
    /// The files are converge.csv, converge.json, converge.svg, converge.png and converge.html. Older ones are replaced.
    #[arg(short, long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) output: Option<PathBuf>,

    /// Compare these values of a `render` option, such as sampler=random,sobol; repeat for all combinations
    #[arg(long, value_name = "KEY=A,B,C", value_parser = variation, help_heading = "Experiment")]
    pub(crate) vary: Vec<Variation>,

    /// Measure at these samples per pixel: doublings such as 1..256, or a list such as 4,16,64
    #[arg(long, value_name = "SERIES", value_parser = series, allow_hyphen_values = true, default_value = "1..256", help_heading = "Experiment")]
    pub(crate) spp: Series,

    /// Repeat each render with this many seeds, for confidence intervals
    #[arg(
        long,
        value_name = "N",
        value_parser = values::whole(2..=1000_u32),
        allow_negative_numbers = true,
        default_value_t = 8,
        help_heading = "Experiment"
    )]
    pub(crate) seeds: u32,

    /// Choose the kind of reference [default: first available, in this order]
    #[arg(long, alias = "against", value_name = "NAME", value_enum, help_heading = "Error measurement")]
    pub(crate) reference_kind: Option<ReferenceKind>,

    /// Measure against this image: .exr, .hdr or .pfm; with .png or .jpg, tone-mapped images are compared
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, help_heading = "Error measurement")]
    pub(crate) reference: Option<PathBuf>,

    /// Report the time to reach this RMSE [default: lowest RMSE reached by all methods]
    #[arg(long, alias = "error-goal", value_name = "RMSE", value_parser = values::positive, allow_negative_numbers = true, help_heading = "Error measurement")]
    pub(crate) target_rmse: Option<f64>,

    #[command(flatten)]
    pub(crate) fixed: RawOptions,

    #[command(flatten)]
    pub(crate) development: DevelopmentArgs,

    #[command(flatten)]
    pub(crate) run: ConvergeRunArgs,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Running")]
pub(crate) struct ConvergeRunArgs {
    /// Stop after this time, such as 90s, 10min or 1h, and report the measurements so far
    ///
    /// Sample counts that do not fit are skipped and reported. The first is always measured.
    #[arg(long, value_name = "TIME", value_parser = values::time, allow_hyphen_values = true)]
    pub(crate) time: Option<Duration>,

    /// Set the number of threads [default: one per processor]
    #[arg(long, value_name = "N", value_parser = values::whole(1..=1024_u16), allow_negative_numbers = true)]
    pub(crate) threads: Option<u16>,

    /// Print errors only
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

/// Option of `render` with its values to compare: at least one, none twice.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Variation {
    pub(crate) key: String,
    pub(crate) values: Vec<String>,
}

/// Samples per pixel, ascending; at least one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Series(pub(crate) Vec<u32>);

/// Kind of reference, in order of preference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ReferenceKind {
    /// Image of --reference
    Reference,
    /// Mean radiance that the scene file declares
    Truth,
    /// Mean of two renders by another sampler
    Split,
}

/// `KEY=A,B,C`.
fn variation(text: &str) -> Result<Variation, String> {
    let (key, values) =
        text.split_once('=').ok_or("expected an option and its values, such as sampler=random,sobol")?;
    if key == "spp" {
        return Err("samples per pixel are varied by --spp 1..256 or --spp 4,16,64".to_owned());
    }
    let key = variable_option(key)?;
    let values: Vec<String> = values.split(',').map(|value| value.trim().to_owned()).collect();
    for (index, value) in values.iter().enumerate() {
        if value.is_empty() {
            return Err("expected a value between commas, such as sampler=random,sobol".to_owned());
        }
        if values[..index].contains(value) {
            return Err(format!("the value {value} is repeated; remove one"));
        }
    }
    Ok(Variation { key, values })
}

/// `FIRST..LAST` or `A,B,C`.
fn series(text: &str) -> Result<Series, String> {
    let number = |text: &str| {
        let number = text.trim().parse().ok().filter(|number| (1..=MAX_SPP).contains(number));
        number.ok_or_else(|| format!("expected numbers from 1 to {MAX_SPP}, such as 1..256 or 4,16,64"))
    };
    let numbers: Vec<u32> = match text.split_once("..") {
        Some((first, last)) => {
            let last = number(last)?;
            let twice = |n: &u32| n.checked_mul(2).filter(|&n| n <= last);
            std::iter::successors(Some(number(first)?).filter(|&first| first <= last), twice).collect()
        }
        None => text.split(',').map(number).collect::<Result<_, _>>()?,
    };
    if numbers.is_empty() || !numbers.is_sorted_by(|a, b| a < b) {
        return Err("expected ascending numbers, such as 1..256 or 4,16,64".to_owned());
    }
    Ok(Series(numbers))
}

pub(super) const CONVERGE_HELP: &str = "\
Measure error against run time for several methods, with confidence intervals

A method is a combination of the --vary values. Each is rendered at a series of sample counts with several seeds. Errors are measured \
against the first available reference: the image of --reference, the mean radiance that the scene declares (truth), or a reference \
rendered in two halves by another sampler with other seeds (split).

The squared error of a split reference is a quarter of the mean squared difference of its halves. It is printed, plotted, and \
subtracted. Points below 1.73 times the RMSE of the reference are excluded from plots and fits.

RMSE is the root of the mean squared error over pixels, channels and seeds; with a truth, that of the image mean. relMSE is the mean of \
(A - B)^2 / (B^2 + 0.01). Bias is the mean of A - B. Its standard error includes the spread between seeds and the error of the \
reference. FLIP is that of the first seed.

Seconds are the processor time of all threads for rendering, without building, as the median over seeds. Efficiency is 1 / (MSE * \
seconds). If the squared error falls as 1/N, twice the efficiency means half the time to the same error.

Slopes are fitted per seed to log RMSE against log N (samples per pixel), and against log seconds. The 95 % intervals of slopes and plot \
are by Student's t over the seeds. The error of a truth is a single number and may be zero. Logarithms are then taken of the mean over \
seeds, and intervals are by the jackknife.";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn series_double_or_are_listed() {
        assert_eq!(series("1..16"), Ok(Series(vec![1, 2, 4, 8, 16])));
        assert_eq!(series("3..20"), Ok(Series(vec![3, 6, 12])));
        assert_eq!(series("4, 16,100"), Ok(Series(vec![4, 16, 100])));
        assert_eq!(series("7"), Ok(Series(vec![7])));
        assert_eq!(series("1073741824..2147483648").map(|series| series.0.len()), Ok(2));
        for bad in ["", "..", "0..4", "8..4", "4,4", "16,4", "1,,2", "a..b", "-1", "1.5", "1..2147483649"] {
            assert!(series(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn variations_name_options_of_render() {
        let values = vec!["random".to_owned(), "no-such-sampler".to_owned()];
        let expected = Variation { key: "sampler".to_owned(), values };
        assert_eq!(variation("sampler=random, no-such-sampler"), Ok(expected));
        for (bad, message) in [
            ("sampler", "such as sampler=random,sobol"),
            ("sampelr=a", "did you mean `sampler`"),
            ("size=1x1,2x2", "unknown option to vary `size`"),
            ("spp=1,2", "--spp 4,16,64"),
            ("sampler=", "expected a value between commas, such as sampler=random,sobol"),
            ("sampler=a,,b", "expected a value between commas, such as sampler=random,sobol"),
            ("sampler=a,b,a", "the value a is repeated"),
        ] {
            let error = variation(bad).expect_err(bad);
            assert!(error.contains(message), "{bad}: {error}");
        }
    }
}
