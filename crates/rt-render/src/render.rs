//! The loop over tiles, pixels and samples.

use std::{sync::mpsc, time::Instant};

use rayon::prelude::*;
use rt_accel::AnyStructure;
use rt_camera::Film;
use rt_geometry::SurfaceNeeds;
use rt_math::{Counters, DVec2, Interval, NoProbe, Probe, Ray, RayCounts, RayKind, Rgb, Tally};
use rt_scene_io::Integrator;
use rt_shading::{Background, FirstHitView, Interior, Seen, ShadingCounts, Tracer, Whitted};

use crate::{
    Crop, RenderError, RenderPlan, Statistics,
    pixel::Pixel,
    plan::{View, World},
    surroundings::Surroundings,
    tiles::{Tile, tiles},
    trace::{Surfaces, WorldTracer},
    visible::Visible,
    world::Parts,
};

/// Positions of samples that are computed at a time.
const POSITIONS: u32 = 64;

/// How to run a plan; none of it changes the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RunOptions {
    /// Number of threads; 0 for one per processor.
    pub threads: usize,
    /// Count nodes, primitive tests and hits as well as rays.
    pub count: bool,
}

/// How far a render has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Camera samples taken.
    pub samples: u64,
    /// Camera samples in all.
    pub total_samples: u64,
    /// Rays traced so far, of all kinds.
    pub rays: u64,
}

/// A finished render.
#[derive(Clone, Debug)]
pub struct Rendering {
    /// The picture, in linear radiance.
    pub film: Film,
    /// What it took.
    pub statistics: Statistics,
}

/// What structures report to: a probe that counts all, or none. Rays are counted beside it, so that structures need no
/// code for a third.
trait Countable: Probe + Default + Send {
    /// The full table, as far as it is known.
    fn counters(&self, rays: RayCounts) -> Counters;
}

impl Countable for Counters {
    fn counters(&self, _rays: RayCounts) -> Counters {
        *self
    }
}

impl Countable for NoProbe {
    fn counters(&self, rays: RayCounts) -> Counters {
        Counters::from(rays)
    }
}

/// A rendered tile on its way to the film.
struct Finished {
    tile: Tile,
    /// Radiance, not yet rounded to what a film holds.
    pixels: Vec<Rgb>,
    /// Coverage; empty unless the plan asks for it.
    alpha: Vec<f64>,
    counters: Counters,
    shading: ShadingCounts,
    bad_samples: u64,
}

impl Finished {
    /// A tile without its pixels.
    fn new(tile: Tile, with_alpha: bool) -> Self {
        let count = tile.width as usize * tile.height as usize;
        Self {
            tile,
            pixels: Vec::with_capacity(count),
            alpha: Vec::with_capacity(if with_alpha { count } else { 0 }),
            counters: Counters::default(),
            shading: ShadingCounts::default(),
            bad_samples: 0,
        }
    }

    /// Adds the next pixel of the tile.
    fn push(&mut self, pixel: &Pixel) {
        let (radiance, coverage) = pixel.mean();
        self.pixels.push(radiance);
        self.alpha.extend(coverage);
        self.bad_samples += pixel.bad_samples();
    }
}

