//! Counts of trials and failures.

use std::{fmt::Display, mem};

use rayon::prelude::*;
use rt_math::float::UNIT_ROUNDOFF;
use rt_tests::Draw;

/// Failures that are described; further ones are only counted.
const DESCRIBED: usize = 5;
/// Checks that a thread makes in one go.
const BLOCK: u64 = 512;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Tolerance {
    /// Bit-identical, but for the sign of 0.
    Bits,
    /// Relative to what is expected.
    Relative(f64),
    Absolute(f64),
}

/// Four times the unit roundoff: two steps from number to number.
pub(super) const FOUR_U: Tolerance = Tolerance::Relative(4.0 * UNIT_ROUNDOFF);

/// Counts of trials and failures.
#[derive(Debug, Default)]
pub(super) struct Checks {
    pub tried: u64,
    pub failed: u64,
    /// Maximum error, in the measure of the tolerance.
    pub worst: Option<f64>,
    /// The first failures.
    pub problems: Vec<String>,
    pub notes: Vec<String>,
}

impl Checks {
    /// Counts a condition.
    pub(super) fn check(&mut self, holds: bool, problem: impl FnOnce() -> String) {
        self.tried += 1;
        if !holds {
            self.failed += 1;
            if self.problems.len() < DESCRIBED {
                self.problems.push(problem());
            }
        }
    }

    /// Counts an error, which fails beyond the limit or as NaN.
    pub(super) fn limit(&mut self, error: f64, limit: f64, what: impl Display) {
        let size = if error.is_nan() { f64::INFINITY } else { error.abs() };
        self.worst = Some(self.worst.unwrap_or(0.0).max(size));
        self.check(size <= limit, || format!("{what}: off by {error:e}"));
    }

    /// Compares a number with the expected one.
    pub(super) fn near(&mut self, computed: f64, expected: f64, tolerance: Tolerance, what: impl Display) {
        let what = format_args!("{what}: {computed:?} instead of {expected:?}");
        match tolerance {
            // Infinities are equal, though their difference is no number.
            _ if computed == expected => self.limit(0.0, 0.0, what),
            Tolerance::Bits => self.limit(computed - expected, 0.0, what),
            Tolerance::Relative(limit) => self.limit((computed - expected) / expected, limit, what),
            Tolerance::Absolute(limit) => self.limit(computed - expected, limit, what),
        }
    }

    /// Compares like [`near`](Self::near); a miss is a failure.
    pub(super) fn hit(&mut self, computed: Option<f64>, expected: f64, tolerance: Tolerance, what: impl Display) {
        match computed {
            Some(computed) => self.near(computed, expected, tolerance, what),
            None => self.check(false, || format!("{what}: a miss instead of {expected:?}")),
        }
    }

    /// Compares for equality.
    pub(super) fn same<T: PartialEq + std::fmt::Debug>(&mut self, computed: T, expected: T, what: impl Display) {
        let holds = computed == expected;
        self.check(holds, || format!("{what}: {computed:?} instead of {expected:?}"));
    }

    pub(super) fn note(&mut self, note: impl Into<String>) {
        self.notes.push(note.into());
    }

    /// Sums of both.
    fn and(mut self, other: Self) -> Self {
        self.tried += other.tried;
        self.failed += other.failed;
        self.worst = match (self.worst, other.worst) {
            (Some(a), Some(b)) => Some(a.max(b)),
            (a, b) => a.or(b),
        };
        let left = DESCRIBED.saturating_sub(self.problems.len());
        self.problems.extend(other.problems.into_iter().take(left));
        self.notes.extend(other.notes);
        self
    }

    /// Adds the checks of items 0 to `count` − 1, made on all threads.
    pub(super) fn of_all(&mut self, count: u64, check: impl Fn(u64, &mut Self) + Sync) {
        self.in_parallel(count, &check);
    }

    /// [`of_all`](Self::of_all), with the random numbers of each item.
    pub(super) fn draw_all(&mut self, count: u64, seed: u64, check: impl Fn(&mut Draw, &mut Self) + Sync) {
        self.in_parallel(count, &|index, checks| check(&mut Draw::of(seed, index), checks));
    }

    /// [`of_all`](Self::of_all), compiled once for all cases.
    fn in_parallel(&mut self, count: u64, check: &(dyn Fn(u64, &mut Self) + Sync)) {
        let all = (0..count.div_ceil(BLOCK))
            .into_par_iter()
            .map(|block| {
                let mut checks = Self::default();
                for index in block * BLOCK..count.min((block + 1) * BLOCK) {
                    check(index, &mut checks);
                }
                checks
            })
            .reduce(Self::default, Self::and);
        *self = mem::take(self).and(all);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_measured_as_the_tolerance_says() {
        let mut checks = Checks::default();
        checks.near(8.0, 8.0, Tolerance::Bits, "same");
        checks.near(0.0, -0.0, Tolerance::Bits, "zeros");
        checks.near(f64::INFINITY, f64::INFINITY, FOUR_U, "infinities");
        checks.near(8.0 * (1.0 + 1e-9), 8.0, Tolerance::Relative(1e-8), "relative");
        assert_eq!((checks.tried, checks.failed), (4, 0));
        assert!((checks.worst.unwrap() - 1e-9).abs() < 1e-15);
        checks.near(8.5, 8.0, Tolerance::Absolute(0.25), "absolute");
        checks.near(1f64.next_up(), 1.0, Tolerance::Bits, "next");
        checks.near(f64::NAN, 1.0, Tolerance::Absolute(9.0), "no number");
        checks.hit(None, 1.0, FOUR_U, "nothing");
        assert_eq!((checks.tried, checks.failed, checks.worst), (8, 4, Some(f64::INFINITY)));
        assert_eq!(checks.problems.len(), 4);
        assert_eq!(checks.problems[3], "nothing: a miss instead of 1.0");
    }

    #[test]
    fn all_items_are_checked_once_and_the_first_failures_described() {
        let mut checks = Checks::default();
        checks.of_all(10_000, |index, checks| {
            checks.check(index % 1000 != 999, || index.to_string());
            checks.limit(index as f64, f64::INFINITY, index);
        });
        assert_eq!((checks.tried, checks.failed, checks.worst), (20_000, 10, Some(9999.0)));
        assert_eq!(checks.problems, ["999", "1999", "2999", "3999", "4999"]);
    }
}
