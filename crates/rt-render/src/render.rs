//! The loop over tiles, pixels and samples.

use std::sync::atomic::AtomicBool;
use std::time::Instant;

use rt_image::Image;
use rt_math::Rgb;
use rt_scene_io::{Integrator, Settings};
use rt_shading::{AmbientOcclusion, AovIntegrator, Clamp, Follows, LightTracingIntegrator, PathSettings};

use crate::{
    Crop, ErrorEstimate, RenderError, RenderPlan, Statistics, StopRule, Stopped,
    checkpoint::Checkpoint,
    crew::Crew,
    observer::{Kept, Observer, RenderSnapshot, State},
    part::{Frame, Part, Share, TilePixels},
    plan::View,
    splats::SplatImage,
    tile::{Task, Worker},
    tiles::Tile,
};

/// How to run a plan; none of it changes what a pixel shows.
#[derive(Clone, Copy, Debug, Default)]
pub struct RunOptions<'a> {
    /// Number of threads; 0 for one per processor.
    pub threads: usize,
    /// Count nodes, primitive tests and hits as well as rays.
    pub count: bool,
    /// Keep the standard error of each pixel and the number of its samples.
    pub maps: bool,
    /// The tiles to render.
    pub share: Share,
    /// May be set at any time, by a signal or another thread: the tiles that are being rendered are finished, no other is begun,
    /// and the render ends as [`Stopped::Interrupted`].
    pub interrupt: Option<&'a AtomicBool>,
}

/// How far a render has come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Camera samples taken.
    pub samples: u64,
    /// Camera samples in all; a guess where time, error or edges decide.
    pub total_samples: u64,
    /// Rays traced so far, of all kinds.
    pub rays: u64,
    /// Where a progressive render stands.
    pub pass: Option<PassProgress>,
}

/// Where a progressive render stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PassProgress {
    /// Passes finished.
    pub finished: u32,
    /// Samples of the pixel that has most.
    pub spp: u32,
    /// Estimated root mean square error of the picture so far, from two passes on.
    pub rmse: Option<f64>,
    /// Distance from the target error, if there is one and an estimate is known.
    pub towards: Option<Towards>,
}

/// Estimated and wanted error of a render that ends by its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Towards {
    /// Relative root mean square error of the image.
    Image {
        /// Current estimate.
        error: f64,
        /// Error at which the render ends.
        target: f64,
    },
    /// Share of the pixels that have reached their error.
    Pixels {
        /// Current share.
        share: f64,
        /// Share at which the render ends.
        target: f64,
    },
}

/// A finished render.
#[derive(Clone, Debug)]
pub struct Rendering {
    /// The picture, in linear radiance.
    pub film: Image,
    /// What it took.
    pub statistics: Statistics,
    /// What ended it.
    pub stopped: Stopped,
    /// How far it is from the truth; `None` if there was but one pass, or all are the same.
    pub error: Option<ErrorEstimate>,
    /// Samples that the pixels of the picture are made of.
    pub samples_per_pixel: SampleRange,
    /// Pixels that have not reached the error, where each has to ([`Criterion::Pixels`](crate::Criterion)).
    pub unconverged: Option<u64>,
    /// With [`RunOptions::maps`], the standard error of each pixel, by channel; infinite after one pass.
    pub standard_error: Option<Image>,
    /// With [`RunOptions::maps`], the samples of each pixel, in all channels.
    pub sample_counts: Option<Image>,
    /// What a worker has failed at, by a defect of this program: these tiles lack some of their samples, or are black.
    pub lost: Vec<Crop>,
}

/// Samples of the pixels of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleRange {
    /// Of the pixel that has fewest.
    pub least: u32,
    /// Of all pixels.
    pub mean: f64,
    /// Of the pixel that has most.
    pub most: u32,
}