impl RenderPlan<'_> {
    /// Renders the picture. `progress` is called on this thread after each tile.
    ///
    /// # Errors
    /// [`RenderError::Threads`] if the worker threads cannot be started.
    pub fn render(&self, options: &RunOptions, mut progress: impl FnMut(Progress)) -> Result<Rendering, RenderError> {
        let started = Instant::now();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(options.threads).build()?;
        let crop = self.crop;
        let tiles = tiles(crop.x, crop.y, crop.width, crop.height);
        let mut film = Film::new(crop.width, crop.height, self.transparent);
        let mut statistics = Statistics {
            samples: 0,
            counters: Counters::default(),
            shading: ShadingCounts::default(),
            bad_samples: 0,
            threads: pool.current_num_threads(),
            build_seconds: self.build_seconds,
            render_seconds: 0.0,
        };
        let total_samples = u64::from(crop.width) * u64::from(crop.height) * u64::from(self.spp);
        let (sender, finished) = mpsc::channel();
        // Tiles are rendered in the pool while this thread puts them in their places.
        pool.in_place_scope(|scope| {
            scope.spawn(|_| {
                tiles.par_iter().with_max_len(1).for_each_with(sender, |sender, tile| {
                    // The receiver outlives this loop, so that sending cannot fail.
                    let _ = sender.send(self.render_tile(*tile, options.count));
                });
            });
            for tile in finished {
                self.expose(&mut film, &tile);
                statistics.counters += tile.counters;
                statistics.shading += tile.shading;
                statistics.bad_samples += tile.bad_samples;
                statistics.samples += tile.pixels.len() as u64 * u64::from(self.spp);
                let rays = statistics.counters.total().rays;
                progress(Progress { samples: statistics.samples, total_samples, rays });
            }
        });
        statistics.render_seconds = started.elapsed().as_secs_f64();
        Ok(Rendering { film, statistics })
    }

    /// The radiance of one pixel as it is before the film rounds it to `f32`; (`x`, `y`) counts from the upper left
    /// corner of the whole image. `None` outside of what the plan renders.
    pub fn pixel(&self, x: u32, y: u32) -> Option<Rgb> {
        let Crop { x: left, y: top, width, height } = self.crop;
        let inside = (left..left + width).contains(&x) && (top..top + height).contains(&y);
        let tile = Tile { x, y, width: 1, height: 1 };
        if inside { self.render_tile(tile, false).pixels.first().copied() } else { None }
    }

    /// Rounds a tile to what the film holds, in its place.
    fn expose(&self, film: &mut Film, finished: &Finished) {
        let Tile { x, y, width, height } = finished.tile;
        let stride = film.width() as usize;
        for row in 0..height as usize {
            let at = (y - self.crop.y) as usize * stride + row * stride + (x - self.crop.x) as usize;
            let from = row * width as usize;
            for (place, radiance) in film.pixels_mut()[at..at + width as usize].iter_mut().zip(&finished.pixels[from..])
            {
                *place = radiance.to_array().map(|c| c as f32);
            }
            if let Some(alpha) = film.alpha_mut() {
                for (place, coverage) in alpha[at..at + width as usize].iter_mut().zip(&finished.alpha[from..]) {
                    *place = *coverage as f32;
                }
            }
        }
    }

    /// Chooses the concrete types, one `match` for each axis.
    fn render_tile(&self, tile: Tile, count: bool) -> Finished {
        if count || self.integrator == Integrator::Cost {
            self.with_probe::<Counters>(tile)
        } else {
            self.with_probe::<NoProbe>(tile)
        }
    }

    fn with_probe<S: Countable>(&self, tile: Tile) -> Finished {
        match &self.world {
            World::Spheres(world, structure) => self.with_world::<_, S>(world, structure, tile),
            World::Parts(top, levels) => {
                self.with_world::<_, S>(&Parts { parts: &top.parts, levels }, &top.structure, tile)
            }
        }
    }

    fn with_world<W: Surfaces, S: Countable>(&self, world: &W, structure: &AnyStructure, tile: Tile) -> Finished {
        let few = self.few_in(tile, world, structure);
        if few.as_ref().is_some_and(Visible::is_empty)
            && let Some(finished) = self.empty_tile(tile)
        {
            return finished;
        }
        let visible = few.as_ref().or(self.visible.as_ref());
        let mut tracer = WorldTracer::new(world, structure, visible, S::default());
        let mut whitted = Whitted::new(self.depth, self.min_contribution, self.needs);
        let mut finished = match (&self.view, &self.surroundings) {
            (View::Light, Surroundings::Same(interior)) => {
                whitted.set_surroundings(interior);
                self.sample_tile(tile, |ray| whitted.radiance(&mut tracer, &self.appearance, ray))
            }
            (View::Light, Surroundings::ByRay(reach)) => {
                let mut interior = Interior::default();
                self.sample_tile(tile, |ray| {
                    interior.clear();
                    if reach.contains(ray.origin) {
                        interior.look_around(&mut tracer, &self.appearance.materials, ray);
                    }
                    whitted.set_surroundings(&interior);
                    whitted.radiance(&mut tracer, &self.appearance, ray)
                })
            }
            (View::FirstHit(view), _) => self.sample_tile(tile, |ray| view.radiance(&mut tracer, ray)),
            (View::Cost, _) => self.sample_tile(tile, |ray| cost(&mut tracer, ray)),
        };
        finished.counters = tracer.probe.counters(tracer.rays);
        finished.shading = whitted.counts();
        finished
    }

    /// What the camera rays of the tile can meet, if that is little.
    fn few_in<W: Surfaces>(&self, tile: Tile, world: &W, structure: &AnyStructure) -> Option<Visible> {
        let Tile { x, y, width, height } = tile;
        let volume = self.narrows.then(|| self.view_volume(Crop { x, y, width, height }))?;
        Visible::few(world, structure, self.visible.as_ref(), &volume)
    }

    fn sample_tile(&self, tile: Tile, mut radiance: impl FnMut(&Ray) -> Seen) -> Finished {
        let mut finished = Finished::new(tile, self.transparent);
        let mut positions = vec![[0.0; 2]; self.spp.min(POSITIONS) as usize];
        for [x, y] in tile.pixels() {
            let corner = DVec2::new(f64::from(x), f64::from(y)) + self.sample_offset;
            let mut pixel = Pixel::new(self.transparent);
            for first in (0..self.spp).step_by(positions.len()) {
                let count = positions.len().min((self.spp - first) as usize);
                self.sampler.positions([x, y], first, &mut positions[..count]);
                for &position in &positions[..count] {
                    let (offset, weight) = self.filter.sample(position);
                    let ray = self.camera.ray(corner + offset, 0.0);
                    pixel.add(&radiance(&ray), weight);
                }
            }
            finished.push(&pixel);
        }
        finished
    }

    /// A tile in whose part of the view there is nothing, if that can be told without a ray: where all samples see the
    /// same background and weigh the same, so that no pixel depends on where they are.
    fn empty_tile(&self, tile: Tile) -> Option<Finished> {
        let (View::Light, Surroundings::Same(_), Background::Constant(radiance)) =
            (&self.view, &self.surroundings, self.appearance.background)
        else {
            return None;
        };
        if self.filter.has_negative_lobes() {
            return None;
        }
        let mut pixel = Pixel::new(self.transparent);
        for _ in 0..self.spp {
            pixel.add(&Seen { radiance, hit: false }, 1.0);
        }
        let mut finished = Finished::new(tile, self.transparent);
        tile.pixels().for_each(|_| finished.push(&pixel));
        let mut rays = RayCounts::default();
        rays.rays[RayKind::Primary as usize] = finished.pixels.len() as u64 * u64::from(self.spp);
        finished.counters = Counters::from(rays);
        Some(finished)
    }
}

