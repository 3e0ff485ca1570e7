//! Means with confidence intervals, slopes, and times to an error.
//!
//! Repetitions have independent seeds. Each seed gives one value (a logarithm of an error, a slope), and Student's t over the seeds
//! gives the interval. Errors of one seed may be correlated.

use rt_math::stats::student_t;
use rt_math::transcendental::{exp, log};
use serde::Serialize;

const CONFIDENCE: f64 = 0.95;

/// Mean with its 95 % confidence interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct ConfidenceInterval {
    pub(super) low: f64,
    pub(super) mean: f64,
    pub(super) high: f64,
}

impl ConfidenceInterval {
    /// Interval by Student's t; `None` for fewer than two values, or if one is not finite.
    pub(super) fn of(values: &[f64]) -> Option<Self> {
        let (mean, error) = mean_and_error(values)?;
        let half = error * student_t(CONFIDENCE, values.len() as f64 - 1.0);
        Some(Self { low: mean - half, mean, high: mean + half })
    }

    /// Applies a monotonically increasing function.
    pub(super) fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self { low: f(self.low), mean: f(self.mean), high: f(self.high) }
    }
}

/// Mean of independent values and its standard error; `None` for fewer than two, or if one is not finite.
pub(super) fn mean_and_error(values: &[f64]) -> Option<(f64, f64)> {
    let count = values.len() as f64;
    if values.len() < 2 || !values.iter().all(|value| value.is_finite()) {
        return None;
    }
    let mean = mean(values);
    let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
    Some((mean, (squares / (count * (count - 1.0))).sqrt()))
}

/// Mean; NaN of no values.
pub(super) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Median; NaN of no values.
pub(super) fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    match (sorted.get(sorted.len() / 2), sorted.len() % 2) {
        (None, _) => f64::NAN,
        (Some(&middle), 1) => middle,
        (Some(&upper), _) => 0.5 * (sorted[sorted.len() / 2 - 1] + upper),
    }
}

/// Estimator of logarithms of errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Repetitions {
    /// Logarithm per repetition, for errors that are means over many pixels.
    Each,
    /// Logarithm of the mean over all repetitions, with the jackknife (Tukey 1958) for the spread. For errors that are single
    /// numbers and may be zero.
    Together,
}

impl Repetitions {
    /// Value of a statistic for each repetition, which is a row. The values have the mean of the statistic and the spread of its
    /// error.
    fn values(self, rows: &[Vec<f64>], statistic: impl Fn(&[f64]) -> Option<f64>) -> Option<Vec<f64>> {
        match self {
            Self::Each => rows.iter().map(|row| statistic(row)).collect(),
            Self::Together => {
                let count = rows.len() as f64;
                let sums: Vec<f64> = (0..rows.first()?.len()).map(|at| rows.iter().map(|row| row[at]).sum()).collect();
                let of_all = statistic(&sums.iter().map(|sum| sum / count).collect::<Vec<_>>())?;
                let without = |row: &Vec<f64>| {
                    let rest: Vec<f64> =
                        sums.iter().zip(row).map(|(sum, value)| (sum - value) / (count - 1.0)).collect();
                    Some(count * of_all - (count - 1.0) * statistic(&rest)?)
                };
                rows.iter().map(without).collect()
            }
        }
    }

    /// Root of mean squared errors, by the mean of its logarithm.
    pub(super) fn root_mean(self, squares: &[f64]) -> Option<ConfidenceInterval> {
        let rows: Vec<Vec<f64>> = squares.iter().map(|&square| vec![square]).collect();
        let logs = self.values(&rows, |row| Some(0.5 * log(row[0])))?;
        ConfidenceInterval::of(&logs).map(|interval| interval.map(exp))
    }

    /// The slope of the logarithm of the root of `squares` against log `x`, by least squares. `None` if there are fewer than
    /// two different `x` or two repetitions, or a logarithm of a number that is not positive.
    pub(super) fn slope(self, x: &[f64], squares: &[Vec<f64>]) -> Option<ConfidenceInterval> {
        let x: Vec<f64> = x.iter().map(|&x| log(x)).collect();
        let of_roots = |squares: &[f64]| slope(&x, &squares.iter().map(|&y| 0.5 * log(y)).collect::<Vec<_>>());
        ConfidenceInterval::of(&self.values(squares, of_roots)?)
    }
}