impl RenderPlan<'_> {
    /// Renders the picture with the samples that its scene asks for. The observer is called on this thread after each tile.
    ///
    /// # Errors
    /// [`RenderError::Threads`] if the worker threads cannot be started.
    pub fn render(&self, options: &RunOptions<'_>, observer: impl Observer) -> Result<Rendering, RenderError> {
        Ok(self.render_part(options, None, None, observer)?.into_rendering())
    }

    /// Renders pass after pass until the rule says stop; the number of samples in the scene is not looked at. The observer is
    /// called on this thread after each tile.
    ///
    /// # Errors
    /// As [`render_part`](Self::render_part).
    pub fn render_until(
        &self,
        options: &RunOptions<'_>,
        rule: &StopRule,
        observer: impl Observer,
    ) -> Result<Rendering, RenderError> {
        Ok(self.render_part(options, Some(rule), None, observer)?.into_rendering())
    }

    /// Renders the tiles of [`RunOptions::share`], with the samples that the scene asks for or until the rule says stop, and goes on
    /// from a checkpoint if there is one. Apart from what depends on the clock, the result is the same to the bit with
    /// and without interruptions.
    ///
    /// # Errors
    /// [`RenderError::Threads`] if the worker threads cannot be started, [`RenderError::TargetError`] and
    /// [`RenderError::NoSamples`] for a rule with such numbers, [`RenderError::AdaptiveUntil`] for a rule and a plan that tells
    /// pixels apart in object space, [`RenderError::SamePasses`] for an error that would never be known,
    /// [`RenderError::SharedUntil`] for a rule and a share of the tiles, and [`RenderError::Checkpoint`] for a checkpoint that was
    /// not made with the same plan, rule and options.
    pub fn render_part(
        &self,
        options: &RunOptions<'_>,
        rule: Option<&StopRule>,
        from: Option<Checkpoint>,
        observer: impl Observer,
    ) -> Result<Part, RenderError> {
        if let Some(rule) = rule {
            self.check_rule(rule, options.share)?;
        }
        let crew = Crew::new(self, options)?;
        let frame = Frame::new(self, options);
        let statistics = Statistics::new(&crew, self);
        if rule.is_some() || self.light_sources.is_some() {
            let state = Checkpoint::passes_of(from, frame, options.share, rule, statistics)?;
            Ok(self.render_passes(&crew, options.share, rule, state, observer))
        } else {
            let part = Checkpoint::part_of(from, frame, options.share, statistics)?;
            Ok(self.render_tiles(&crew, part, observer))
        }
    }

    fn check_rule(&self, rule: &StopRule, share: Share) -> Result<(), RenderError> {
        rule.validate()?;
        if self.simple_pass_spp.is_some() {
            return Err(RenderError::AdaptiveUntil);
        }
        if rule.target.is_some() && !self.passes_differ() {
            return Err(RenderError::SamePasses(self.pattern.name()));
        }
        if share != Share::ALL {
            return Err(RenderError::SharedUntil);
        }
        Ok(())
    }

    /// Tile after tile, each with all of its samples, so that no sums of the whole image are kept.
    fn render_tiles(&self, crew: &Crew<'_>, mut part: Part, mut observer: impl Observer) -> Part {
        let (started, spent) = (Instant::now(), part.statistics.render_seconds);
        let sweep = self.all_passes();
        let is_of_share = |number: &usize| part.share.holds(*number);
        let numbers: Vec<_> = (0..crew.tiles().len()).filter(is_of_share).collect();
        let area = |number: usize| crew.tiles()[number].area();
        let pixels = numbers.iter().map(|&number| area(number)).sum::<u64>();
        let (done, left): (Vec<_>, Vec<_>) =
            numbers.iter().partition(|number| part.tiles.contains_key(&(**number as u32)));
        let mut pixels_done = done.iter().map(|&number| area(number)).sum::<u64>();
        let outcome = crew.sweep(&sweep, &left, |number, tile| {
            let maps = part.frame.maps;
            part.tiles.insert(number as u32, TilePixels::new(&tile, self.samples_per_pixel(), maps));
            let statistics = &mut part.statistics;
            statistics.add(&tile);
            statistics.render_seconds = spent + started.elapsed().as_secs_f64();
            pixels_done += tile.pixels.len() as u64;
            let total_samples = match self.simple_pass_spp {
                None => pixels * sweep.samples_per_pixel(),
                Some(_) => (statistics.samples as f64 * (pixels as f64 / pixels_done as f64)) as u64,
            };
            let rays = statistics.counters.total().rays;
            let progress = Progress { samples: statistics.samples, total_samples, rays, pass: None };
            observer.tile_done(&RenderSnapshot { progress, tile: tile.tile, state: State::Tiles(&part) });
        });
        part.statistics.passes = self.passes;
        part.statistics.render_seconds = spent + started.elapsed().as_secs_f64();
        part.stopped = if outcome.interrupted { Stopped::Interrupted } else { Stopped::Samples };
        part.lost = outcome.lost.iter().map(|&number| number as u32).collect();
        if outcome.interrupted || !outcome.lost.is_empty() {
            observer.unfinished(&Kept(State::Tiles(&part)));
        }
        part
    }

    /// The radiance of one pixel as it is before the film rounds it to `f32`; (`x`, `y`) counts from the upper left
    /// corner of the whole image. `None` outside of what the plan renders.
    pub fn pixel(&self, x: u32, y: u32) -> Option<Rgb> {
        let Crop { x: left, y: top, width, height } = self.crop;
        let inside = (left..left + width).contains(&x) && (top..top + height).contains(&y);
        let sweep = self.all_passes();
        let task = Task::new(Tile { x, y, width: 1, height: 1 }, &sweep);
        let pixel = inside.then(|| self.render_tile(&task, false, &mut Worker::new(self)).pixels[0])?;
        Some(pixel + self.splatted((y - top) as usize * width as usize + (x - left) as usize))
    }

    /// What light paths bring to a pixel, by its place in what is rendered: the mean of all passes.
    fn splatted(&self, pixel: usize) -> Rgb {
        let mut tracer = LightTracingIntegrator::new(self.view.path_settings(), self.needs);
        let mut sum = Rgb::BLACK;
        for light in (0..self.passes).filter_map(|pass| self.light_pass(pass, self.pass_spp)) {
            let mut image = SplatImage::new(self.crop, self.filter);
            for chunk in 0..light.chunks() {
                self.trace_light(light, chunk, false, &mut tracer).splats.iter().for_each(|splat| image.add(splat));
            }
            sum += image.radiance(pixel);
        }
        sum / f64::from(self.passes)
    }
}

