//! Progressive rendering: passes over the whole image until a stop rule applies.
//!
//! The estimate of a pixel depends on the seed and its passes alone, independent of threads. The clock or the
//! estimated error decides how many passes there are, and nothing else.
//!
//! A render can be interrupted in the midst of a pass and go on from there: [`PassState`] is all that it knows.

use core::ops::ControlFlow;
use std::time::{Duration, Instant};

use rt_camera::SamplerKind;
use rt_math::Rgb;

use crate::{
    Criterion, Crop, Observer, Part, PassProgress, Progress, RenderPlan, RenderSnapshot, Share, Statistics, StopRule,
    Stopped, TargetError, Towards,
    error_estimate::ErrorSums,
    estimate::PixelEstimate,
    forecast::Forecast,
    observer::State,
    pass_state::{PassCursor, PassState, pixel_index},
    passes::{PassSpec, PixelMask},
    splats::SplatImage,
    tile_job::TileResult,
    tile_scheduler::TileScheduler,
    tiles::Tile,
};

/// A render in progress.
pub(crate) struct Progressive<'p, O> {
    pub(crate) plan: &'p RenderPlan<'p>,
    pub(crate) scheduler: &'p TileScheduler<'p>,
    pub(crate) rule: StopRule,
    pub(crate) started: Instant,
    /// Time that earlier runs took.
    pub(crate) spent: Duration,
    /// Numbers of the tiles to render.
    pub(crate) of_share: Vec<usize>,
    pub(crate) state: PassState,
    /// Samples that are expected in all, where the error decides.
    pub(crate) forecast: Forecast,
    /// Share of the pixels that have reached their error, where each has to.
    pub(crate) converged: Option<f64>,
    pub(crate) observer: O,
}