/// Least-squares slope.
fn slope(x: &[f64], y: &[f64]) -> Option<f64> {
    let (mean_x, mean_y) = (mean(x), mean(y));
    let products = x.iter().zip(y).map(|(x, y)| (x - mean_x) * (y - mean_y)).sum::<f64>();
    let squares = x.iter().map(|x| (x - mean_x) * (x - mean_x)).sum::<f64>();
    Some(products / squares).filter(|slope| x.len() == y.len() && slope.is_finite())
}

/// Time at which an error falls to a target, in seconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "reached", content = "seconds")]
pub(super) enum TimeToError {
    /// Later than the longest measurement.
    NotWithin(f64),
    /// Interpolated linearly in logarithms between two measurements.
    At(f64),
    /// Earlier than the shortest measurement.
    Before(f64),
}

/// Time at which the error falls to `goal`, by (seconds, error) in the order of measurement; `None` without measurements.
pub(super) fn time_to_error(measured: &[(f64, f64)], goal: f64) -> Option<TimeToError> {
    let reached = measured.iter().position(|&(_, error)| error <= goal);
    Some(match reached {
        None => TimeToError::NotWithin(measured.last()?.0),
        Some(0) => TimeToError::Before(measured[0].0),
        Some(index) => {
            let ((from, above), (to, below)) = (measured[index - 1], measured[index]);
            let part = if below > 0.0 { log(above / goal) / log(above / below) } else { 1.0 };
            TimeToError::At(from * exp(part * log(to / from)))
        }
    })
}

#[cfg(test)]
mod tests {
    use rt_math::random::{hash, unit};
    use rt_math::transcendental::{cos, pow};

    use super::*;

    /// Standard normal random number (Box and Muller 1958).
    fn normal(words: &[u64]) -> f64 {
        let uniform = |index| unit(hash(&[words, &[index]].concat()));
        (-2.0 * log(1.0 - uniform(0))).sqrt() * cos(core::f64::consts::TAU * uniform(1))
    }

    /// Squared errors that fall as N^slope, with a random factor per repetition and per measurement.
    fn errors(x: &[f64], slope: f64, repetitions: u64, trial: u64) -> Vec<Vec<f64>> {
        let repetition = |r| {
            let own = 0.1 * normal(&[trial, r]);
            let error = |(n, &x): (u64, &f64)| 0.3 * pow(x, slope) * exp(own + 0.2 * normal(&[trial, r, n]));
            (0..).zip(x).map(error).map(|error| error * error).collect()
        };
        (0..repetitions).map(repetition).collect()
    }