/// What a film holds of a value.
pub(crate) fn rounded(value: Rgb) -> [f32; 3] {
    value.to_array().map(|component| component as f32)
}

impl View {
    /// What the integrator of the settings looks at.
    pub(crate) fn new(settings: &Settings, near: f64, far: f64) -> Self {
        let paths = |max_depth, follows| {
            let clamp = settings.clamp.and_then(Clamp::new).unwrap_or_default();
            Self::Paths(PathSettings { max_depth, roulette_from: settings.roulette_from, follows, clamp })
        };
        match settings.integrator {
            Integrator::Whitted => Self::Light,
            Integrator::Distributed => paths(settings.depth, Follows::Reflections),
            Integrator::Path => paths(settings.depth, Follows::Everything),
            Integrator::Caustics => paths(settings.depth, Follows::AllButCaustics),
            Integrator::Direct => paths(0, Follows::Everything),
            Integrator::AmbientOcclusion => {
                Self::AmbientOcclusion(AmbientOcclusion { reach: settings.occlusion_distance })
            }
            Integrator::Normals => Self::FirstHit(AovIntegrator::Normals),
            Integrator::Depth => Self::FirstHit(AovIntegrator::Depth { near, far }),
            Integrator::Uv => Self::FirstHit(AovIntegrator::Uv),
            Integrator::Cost => Self::Cost,
        }
    }
}
