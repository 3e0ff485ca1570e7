//! Adaptive sampling in image space: passes over the pixels that are not yet sure of what they show.

use std::time::Duration;

use crate::{
    Progress, Stopped, TargetError, estimate::PixelEstimate, passes::PixelMask, progressive::Progressive,
    quantile::student_t, stop::PASSES_BETWEEN_TESTS, tiles::Tile,
};

/// Number of the first pass whose samples nothing was decided by.
const SECOND_STAGE: u32 = 1 << 31;

/// Added to radiance, so that black pixels can be sure of it as well.
const DARK: f64 = 0.01;

impl TargetError {
    const CONFIDENCE: f64 = 0.95;

    /// How much too wide a pixel's interval is, in the channel where it is worst: up to 1, the pixel has converged.
    fn excess(&self, pixel: &PixelEstimate, student: f64) -> f64 {
        let Some(variance) = pixel.variance() else { return f64::INFINITY };
        let excess = |variance: f64, mean: f64| student * variance.sqrt() / (self.relative * (mean.max(0.0) + DARK));
        let channels = variance.to_array().into_iter().zip(pixel.mean().to_array());
        channels.map(|(variance, mean)| excess(variance, mean)).fold(0.0, f64::max)
    }
}

impl<F: FnMut(Progress)> Progressive<'_, F> {
    /// Takes passes until all pixels have reached the error, or there is no more time, or no pixel may have more samples. The
    /// second result is how many have not reached it.
    pub(crate) fn refine(&mut self, target: TargetError) -> (Stopped, u64) {
        let Some(time) = self.rule.time.filter(|_| target.two_stage) else {
            let end = self.decide(target, self.rule.time);
            return if target.two_stage { self.repeat(end, None) } else { end };
        };
        let end = self.decide(target, Some(time / 2));
        self.repeat(end, Some(time))
    }

    /// Samples all pixels until they have converged.
    fn decide(&mut self, target: TargetError, time: Option<Duration>) -> (Stopped, u64) {
        let mut mask = None;
        let mut active = vec![true; self.pixels.len()];
        let (mut wanted, mut taken) = (active.len(), 0);
        let mut cause = Stopped::Samples;
        let mut pass = 0;
        while let Some(spp) = self.pass_spp(pass, taken) {
            if pass > 0 && !self.is_in_time(spp, wanted, time) {
                cause = Stopped::Time;
                break;
            }
            self.take_pass(pass, spp, mask.as_ref());
            (pass, taken) = (pass + 1, taken + spp);
            if pass.is_multiple_of(PASSES_BETWEEN_TESTS) {
                let unconverged = self.unconverged(target, &active, pass);
                active = neighbourhood(&unconverged, &active, self.part());
                wanted = active.iter().filter(|&&active| active).count();
                if wanted == 0 {
                    return (Stopped::Target, 0);
                }
                mask = Some(PixelMask::new(self.part(), active.clone()));
            }
        }
        match self.unconverged(target, &active, pass).into_iter().filter(|&missing| missing).count() {
            0 => (Stopped::Target, 0),
            missing => (cause, missing as u64),
        }
    }

    /// The active pixels that have not reached the error, all of which have taken so many passes.
    fn unconverged(&mut self, target: TargetError, active: &[bool], passes: u32) -> Vec<bool> {
        let student =
            if passes > 1 { student_t(TargetError::CONFIDENCE, f64::from(passes - 1)) } else { f64::INFINITY };
        // The error falls as the square root of the number of samples, or faster.
        let mut needed = self.samples() as f64;
        let of = |(pixel, &active): (&PixelEstimate, &bool)| {
            let excess = if active { target.excess(pixel, student) } else { 0.0 };
            if excess > 1.0 {
                let more = f64::from(pixel.samples()) * (excess * excess - 1.0);
                needed += more.min(f64::from(self.rule.max_spp.saturating_sub(pixel.samples())));
            }
            excess > 1.0
        };
        let unconverged = self.pixels.iter().zip(active).map(of).collect();
        self.expected_samples = Some(needed as u64);
        unconverged
    }

    /// Takes as many passes of each pixel as decided, from new samples.
    fn repeat(&mut self, (stopped, unconverged): (Stopped, u64), time: Option<Duration>) -> (Stopped, u64) {
        let decided: Vec<_> = self.pixels.iter().map(PixelEstimate::passes).collect();
        self.pixels.fill(PixelEstimate::default());
        let last = decided.iter().copied().max().unwrap_or(0);
        let mut taken = 0;
        for pass in 0..last {
            let active: Vec<_> = decided.iter().map(|&passes| passes > pass).collect();
            let wanted = active.iter().filter(|&&active| active).count();
            let Some(spp) = self.pass_spp(pass, taken) else { break };
            if pass > 0 && !self.is_in_time(spp, wanted, time) {
                return (Stopped::Time, wanted.max(unconverged as usize) as u64);
            }
            self.take_pass(SECOND_STAGE | pass, spp, Some(&PixelMask::new(self.part(), active)));
            taken += spp;
        }
        (stopped, unconverged)
    }
}

/// The pixels among those that are active which have an unconverged one in the square of nine around them.
fn neighbourhood(unconverged: &[bool], active: &[bool], part: Tile) -> Vec<bool> {
    let (width, height) = (part.width as usize, part.height as usize);
    let row_of_three =
        |x: usize, y: usize| unconverged[y * width..][x.saturating_sub(1)..width.min(x + 2)].contains(&true);
    let near = |x: usize, y: usize| (y.saturating_sub(1)..height.min(y + 2)).any(|y| row_of_three(x, y));
    (0..active.len()).map(|index| active[index] && near(index % width, index / width)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_go_on_if_they_are_still_active() {
        let part = Tile { x: 5, y: 7, width: 4, height: 3 };
        let mut unconverged = vec![false; 12];
        unconverged[4] = true;
        let near = [true, true, false, false];
        assert_eq!(neighbourhood(&unconverged, &[true; 12], part), near.repeat(3));
        let mut active = [true; 12];
        active[1] = false;
        let mut expected = near.repeat(3);
        expected[1] = false;
        assert_eq!(neighbourhood(&unconverged, &active, part), expected);
        assert_eq!(neighbourhood(&[false; 12], &[true; 12], part), [false; 12]);
    }
}
