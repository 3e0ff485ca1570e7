//! Passes over the whole image, one after the other, until there is enough.
//!
//! What is known of a pixel is a function of the seed and of the passes that it took, whatever the threads do. The clock decides
//! how many passes there are, and nothing else.

use std::time::{Duration, Instant};

use rt_camera::Film;
use rt_math::Rgb;

use crate::{
    Crop, PassProgress, Progress, RenderError, RenderPlan, Rendering, RunOptions, SampleRange, Statistics, StopRule,
    Stopped,
    crew::Crew,
    error_estimate::ErrorSums,
    estimate::PixelEstimate,
    passes::{PixelMask, Sweep},
    render::rounded,
    splats::SplatImage,
    tile::Finished,
    tiles::Tile,
};

impl RenderPlan<'_> {
    /// Renders pass after pass until the rule says stop; the number of samples in the scene is not looked at. `progress` is
    /// called on this thread after each tile.
    ///
    /// # Errors
    /// [`RenderError::Threads`] if the worker threads cannot be started, [`RenderError::TargetError`] and
    /// [`RenderError::NoSamples`] for a rule with such numbers, [`RenderError::AdaptiveUntil`] for a plan that tells pixels apart
    /// in object space, [`RenderError::SamePasses`] for an error that would never
    /// be known.
    pub fn render_until(
        &self,
        options: &RunOptions,
        rule: &StopRule,
        progress: impl FnMut(Progress),
    ) -> Result<Rendering, RenderError> {
        rule.validate()?;
        if self.simple_pass_spp.is_some() {
            return Err(RenderError::AdaptiveUntil);
        }
        if rule.target.is_some() && !self.passes_differ() {
            return Err(RenderError::SamePasses(self.pattern.name()));
        }
        let mut render = Progressive::new(self, options, *rule, progress)?;
        let (stopped, unconverged) = match rule.target {
            None => (render.pass_after_pass(), None),
            Some(target) => {
                let (stopped, unconverged) = render.refine(target);
                (stopped, Some(unconverged))
            }
        };
        Ok(render.finish(stopped, unconverged, options.maps))
    }
}

impl RenderPlan<'_> {
    /// Renders the passes of a fixed number of samples one after the other, with the light paths of each before it: in memory
    /// there are those of one pass.
    pub(crate) fn render_by_passes(
        &self,
        options: &RunOptions,
        progress: impl FnMut(Progress),
    ) -> Result<Rendering, RenderError> {
        let rule = StopRule { max_spp: self.samples_per_pixel(), ..StopRule::default() };
        let mut render = Progressive::new(self, options, rule, progress)?;
        let stopped = render.all_passes();
        Ok(render.finish(stopped, None, options.maps))
    }
}

/// A render in progress.
pub(crate) struct Progressive<'p, F> {
    plan: &'p RenderPlan<'p>,
    crew: Crew<'p>,
    pub(crate) rule: StopRule,
    started: Instant,
    statistics: Statistics,
    /// All pixels, row by row.
    pub(crate) pixels: Vec<PixelEstimate>,
    /// Wall-clock seconds that the last pass took for a sample.
    seconds_per_sample: f64,
    rmse: Option<f64>,
    /// Samples that pixels are expected to need in all, if more is known than what time allows.
    pub(crate) expected_samples: Option<u64>,
    progress: F,
}

impl<'p, F: FnMut(Progress)> Progressive<'p, F> {
    fn new(plan: &'p RenderPlan<'p>, options: &RunOptions, rule: StopRule, progress: F) -> Result<Self, RenderError> {
        let started = Instant::now();
        let crew = Crew::new(plan, options)?;
        let Crop { width, height, .. } = plan.crop;
        Ok(Self {
            statistics: Statistics::new(&crew, plan),
            plan,
            crew,
            rule,
            started,
            pixels: vec![PixelEstimate::default(); width as usize * height as usize],
            seconds_per_sample: 0.0,
            rmse: None,
            expected_samples: None,
            progress,
        })
    }

    /// The passes that the plan splits its samples into.
    fn all_passes(&mut self) -> Stopped {
        (0..self.plan.passes).for_each(|pass| self.take_pass(pass, self.plan.pass_spp, None));
        Stopped::Samples
    }

    /// Passes that grow, over all pixels.
    fn pass_after_pass(&mut self) -> Stopped {
        let mut taken = 0;
        for pass in 0.. {
            let Some(spp) = self.pass_spp(pass, taken) else { return Stopped::Samples };
            if pass > 0 && !self.is_in_time(spp, self.pixels.len(), self.rule.time) {
                return Stopped::Time;
            }
            self.take_pass(pass, spp, None);
            taken += spp;
        }
        Stopped::Samples
    }

    /// Samples of the next pass; `None` if the rule allows no more.
    pub(crate) fn pass_spp(&self, pass: u32, taken: u32) -> Option<u32> {
        self.rule.pass_spp(self.plan.pattern, pass, taken)
    }