/// Work of a camera ray, nodes and primitive tests together, on a logarithmic scale from black over blue, red and
/// yellow to white: black is 1 step, white 1024 or more.
fn cost<W: Surfaces, S: Countable>(tracer: &mut WorldTracer<'_, W, S>, ray: &Ray) -> Seen {
    let work = |tally: Tally| tally.nodes + tally.tests;
    let before = work(tracer.probe.counters(tracer.rays).of(RayKind::Primary));
    let needs = SurfaceNeeds { uv: false, shading_normal: false };
    let hit = tracer.closest(ray, Interval::FORWARD, RayKind::Primary, needs);
    let steps = work(tracer.probe.counters(tracer.rays).of(RayKind::Primary)) - before;
    let heat = (rt_math::transcendental::log2(steps.max(1) as f64) / 10.0).min(1.0);
    Seen { radiance: heat_colour(heat), hit: hit.is_some() }
}

fn heat_colour(heat: f64) -> Rgb {
    const STOPS: [Rgb; 5] =
        [Rgb::BLACK, Rgb::new(0.0, 0.05, 0.8), Rgb::new(0.8, 0.0, 0.05), Rgb::new(1.0, 0.8, 0.0), Rgb::WHITE];
    let position = heat * (STOPS.len() - 1) as f64;
    let index = (position as usize).min(STOPS.len() - 2);
    STOPS[index].lerp(STOPS[index + 1], position - index as f64)
}

impl View {
    /// What the integrator of the settings looks at.
    pub(crate) fn new(integrator: Integrator, near: f64, far: f64) -> Self {
        match integrator {
            Integrator::Whitted => Self::Light,
            Integrator::Normals => Self::FirstHit(FirstHitView::Normals),
            Integrator::Depth => Self::FirstHit(FirstHitView::Depth { near, far }),
            Integrator::Uv => Self::FirstHit(FirstHitView::Uv),
            Integrator::Cost => Self::Cost,
        }
    }
}
