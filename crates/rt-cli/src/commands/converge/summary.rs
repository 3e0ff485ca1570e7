//! Results of an experiment: per sample count, and per method.

use serde::Serialize;

use super::methods::MethodName;
use super::reference::{Floor, Reference};
use super::runner::{Experiment, Measured, Point, Run};
use super::statistics::{ConfidenceInterval, Repetitions, TimeToError, mean, mean_and_error, median, time_to_error};

/// Minimum ratio of a trusted squared error to that of the reference.
pub(super) const TRUSTED: f64 = 3.0;

#[derive(Clone, Debug, Serialize)]
pub(super) struct Summary {
    pub(super) methods: Vec<MethodSummary>,
    #[serde(rename = "error_goal")]
    pub(super) target_rmse: f64,
}

#[derive(Clone, Debug, Serialize)]
pub(super) struct MethodSummary {
    #[serde(flatten)]
    pub(super) name: MethodName,
    pub(super) points: Vec<PointSummary>,
    /// Slope of log RMSE against log samples per pixel.
    pub(super) slope_of_samples: Option<ConfidenceInterval>,
    /// Slope of log RMSE against log seconds.
    pub(super) slope_of_seconds: Option<ConfidenceInterval>,
    /// Time to the target RMSE.
    #[serde(rename = "arrival")]
    pub(super) time_to_error: Option<TimeToError>,
}

#[derive(Clone, Debug, Serialize)]
pub(super) struct PointSummary {
    pub(super) spp: u32,
    /// Root of the mean squared error over all seeds minus that of the reference; `None` if negative.
    pub(super) rmse: Option<f64>,
    /// RMSE of the median over the seeds, which is robust to fireflies.
    pub(super) rmse_median: Option<f64>,
    /// Mean of log RMSE over the seeds and its interval, as errors.
    pub(super) rmse_interval: Option<ConfidenceInterval>,
    pub(super) relative_mse: f64,
    pub(super) bias: f64,
    /// Includes the error of the reference.
    pub(super) bias_standard_error: f64,
    pub(super) flip: Option<f64>,
    /// Processor seconds of rendering, the median over the seeds.
    pub(super) seconds: f64,
    pub(super) wall_seconds: f64,
    pub(super) build_seconds: f64,
    /// 1 / (MSE · seconds).
    pub(super) efficiency: Option<f64>,
    /// False if the error is too close to that of the reference to be plotted and fitted.
    pub(super) is_trusted: bool,
    pub(super) runs: Vec<Run>,
}

/// Influence of the reference on the measurements.
#[derive(Clone, Copy, Debug)]
pub(super) struct Precision {
    floor: Floor,
    /// Smallest trusted squared error.
    min_mse: f64,
    repetitions: Repetitions,
}

impl Precision {
    pub(super) fn of(reference: &Reference) -> Self {
        let floor = reference.floor().unwrap_or(Floor { mse: 0.0, relative_mse: 0.0, mean_error: 0.0 });
        let min_mse = TRUSTED * floor.mse.max(reference.resolution());
        Self { floor, min_mse, repetitions: reference.repetitions() }
    }
}

impl Summary {
    /// Summary of an experiment. The target is by default the lowest RMSE that all methods reach.
    pub(super) fn new(experiment: &Experiment, precision: Precision, target_rmse: Option<f64>) -> Self {
        let points = |measured: &Measured| -> Vec<_> {
            measured.points.iter().map(|point| PointSummary::new(point, precision)).collect()
        };
        let points: Vec<Vec<PointSummary>> = experiment.methods.iter().map(points).collect();
        let target_rmse = target_rmse.unwrap_or_else(|| common_error(&points));
        let methods = experiment.methods.iter().zip(points);
        let methods =
            methods.map(|(measured, points)| MethodSummary::new(measured.name.clone(), points, precision, target_rmse));
        Self { methods: methods.collect(), target_rmse }
    }
}

