//! A tile of the image, from samples to pixels.

use rt_accel::{AnyAccelerator, wide::SmallSet};
use rt_camera::SampleStream;
use rt_geometry::{Counters, Hit, NoProbe, Probe, RayCounts};
use rt_math::{Ray, Rgb};
use rt_scene_io::Integrator;
use rt_shading::{Background, Interior, Lighting, OcclusionWave, PathTracer, Seen, ShadingCounts, Whitted};

use crate::{
    Crop, RenderPlan,
    cost::cost,
    error_estimate::ErrorSums,
    estimate::PixelEstimate,
    passes::{PixelMask, Sweep},
    pixel::Pixel,
    plan::{View, World},
    surroundings::CameraMedium,
    tiles::Tile,
    trace::{Surfaces, WorldTracer},
    visible::{self, InView},
    wave::CameraWave,
};

/// What structures report to: a probe that counts all, or none. Rays are counted beside it, so that structures need no
/// code for a third.
pub(crate) trait Countable: Probe + Default + Send {
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

/// What a thread does at a time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Task<'a> {
    pub(crate) tile: Tile,
    pub(crate) sweep: &'a Sweep<'a>,
    /// The pixels of the tile that show no edge, where pixels are told apart in object space; known once it is begun.
    pub(crate) simple: Option<&'a PixelMask>,
}

impl<'a> Task<'a> {
    pub(crate) const fn new(tile: Tile, sweep: &'a Sweep<'a>) -> Self {
        Self { tile, sweep, simple: None }
    }

    fn is_simple(&self, pixel: [u32; 2]) -> bool {
        self.simple.is_some_and(|simple| simple.contains(pixel))
    }

    /// Samples per pass of a pixel.
    pub(crate) fn spp_of(&self, pixel: [u32; 2]) -> u32 {
        self.sweep.simple_spp.filter(|_| self.is_simple(pixel)).unwrap_or(self.sweep.spp)
    }
}

/// A rendered tile on its way to the film: its pixels row by row, but for those that the sweep leaves out.
pub(crate) struct Finished {
    pub(crate) tile: Tile,
    /// Radiance, not yet rounded to what a film holds.
    pub(crate) pixels: Vec<Rgb>,
    /// Coverage; empty unless the plan asks for it.
    pub(crate) alpha: Vec<f64>,
    with_alpha: bool,
    with_counts: bool,
    /// Squares of standard errors; empty after a single pass.
    pub(crate) variances: Vec<Rgb>,
    /// Samples of each pixel; empty where all have the same number.
    pub(crate) counts: Vec<u32>,
    /// Samples of all pixels.
    pub(crate) samples: u64,
    /// Pixels that show no edge.
    pub(crate) simple_pixels: u64,
    pub(crate) error: ErrorSums,
    pub(crate) counters: Counters,
    /// Samples that met a surface.
    pub(crate) camera_hits: u64,
    pub(crate) primary_rays_spared: u64,
    pub(crate) shading: ShadingCounts,
    pub(crate) bad_samples: u64,
}

impl Finished {
    /// A tile without its pixels.
    pub(crate) fn new(task: &Task<'_>, with_alpha: bool) -> Self {
        let tile = task.tile;
        let count = tile.width as usize * tile.height as usize;
        let room = |needed: bool| if needed { count } else { 0 };
        Self {
            tile,
            pixels: Vec::with_capacity(count),
            alpha: Vec::with_capacity(room(with_alpha)),
            with_alpha,
            with_counts: task.simple.is_some(),
            variances: Vec::with_capacity(room(task.sweep.count > 1)),
            counts: Vec::with_capacity(room(task.simple.is_some())),
            samples: 0,
            simple_pixels: task.simple.map_or(0, |simple| simple.count() as u64),
            error: ErrorSums::default(),
            counters: Counters::default(),
            camera_hits: 0,
            primary_rays_spared: 0,
            shading: ShadingCounts::default(),
            bad_samples: 0,
        }
    }