    #[test]
    fn intervals_are_those_of_the_tables() {
        // t(0.975) with 7 degrees of freedom is 2.3646, and the deviation of 1 to 8 is √6.
        let interval = ConfidenceInterval::of(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]).expect("eight values");
        let half = 2.364_624_251 * (6.0f64 / 8.0).sqrt();
        assert_eq!(interval.mean, 4.5);
        assert!((interval.high - 4.5 - half).abs() < 1e-8 && (4.5 - interval.low - half).abs() < 1e-8, "{interval:?}");
        let two = ConfidenceInterval::of(&[0.0, 2.0]).expect("two values");
        assert!((two.high - 1.0 - 12.706_204_736).abs() < 1e-7, "{two:?}");
        for bad in [&[][..], &[1.0], &[1.0, f64::NAN], &[f64::NEG_INFINITY, 1.0]] {
            assert_eq!(ConfidenceInterval::of(bad), None, "{bad:?}");
        }
    }

    #[test]
    fn the_median_is_in_the_middle() {
        assert_eq!((median(&[3.0, 1.0, 2.0]), median(&[4.0, 1.0, 2.0, 10.0])), (2.0, 3.0));
        assert!(median(&[]).is_nan());
    }

    #[test]
    fn slopes_without_noise_are_exact() {
        let x = [4.0, 16.0, 64.0];
        let y = x.map(|x| 5.0 * pow(x, -1.5)).to_vec();
        for repetitions in [Repetitions::Each, Repetitions::Together] {
            let slope = |x: &[f64], rows: &[Vec<f64>]| repetitions.slope(x, rows);
            let exact = slope(&x, &[y.clone(), y.clone()]).expect("a line");
            assert!((exact.mean + 0.75).abs() < 1e-13 && exact.high - exact.low < 1e-11, "{exact:?}");
            assert_eq!(slope(&x, std::slice::from_ref(&y)), None, "one repetition tells no spread");
            assert_eq!(slope(&[4.0; 3], &[y.clone(), y.clone()]), None);
            assert_eq!(slope(&x, &[vec![1.0, 0.0, 1.0], vec![1.0, 0.0, 1.0]]), None);
            assert_eq!(slope(&x[..1], &[vec![1.0], vec![2.0]]), None);
            assert_eq!(slope(&x[..2], &[y.clone(), y.clone()]), None);
        }
        assert_eq!(Repetitions::Each.slope(&x, &[y.clone(), vec![1.0, 0.0, 1.0]]), None);
        assert!(Repetitions::Together.slope(&x, &[y, vec![1.0, 0.0, 1.0], vec![2.0; 3]]).is_some());
    }

    /// Share of intervals that contain the truth.
    fn coverage(interval: impl Fn(u64) -> Option<ConfidenceInterval>, truth: f64) -> f64 {
        let trials = 2000;
        let holds = |&trial: &u64| {
            let interval = interval(trial).expect("repetitions");
            interval.low <= truth && truth <= interval.high
        };
        (0..trials).filter(holds).count() as f64 / trials as f64
    }

    #[test]
    fn intervals_contain_the_truth_at_their_confidence_level() {
        // The standard deviation of a share of 2000 is 0.5 %.
        let x = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0];
        for repetitions in [Repetitions::Each, Repetitions::Together] {
            let share = coverage(|trial| repetitions.slope(&x, &errors(&x, -0.75, 8, trial)), -0.75);
            assert!((share - 0.95).abs() < 0.02, "{repetitions:?}: {share}");
        }
        let root = |trial| {
            let squares: Vec<f64> = errors(&[1.0], 0.0, 8, trial).iter().map(|row| row[0]).collect();
            Repetitions::Each.root_mean(&squares)
        };
        let share = coverage(root, 0.3);
        assert!((share - 0.95).abs() < 0.02, "{share}");
    }

    #[test]
    fn single_numbers_are_taken_together() {
        let x = [1.0, 4.0, 16.0];
        // Squares of normal numbers: the deviation falls as N^-1/2.
        let row = |trial, r| {
            (0..)
                .zip(x)
                .map(|(n, x)| {
                    let e = normal(&[trial, r, n]);
                    e * e / x
                })
                .collect()
        };
        let rows = |trial| (0..16).map(|r| row(trial, r)).collect::<Vec<Vec<f64>>>();
        let share = coverage(|trial| Repetitions::Together.slope(&x, &rows(trial)), -0.5);
        assert!((0.91..0.98).contains(&share), "{share}");
        let first = |trial| rows(trial).iter().map(|row| row[0]).collect::<Vec<_>>();
        let share = coverage(|trial| Repetitions::Together.root_mean(&first(trial)), 1.0);
        assert!((0.88..0.98).contains(&share), "{share}");
    }

    #[test]
    fn goals_are_reached_between_measurements() {
        let measured = [(1.0, 0.1), (4.0, 0.05), (16.0, 0.025)];
        let Some(TimeToError::At(seconds)) = time_to_error(&measured, 0.1 / 2f64.sqrt()) else { panic!("within") };
        assert!((seconds - 2.0).abs() < 1e-12, "{seconds}");
        assert_eq!(time_to_error(&measured, 0.2), Some(TimeToError::Before(1.0)));
        assert_eq!(time_to_error(&measured, 0.01), Some(TimeToError::NotWithin(16.0)));
        assert_eq!(time_to_error(&[(1.0, 0.1), (2.0, 0.0)], 0.01), Some(TimeToError::At(2.0)));
        assert_eq!(time_to_error(&[], 0.1), None);
    }
}