/// Lowest error that all methods reach.
fn common_error(methods: &[Vec<PointSummary>]) -> f64 {
    let best = |points: &Vec<PointSummary>| {
        points.iter().filter(|point| point.is_trusted).filter_map(|point| point.rmse).fold(f64::INFINITY, f64::min)
    };
    methods.iter().map(best).filter(|error| error.is_finite()).fold(0.0, f64::max)
}

impl MethodSummary {
    fn new(name: MethodName, points: Vec<PointSummary>, precision: Precision, target: f64) -> Self {
        let fitted: Vec<&PointSummary> = points.iter().filter(|point| point.is_trusted).collect();
        let seeds = fitted.first().map_or(0, |point| point.runs.len());
        let of_seed = |seed: usize| -> Vec<f64> {
            fitted.iter().map(|point| point.runs[seed].errors.mse - precision.floor.mse).collect()
        };
        let errors: Vec<Vec<f64>> = (0..seeds).map(of_seed).collect();
        let against = |x: &dyn Fn(&PointSummary) -> f64| {
            precision.repetitions.slope(&fitted.iter().map(|point| x(point)).collect::<Vec<_>>(), &errors)
        };
        let measured: Vec<_> = fitted.iter().filter_map(|point| Some((point.seconds, point.rmse?))).collect();
        Self {
            slope_of_samples: against(&|point| f64::from(point.spp)),
            slope_of_seconds: against(&|point| point.seconds),
            time_to_error: time_to_error(&measured, target),
            name,
            points,
        }
    }
}

