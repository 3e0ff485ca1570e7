//! A tile of the image, from samples to pixels.

use rt_accel::{AnyAccelerator, wide::Handful};
use rt_camera::SampleStream;
use rt_geometry::{Counters, Hit, NoProbe};
use rt_math::Ray;
use rt_scene_io::Integrator;
use rt_shading::{Background, Interior, Lighting, OcclusionWave, PathTracer, Seen, Whitted};

use crate::{
    Crop, RenderPlan,
    cost::cost,
    estimate::PixelEstimate,
    integrator::IntegratorState,
    pixel::Pixel,
    surroundings::CameraMedium,
    tile_job::{Finished, Task},
    tiles::Tile,
    trace::{Countable, WorldTracer},
    visible::{self, InView},
    wave::CameraWave,
    world::{Surfaces, World},
};

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
        let settings = &plan.scene.source.settings;
        Self {
            whitted: Whitted::new(settings.depth, settings.min_contribution, plan.scene.features),
            paths: PathTracer::new(plan.integrator.path_settings(), plan.scene.features),
            occlusion: OcclusionWave::default(),
            camera: CameraWave::default(),
            hits: Vec::new(),
        }
    }
}

impl RenderPlan<'_> {
    /// Chooses the concrete types, one `match` for each axis.
    pub(crate) fn render_tile(&self, task: &Task<'_>, count: bool, worker: &mut Worker) -> Finished {
        if count || self.integrator_kind() == Integrator::Cost {
            self.with_probe::<Counters>(task, worker)
        } else {
            self.with_probe::<NoProbe>(task, worker)
        }
    }

    fn with_probe<S: Countable>(&self, task: &Task<'_>, worker: &mut Worker) -> Finished {
        match &self.scene.world {
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
        let in_view = match (&few, &self.frame.visible) {
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
        let lighting =
            Lighting { appearance: &self.scene.appearance, emitters: &self.scene.emitters, bsdfs: &self.scene.bsdfs };
        let mut tracer = WorldTracer::new(world, structure, in_view, S::default()).with_buffer(core::mem::take(hits));
        let mut finished = match (&self.integrator, &self.frame.medium) {
            (IntegratorState::Whitted, CameraMedium::Same(interior)) => {
                whitted.set_surroundings(interior);
                self.sample_tile(task, camera, |wave, seen| {
                    whitted.radiance_of(&mut tracer, &self.scene.appearance, wave.rays, seen);
                })
            }
            (IntegratorState::Path(_), CameraMedium::Same(interior)) => {
                paths.set_surroundings(interior);
                self.sample_tile(task, camera, |wave, seen| {
                    paths.radiance_of(&mut tracer, lighting, wave.rays, wave.samplers, seen);
                })
            }
            (IntegratorState::Path(_), CameraMedium::ByRay(reach)) => {
                let mut interior = Interior::default();
                self.sample_tile(task, camera, |wave, seen| {
                    for (i, ray) in wave.rays.iter().enumerate() {
                        interior.look_around_within(*reach, &mut tracer, &self.scene.appearance.materials, &ray.0);
                        paths.set_surroundings(&interior);
                        let (rays, samplers) = (&wave.rays[i..=i], &wave.samplers[i..=i]);
                        paths.radiance_of(&mut tracer, lighting, rays, samplers, &mut seen[i..=i]);
                    }
                })
            }
            (IntegratorState::AmbientOcclusion(view), _) => self.sample_tile(task, camera, |wave, seen| {
                occlusion.radiance_of(view, &mut tracer, wave.rays, wave.samplers, seen);
            }),
            (IntegratorState::Whitted, CameraMedium::ByRay(reach)) => {
                let mut interior = Interior::default();
                self.sample_each(task, camera, |ray| {
                    interior.look_around_within(*reach, &mut tracer, &self.scene.appearance.materials, ray);
                    whitted.set_surroundings(&interior);
                    whitted.radiance(&mut tracer, &self.scene.appearance, ray)
                })
            }
            (IntegratorState::Aov(view), _) => {
                self.sample_tile(task, camera, |wave, seen| view.radiance_of(&mut tracer, wave.rays, seen))
            }
            (IntegratorState::Cost, _) => self.sample_each(task, camera, |ray| cost(&mut tracer, ray)),
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
    fn few_in<W: Surfaces>(&self, tile: Tile, world: &W, structure: &AnyAccelerator) -> Option<Handful> {
        let Tile { x, y, width, height } = tile;
        let volume = self.frame.culls_tiles.then(|| self.frame.view_volume(Crop { x, y, width, height }))?;
        let few = visible::few(world, structure, self.frame.visible.as_ref(), &volume)?;
        Some(match self.scene.accel.simd {
            Some(level) => few.with_level(level),
            None => few,
        })
    }

    /// A tile in whose part of the view there is nothing, if that can be told without a ray: where all samples see the
    /// same background and weigh the same, so that no pixel depends on where they are.
    fn empty_tile(&self, task: &Task<'_>) -> Option<Finished> {
        let (
            IntegratorState::Whitted | IntegratorState::Path(_),
            CameraMedium::Same(_),
            Background::Constant(radiance),
        ) = (&self.integrator, &self.frame.medium, &self.scene.appearance.background)
        else {
            return None;
        };
        if self.frame.filter.has_negative_lobes() {
            return None;
        }
        let sweep = task.sweep;
        let pixel_of = |spp: u32| {
            let mut pass = Pixel::new(self.frame.transparent);
            for _ in 0..spp {
                pass.add(&Seen { radiance: self.frame.backdrop.unwrap_or(*radiance), hit: false }, 1.0);
            }
            let mut pixel = PixelEstimate::default();
            for _ in 0..sweep.count {
                let (radiance, coverage) = pass.mean();
                pixel.add(radiance, coverage, spp);
            }
            (pixel, pass.bad_samples() * u64::from(sweep.count))
        };
        let (usual, simple) = (pixel_of(sweep.spp), sweep.simple_spp.map(pixel_of));
        let mut finished = Finished::new(task, self.frame.transparent);
        for at in sweep.pixels_of(task.tile) {
            let (pixel, bad_samples) = simple.as_ref().filter(|_| task.is_simple(at)).unwrap_or(&usual);
            finished.push(pixel);
            finished.bad_samples += bad_samples;
        }
        finished.primary_rays_spared = finished.samples;
        Some(finished)
    }
}
