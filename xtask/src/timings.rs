//! Repeated measurements of one figure.

use std::time::{Duration, Instant};

use cpu_time::ProcessTime;
use serde::Serialize;

use crate::error::TaskError;

/// CPU seconds of all threads, and wall seconds, of each run.
#[derive(Debug, Default)]
pub(crate) struct Timings {
    pub cpu: Vec<f64>,
    pub wall: Vec<f64>,
}

impl Timings {
    /// Measures up to `reps` runs, and no more after `patience`. Returns the result of the last one.
    pub(crate) fn of<T>(
        reps: u32,
        patience: Duration,
        mut run: impl FnMut() -> Result<T, TaskError>,
    ) -> Result<(T, Self), TaskError> {
        let (mut timings, started) = (Self::default(), Instant::now());
        loop {
            let (cpu, wall) = (ProcessTime::now(), Instant::now());
            let result = run()?;
            timings.cpu.push(cpu.elapsed().as_secs_f64());
            timings.wall.push(wall.elapsed().as_secs_f64());
            if timings.cpu.len() >= reps as usize || started.elapsed() > patience {
                return Ok((result, timings));
            }
        }
    }
}

/// Median, minimum and maximum of several measurements; NaN without any.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Spread {
    pub median: f64,
    pub min: f64,
    pub max: f64,
}

impl Spread {
    /// Sorts at least one measurement.
    pub(crate) fn of(mut figures: Vec<f64>) -> Self {
        figures.sort_by(f64::total_cmp);
        let at = |index: usize| figures.get(index).copied().unwrap_or(f64::NAN);
        Self { median: at(figures.len() / 2), min: at(0), max: at(figures.len().saturating_sub(1)) }
    }

    /// `MEDIAN (MIN..MAX)`.
    pub(crate) fn shown(self, number: impl Fn(f64) -> String) -> String {
        format!("{} ({}..{})", number(self.median), number(self.min), number(self.max))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_spread_does_not_depend_on_the_order() {
        assert_eq!(Spread::of(vec![3.0, 1.0, 2.0]), Spread { median: 2.0, min: 1.0, max: 3.0 });
        assert_eq!(Spread::of(vec![5.0]), Spread { median: 5.0, min: 5.0, max: 5.0 });
        assert!(Spread::of(Vec::new()).median.is_nan());
    }
}
