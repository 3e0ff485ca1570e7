//! Passes over the whole image, one after the other, until there is enough.
//!
//! What is known of a pixel is a function of the seed and of the passes that it took, whatever the threads do. The clock or the
//! estimated error decides how many passes there are, and nothing else.
//!
//! A render can be interrupted in the midst of a pass and go on from there: [`PassState`] is all that it knows.

use core::ops::ControlFlow;
use std::time::{Duration, Instant};

use rt_camera::SamplerKind;
use rt_image::Image;
use rt_math::Rgb;
use serde::{Deserialize, Serialize};

use crate::{
    ContentError, Criterion, Crop, Observer, Part, PassProgress, Progress, RenderPlan, RenderSnapshot, Share,
    Statistics, StopRule, Stopped, TargetError, Towards,
    content::{MAX_PASSES, check_count, check_crop, check_length, check_lost, check_number, check_share},
    crew::Crew,
    error_estimate::ErrorSums,
    estimate::PixelEstimate,
    forecast::Forecast,
    observer::{Kept, State},
    part::{Frame, TilePixels},
    passes::{PixelMask, Sweep},
    refine::Stage,
    render::rounded,
    splats::SplatImage,
    tile::Finished,
    tiles::{Tile, tile_count, tiles},
};

impl RenderPlan<'_> {
    /// Renders passes over the whole image: those of a fixed number of samples, or as many as the rule wants. In memory there are
    /// the light paths of one pass.
    pub(crate) fn render_passes(
        &self,
        crew: &Crew<'_>,
        share: Share,
        rule: Option<&StopRule>,
        state: PassState,
        observer: impl Observer,
    ) -> Part {
        let fixed = StopRule { max_spp: self.samples_per_pixel(), ..StopRule::default() };
        let mut render = Progressive {
            plan: self,
            crew,
            rule: rule.copied().unwrap_or(fixed),
            started: Instant::now(),
            spent: Duration::try_from_secs_f64(state.statistics.render_seconds).unwrap_or_default(),
            of_share: (0..crew.tiles().len()).filter(|number| share.holds(*number)).collect(),
            state,
            forecast: Forecast::default(),
            converged: None,
            observer,
        };
        let (stopped, unconverged) = match rule {
            None => (render.all_passes(), None),
            Some(StopRule { target: None, .. }) => (render.pass_after_pass(), None),
            Some(StopRule { target: Some(target), .. }) => {
                let (stopped, unconverged) = render.refine(*target);
                (stopped, unconverged.filter(|_| target.criterion != Criterion::Image))
            }
        };
        if stopped == Stopped::Interrupted {
            render.observer.unfinished(&Kept(State::Passes(&render.state)));
        }
        render.finish(share, stopped, unconverged)
    }
}

/// What a render of passes knows of its pixels, and where it stands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct PassState {
    pub(crate) frame: Frame,
    share: Share,
    way: Way,
    /// All pixels, row by row.
    pub(crate) pixels: Vec<PixelEstimate>,
    pub(crate) statistics: Statistics,
    pub(crate) place: Place,
    /// Wall-clock seconds that the last pass took for a sample.
    seconds_per_sample: f64,
    /// Error of the picture after the last pass.
    pub(crate) error: ErrorSums,
    /// Numbers of the tiles in which a worker failed.
    lost: Vec<u32>,
}

/// What says how large passes are, and which pixels take them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
enum Way {
    /// The plan.
    Fixed,
    /// They grow until there is enough.
    Growing,
    /// They grow until the error is reached, or a pixel has so many samples.
    Target(TargetError, u32),
}

/// Where in its passes a render stands.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Place {
    /// Number of the pass that is taken now or next.
    pub(crate) pass: u32,
    /// Samples that a pixel has if it took all passes before.
    pub(crate) taken: u32,
    /// Tiles that have taken the pass; empty before the first one has.
    pub(crate) begun: Vec<bool>,
    pub(crate) stage: Stage,
}

impl PassState {
    /// Of a render that has not begun.
    pub(crate) fn new(frame: Frame, share: Share, rule: Option<&StopRule>, statistics: Statistics) -> Self {
        let Crop { width, height, .. } = frame.crop;
        Self {
            frame,
            share,
            way: Way::new(rule),
            pixels: vec![PixelEstimate::default(); width as usize * height as usize],
            statistics,
            place: Place::default(),
            seconds_per_sample: 0.0,
            error: ErrorSums::default(),
            lost: Vec::new(),
        }
    }

    /// True if a render of this kind can go on from here.
    pub(crate) fn fits(&self, frame: Frame, share: Share, rule: Option<&StopRule>) -> bool {
        self.frame == frame && self.share == share && self.way == Way::new(rule)
    }

