//! Progressive rendering: passes over the whole image until a stop rule applies.
//!
//! The value of a pixel depends only on the seed and its passes. The clock and the estimated error determine the number of
//! passes, and nothing else.
//!
//! A render can be interrupted within a pass and resumed from its [`PassState`].

use core::ops::ControlFlow;
use std::time::{Duration, Instant};

use rt_camera::SamplerKind;
use rt_math::Rgb;

use crate::{
    Criterion, Crop, ErrorProgress, Observer, PassProgress, Progress, RenderPlan, RenderSnapshot, Shard, ShardSpec,
    Statistics, StopRule, Stopped, TargetError,
    error_estimate::ErrorSums,
    film::{film_tile::FilmLayout, pixel_estimate::PixelEstimate},
    forecast::Forecast,
    observer::FilmState,
    pass_state::{PassCursor, PassState},
    passes::{PassSpec, PixelMask},
    splats::SplatImage,
    tile_job::TileResult,
    tile_scheduler::TileScheduler,
};

/// A render in progress.
pub(crate) struct Progressive<'p> {
    pub(crate) plan: &'p RenderPlan<'p>,
    pub(crate) scheduler: &'p TileScheduler<'p>,
    pub(crate) rule: StopRule,
    pub(crate) started: Instant,
    /// Time of earlier runs.
    pub(crate) spent: Duration,
    /// Indices of the tiles to render.
    pub(crate) tiles: Vec<usize>,
    pub(crate) state: PassState,
    /// Forecast of the total number of samples, with a target error.
    pub(crate) forecast: Forecast,
    /// Fraction of converged pixels, with [`Criterion::Pixels`].
    pub(crate) converged: Option<f64>,
    pub(crate) observer: &'p mut dyn Observer,
}

