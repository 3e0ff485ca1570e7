//! When a render that goes on pass after pass has enough.

use std::time::Duration;

use rt_camera::SamplePattern;
use serde::{Deserialize, Serialize};

use crate::RenderError;

/// What ends a render of passes over the whole image: whichever of these comes first. At least one pass is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StopRule {
    /// Wall-clock time to render. A pass begins only if it will be over in time, judged by the pass before.
    pub time: Option<Duration>,
    /// The error to reach in every pixel. With one, pixels that have reached it take no more samples.
    pub target: Option<TargetError>,
    /// Most samples of a pixel, at least 1.
    pub max_spp: u32,
}

impl StopRule {
    /// Most samples of a pixel unless something else is said.
    pub const DEFAULT_MAX_SPP: u32 = 1 << 20;
}

impl Default for StopRule {
    /// The largest number of samples, however long it takes.
    fn default() -> Self {
        Self { time: None, target: None, max_spp: Self::DEFAULT_MAX_SPP }
    }
}

/// How sure a pixel has to be of its radiance m, in each channel: with a confidence of 95 %, the truth lies within
/// ± `relative` · (m + 0.01).
///
/// Whether it does is tested when 64, 128, 256, … samples have been taken, by Student's t. A pixel goes on as long as one of
/// its eight neighbours does: what it has missed, they may have seen.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TargetError {
    /// The error, as a share of radiance; finite and above 0.
    pub relative: f64,
    /// Samples that decide when to stop are no impartial witnesses: they are too sure of themselves where they happen to agree
    /// (Kirk and Arvo 1991). If set, they only decide how many samples each pixel takes, and the picture is made of as many
    /// new ones (Stein 1945); what time there is, is shared.
    pub two_stage: bool,
}

/// What ended a render.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Stopped {
    /// All samples that were asked for, or as many as a pixel may have.
    Samples,
    /// Another pass would not have been over in time.
    Time,
    /// All pixels have reached the error that was asked for.
    Target,
    /// [`RunOptions::interrupt`](crate::RunOptions) was set.
    Interrupted,
}

impl StopRule {
    /// Checks the numbers.
    ///
    /// # Errors
    /// [`RenderError::TargetError`] and [`RenderError::NoSamples`].
    pub(crate) fn validate(&self) -> Result<(), RenderError> {
        match self.target {
            Some(TargetError { relative, .. }) if !(relative.is_finite() && relative > 0.0) => {
                Err(RenderError::TargetError(relative))
            }
            _ if self.max_spp == 0 => Err(RenderError::NoSamples),
            _ => Ok(()),
        }
    }

    /// Samples of pass number `pass`, if each pixel has `taken` so many; `None` if it has all that it may.
    pub(crate) fn pass_spp(&self, pattern: SamplePattern, pass: u32, taken: u32) -> Option<u32> {
        let left = self.max_spp.saturating_sub(taken);
        let wanted = if self.target.is_some() { self.testable_spp(pass) } else { growing_spp(pass) };
        let spp = pattern.round_up(wanted.min(left.max(1)));
        (pass == 0 || spp <= left).then_some(spp)
    }

    /// Eight passes between tests, after each of which the number of samples has doubled. Fewer passes would leave
    /// the error uncertain, and with sixteen samples to begin with, instead of 64, a part of a tenth of the pixel would go
    /// unnoticed one time in five.
    fn testable_spp(&self, pass: u32) -> u32 {
        let first = (self.max_spp / PASSES_BETWEEN_TESTS).clamp(1, FIRST_TEST / PASSES_BETWEEN_TESTS);
        let doublings = (pass / PASSES_BETWEEN_TESTS).saturating_sub(1);
        first.checked_shl(doublings).filter(|spp| spp >> doublings == first).unwrap_or(u32::MAX)
    }
}

/// Passes from one test of convergence to the next.
pub(crate) const PASSES_BETWEEN_TESTS: u32 = 8;

/// Samples of a pixel when it is tested for the first time.
const FIRST_TEST: u32 = 64;

/// 1, 1, 2, 4, 8, and then always 16: a first picture soon, and then passes that patterns are good for.
const fn growing_spp(pass: u32) -> u32 {
    match pass {
        0 | 1 => 1,
        2..5 => 1 << (pass - 1),
        _ => 16,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sizes(rule: &StopRule, pattern: SamplePattern) -> Vec<u32> {
        let (mut sizes, mut taken) = (Vec::new(), 0);
        while let Some(spp) = rule.pass_spp(pattern, sizes.len() as u32, taken) {
            sizes.push(spp);
            taken += spp;
        }
        sizes
    }

    #[test]
    fn passes_grow_to_sixteen_samples_and_stop_at_the_bound() {
        let of = |max_spp, pattern| sizes(&StopRule { max_spp, ..StopRule::default() }, pattern);
        assert_eq!(of(50, SamplePattern::Random), [1, 1, 2, 4, 8, 16, 16, 2]);
        assert_eq!(of(64, SamplePattern::Sobol), [1, 1, 2, 4, 8, 16, 16, 16]);
        assert_eq!(of(20, SamplePattern::Jittered), [1, 1, 4, 4, 9, 1]);
        assert_eq!(of(1, SamplePattern::Sobol), [1]);
    }

    #[test]
    fn samples_double_between_tests() {
        let target = Some(TargetError { relative: 0.01, two_stage: false });
        let of = |max_spp, pattern| sizes(&StopRule { max_spp, target, time: None }, pattern);
        let sobol = of(1024, SamplePattern::Sobol);
        let at_tests: Vec<u32> = (1..=5).map(|test| sobol[..8 * test].iter().sum()).collect();
        assert_eq!(at_tests, [64, 128, 256, 512, 1024]);
        assert_eq!(sobol.len(), 40);
        assert_eq!(of(16, SamplePattern::Halton), [2; 8]);
        assert_eq!(of(3, SamplePattern::Halton), [1; 3]);
    }

    #[test]
    fn numbers_that_are_no_errors_are_refused() {
        for relative in [0.0, -0.01, f64::NAN, f64::INFINITY] {
            let rule = StopRule { target: Some(TargetError { relative, two_stage: false }), ..StopRule::default() };
            assert!(matches!(rule.validate(), Err(RenderError::TargetError(_))), "{relative}");
        }
        assert!(matches!(StopRule { max_spp: 0, ..StopRule::default() }.validate(), Err(RenderError::NoSamples)));
        assert!(StopRule::default().validate().is_ok());
    }
}