    /// Checks every number that a file may have got wrong.
    pub(crate) fn validate(&self) -> Result<(), ContentError> {
        let Self { frame, share, way: _, pixels, statistics, place, seconds_per_sample, error, lost } = self;
        let Place { pass, taken, begun, stage } = place;
        let crop = frame.crop;
        check_crop(crop)?;
        check_share(*share)?;
        let area = crop.width as usize * crop.height as usize;
        let of = || "the picture".to_owned();
        check_length("pixels", of, pixels.len(), area)?;
        if !begun.is_empty() {
            check_length("tiles of the pass", of, begun.len(), tile_count(crop))?;
        }
        stage.validate(area)?;
        check_count("the number of the pass", (*pass).into(), MAX_PASSES.into())?;
        // A pixel has taken the passes so far, or fewer, and in a tile that has begun the next one perhaps that as well.
        for (number, tile) in tiles(crop).into_iter().enumerate() {
            let has_begun = begun.get(number).copied().unwrap_or(false);
            let (passes, samples) = if has_begun { (pass + 1, u32::MAX) } else { (*pass, *taken) };
            let indices = tile.pixels().map(|at| place_of(crop, at));
            for (index, pixel) in indices.filter_map(|index| Some((index, pixels.get(index)?))) {
                pixel.validate(index, passes, samples)?;
            }
        }
        check_lost(lost, crop)?;
        statistics.validate()?;
        check_number("the time of a sample in seconds", *seconds_per_sample)?;
        error.validate(area as u64)
    }

    /// The picture so far.
    pub(crate) fn film(&self) -> Image {
        let Crop { width, height, .. } = self.frame.crop;
        let mut film = Image::new(width, height, self.frame.transparent);
        for (place, pixel) in film.pixels_mut().iter_mut().zip(&self.pixels) {
            *place = rounded(pixel.mean());
        }
        for (place, pixel) in film.alpha_mut().unwrap_or_default().iter_mut().zip(&self.pixels) {
            *place = rounded_coverage(pixel);
        }
        film
    }

    /// What a tile shows now.
    pub(crate) fn tile_pixels(&self, tile: Tile) -> TilePixels {
        let Frame { crop, transparent, maps, .. } = self.frame;
        let pixels = || tile.pixels().filter_map(move |at| self.pixels.get(place_of(crop, at)));
        let counts: Vec<_> = pixels().map(PixelEstimate::samples).collect();
        let range = [counts.iter().copied().min(), counts.iter().copied().max()].map(Option::unwrap_or_default);
        let standard_error = |pixel: &PixelEstimate| match pixel.variance() {
            Some(variance) => rounded(variance.map(f64::sqrt)),
            None => [f32::INFINITY; 3],
        };
        let mut error = ErrorSums::default();
        pixels().for_each(|pixel| error.add(pixel));
        TilePixels {
            pixels: pixels().map(|pixel| rounded(pixel.mean())).collect(),
            alpha: pixels().filter(|_| transparent).map(rounded_coverage).collect(),
            standard_errors: pixels().filter(|_| maps).map(standard_error).collect(),
            samples: counts.iter().copied().map(u64::from).sum(),
            counts: if range[0] == range[1] { Vec::new() } else { counts },
            range,
            error,
        }
    }
}

impl Way {
    fn new(rule: Option<&StopRule>) -> Self {
        match rule {
            None => Self::Fixed,
            Some(StopRule { target: None, .. }) => Self::Growing,
            Some(StopRule { target: Some(target), max_spp, .. }) => Self::Target(*target, *max_spp),
        }
    }
}

/// A render in progress.
pub(crate) struct Progressive<'p, O> {
    plan: &'p RenderPlan<'p>,
    crew: &'p Crew<'p>,
    pub(crate) rule: StopRule,
    started: Instant,
    /// Time that earlier runs took.
    spent: Duration,
    /// Numbers of the tiles to render.
    of_share: Vec<usize>,
    pub(crate) state: PassState,
    /// Samples that are expected in all, where the error decides.
    pub(crate) forecast: Forecast,
    /// Share of the pixels that have reached their error, where each has to.
    pub(crate) converged: Option<f64>,
    observer: O,
}

