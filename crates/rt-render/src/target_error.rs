//! Rendering to a target error: passes over the whole image, or over unconverged pixels (adaptive sampling in image space).

use std::time::Duration;

use crate::{
    Criterion, Crop, Stopped, TargetError,
    film::pixel_estimate::PixelEstimate,
    pass_state::{PassCursor, RefineStage},
    passes::PixelMask,
    progressive::Progressive,
    stop::{FIRST_TEST_OF_IMAGE, PASSES_BETWEEN_TESTS},
};
use rt_math::stats::student_t;

/// Minimum samples per pixel before an estimated error of zero counts. Fewer samples can miss rare light.
const MIN_SPP_WITHOUT_NOISE: f64 = 64.0;

/// Added to radiance, so that black pixels can converge.
const RADIANCE_EPSILON: f64 = 0.01;

impl TargetError {
    const CONFIDENCE: f64 = 0.95;

    /// Width of the confidence interval of a pixel over the target, in the worst channel. At most 1 for converged pixels.
    fn excess(&self, pixel: &PixelEstimate, student: f64) -> f64 {
        let Some(variance) = pixel.variance() else { return f64::INFINITY };
        let excess =
            |variance: f64, mean: f64| student * variance.sqrt() / (self.relative * (mean.max(0.0) + RADIANCE_EPSILON));
        let channels = variance.to_array().into_iter().zip(pixel.mean().to_array());
        channels.map(|(variance, mean)| excess(variance, mean)).fold(0.0, f64::max)
    }
}

impl Progressive<'_> {
    /// Renders passes until the target error, the time limit or the maximum number of samples is reached. The second result is
    /// the number of unconverged pixels; `None` with [`Criterion::Image`].
    pub(crate) fn refine(&mut self, target: TargetError) -> (Stopped, Option<u64>) {
        let time = self.rule.time;
        if !target.takes_new_samples(self.state.pixels.len()) {
            return self.refine_stage(target, time, 1.0);
        }
        if !matches!(self.state.cursor.stage, RefineStage::Repeat(..)) {
            let end = self.refine_stage(target, time.map(|time| time / 2), 2.0);
            if end.0 == Stopped::Interrupted {
                return end;
            }
            let decided = self.state.pixels.iter().map(PixelEstimate::passes).collect();
            self.state.pixels.fill(PixelEstimate::default());
            self.state.cursor =
                PassCursor { stage: RefineStage::Repeat(decided, end.0, end.1.unwrap_or(0)), ..PassCursor::default() };
        }
        let (stopped, unconverged) = self.repeat(time);
        (stopped, Some(unconverged))
    }

    /// Renders the passes that determine the number of samples. The whole render has `stages` times as many samples.
    fn refine_stage(&mut self, target: TargetError, time: Option<Duration>, stages: f64) -> (Stopped, Option<u64>) {
        match target.criterion {
            Criterion::Image => (self.refine_image(target.relative, time, stages), None),
            Criterion::Pixels { share } => {
                let (stopped, unconverged) = self.refine_pixels(target, share, time, stages);
                (stopped, Some(unconverged))
            }
        }
    }

    /// Samples all pixels until the error of the image reaches the target.
    fn refine_image(&mut self, relative: f64, time: Option<Duration>, stages: f64) -> Stopped {
        let pixels = self.state.pixels.len();
        let max_samples = stages * pixels as f64 * f64::from(self.rule.max_spp);
        while let Some(spp) = self.pass_spp() {
            if !self.is_in_time(spp, pixels, time) {
                return Stopped::Time;
            }
            if self.take_pass(spp, None).is_break() {
                return Stopped::Interrupted;
            }
            if let Some(error) = self.relative_rmse().filter(|_| self.state.cursor.pass >= FIRST_TEST_OF_IMAGE) {
                let samples = self.samples() as f64;
                let may_lack_light = error == 0.0 && samples < MIN_SPP_WITHOUT_NOISE * pixels as f64;
                if error <= relative && !may_lack_light {
                    return Stopped::Target;
                }
                self.forecast.observe([samples, stages], error, relative, max_samples);
            }
        }
        Stopped::Samples
    }

    /// Flags of the active pixels: those that may still be unconverged.
    fn active(&self) -> Vec<bool> {
        match &self.state.cursor.stage {
            RefineStage::Decide(active) => active.clone(),
            RefineStage::Everywhere | RefineStage::Repeat(..) => vec![true; self.state.pixels.len()],
        }
    }

    /// Samples the active pixels until this share of all pixels has converged.
    fn refine_pixels(
        &mut self,
        target: TargetError,
        share: f64,
        time: Option<Duration>,
        stages: f64,
    ) -> (Stopped, u64) {
        // The epsilon keeps rounding from reducing the number of allowed pixels.
        let allowed = ((1.0 - share) * self.state.pixels.len() as f64 + 1e-6) as usize;
        let mut cause = Stopped::Samples;
        let mut active = self.active();
        let mut active_count = count(&active);
        let mut mask = (active_count < active.len()).then(|| PixelMask::new(self.area(), active.clone()));
        while let Some(spp) = self.pass_spp() {
            if !self.is_in_time(spp, active_count, time) {
                cause = Stopped::Time;
                break;
            }
            if self.take_pass(spp, mask.as_ref()).is_break() {
                return (Stopped::Interrupted, active_count as u64);
            }
            if self.state.cursor.pass.is_multiple_of(PASSES_BETWEEN_TESTS) {
                let unconverged = self.unconverged(target, &active, stages);
                let missing = count(&unconverged);
                if missing <= allowed {
                    return (Stopped::Target, missing as u64);
                }
                active = neighbourhood(&unconverged, &active, self.area());
                active_count = count(&active);
                mask = Some(PixelMask::new(self.area(), active.clone()));
                self.state.cursor.stage = RefineStage::Decide(active.clone());
            }
        }
        match count(&self.unconverged(target, &active, stages)) {
            missing if missing <= allowed => (Stopped::Target, missing as u64),
            missing => (cause, missing as u64),
        }
    }

    /// Flags of the unconverged pixels. All active pixels must have taken all passes so far.
    fn unconverged(&mut self, target: TargetError, active: &[bool], stages: f64) -> Vec<bool> {
        let first = self.state.pixels.iter().zip(active).find(|(pixel, active)| **active && pixel.passes() > 1);
        let student = first.map_or(f64::INFINITY, |(pixel, _)| student_t(TargetError::CONFIDENCE, pixel.freedom()));
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
        let unconverged: Vec<bool> = self.state.pixels.iter().zip(active).map(of).collect();
        self.forecast.add(stages * needed);
        self.converged = Some(1.0 - count(&unconverged) as f64 / unconverged.len().max(1) as f64);
        unconverged
    }

    /// Renders the second stage: new samples, with the number of passes of each pixel from the first stage.
    fn repeat(&mut self, time: Option<Duration>) -> (Stopped, u64) {
        let RefineStage::Repeat(decided, stopped, unconverged) = self.state.cursor.stage.clone() else {
            return (Stopped::Samples, 0);
        };
        let last = decided.iter().copied().max().unwrap_or(0);
        self.forecast.set_total(self.samples_with_new_ones(&decided, last) as f64);
        while self.state.cursor.pass < last {
            let pass = self.state.cursor.pass;
            let active: Vec<_> = decided.iter().map(|&passes| passes > pass).collect();
            let active_count = count(&active);
            let Some(spp) = self.pass_spp() else { break };
            if !self.is_in_time(spp, active_count, time) {
                return (Stopped::Time, active_count.max(unconverged as usize) as u64);
            }
            if self.take_pass(spp, Some(&PixelMask::new(self.area(), active))).is_break() {
                return (Stopped::Interrupted, active_count.max(unconverged as usize) as u64);
            }
        }
        (stopped, unconverged)
    }
}