    /// True if so many samples of so many pixels can be expected to be there by then.
    pub(crate) fn is_in_time(&self, spp: u32, pixels: usize, limit: Option<Duration>) -> bool {
        let next = self.seconds_per_sample * f64::from(spp) * pixels as f64;
        limit.is_none_or(|limit| self.started.elapsed().as_secs_f64() + next <= limit.as_secs_f64())
    }

    /// Takes a pass over the pixels of the mask.
    pub(crate) fn take_pass(&mut self, pass: u32, spp: u32, mask: Option<&PixelMask>) {
        let (began, samples_before) = (Instant::now(), self.statistics.samples);
        let sweep = Sweep { first: pass, count: 1, spp, simple_spp: None, pixels: mask };
        let Self { plan, crew, started, statistics, pixels, rmse, progress, rule, expected_samples, .. } = self;
        let most = pixels.iter().map(PixelEstimate::samples).max().unwrap_or(0);
        let here = PassProgress { finished: statistics.passes, spp: most, rmse: *rmse };
        let light = plan.light_pass(pass, spp).map(|light| {
            let mut image = SplatImage::new(plan.crop, plan.filter);
            crew.trace_light(light, |lit| {
                statistics.add_light(&lit);
                lit.splats.iter().for_each(|splat| image.add(splat));
            });
            image
        });
        crew.sweep(&sweep, |_, tile| {
            fold(plan.crop, pixels, &tile, light.as_ref(), &sweep);
            statistics.add(&tile);
            let samples = statistics.samples;
            let total_samples = match (*expected_samples, rule.time) {
                (Some(expected), _) => expected.max(samples),
                (None, Some(time)) => in_all(samples, started.elapsed(), time),
                (None, None) => (pixels.len() as u64).saturating_mul(rule.max_spp.into()),
            };
            let rays = statistics.counters.total().rays;
            progress(Progress { samples, total_samples, rays, pass: Some(here) });
        });
        statistics.passes += 1;
        *rmse = error_of(pixels).rmse();
        let samples = statistics.samples - samples_before;
        self.seconds_per_sample = began.elapsed().as_secs_f64() / samples.max(1) as f64;
    }

    /// The part of the image that is rendered.
    pub(crate) const fn part(&self) -> Tile {
        let Crop { x, y, width, height } = self.plan.crop;
        Tile { x, y, width, height }
    }

    /// Samples taken so far, also those that were thrown away.
    pub(crate) const fn samples(&self) -> u64 {
        self.statistics.samples
    }

    fn finish(mut self, stopped: Stopped, unconverged: Option<u64>, maps: bool) -> Rendering {
        let Crop { width, height, .. } = self.plan.crop;
        let film = |with_alpha: bool, of: &dyn Fn(&PixelEstimate) -> [f32; 3]| {
            let mut film = Film::new(width, height, with_alpha);
            for (place, pixel) in film.pixels_mut().iter_mut().zip(&self.pixels) {
                *place = of(pixel);
            }
            film
        };
        let mut picture = film(self.plan.transparent, &|pixel| rounded(pixel.mean()));
        for (place, pixel) in picture.alpha_mut().unwrap_or_default().iter_mut().zip(&self.pixels) {
            *place = pixel.coverage().clamp(0.0, 1.0) as f32;
        }
        let standard_error = |pixel: &PixelEstimate| match pixel.variance() {
            Some(variance) => rounded(variance.map(f64::sqrt)),
            None => [f32::INFINITY; 3],
        };
        let counts = |pixel: &PixelEstimate| [pixel.samples() as f32; 3];
        let (standard_error, sample_counts) =
            (maps.then(|| film(false, &standard_error)), maps.then(|| film(false, &counts)));
        self.statistics.render_seconds = self.started.elapsed().as_secs_f64();
        Rendering {
            film: picture,
            statistics: self.statistics,
            stopped,
            error: error_of(&self.pixels).estimate().filter(|_| self.plan.passes_differ()),
            samples_per_pixel: sample_range(&self.pixels),
            unconverged,
            standard_error,
            sample_counts,
        }
    }
}

/// Adds the pixels of a tile that went through a pass to what is known of them, and what light paths brought in the same pass.
fn fold(crop: Crop, pixels: &mut [PixelEstimate], tile: &Finished, light: Option<&SplatImage>, sweep: &Sweep<'_>) {
    let mut coverage = tile.alpha.iter().copied();
    for ([x, y], radiance) in sweep.pixels_of(tile.tile).zip(&tile.pixels) {
        let index = (y - crop.y) as usize * crop.width as usize + (x - crop.x) as usize;
        let brought = light.map_or(Rgb::BLACK, |light| light.radiance(index));
        pixels[index].add(*radiance + brought, coverage.next().unwrap_or(1.0), sweep.spp);
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

fn sample_range(pixels: &[PixelEstimate]) -> SampleRange {
    let samples = || pixels.iter().map(PixelEstimate::samples);
    let mean = samples().map(u64::from).sum::<u64>() as f64 / pixels.len().max(1) as f64;
    SampleRange { least: samples().min().unwrap_or(0), mean, most: samples().max().unwrap_or(0) }
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