impl Progressive<'_> {
    /// Renders the fixed number of passes of the plan.
    pub(crate) fn run_fixed(&mut self) -> Stopped {
        while self.state.cursor.pass < self.plan.frame.passes {
            if self.take_pass(self.plan.frame.pass_spp, None).is_break() {
                return Stopped::Interrupted;
            }
        }
        Stopped::Samples
    }

    /// Renders growing passes over all pixels.
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

    /// Samples of the next pass; `None` at the maximum number of samples.
    pub(crate) fn pass_spp(&self) -> Option<u32> {
        let PassCursor { pass, taken, .. } = self.state.cursor;
        self.rule.pass_spp(self.plan.frame.sampler, pass, taken)
    }

    /// Sample pattern of the plan.
    pub(crate) const fn pattern(&self) -> SamplerKind {
        self.plan.frame.sampler
    }

    /// True if a pass of `spp` samples is expected to end within the limit. The first pass is always taken, and a begun pass is
    /// always finished.
    pub(crate) fn is_in_time(&self, spp: u32, pixels: usize, limit: Option<Duration>) -> bool {
        let next = self.state.seconds_per_sample * f64::from(spp) * pixels as f64;
        let is_due = self.state.cursor.pass == 0 || !self.state.cursor.done_tiles.is_empty();
        is_due || limit.is_none_or(|limit| self.elapsed().as_secs_f64() + next <= limit.as_secs_f64())
    }

    fn elapsed(&self) -> Duration {
        self.spent + self.started.elapsed()
    }

    /// Renders the next pass over the pixels of the mask, or the remaining tiles of a begun pass.
    pub(crate) fn take_pass(&mut self, spp: u32, mask: Option<&PixelMask>) -> ControlFlow<()> {
        let pass_started = Instant::now();
        let pass = self.state.cursor.stage.seed_of(self.state.cursor.pass);
        let light = self.trace_light(pass, spp)?;
        let pass_spec = PassSpec { first: pass, count: 1, spp, simple_spp: None, pixels: mask };
        let error_progress = self.error_progress();
        let Self { scheduler, started, spent, tiles, state, observer, rule, forecast, .. } = self;
        state.cursor.done_tiles.resize(scheduler.tiles().len(), false);
        let left: Vec<_> = tiles.iter().copied().filter(|&number| !state.cursor.done_tiles[number]).collect();
        let samples_before = state.statistics.samples;
        let (finished, taken) = (state.statistics.passes, state.cursor.taken);
        let rmse = state.error.rmse();
        let end_of_pass = samples_before + pass_spec.samples_of(left.iter().map(|&number| scheduler.tiles()[number]));
        let pixels: u64 = tiles.iter().map(|&number| scheduler.tiles()[number].area()).sum();
        let outcome = scheduler.render_tiles(&pass_spec, &left, |number, tile| {
            let saturated = accumulate(state.layout, &mut state.pixels, &tile, light.as_ref(), &pass_spec);
            state.cursor.done_tiles[number] = true;
            let elapsed = *spent + started.elapsed();
            let statistics = &mut state.statistics;
            statistics.join(&tile.statistics);
            statistics.saturated_pixels += saturated;
            statistics.render_seconds = elapsed.as_secs_f64();
            let samples = statistics.samples;
            let in_time = rule.time.map(|time| extrapolated(samples, elapsed, time));
            let total_samples = match (forecast.total(samples), in_time) {
                (Some(expected), Some(in_time)) => expected.min(in_time),
                (Some(total), None) | (None, Some(total)) => total,
                (None, None) => pixels.saturating_mul(rule.max_spp.into()),
            };
            let rays = statistics.counters.total().rays;
            let samples_left = end_of_pass.saturating_sub(samples);
            let pass = PassProgress { finished, samples_left, spp: taken, rmse, error_progress };
            let progress = Progress { samples, total_samples, rays, pass: Some(pass) };
            observer.tile_done(&RenderSnapshot { progress, tile: tile.tile, state: FilmState::Passes(state) });
        });
        state.lost.extend(outcome.lost.iter().map(|&number| number as u32));
        if outcome.interrupted {
            return ControlFlow::Break(());
        }
        state.statistics.passes += 1;
        state.error = ErrorSums::of(&state.pixels);
        let samples = state.statistics.samples - samples_before;
        if samples > 0 {
            state.seconds_per_sample = pass_started.elapsed().as_secs_f64() / samples as f64;
        }
        state.cursor.pass += 1;
        state.cursor.taken = state.cursor.taken.saturating_add(spp);
        state.cursor.done_tiles.clear();
        ControlFlow::Continue(())
    }

    /// Relative root mean square error of the image, from two passes on.
    pub(crate) fn relative_rmse(&self) -> Option<f64> {
        self.state.error.relative_rmse()
    }

    /// Current and target error, if known.
    fn error_progress(&self) -> Option<ErrorProgress> {
        let TargetError { relative, criterion, .. } = self.rule.target?;
        match criterion {
            Criterion::Image => self.relative_rmse().map(|error| ErrorProgress::Image { error, target: relative }),
            Criterion::Pixels { share: target } => self.converged.map(|share| ErrorProgress::Pixels { share, target }),
        }
    }

    /// Traces the light paths of a pass, if the plan has any. A run that resumes within a pass traces them again, but counts
    /// them once.
    fn trace_light(&mut self, pass: u32, spp: u32) -> ControlFlow<(), Option<SplatImage>> {
        let Self { plan, scheduler, state, .. } = self;
        let Some(light) = plan.light_pass(pass, spp) else { return ControlFlow::Continue(None) };
        let mut image = SplatImage::new(plan.frame.crop, plan.frame.filter);
        let mut statistics = state.statistics;
        let outcome = scheduler.trace_light(light, |lit| {
            statistics.join(&lit.statistics);
            lit.splats.iter().for_each(|splat| image.add(splat));
        });
        if outcome.interrupted {
            return ControlFlow::Break(());
        }
        if !outcome.lost.is_empty() {
            state.lost = (0..scheduler.tiles().len() as u32).collect();
        }
        if state.cursor.done_tiles.is_empty() {
            state.statistics = statistics;
        }
        ControlFlow::Continue(Some(image))
    }

    /// Rendered rectangle of the image.
    pub(crate) const fn area(&self) -> Crop {
        self.plan.frame.crop
    }

    /// Samples taken so far, including discarded ones.
    pub(crate) const fn samples(&self) -> u64 {
        self.state.statistics.samples
    }

    /// Converts the film to the film tiles of its shard.
    pub(crate) fn finish(self, spec: ShardSpec, stopped: Stopped, unconverged: Option<u64>) -> Shard {
        let (state, seconds) = (&self.state, self.elapsed().as_secs_f64());
        let mut shard = Shard::empty(state.layout, spec, Statistics { render_seconds: seconds, ..state.statistics });
        for number in self.tiles {
            shard.tiles.insert(number as u32, state.film_tile(self.scheduler.tiles()[number]));
        }
        let mut lost = state.lost.clone();
        lost.sort_unstable();
        lost.dedup();
        Shard { stopped, unconverged, lost, ..shard }
    }
}

/// Adds a pass of a tile, and the light paths of that pass, to the pixel accumulators of the film. Returns the number of pixels
/// whose light paths exceed the bound of their sums.
fn accumulate(
    layout: FilmLayout,
    pixels: &mut [PixelEstimate],
    tile: &TileResult,
    light: Option<&SplatImage>,
    pass_spec: &PassSpec<'_>,
) -> u64 {
    let mut saturated = 0;
    for (at, pass) in pass_spec.pixels_of(tile.tile).zip(&tile.pixels) {
        let index = layout.crop.pixel_index(at);
        let splatted = light.map_or(Rgb::BLACK, |light| light.radiance(index));
        saturated += u64::from(light.is_some_and(|light| light.is_saturated(index)));
        let coverage = if layout.transparent { pass.coverage() } else { 1.0 };
        pixels[index].add(pass.mean() + splatted, coverage, pass_spec.spp);
    }
    saturated
}

/// Total number of samples at the end of `time`, extrapolated from the current rate.
fn extrapolated(samples: u64, elapsed: Duration, time: Duration) -> u64 {
    let progress = elapsed.as_secs_f64() / time.as_secs_f64().max(1e-9);
    (samples as f64 / progress.clamp(1e-9, 1.0)) as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_total_is_extrapolated_from_the_rate() {
        assert_eq!(extrapolated(100, Duration::from_secs(1), Duration::from_secs(4)), 400);
        assert_eq!(extrapolated(100, Duration::from_secs(5), Duration::from_secs(4)), 100);
        assert_eq!(extrapolated(0, Duration::ZERO, Duration::ZERO), 0);
    }
}