impl Progressive<'_> {
    /// Total number of samples once each pixel has `decided` passes of the second stage.
    fn samples_with_new_ones(&self, decided: &[u32], last: u32) -> u64 {
        let (mut taken, mut after) = (0, vec![0u64]);
        for pass in 0..last {
            let Some(spp) = self.rule.pass_spp(self.pattern(), pass, taken) else { break };
            taken = taken.saturating_add(spp);
            after.push(taken.into());
        }
        let new: u64 = decided.iter().filter_map(|&passes| after.get(passes as usize)).sum();
        let current: u64 = self.state.pixels.iter().map(|pixel| u64::from(pixel.samples())).sum();
        self.samples() - current.min(self.samples()) + new
    }
}

fn count(pixels: &[bool]) -> usize {
    pixels.iter().filter(|&&is| is).count()
}

/// Active pixels with an unconverged pixel among themselves and their eight neighbours.
fn neighbourhood(unconverged: &[bool], active: &[bool], area: Crop) -> Vec<bool> {
    let (width, height) = (area.width as usize, area.height as usize);
    let row_of_three =
        |x: usize, y: usize| unconverged[y * width..][x.saturating_sub(1)..width.min(x + 2)].contains(&true);
    let near = |x: usize, y: usize| (y.saturating_sub(1)..height.min(y + 2)).any(|y| row_of_three(x, y));
    (0..active.len()).map(|index| active[index] && near(index % width, index / width)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn active_neighbours_stay_active() {
        let area = Crop { x: 5, y: 7, width: 4, height: 3 };
        let mut unconverged = vec![false; 12];
        unconverged[4] = true;
        let near = [true, true, false, false];
        assert_eq!(neighbourhood(&unconverged, &[true; 12], area), near.repeat(3));
        let mut active = [true; 12];
        active[1] = false;
        let mut expected = near.repeat(3);
        expected[1] = false;
        assert_eq!(neighbourhood(&unconverged, &active, area), expected);
        assert_eq!(neighbourhood(&[false; 12], &[true; 12], area), [false; 12]);
    }
}