    /// Adds the next pixel of the tile.
    pub(crate) fn push(&mut self, pixel: &PixelEstimate) {
        self.pixels.push(pixel.mean());
        if self.with_alpha {
            self.alpha.push(pixel.coverage());
        }
        self.variances.extend(pixel.variance());
        self.samples += u64::from(pixel.samples());
        if self.with_counts {
            self.counts.push(pixel.samples());
        }
        self.error.add(pixel);
    }
}

/// What a thread uses again from tile to tile.
pub(crate) struct Worker {
    whitted: Whitted,
    paths: PathTracer<SampleStream>,
    occlusion: OcclusionWave,
    camera: CameraWave,
    hits: Vec<Option<Hit>>,
}

impl Worker {
    pub(crate) fn new(plan: &RenderPlan<'_>) -> Self {
        Self {
            whitted: Whitted::new(plan.depth, plan.min_contribution, plan.needs),
            paths: PathTracer::new(plan.view.path_settings(), plan.needs),
            occlusion: OcclusionWave::default(),
            camera: CameraWave::default(),
            hits: Vec::new(),
        }
    }
}

impl RenderPlan<'_> {
    /// Chooses the concrete types, one `match` for each axis.
    pub(crate) fn render_tile(&self, task: &Task<'_>, count: bool, worker: &mut Worker) -> Finished {
        if count || self.integrator == Integrator::Cost {
            self.with_probe::<Counters>(task, worker)
        } else {
            self.with_probe::<NoProbe>(task, worker)
        }
    }

    fn with_probe<S: Countable>(&self, task: &Task<'_>, worker: &mut Worker) -> Finished {
        match &self.world {
            World::Spheres(world, structure) => self.with_world::<_, S>(world, structure, task, worker),
            World::Parts(top, levels) => self.with_world::<_, S>(&top.set(levels), &top.structure, task, worker),
        }
    }

    fn with_world<W: Surfaces, S: Countable>(
        &self,
        world: &W,
        structure: &AnyAccelerator,
        task: &Task<'_>,
        worker: &mut Worker,
    ) -> Finished {
        let simple = task.sweep.simple_spp.map(|_| self.simple_pixels(task.tile, world, structure));
        let task = &Task { simple: simple.as_ref(), ..*task };
        let few = self.few_in(task.tile, world, structure);
        let in_view = match (&few, &self.visible) {
            (Some(few), _) => InView::Few(few),
            (None, Some(part)) => InView::Part(part),
            (None, None) => InView::All(structure),
        };
        if in_view.is_empty()
            && let Some(finished) = self.empty_tile(task)
        {
            return finished;
        }
        let Worker { whitted, paths, occlusion, camera, hits } = worker;
        let lighting = Lighting { appearance: &self.appearance, emitters: &self.emitters, bsdfs: &self.bsdfs };
        let mut tracer = WorldTracer::new(world, structure, in_view, S::default()).with_buffer(core::mem::take(hits));
        let mut finished = match (&self.view, &self.surroundings) {
            (View::Light, CameraMedium::Same(interior)) => {
                whitted.set_surroundings(interior);
                self.sample_tile(task, camera, |wave, seen| {
                    whitted.radiance_of(&mut tracer, &self.appearance, wave.rays, seen);
                })
            }
            (View::Paths(_), CameraMedium::Same(interior)) => {
                paths.set_surroundings(interior);
                self.sample_tile(task, camera, |wave, seen| {
                    paths.radiance_of(&mut tracer, lighting, wave.rays, wave.samplers, seen);
                })
            }
            (View::Paths(_), CameraMedium::ByRay(reach)) => {
                let mut interior = Interior::default();
                self.sample_tile(task, camera, |wave, seen| {
                    for (i, ray) in wave.rays.iter().enumerate() {
                        interior.look_around_within(*reach, &mut tracer, &self.appearance.materials, &ray.0);
                        paths.set_surroundings(&interior);
                        let (rays, samplers) = (&wave.rays[i..=i], &wave.samplers[i..=i]);
                        paths.radiance_of(&mut tracer, lighting, rays, samplers, &mut seen[i..=i]);
                    }
                })
            }
            (View::AmbientOcclusion(view), _) => self.sample_tile(task, camera, |wave, seen| {
                occlusion.radiance_of(view, &mut tracer, wave.rays, wave.samplers, seen);
            }),
            (View::Light, CameraMedium::ByRay(reach)) => {
                let mut interior = Interior::default();
                self.sample_each(task, camera, |ray| {
                    interior.look_around_within(*reach, &mut tracer, &self.appearance.materials, ray);
                    whitted.set_surroundings(&interior);
                    whitted.radiance(&mut tracer, &self.appearance, ray)
                })
            }
            (View::FirstHit(view), _) => {
                self.sample_tile(task, camera, |wave, seen| view.radiance_of(&mut tracer, wave.rays, seen))
            }
            (View::Cost, _) => self.sample_each(task, camera, |ray| cost(&mut tracer, ray)),
        };
        finished.counters = tracer.probe.counters(tracer.rays);
        finished.primary_rays_spared = tracer.spared;
        finished.shading = whitted.take_counts();
        finished.shading += paths.take_counts();
        *hits = tracer.into_buffer();
        finished
    }

    /// For what can only be told of one ray after the other.
    fn sample_each(
        &self,
        task: &Task<'_>,
        camera: &mut CameraWave,
        mut radiance: impl FnMut(&Ray) -> Seen,
    ) -> Finished {
        self.sample_tile(task, camera, |wave, seen| {
            for ((ray, _), seen) in wave.rays.iter().zip(seen) {
                *seen = radiance(ray);
            }
        })
    }

    /// What the camera rays of the tile can meet, if that is little.
    fn few_in<W: Surfaces>(&self, tile: Tile, world: &W, structure: &AnyAccelerator) -> Option<SmallSet> {
        let Tile { x, y, width, height } = tile;
        let volume = self.narrows.then(|| self.view_volume(Crop { x, y, width, height }))?;
        let few = visible::few(world, structure, self.visible.as_ref(), &volume)?;
        Some(match self.wanted.simd {
            Some(level) => few.with_level(level),
            None => few,
        })
    }

    /// A tile in whose part of the view there is nothing, if that can be told without a ray: where all samples see the
    /// same background and weigh the same, so that no pixel depends on where they are.
    fn empty_tile(&self, task: &Task<'_>) -> Option<Finished> {
        let (View::Light | View::Paths(_), CameraMedium::Same(_), Background::Constant(radiance)) =
            (&self.view, &self.surroundings, &self.appearance.background)
        else {
            return None;
        };
        if self.filter.has_negative_lobes() {
            return None;
        }
        let sweep = task.sweep;
        let pixel_of = |spp: u32| {
            let mut pass = Pixel::new(self.transparent);
            for _ in 0..spp {
                pass.add(&Seen { radiance: self.backdrop.unwrap_or(*radiance), hit: false }, 1.0);
            }
            let mut pixel = PixelEstimate::default();
            for _ in 0..sweep.count {
                let (radiance, coverage) = pass.mean();
                pixel.add(radiance, coverage, spp);
            }
            (pixel, pass.bad_samples() * u64::from(sweep.count))
        };
        let (usual, simple) = (pixel_of(sweep.spp), sweep.simple_spp.map(pixel_of));
        let mut finished = Finished::new(task, self.transparent);
        for at in sweep.pixels_of(task.tile) {
            let (pixel, bad_samples) = simple.as_ref().filter(|_| task.is_simple(at)).unwrap_or(&usual);
            finished.push(pixel);
            finished.bad_samples += bad_samples;
        }
        finished.primary_rays_spared = finished.samples;
        Some(finished)
    }
}
