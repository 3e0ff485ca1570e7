//! Rendering of a plan: tile by tile, or pass by pass.

use std::time::{Duration, Instant};

use rt_math::Rgb;
use rt_shading::LightTracingIntegrator;

use crate::{
    Criterion, Crop, Progress, RenderError, RenderPlan, Rendering, RunOptions, ShardSpec, Statistics, StopRule,
    Stopped,
    checkpoint::Checkpoint,
    film::film_tile::{FilmLayout, FilmTile},
    first_hit_layers::FilmLayers,
    forecast::Forecast,
    observer::{CheckpointRef, FilmState, Observer, RenderSnapshot},
    pass_state::PassState,
    progressive::Progressive,
    render_tile::ThreadState,
    shard::Shard,
    splats::SplatImage,
    tile_job::TileJob,
    tile_scheduler::TileScheduler,
};

impl RenderPlan<'_> {
    /// Renders the image with the number of samples of the scene. The observer is called on this thread after each tile.
    ///
    /// # Errors
    /// Those of [`render_shard`](Self::render_shard). At present none of them can occur here.
    pub fn render(&self, options: &RunOptions<'_>, observer: impl Observer) -> Result<Rendering, RenderError> {
        Ok(self.render_shard(options, None, None, observer)?.into_rendering())
    }

    /// Renders pass by pass until the stop rule applies; ignores the number of samples in the scene. The observer is called on
    /// this thread after each tile.
    ///
    /// # Errors
    /// Those of [`render_shard`](Self::render_shard).
    pub fn render_until(
        &self,
        options: &RunOptions<'_>,
        rule: &StopRule,
        observer: impl Observer,
    ) -> Result<Rendering, RenderError> {
        Ok(self.render_shard(options, Some(rule), None, observer)?.into_rendering())
    }

    /// Renders the tiles of [`RunOptions::shard`], and resumes from a checkpoint if one is given.
    ///
    /// Without a rule, pixels take the number of samples of the scene. With a rule, passes follow until it applies. A resumed
    /// render is bit-identical to an uninterrupted one, except for times and for passes that depend on the clock.
    ///
    /// # Errors
    /// * [`RenderError::TargetError`], [`RenderError::TargetShare`], [`RenderError::NoSamples`]: a number of the rule is invalid.
    /// * [`RenderError::AdaptiveUntil`]: a rule with adaptive sampling in object space.
    /// * [`RenderError::SamePasses`]: a target error, but all passes are equal.
    /// * [`RenderError::ShardWithStopRule`]: a rule with a shard.
    /// * [`RenderError::Checkpoint`]: the checkpoint has another size, shard, rule or options.
    pub fn render_shard(
        &self,
        options: &RunOptions<'_>,
        rule: Option<&StopRule>,
        from: Option<Checkpoint>,
        mut observer: impl Observer,
    ) -> Result<Shard, RenderError> {
        self.render_observed(options, rule, from, &mut observer)
    }

    /// True if [`render_shard`](Self::render_shard) with these options and this rule can resume from `checkpoint`: size, shard, rule
    /// and options are the same.
    pub fn accepts(&self, checkpoint: &Checkpoint, options: &RunOptions<'_>, rule: Option<&StopRule>) -> bool {
        checkpoint.fits(FilmLayout::new(self, options), options.shard, rule, self.is_pass_by_pass(rule))
    }

    const fn is_pass_by_pass(&self, rule: Option<&StopRule>) -> bool {
        rule.is_some() || self.scene.light_sources.is_some()
    }

    /// [`render_shard`](Self::render_shard), compiled once for all types of observers.
    fn render_observed(
        &self,
        options: &RunOptions<'_>,
        rule: Option<&StopRule>,
        from: Option<Checkpoint>,
        observer: &mut dyn Observer,
    ) -> Result<Shard, RenderError> {
        if let Some(rule) = rule {
            self.check_rule(rule, options.shard)?;
        }
        let pass_by_pass = self.is_pass_by_pass(rule);
        // The first pass may have too few samples for layers.
        let layers_of_run = if pass_by_pass { &[] } else { options.layers };
        let scheduler = TileScheduler::new(self, &RunOptions { layers: layers_of_run, ..*options });
        let layout = FilmLayout::new(self, options);
        let new_layers = || FilmLayers::new(self.frame.crop, options.layers, rule.is_none());
        let layers = (!options.layers.is_empty()).then(new_layers);
        let statistics = Statistics::new(scheduler.threads(), self.build_seconds());
        if pass_by_pass {
            let state = Checkpoint::passes_of(from, layout, options.shard, rule, statistics)?;
            Ok(Shard { layers, ..self.render_pass_by_pass(&scheduler, options.shard, rule, state, observer) })
        } else {
            let shard = Checkpoint::shard_of(from, layout, options.shard, statistics)?;
            Ok(self.render_tile_by_tile(&scheduler, Shard { layers, ..shard }, observer))
        }
    }

    fn check_rule(&self, rule: &StopRule, spec: ShardSpec) -> Result<(), RenderError> {
        rule.validate()?;
        if self.frame.simple_pass_spp.is_some() {
            return Err(RenderError::AdaptiveUntil);
        }
        if rule.target.is_some() && !self.passes_differ() {
            return Err(RenderError::SamePasses(self.frame.sampler.name()));
        }
        if spec != ShardSpec::ALL {
            return Err(RenderError::ShardWithStopRule);
        }
        Ok(())
    }

    /// Renders each tile with all of its samples. Pixel accumulators are kept for tiles in progress only.
    fn render_tile_by_tile(
        &self,
        scheduler: &TileScheduler<'_>,
        mut shard: Shard,
        observer: &mut dyn Observer,
    ) -> Shard {
        let (started, spent) = (Instant::now(), shard.statistics.render_seconds);
        let pass_spec = self.frame.all_passes();
        let has_errors = shard.layout.maps && pass_spec.count > 1;
        let is_of_shard = |number: &usize| shard.spec.holds(*number);
        let numbers: Vec<_> = (0..scheduler.tiles().len()).filter(is_of_shard).collect();
        let area = |number: usize| scheduler.tiles()[number].area();
        let pixels = numbers.iter().map(|&number| area(number)).sum::<u64>();
        let (done, left): (Vec<_>, Vec<_>) =
            numbers.iter().partition(|number| shard.tiles.contains_key(&(**number as u32)));
        let mut pixels_done = done.iter().map(|&number| area(number)).sum::<u64>();
        let outcome = scheduler.render_tiles(&pass_spec, &left, |number, mut tile| {
            if let Some(layers) = &mut shard.layers {
                layers.insert(tile.tile, core::mem::take(&mut tile.layers));
            }
            shard.tiles.insert(number as u32, FilmTile::new(&tile.pixels, shard.layout, has_errors));
            let statistics = &mut shard.statistics;
            statistics.join(&tile.statistics);
            statistics.render_seconds = spent + started.elapsed().as_secs_f64();
            pixels_done += tile.pixels.len() as u64;
            let total_samples = match self.frame.simple_pass_spp {
                None => pixels * pass_spec.samples_per_pixel(),
                Some(_) => (statistics.samples as f64 * (pixels as f64 / pixels_done as f64)) as u64,
            };
            let rays = statistics.counters.total().rays;
            let progress = Progress { samples: statistics.samples, total_samples, rays, pass: None };
            observer.tile_done(&RenderSnapshot { progress, tile: tile.tile, state: FilmState::Tiles(&shard) });
        });
        shard.statistics.passes = self.frame.passes;
        shard.statistics.render_seconds = spent + started.elapsed().as_secs_f64();
        shard.stopped = if outcome.interrupted { Stopped::Interrupted } else { Stopped::Samples };
        shard.lost = outcome.lost.iter().map(|&number| number as u32).collect();
        if outcome.interrupted || !outcome.lost.is_empty() {
            observer.unfinished(&CheckpointRef(FilmState::Tiles(&shard)));
        }
        shard
    }

    /// Renders passes over the whole image: a fixed number without a rule, or until the rule applies. The splats of one pass are
    /// held in memory.
    pub(crate) fn render_pass_by_pass(
        &self,
        scheduler: &TileScheduler<'_>,
        spec: ShardSpec,
        rule: Option<&StopRule>,
        state: PassState,
        observer: &mut dyn Observer,
    ) -> Shard {
        let fixed = StopRule { max_spp: self.samples_per_pixel(), ..StopRule::default() };
        let mut render = Progressive {
            plan: self,
            scheduler,
            rule: rule.copied().unwrap_or(fixed),
            started: Instant::now(),
            spent: Duration::try_from_secs_f64(state.statistics.render_seconds).unwrap_or_default(),
            tiles: (0..scheduler.tiles().len()).filter(|number| spec.holds(*number)).collect(),
            state,
            forecast: Forecast::default(),
            converged: None,
            observer,
        };
        let (stopped, unconverged) = match rule {
            None => (render.run_fixed(), None),
            Some(StopRule { target: None, .. }) => (render.run_progressive(), None),
            Some(StopRule { target: Some(target), .. }) => {
                let (stopped, unconverged) = render.refine(*target);
                (stopped, unconverged.filter(|_| target.criterion != Criterion::Image))
            }
        };
        if stopped == Stopped::Interrupted {
            render.observer.unfinished(&CheckpointRef(FilmState::Passes(&render.state)));
        }
        render.finish(spec, stopped, unconverged)
    }

    /// Radiance of one pixel, not rounded to `f32`. Coordinates count from the upper left corner of the whole image; `None`
    /// outside of the crop.
    pub fn pixel(&self, x: u32, y: u32) -> Option<Rgb> {
        let crop = self.frame.crop;
        let inside = (crop.x..crop.x + crop.width).contains(&x) && (crop.y..crop.y + crop.height).contains(&y);
        let pass_spec = self.frame.all_passes();
        let job = TileJob::new(Crop { x, y, width: 1, height: 1 }, &pass_spec, None);
        let pixel = inside.then(|| self.render_tile(&job, false, &mut ThreadState::new(self)).pixels[0].mean())?;
        Some(pixel + self.splatted(crop.pixel_index([x, y])))
    }

    /// Radiance of light paths at a pixel of the crop: the mean of all passes.
    fn splatted(&self, pixel: usize) -> Rgb {
        let mut tracer = LightTracingIntegrator::new(self.integrator.path_settings(), self.scene.features);
        let mut sum = Rgb::BLACK;
        for light in (0..self.frame.passes).filter_map(|pass| self.light_pass(pass, self.frame.pass_spp)) {
            let mut image = SplatImage::new(self.frame.crop, self.frame.filter);
            for chunk in 0..light.chunks() {
                self.trace_light(light, chunk, false, &mut tracer).splats.iter().for_each(|splat| image.add(splat));
            }
            sum += image.radiance(pixel);
        }
        sum / f64::from(self.frame.passes)
    }
}
