//! Spans of queries, rounded for filters.

use rt_math::Interval;

use super::ray::SLACK;
use super::simd::Simd;

/// Span of a query, rounded for filters.
#[derive(Clone, Copy)]
pub(super) struct FilterTRange {
    /// Begin rounded down and up, end rounded down; the fourth is spare.
    numbers: [f32; 4],
}

impl FilterTRange {
    /// Applies [`round_down`](super::ray::round_down) and [`round_up`](super::ray::round_up) to a span of non-negative
    /// numbers.
    #[inline(always)]
    pub(super) fn new<S: Simd>(simd: S, span: Interval) -> Self {
        let Interval { min, max } = span;
        let (below, above, tiny) = (1.0 - SLACK, 1.0 + SLACK, f64::from(f32::MIN_POSITIVE));
        let numbers = simd.mul_f64(simd.f64x4([min, min, max, max]), simd.f64x4([below, above, below, below]));
        let numbers = simd.sub_f64(numbers, simd.f64x4([tiny, -tiny, tiny, tiny]));
        Self { numbers: simd.to_f32(simd.max_f64(numbers, simd.f64x4([0.0; 4]))) }
    }

    /// Begin, rounded down.
    #[inline(always)]
    pub(super) const fn min(&self) -> f32 {
        self.numbers[0]
    }

    #[inline(always)]
    pub(super) fn splat<S: Simd>(&self, simd: S) -> SpanLanes<S> {
        let [at_most_min, at_least_min, at_most_max, _] = self.numbers;
        SpanLanes { min: [simd.splat(at_most_min), simd.splat(at_least_min)], max: simd.splat(at_most_max) }
    }
}

/// SIMD version of [`FilterTRange`].
#[derive(Clone, Copy)]
pub(super) struct SpanLanes<S: Simd> {
    pub(super) min: [S::F32x8; 2],
    pub(super) max: S::F32x8,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wide::ray::{round_down, round_up};
    use crate::wide::simd::{DetectedSimd, SimdLevel, WithSimd};

    struct Make<'a>(&'a mut [f32; 4]);

    impl WithSimd<Interval, ()> for Make<'_> {
        #[inline(always)]
        fn run<S: Simd>(self, simd: S, span: Interval, (): ()) {
            *self.0 = FilterTRange::new(simd, span).numbers;
        }
    }

    #[test]
    fn spans_are_rounded_to_the_safe_side() {
        for t in [0.0, 5e-324, 1e-45, 1e-40, 1.2e-38, 1e-20, 0.1, 1.0 / 3.0, 1.0, 16_777_217.0, 3e38, f64::INFINITY] {
            for &level in SimdLevel::ALL {
                let mut numbers = [0.0; 4];
                DetectedSimd::new(level).dispatch(Make(&mut numbers), Interval::new(t, t), ());
                let [at_most_min, at_least_min, at_most_max, _] = numbers;
                assert_eq!([at_most_min, at_most_max], [round_down(t); 2], "{t}");
                assert!(f64::from(at_most_min) <= t && t <= f64::from(at_least_min), "{t}: {numbers:?}");
                assert!(f64::from(round_down(t)) <= t && t <= f64::from(round_up(t)), "{t}");
            }
        }
    }
}
