//! The loop over tiles, pixels and samples.

use std::time::Instant;

use rt_camera::Film;
use rt_math::Rgb;
use rt_scene_io::{Integrator, Settings};
use rt_shading::{AmbientOcclusion, FirstHitView, Follows, LightTracer, PathSettings};

use crate::{
    Crop, ErrorEstimate, RenderError, RenderPlan, Statistics, Stopped,
    crew::Crew,
    error_estimate::ErrorSums,
    plan::View,
    splats::SplatImage,
    tile::{Finished, Task, Worker},
    tiles::Tile,
};

/// How to run a plan; none of it changes the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RunOptions {
    /// Number of threads; 0 for one per processor.
    pub threads: usize,
    /// Count nodes, primitive tests and hits as well as rays.
    pub count: bool,
    /// Keep the standard error of each pixel and the number of its samples.
    pub maps: bool,
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
}

/// A finished render.
#[derive(Clone, Debug)]
pub struct Rendering {
    /// The picture, in linear radiance.
    pub film: Film,
    /// What it took.
    pub statistics: Statistics,
    /// What ended it.
    pub stopped: Stopped,
    /// How far it is from the truth; `None` if there was but one pass, or all are the same.
    pub error: Option<ErrorEstimate>,
    /// Samples that the pixels of the picture are made of.
    pub samples_per_pixel: SampleRange,
    /// Pixels that have not reached the error that was asked for, if one was.
    pub unconverged: Option<u64>,
    /// With [`RunOptions::maps`], the standard error of each pixel, by channel; infinite after one pass.
    pub standard_error: Option<Film>,
    /// With [`RunOptions::maps`], the samples of each pixel, in all channels.
    pub sample_counts: Option<Film>,
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
    /// Renders the picture with the samples that its scene asks for. `progress` is called on this thread after each tile.
    ///
    /// # Errors
    /// [`RenderError::Threads`] if the worker threads cannot be started.
    pub fn render(&self, options: &RunOptions, mut progress: impl FnMut(Progress)) -> Result<Rendering, RenderError> {
        if self.light_sources.is_some() {
            return self.render_by_passes(options, progress);
        }
        let started = Instant::now();
        let crew = Crew::new(self, options)?;
        let Crop { width, height, .. } = self.crop;
        let sweep = self.all_passes();
        let mut film = Film::new(width, height, self.transparent);
        let mut standard_error = options.maps.then(|| constant_film(width, height, f32::INFINITY));
        let mut statistics = Statistics::new(&crew, self);
        let mut sample_counts = options.maps.then(|| constant_film(width, height, self.samples_per_pixel() as f32));
        let mut range = None;
        let mut pixels_done = 0;
        let mut errors = vec![ErrorSums::default(); if self.passes > 1 { crew.tile_count() } else { 0 }];
        let pixels = u64::from(width) * u64::from(height);
        crew.sweep(&sweep, |index, tile| {
            self.expose(&mut film, standard_error.as_mut(), sample_counts.as_mut(), &tile);
            statistics.add(&tile);
            pixels_done += tile.pixels.len() as u64;
            let counts = tile.counts.iter().copied();
            range = counts.fold(range, |range: Option<[u32; 2]>, count| {
                Some(range.map_or([count; 2], |[least, most]| [least.min(count), most.max(count)]))
            });
            if let Some(error) = errors.get_mut(index) {
                *error = tile.error;
            }
            let rays = statistics.counters.total().rays;
            let total_samples = match self.simple_pass_spp {
                None => pixels * sweep.samples_per_pixel(),
                Some(_) => (statistics.samples as f64 * (pixels as f64 / pixels_done as f64)) as u64,
            };
            progress(Progress { samples: statistics.samples, total_samples, rays, pass: None });
        });
        statistics.passes = self.passes;
        statistics.render_seconds = started.elapsed().as_secs_f64();
        let [least, most] = range.unwrap_or([self.samples_per_pixel(); 2]);
        Ok(Rendering {
            film,
            statistics,
            stopped: Stopped::Samples,
            error: ErrorSums::joined(&errors).estimate().filter(|_| self.passes_differ()),
            samples_per_pixel: SampleRange { least, mean: statistics.samples as f64 / pixels as f64, most },
            unconverged: None,
            standard_error,
            sample_counts,
        })
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
        let mut tracer = LightTracer::new(self.view.path_settings(), self.needs);
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

    /// Rounds a tile to what films hold, in its place.
    fn expose(
        &self,
        film: &mut Film,
        standard_error: Option<&mut Film>,
        sample_counts: Option<&mut Film>,
        finished: &Finished,
    ) {
        let Crop { x: left, y: top, .. } = self.crop;
        let stride = film.width() as usize;
        let places = finished.tile.pixels().map(|[x, y]| (y - top) as usize * stride + (x - left) as usize);
        for (place, radiance) in places.clone().zip(&finished.pixels) {
            film.pixels_mut()[place] = rounded(*radiance);
        }
        if let Some(alpha) = film.alpha_mut() {
            for (place, coverage) in places.clone().zip(&finished.alpha) {
                alpha[place] = coverage.clamp(0.0, 1.0) as f32;
            }
        }
        if let Some(standard_error) = standard_error {
            for (place, variance) in places.clone().zip(&finished.variances) {
                standard_error.pixels_mut()[place] = rounded(variance.map(f64::sqrt));
            }
        }
        if let Some(sample_counts) = sample_counts {
            for (place, count) in places.zip(&finished.counts) {
                sample_counts.pixels_mut()[place] = [*count as f32; 3];
            }
        }
    }
}

/// What a film holds of a value.
pub(crate) fn rounded(value: Rgb) -> [f32; 3] {
    value.to_array().map(|component| component as f32)
}

fn constant_film(width: u32, height: u32, value: f32) -> Film {
    let mut film = Film::new(width, height, false);
    film.pixels_mut().fill([value; 3]);
    film
}

impl View {
    /// What the integrator of the settings looks at.
    pub(crate) fn new(settings: &Settings, near: f64, far: f64) -> Self {
        let paths = |max_depth, follows| {
            Self::Paths(PathSettings { max_depth, roulette_from: settings.roulette_from, follows })
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
            Integrator::Normals => Self::FirstHit(FirstHitView::Normals),
            Integrator::Depth => Self::FirstHit(FirstHitView::Depth { near, far }),
            Integrator::Uv => Self::FirstHit(FirstHitView::Uv),
            Integrator::Cost => Self::Cost,
        }
    }
}
