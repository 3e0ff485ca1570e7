//! Coarseness of a preview that is rendered within a time budget.

use std::time::Duration;

/// Time that a preview may take.
const BUDGET: Duration = Duration::from_millis(60);

/// Largest side of a coarse pixel.
const COARSEST: u32 = 16;

/// Side of a coarse pixel before the first measurement.
const FIRST: u32 = 8;

/// Render time of a pixel, measured at the last preview.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct FrameBudget {
    seconds_per_pixel: Option<f64>,
}

impl FrameBudget {
    /// Notes the time that some pixels of one sample each took.
    pub(super) fn learn(&mut self, pixels: usize, took: Duration) {
        self.seconds_per_pixel = Some(took.as_secs_f64() / pixels.max(1) as f64);
    }

    /// Side of the coarse pixels for an image of this size to meet the budget, a power of two.
    pub(super) fn pixel_side(&self, [width, height]: [u32; 2]) -> u32 {
        let Some(seconds_per_pixel) = self.seconds_per_pixel else { return FIRST };
        let is_quick = |side: &u32| {
            let pixels = f64::from(width.div_ceil(*side)) * f64::from(height.div_ceil(*side));
            pixels * seconds_per_pixel <= BUDGET.as_secs_f64()
        };
        let mut sides = core::iter::successors(Some(1), |side| Some(2 * side)).take_while(|side| *side < COARSEST);
        sides.find(is_quick).unwrap_or(COARSEST)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn previews_are_as_fine_as_time_allows() {
        let mut budget = FrameBudget::default();
        assert_eq!(budget.pixel_side([640, 480]), FIRST);
        for (micros, expected) in [(60_000, 1), (61_000, 2), (239_000, 2), (241_000, 4), (10_000_000, 16)] {
            budget.learn(640 * 480, Duration::from_micros(micros));
            assert_eq!(budget.pixel_side([640, 480]), expected, "{micros}");
        }
        budget.learn(0, Duration::ZERO);
        assert_eq!(budget.pixel_side([1, 1]), 1);
    }
}