impl<O: Observer> Progressive<'_, O> {
    /// The passes that the plan splits its samples into.
    pub(crate) fn run_fixed(&mut self) -> Stopped {
        while self.state.cursor.pass < self.plan.frame.passes {
            if self.take_pass(self.plan.frame.pass_spp, None).is_break() {
                return Stopped::Interrupted;
            }
        }
        Stopped::Samples
    }

    /// Passes that grow, over all pixels.
    pub(crate) fn run_progressive(&mut self) -> Stopped {
        while let Some(spp) = self.pass_spp() {
            if !self.is_in_time(spp, self.state.pixels.len(), self.rule.time) {
                return Stopped::Time;
            }
            if self.take_pass(spp, None).is_break() {
                return Stopped::Interrupted;
            }
        }
        Stopped::Samples
    }

    /// Samples of the next pass; `None` if the rule allows no more.
    pub(crate) fn pass_spp(&self) -> Option<u32> {
        let PassCursor { pass, taken, .. } = self.state.cursor;
        self.rule.pass_spp(self.plan.frame.sampler, pass, taken)
    }

    /// Sample pattern of the plan.
    pub(crate) const fn pattern(&self) -> SamplerKind {
        self.plan.frame.sampler
    }

    /// True if so many samples of so many pixels can be expected to be there by then. The first pass is always taken, and one
    /// that was begun is always finished.
    pub(crate) fn is_in_time(&self, spp: u32, pixels: usize, limit: Option<Duration>) -> bool {
        let next = self.state.seconds_per_sample * f64::from(spp) * pixels as f64;
        let is_due = self.state.cursor.pass == 0 || !self.state.cursor.begun.is_empty();
        is_due || limit.is_none_or(|limit| self.elapsed().as_secs_f64() + next <= limit.as_secs_f64())
    }

    fn elapsed(&self) -> Duration {
        self.spent + self.started.elapsed()
    }

    /// Takes the next pass over the pixels of the mask, or what is left of it.
    pub(crate) fn take_pass(&mut self, spp: u32, mask: Option<&PixelMask>) -> ControlFlow<()> {
        let began = Instant::now();
        let pass = self.state.cursor.stage.seed_of(self.state.cursor.pass);
        let light = self.trace_light(pass, spp)?;
        let pass_spec = PassSpec { first: pass, count: 1, spp, simple_spp: None, pixels: mask };
        let towards = self.towards();
        let Self { plan, scheduler, started, spent, of_share, state, observer, rule, forecast, .. } = self;
        state.cursor.begun.resize(scheduler.tiles().len(), false);
        let left: Vec<_> = of_share.iter().copied().filter(|&number| !state.cursor.begun[number]).collect();
        let samples_before = state.statistics.samples;
        let most = state.pixels.iter().map(PixelEstimate::samples).max().unwrap_or(0);
        let here = PassProgress { finished: state.statistics.passes, spp: most, rmse: state.error.rmse(), towards };
        let pixels: u64 = of_share.iter().map(|&number| scheduler.tiles()[number].area()).sum();
        let outcome = scheduler.render_tiles(&pass_spec, &left, |number, tile| {
            accumulate(plan.frame.crop, &mut state.pixels, &tile, light.as_ref(), &pass_spec);
            state.cursor.begun[number] = true;
            let elapsed = *spent + started.elapsed();
            let statistics = &mut state.statistics;
            statistics.add(&tile);
            statistics.render_seconds = elapsed.as_secs_f64();
            let samples = statistics.samples;
            let in_time = rule.time.map(|time| in_all(samples, elapsed, time));
            let total_samples = match (forecast.total(samples), in_time) {
                (Some(expected), Some(in_time)) => expected.min(in_time),
                (Some(total), None) | (None, Some(total)) => total,
                (None, None) => pixels.saturating_mul(rule.max_spp.into()),
            };
            let rays = statistics.counters.total().rays;
            let progress = Progress { samples, total_samples, rays, pass: Some(here) };
            observer.tile_done(&RenderSnapshot { progress, tile: tile.tile, state: State::Passes(state) });
        });
        state.lost.extend(outcome.lost.iter().map(|&number| number as u32));
        if outcome.interrupted {
            return ControlFlow::Break(());
        }
        state.statistics.passes += 1;
        state.error = error_of(&state.pixels);
        let samples = state.statistics.samples - samples_before;
        if samples > 0 {
            state.seconds_per_sample = began.elapsed().as_secs_f64() / samples as f64;
        }
        state.cursor.pass += 1;
        state.cursor.taken = state.cursor.taken.saturating_add(spp);
        state.cursor.begun.clear();
        ControlFlow::Continue(())
    }

    /// Relative root mean square error of the image, from two passes on.
    pub(crate) fn relative_rmse(&self) -> Option<f64> {
        self.state.error.relative_rmse()
    }

    /// Distance from the target, if it is known.
    fn towards(&self) -> Option<Towards> {
        let TargetError { relative, criterion, .. } = self.rule.target?;
        match criterion {
            Criterion::Image => self.relative_rmse().map(|error| Towards::Image { error, target: relative }),
            Criterion::Pixels { share: target } => self.converged.map(|share| Towards::Pixels { share, target }),
        }
    }

    /// The light paths of a pass, if the plan follows any. They belong to the pass as a whole: a run that goes on in the midst of
    /// it follows them again, and does not count them again.
    fn trace_light(&mut self, pass: u32, spp: u32) -> ControlFlow<(), Option<SplatImage>> {
        let Self { plan, scheduler, state, .. } = self;
        let Some(light) = plan.light_pass(pass, spp) else { return ControlFlow::Continue(None) };
        let mut image = SplatImage::new(plan.frame.crop, plan.frame.filter);
        let mut statistics = state.statistics;
        let outcome = scheduler.trace_light(light, |lit| {
            statistics.add_light(&lit);
            lit.splats.iter().for_each(|splat| image.add(splat));
        });
        if outcome.interrupted {
            return ControlFlow::Break(());
        }
        if !outcome.lost.is_empty() {
            state.lost = (0..scheduler.tiles().len() as u32).collect();
        }
        if state.cursor.begun.is_empty() {
            state.statistics = statistics;
        }
        ControlFlow::Continue(Some(image))
    }

    /// The part of the image that is rendered.
    pub(crate) const fn part(&self) -> Tile {
        let Crop { x, y, width, height } = self.plan.frame.crop;
        Tile { x, y, width, height }
    }

    /// Samples taken so far, also those that were thrown away.
    pub(crate) const fn samples(&self) -> u64 {
        self.state.statistics.samples
    }

    /// Each tile with what it shows now, the tiles of other shares left out.
    pub(crate) fn finish(self, share: Share, stopped: Stopped, unconverged: Option<u64>) -> Part {
        let (state, seconds) = (&self.state, self.elapsed().as_secs_f64());
        let mut part = Part::empty(state.frame, share, Statistics { render_seconds: seconds, ..state.statistics });
        for number in self.of_share {
            part.tiles.insert(number as u32, state.tile_pixels(self.scheduler.tiles()[number]));
        }
        let mut lost = state.lost.clone();
        lost.sort_unstable();
        lost.dedup();
        Part { stopped, unconverged, lost, ..part }
    }
}

/// Adds the pixels of a tile that went through a pass to what is known of them, and what light paths brought in the same pass.
fn accumulate(
    crop: Crop,
    pixels: &mut [PixelEstimate],
    tile: &TileResult,
    light: Option<&SplatImage>,
    pass_spec: &PassSpec<'_>,
) {
    let mut coverage = tile.alpha.iter().copied();
    for (at, radiance) in pass_spec.pixels_of(tile.tile).zip(&tile.pixels) {
        let index = pixel_index(crop, at);
        let brought = light.map_or(Rgb::BLACK, |light| light.radiance(index));
        pixels[index].add(*radiance + brought, coverage.next().unwrap_or(1.0), pass_spec.spp);
    }
}

/// Samples that there will be at the end if they go on coming at this rate.
fn in_all(samples: u64, elapsed: Duration, time: Duration) -> u64 {
    let share = elapsed.as_secs_f64() / time.as_secs_f64().max(1e-9);
    (samples as f64 / share.clamp(1e-9, 1.0)) as u64
}

fn error_of(pixels: &[PixelEstimate]) -> ErrorSums {
    let mut sums = ErrorSums::default();
    pixels.iter().for_each(|pixel| sums.add(pixel));
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_end_is_foreseen_from_the_rate() {
        assert_eq!(in_all(100, Duration::from_secs(1), Duration::from_secs(4)), 400);
        assert_eq!(in_all(100, Duration::from_secs(5), Duration::from_secs(4)), 100);
        assert_eq!(in_all(0, Duration::ZERO, Duration::ZERO), 0);
    }
}
