//! How coarse a picture must be to be there at once.

use std::time::Duration;

/// Time that a picture may take while the camera moves.
const AT_ONCE: Duration = Duration::from_millis(60);

/// Coarsest picture: pixels of a side.
const COARSEST: u32 = 16;

/// Side of a coarse pixel before anything is known of the scene.
const UNKNOWN: u32 = 8;

/// How quickly pixels have come lately.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pace {
    seconds_per_pixel: Option<f64>,
}

impl Pace {
    /// Learns that so many pixels, of one sample each, took so long.
    pub(super) fn learn(&mut self, pixels: usize, took: Duration) {
        self.seconds_per_pixel = Some(took.as_secs_f64() / pixels.max(1) as f64);
    }

    /// The side of the squares of which one pixel each is rendered, for a picture of this size to be there at once: a power of two.
    pub(super) fn coarseness(&self, [width, height]: [u32; 2]) -> u32 {
        let Some(seconds_per_pixel) = self.seconds_per_pixel else { return UNKNOWN };
        let is_quick = |side: &u32| {
            let pixels = f64::from(width.div_ceil(*side)) * f64::from(height.div_ceil(*side));
            pixels * seconds_per_pixel <= AT_ONCE.as_secs_f64()
        };
        let mut sides = core::iter::successors(Some(1), |side| Some(2 * side)).take_while(|side| *side < COARSEST);
        sides.find(is_quick).unwrap_or(COARSEST)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_as_fine_as_time_allows() {
        let mut pace = Pace::default();
        assert_eq!(pace.coarseness([640, 480]), UNKNOWN);
        for (micros, expected) in [(60_000, 1), (61_000, 2), (239_000, 2), (241_000, 4), (10_000_000, 16)] {
            pace.learn(640 * 480, Duration::from_micros(micros));
            assert_eq!(pace.coarseness([640, 480]), expected, "{micros}");
        }
        pace.learn(0, Duration::ZERO);
        assert_eq!(pace.coarseness([1, 1]), 1);
    }
}
