//! Arguments of `converge`.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueHint};

use super::picture::DevelopmentArgs;
use super::typed::{TypedOptions, variable_names};
use super::values::{self, choice};
use super::{InputArgs, unknown_word};

/// As many samples per pixel as `--spp` of `render` takes.
const MOST_SAMPLES: u32 = 1 << 31;

/// Arguments of `converge`.
#[derive(Debug, Args)]
pub(crate) struct ConvergeArgs {
    #[command(flatten)]
    pub(crate) input: InputArgs,

    /// Folder to write to; by default the scene's name with -converge, in the current folder
    ///
    /// It gets converge.csv, converge.json, converge.svg, converge.png and converge.html, which replace older ones.
    #[arg(short, long, value_name = "FOLDER", value_hint = ValueHint::DirPath)]
    pub(crate) output: Option<PathBuf>,

    /// Option of `render` and its values to compare, as sampler=random,sobol. Of several, all combinations are compared
    #[arg(long, value_name = "KEY=A,B,C", value_parser = variation, help_heading = "What is compared")]
    pub(crate) vary: Vec<Variation>,

    /// Samples per pixel: doublings as 1..256, or a list as 4,16,64; rounded up to what each sampler needs
    #[arg(long, value_name = "SERIES", value_parser = series, default_value = "1..256", help_heading = "What is compared")]
    pub(crate) spp: Series,

    /// Independent repetitions of each render, whose spread gives the intervals
    #[arg(
        long,
        value_name = "N",
        value_parser = clap::value_parser!(u32).range(2..=1000),
        default_value_t = 8,
        help_heading = "What is compared"
    )]
    pub(crate) seeds: u32,

    /// What errors are measured against; by default the first of these that there is
    #[arg(long, value_name = "NAME", value_parser = choice(Against::ALL, Against::name), help_heading = "Measure")]
    pub(crate) against: Option<Against>,

    /// Image to measure against: .exr, .hdr or .pfm; or .png or .jpg, with which developed pictures are compared
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, help_heading = "Measure")]
    pub(crate) reference: Option<PathBuf>,

    /// Tell the time to reach this RMSE; by default the least that all methods reach
    #[arg(long, value_name = "RMSE", value_parser = values::positive, help_heading = "Measure")]
    pub(crate) error_goal: Option<f64>,

    #[command(flatten)]
    pub(crate) fixed: TypedOptions,

    #[command(flatten)]
    pub(crate) development: DevelopmentArgs,

    #[command(flatten)]
    pub(crate) run: ConvergeRunArgs,
}

/// What changes no error.
#[derive(Debug, Args)]
#[command(next_help_heading = "Running")]
pub(crate) struct ConvergeRunArgs {
    /// End within this time, such as 90s, 10m or 1h, with what was measured by then
    ///
    /// Numbers of samples that there is no time for are left out and told. The first is measured in any case.
    #[arg(long, value_name = "TIME", value_parser = values::time)]
    pub(crate) time: Option<Duration>,

    /// Number of threads; by default one for each processor
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,

    /// Print nothing but errors
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

/// An option of `render`, and the values that it takes in turn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Variation {
    pub(crate) key: String,
    /// At least one, none twice.
    pub(crate) values: Vec<String>,
}

/// Samples per pixel, ascending; at least one number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Series(pub(crate) Vec<u32>);

/// What errors are measured against, the best first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Against {
    Truth,
    Reference,
    Split,
}

impl Against {
    pub(crate) const ALL: [Self; 3] = [Self::Truth, Self::Reference, Self::Split];

    /// The name that users type.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Truth => "truth",
            Self::Reference => "reference",
            Self::Split => "split",
        }
    }
}

/// `KEY=A,B,C`.
fn variation(text: &str) -> Result<Variation, String> {
    let (key, values) = text.split_once('=').ok_or("write an option and its values as sampler=random,sobol")?;
    if key == "spp" {
        return Err("samples per pixel are varied by --spp 1..256 or --spp 4,16,64".to_owned());
    }
    let known = variable_names();
    if !known.iter().any(|name| name == key) {
        return Err(unknown_word("option to vary", key, known));
    }
    let values: Vec<String> = values.split(',').map(|value| value.trim().to_owned()).collect();
    for (index, value) in values.iter().enumerate() {
        if value.is_empty() {
            return Err("a value is missing".to_owned());
        }
        if values[..index].contains(value) {
            return Err(format!("{value} is there twice"));
        }
    }
    Ok(Variation { key: key.to_owned(), values })
}

/// `FIRST..LAST` or `A,B,C`.
fn series(text: &str) -> Result<Series, String> {
    let number = |text: &str| {
        let number = text.trim().parse().ok().filter(|number| (1..=MOST_SAMPLES).contains(number));
        number.ok_or_else(|| format!("write numbers from 1 to {MOST_SAMPLES}, as 1..256 or 4,16,64"))
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
        return Err("the numbers must ascend".to_owned());
    }
    Ok(Series(numbers))
}

pub(super) const CONVERGE_HELP: &str = "\
Measure the error of methods against their run time, with confidence

Each method, which is a combination of the values that --vary lists, is rendered at each of a series of sample counts with \
several seeds. Errors are measured against what is best of: the truth that the scene declares, a closed form of the mean \
radiance over all pixels; the image that --reference names; or a reference of its own, rendered in two halves by another \
sampler with other seeds. A quarter of the mean squared difference of the halves is its own error (the floor), which is \
printed, drawn, and subtracted; points below three times the floor are not trusted: neither drawn nor fitted.

RMSE is the root of the mean squared error over pixels, channels and seeds; with a truth, that of the mean over the image. \
relMSE is the mean of (A - B)^2 / (B^2 + 0.01). Bias is the mean of A - B with its standard error, from the spread between seeds and \
the error of the reference. FLIP is that of the first seed. Seconds are processor time of all threads for rendering, the median \
over seeds; building is apart. Efficiency is 1 / (MSE seconds): twice as much is half of the time to the same error, for methods \
whose squared error falls as 1/N. Slopes are those of log RMSE against log N (samples per pixel) and log seconds, fitted for each \
seed; their 95 % intervals are by Student's t over the seeds, and so are those of the plot, which shows the mean of log MSE. With a \
truth, whose error is a single number and may be zero, logarithms are taken of the mean over seeds, and the spread is that of leaving \
out one seed after the other.";

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
            ("sampler", "as sampler=random,sobol"),
            ("sampelr=a", "did you mean `sampler`"),
            ("size=1x1,2x2", "unknown option to vary `size`"),
            ("spp=1,2", "--spp 4,16,64"),
            ("sampler=", "a value is missing"),
            ("sampler=a,,b", "a value is missing"),
            ("sampler=a,b,a", "a is there twice"),
        ] {
            let error = variation(bad).expect_err(bad);
            assert!(error.contains(message), "{bad}: {error}");
        }
    }
}
