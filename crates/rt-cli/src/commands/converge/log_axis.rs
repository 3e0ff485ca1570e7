//! Logarithmic axis; coordinates are exponents of ten.

use core::f64::consts::LN_10;

use core::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use rt_math::transcendental::{log, pow};

/// Only decades are labelled above this range.
const MANY_DECADES: f64 = 2.5;

/// Range of exponents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LogAxis {
    pub(super) low: f64,
    pub(super) high: f64,
}

impl LogAxis {
    /// Axis of these exponents with a margin; `None` without exponents, or if one is not finite.
    pub(super) fn around(exponents: impl Iterator<Item = f64>, margin: f64) -> Option<Self> {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for exponent in exponents {
            if !exponent.is_finite() {
                return None;
            }
            (low, high) = (low.min(exponent), high.max(exponent));
        }
        (low <= high).then_some(Self { low: low - margin, high: high + margin })
    }

    /// Exponents of the numbers with these leading digits.
    fn marks(self, digits: &[f64]) -> Vec<f64> {
        let decades = self.low.floor() as i32..=self.high.ceil() as i32;
        let marks = decades.flat_map(|decade| digits.iter().map(move |&digit| f64::from(decade) + exponent(digit)));
        marks.filter(|mark| (self.low..=self.high).contains(mark)).collect()
    }
}

impl Ranged for LogAxis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, exponent: &f64, (start, end): (i32, i32)) -> i32 {
        // Keep distant points near the plot, but outside.
        let part = ((exponent - self.low) / (self.high - self.low)).clamp(-1.0, 2.0);
        start + (part * f64::from(end - start)).round() as i32
    }

    fn key_points<H: KeyPointHint>(&self, hint: H) -> Vec<f64> {
        if hint.weight().allow_light_points() {
            return self.marks(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]);
        }
        let has_many_decades = self.high - self.low > MANY_DECADES;
        self.marks(if has_many_decades { &[1.0] } else { &[1.0, 2.0, 5.0] })
    }

    fn range(&self) -> Range<f64> {
        self.low..self.high
    }
}

impl ValueFormatter<f64> for LogAxis {
    fn format_ext(&self, exponent: &f64) -> String {
        label(*exponent)
    }
}

/// Decimal logarithm.
pub(super) fn exponent(value: f64) -> f64 {
    log(value) / LN_10
}

/// Number of this exponent with one significant digit.
fn label(exponent: f64) -> String {
    if (-4.0..5.0).contains(&exponent) {
        let text = format!("{:.5}", pow(10.0, exponent));
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        format!("{:.0e}", pow(10.0, exponent))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_contain_all_numbers_and_a_margin() {
        assert_eq!(LogAxis::around([0.0, 2.0].into_iter(), 0.5), Some(LogAxis { low: -0.5, high: 2.5 }));
        for bad in [&[][..], &[f64::NEG_INFINITY, 1.0], &[f64::NAN], &[1.0, f64::INFINITY]] {
            assert_eq!(LogAxis::around(bad.iter().copied(), 0.1), None, "{bad:?}");
        }
    }

    #[test]
    fn infinitely_distant_points_are_drawn_outside() {
        let axis = LogAxis { low: 0.0, high: 1.0 };
        assert_eq!([0.0, 1.0, f64::NEG_INFINITY, f64::INFINITY].map(|at| axis.map(&at, (100, 0))), [100, 0, 200, -100]);
    }

    #[test]
    fn a_narrow_axis_has_few_marks_and_a_wide_one_decades() {
        let marks = |axis: LogAxis, digits: &[f64]| axis.marks(digits).into_iter().map(label).collect::<Vec<_>>();
        let narrow = LogAxis { low: exponent(0.015), high: exponent(0.06) };
        assert_eq!(marks(narrow, &[1.0, 2.0, 5.0]), ["0.02", "0.05"]);
        assert_eq!(marks(LogAxis { low: -6.5, high: -3.5 }, &[1.0]), ["1e-6", "1e-5", "0.0001"]);
    }
}