impl PointSummary {
    fn new(point: &Point, precision: Precision) -> Self {
        let floor = precision.floor;
        let of = |value: fn(&Run) -> f64| -> Vec<f64> { point.runs.iter().map(value).collect() };
        let mses: Vec<f64> = point.runs.iter().map(|run| run.errors.mse - floor.mse).collect();
        let mse = mean(&mses);
        let seconds = median(&of(|run| run.cpu_seconds));
        let rmse_interval = precision.repetitions.root_mean(&mses);
        let (bias, spread) = mean_and_error(&of(|run| run.errors.bias)).unwrap_or((f64::NAN, f64::NAN));
        let root = |mse: f64| (mse >= 0.0).then(|| mse.sqrt());
        Self {
            spp: point.spp,
            rmse: root(mse),
            rmse_median: root(median(&mses)),
            rmse_interval,
            relative_mse: mean(&of(|run| run.errors.relative_mse)) - floor.relative_mse,
            bias,
            bias_standard_error: (spread * spread + floor.mean_error * floor.mean_error).sqrt(),
            flip: point.flip,
            seconds,
            wall_seconds: median(&of(|run| run.wall_seconds)),
            build_seconds: median(&of(|run| run.build_seconds)),
            efficiency: Some(1.0 / (mse * seconds)).filter(|efficiency| efficiency.is_finite() && *efficiency > 0.0),
            is_trusted: mse >= precision.min_mse && rmse_interval.is_some(),
            runs: point.runs.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use rt_math::transcendental::{hypot, pow};

    use super::super::reference::Errors;
    use super::*;

    fn name(label: &str) -> MethodName {
        let choices = vec![("sampler".to_owned(), label.to_owned())];
        MethodName {
            label: label.to_owned(),
            choices,
            integrator: "whitted",
            sampler: "sobol",
            accel: "auto",
            depth: 5,
        }
    }

    /// Errors of c N^slope with 2 % spread between seeds, plus this floor; one microsecond per sample.
    fn measured(label: &str, slope: f64, floor: f64) -> Measured {
        let point = |spp: u32| {
            let run = |seed: u64| {
                let rmse = 0.1 * pow(f64::from(spp), slope) * (1.0 + 0.02 * (seed as f64 - 3.5));
                let errors = Errors { mse: rmse * rmse + floor, relative_mse: 10.0 * floor, bias: 0.001 * seed as f64 };
                let cpu_seconds = f64::from(spp) * 1e-6;
                Run { seed, errors, cpu_seconds, wall_seconds: cpu_seconds, build_seconds: 0.0 }
            };
            Point { spp, runs: (0..8).map(run).collect(), flip: None }
        };
        Measured { name: name(label), points: [1, 4, 16, 64, 256].map(point).to_vec(), images: [None, None] }
    }

    fn precision(floor: Floor) -> Precision {
        Precision { floor, min_mse: TRUSTED * floor.mse, repetitions: Repetitions::Each }
    }

    const EXACT: Floor = Floor { mse: 0.0, relative_mse: 0.0, mean_error: 0.0 };

    fn experiment(methods: Vec<Measured>) -> Experiment {
        Experiment { methods, left_out: Vec::new(), is_interrupted: false, bad_samples: 0, threads: 1 }
    }

    #[test]
    fn the_floor_is_subtracted_and_points_near_it_are_not_trusted() {
        let floor = Floor { mse: 1e-6, relative_mse: 1e-5, mean_error: 0.003 };
        let summary = Summary::new(&experiment(vec![measured("a", -0.75, floor.mse)]), precision(floor), None);
        let method = &summary.methods[0];
        for point in &method.points {
            let expected = 0.1 * pow(f64::from(point.spp), -0.75);
            let rmse = point.rmse.expect("above the floor");
            // The mean of squares is greater than the square of the mean by the variance of the factor, 0.002.
            assert!((rmse / expected - 1.0).abs() < 0.003, "{point:?}");
            assert_eq!(point.is_trusted, expected * expected > 3e-6, "{point:?}");
            assert!(point.relative_mse.abs() < 1e-18, "{point:?}");
            let spread = 0.001 * (6.0f64 / 8.0).sqrt();
            assert!((point.bias_standard_error - hypot(spread, 0.003)).abs() < 1e-12, "{point:?}");
        }
        assert!(method.points[2].is_trusted && !method.points[4].is_trusted);
        let slope = method.slope_of_samples.expect("three points");
        assert!((slope.mean + 0.75).abs() < 1e-6 && slope.low <= slope.mean && slope.mean <= slope.high, "{slope:?}");
    }

    #[test]
    fn a_floor_that_is_kept_flattens_the_slope() {
        let summary = Summary::new(&experiment(vec![measured("a", -0.75, 1e-5)]), precision(EXACT), None);
        let slope = summary.methods[0].slope_of_samples.expect("five points");
        assert!(slope.mean > -0.65, "{slope:?}");
    }

    #[test]
    fn the_goal_is_what_all_reach_unless_it_is_given() {
        let methods = || vec![measured("fast", -1.0, 0.0), measured("slow", -0.5, 0.0)];
        let summary = Summary::new(&experiment(methods()), precision(EXACT), None);
        assert_eq!(Some(summary.target_rmse), summary.methods[1].points[4].rmse);
        let Some(TimeToError::At(fast)) = summary.methods[0].time_to_error else {
            panic!("{:?}", summary.methods[0].time_to_error)
        };
        // 256^-0.5 = 16^-1.
        assert!((fast / 16e-6 - 1.0).abs() < 1e-6, "{fast}");
        let given = Summary::new(&experiment(methods()), precision(EXACT), Some(1e-9));
        assert_eq!(given.methods[0].time_to_error, Some(TimeToError::NotWithin(256e-6)));
    }

    #[test]
    fn efficiency_is_the_inverse_of_squared_error_times_seconds() {
        let summary = Summary::new(&experiment(vec![measured("a", -0.5, 0.0)]), precision(EXACT), None);
        for point in &summary.methods[0].points {
            let rmse = point.rmse.expect("positive");
            let product = point.efficiency.expect("positive") * rmse * rmse * point.seconds;
            assert!((product - 1.0).abs() < 1e-12, "{point:?}");
        }
    }
}