impl<O: Observer> Progressive<'_, O> {
    /// The passes that the plan splits its samples into.
    fn all_passes(&mut self) -> Stopped {
        while self.state.place.pass < self.plan.passes {
            if self.take_pass(self.plan.pass_spp, None).is_break() {
                return Stopped::Interrupted;
            }
        }
        Stopped::Samples
    }

    /// Passes that grow, over all pixels.
    fn pass_after_pass(&mut self) -> Stopped {
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
        let Place { pass, taken, .. } = self.state.place;
        self.rule.pass_spp(self.plan.pattern, pass, taken)
    }

    /// Sample pattern of the plan.
    pub(crate) const fn pattern(&self) -> SamplerKind {
        self.plan.pattern
    }

    /// True if so many samples of so many pixels can be expected to be there by then. The first pass is always taken, and one
    /// that was begun is always finished.
    pub(crate) fn is_in_time(&self, spp: u32, pixels: usize, limit: Option<Duration>) -> bool {
        let next = self.state.seconds_per_sample * f64::from(spp) * pixels as f64;
        let is_due = self.state.place.pass == 0 || !self.state.place.begun.is_empty();
        is_due || limit.is_none_or(|limit| self.elapsed().as_secs_f64() + next <= limit.as_secs_f64())
    }

    fn elapsed(&self) -> Duration {
        self.spent + self.started.elapsed()
    }

    /// Takes the next pass over the pixels of the mask, or what is left of it.
    pub(crate) fn take_pass(&mut self, spp: u32, mask: Option<&PixelMask>) -> ControlFlow<()> {
        let began = Instant::now();
        let pass = self.state.place.stage.seed_of(self.state.place.pass);
        let light = self.trace_light(pass, spp)?;
        let sweep = Sweep { first: pass, count: 1, spp, simple_spp: None, pixels: mask };
        let towards = self.towards();
        let Self { plan, crew, started, spent, of_share, state, observer, rule, forecast, .. } = self;
        state.place.begun.resize(crew.tiles().len(), false);
        let left: Vec<_> = of_share.iter().copied().filter(|&number| !state.place.begun[number]).collect();
        let samples_before = state.statistics.samples;
        let most = state.pixels.iter().map(PixelEstimate::samples).max().unwrap_or(0);
        let here = PassProgress { finished: state.statistics.passes, spp: most, rmse: state.error.rmse(), towards };
        let pixels: u64 = of_share.iter().map(|&number| crew.tiles()[number].area()).sum();
        let outcome = crew.sweep(&sweep, &left, |number, tile| {
            fold(plan.crop, &mut state.pixels, &tile, light.as_ref(), &sweep);
            state.place.begun[number] = true;
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
        state.place.pass += 1;
        state.place.taken = state.place.taken.saturating_add(spp);
        state.place.begun.clear();
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
        let Self { plan, crew, state, .. } = self;
        let Some(light) = plan.light_pass(pass, spp) else { return ControlFlow::Continue(None) };
        let mut image = SplatImage::new(plan.crop, plan.filter);
        let mut statistics = state.statistics;
        let outcome = crew.trace_light(light, |lit| {
            statistics.add_light(&lit);
            lit.splats.iter().for_each(|splat| image.add(splat));
        });
        if outcome.interrupted {
            return ControlFlow::Break(());
        }
        if !outcome.lost.is_empty() {
            state.lost = (0..crew.tiles().len() as u32).collect();
        }
        if state.place.begun.is_empty() {
            state.statistics = statistics;
        }
        ControlFlow::Continue(Some(image))
    }

    /// The part of the image that is rendered.
    pub(crate) const fn part(&self) -> Tile {
        let Crop { x, y, width, height } = self.plan.crop;
        Tile { x, y, width, height }
    }

    /// Samples taken so far, also those that were thrown away.
    pub(crate) const fn samples(&self) -> u64 {
        self.state.statistics.samples
    }

    /// Each tile with what it shows now, the tiles of other shares left out.
    fn finish(self, share: Share, stopped: Stopped, unconverged: Option<u64>) -> Part {
        let (state, seconds) = (&self.state, self.elapsed().as_secs_f64());
        let mut part = Part::empty(state.frame, share, Statistics { render_seconds: seconds, ..state.statistics });
        for number in self.of_share {
            part.tiles.insert(number as u32, state.tile_pixels(self.crew.tiles()[number]));
        }
        let mut lost = state.lost.clone();
        lost.sort_unstable();
        lost.dedup();
        Part { stopped, unconverged, lost, ..part }
    }
}

/// Adds the pixels of a tile that went through a pass to what is known of them, and what light paths brought in the same pass.
fn fold(crop: Crop, pixels: &mut [PixelEstimate], tile: &Finished, light: Option<&SplatImage>, sweep: &Sweep<'_>) {
    let mut coverage = tile.alpha.iter().copied();
    for (at, radiance) in sweep.pixels_of(tile.tile).zip(&tile.pixels) {
        let index = place_of(crop, at);
        let brought = light.map_or(Rgb::BLACK, |light| light.radiance(index));
        pixels[index].add(*radiance + brought, coverage.next().unwrap_or(1.0), sweep.spp);
    }
}

/// Where a pixel of the image is among those of a part of it.
const fn place_of(crop: Crop, [x, y]: [u32; 2]) -> usize {
    (y - crop.y) as usize * crop.width as usize + (x - crop.x) as usize
}

fn rounded_coverage(pixel: &PixelEstimate) -> f32 {
    pixel.coverage().clamp(0.0, 1.0) as f32
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
