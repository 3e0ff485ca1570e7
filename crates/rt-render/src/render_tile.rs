//! Rendering of a tile.

use rt_accel::{AnyAccelerator, wide::SmallSet};
use rt_geometry::HitStream;
use rt_scene_io::Integrator;
use rt_shading::{
    Background, InteriorList, OcclusionWave, PathTracer, RadianceSample, ReferencePathTracer, ShadingCounts, Whitted,
    batch_size,
};

use crate::{
    Crop, Precision, RenderPlan,
    camera_medium::CameraMedium,
    cost_view::cost,
    film::{pixel_accumulator::PixelAccumulator, pixel_estimate::PixelEstimate},
    frustum_cull::{self, PrimaryTarget},
    instance::Instances,
    integrator::IntegratorState,
    primary_rays::PrimaryRayBatch,
    tile_job::{TileJob, TileResult},
    tile_layers::TileLayers,
    tracer::SceneTracer,
    work_probe::WorkProbe,
};

/// Buffers that a thread reuses from tile to tile.
pub(crate) struct ThreadState {
    whitted: Whitted,
    paths: PathTracer,
    occlusion: OcclusionWave,
    hits: HitStream,
    camera: PrimaryRayBatch,
}

impl ThreadState {
    pub(crate) fn new(plan: &RenderPlan<'_>) -> Self {
        let settings = &plan.scene.source.settings;
        let mut paths = PathTracer::new(plan.integrator.path_settings(), plan.scene.features);
        let mut whitted = Whitted::new(settings.depth, settings.min_contribution, plan.scene.features);
        if plan.options.precision == Precision::F64 {
            (paths, whitted) = (paths.in_f64(), whitted.in_f64());
        }
        let lanes = plan.scene.accel.lane_level();
        paths.set_lanes(lanes);
        whitted.set_lanes(lanes);
        Self {
            whitted,
            paths,
            occlusion: OcclusionWave::default(),
            hits: HitStream::default(),
            camera: PrimaryRayBatch::new(batch_size(plan.scene.source.appearance.lights.len())),
        }
    }
}

impl RenderPlan<'_> {
    /// Renders a tile; counts the work of accelerators if `count` is true.
    pub(crate) fn render_tile(&self, job: &TileJob<'_>, count: bool, worker: &mut ThreadState) -> TileResult {
        let probe = WorkProbe::new(count || self.integrator_kind() == Integrator::Cost);
        let (world, accelerator) = (&self.scene.world.instances(), &self.scene.world.top.accelerator);
        let simple = job.pass_spec.simple_spp.map(|_| self.simple_pixels(job.tile, world, accelerator));
        let job = &TileJob { simple: simple.as_ref(), ..*job };
        let few = self.visible_in_tile(job.tile, world, accelerator);
        let primary_target = match (&few, &self.frame.visible) {
            (Some(few), _) => PrimaryTarget::Tile(few),
            (None, Some(part)) => PrimaryTarget::Culled(part),
            (None, None) => PrimaryTarget::All(accelerator),
        };
        let samples = || job.pass_spec.pixels_of(job.tile).map(|pixel| job.samples_of(pixel)).collect();
        let layers = (!job.layers.is_empty()).then(|| TileLayers::new(self.layer_context(), job.layers, samples()));
        if primary_target.is_empty()
            && let Some(finished) = self.empty_tile(job)
        {
            return TileResult { layers: layers.map(|layers| layers.channels()).unwrap_or_default(), ..finished };
        }
        let ThreadState { whitted, paths, occlusion, hits, camera } = worker;
        let lighting = self.scene.lighting();
        let materials = &self.scene.appearance.materials;
        let mut tracer = SceneTracer::new(world, accelerator, primary_target, probe);
        tracer.layers = layers;
        let (medium, mut lists) = (&self.frame.medium, Vec::new());
        let mut result = match &self.integrator {
            IntegratorState::Whitted => self.sample_tile(job, camera, |rays, _, radiances| {
                whitted.set_camera_media(medium.find_all(&mut tracer, materials, rays, &mut lists));
                whitted.radiance_of_stream(&mut tracer, &self.scene.appearance, rays, radiances);
            }),
            IntegratorState::Path(settings) if self.integrator_kind() == Integrator::PathReference => {
                let mut reference = ReferencePathTracer {
                    settings: *settings,
                    lighting,
                    camera_media: InteriorList::default(),
                    counts: ShadingCounts::default(),
                };
                let mut result = self.sample_tile(job, camera, |rays, samplers, radiances| {
                    for (at, (sampler, radiance_sample)) in samplers.iter_mut().zip(radiances).enumerate() {
                        let (ray, _) = rays.get(at);
                        medium.find(&mut tracer, materials, &ray, &mut reference.camera_media);
                        *radiance_sample = reference.li(&mut tracer, &ray, sampler);
                    }
                });
                result.statistics.shading = reference.counts;
                result
            }
            IntegratorState::Path(_) => self.sample_tile(job, camera, |rays, samplers, radiances| {
                paths.set_camera_media(medium.find_all(&mut tracer, materials, rays, &mut lists));
                paths.radiance_of_stream(&mut tracer, lighting, rays, samplers, radiances);
            }),
            IntegratorState::AmbientOcclusion(view) => self.sample_tile(job, camera, |rays, samplers, radiances| {
                occlusion.radiance_of(view, &mut tracer, rays, samplers, radiances);
            }),
            IntegratorState::Aov(view) => {
                self.sample_tile(job, camera, |rays, _, radiances| view.radiance_of(&mut tracer, rays, hits, radiances))
            }
            IntegratorState::Cost => self.sample_tile(job, camera, |rays, _, radiances| {
                for (at, radiance_sample) in radiances.iter_mut().enumerate() {
                    *radiance_sample = cost(&mut tracer, &rays.get(at).0);
                }
            }),
        };
        let statistics = &mut result.statistics;
        statistics.counters = tracer.probe.counters(tracer.rays);
        statistics.primary_rays_skipped = tracer.skipped;
        result.layers = tracer.layers.take().map(|layers| layers.channels()).unwrap_or_default();
        result.statistics.shading += whitted.take_counts();
        result.statistics.shading += paths.take_counts();
        result
    }

    /// Objects in view of the tile, if their number is small.
    fn visible_in_tile(&self, tile: Crop, world: &Instances<'_>, accelerator: &AnyAccelerator) -> Option<SmallSet> {
        let Crop { x, y, width, height } = tile;
        let volume = self.frame.culls_tiles.then(|| self.frame.view_volume(Crop { x, y, width, height }))?;
        let few = frustum_cull::collect_small(world, accelerator, self.frame.visible.as_ref(), &volume)?;
        Some(match self.scene.accel.simd {
            Some(level) => few.with_level(level),
            None => few,
        })
    }

    /// Result for a tile without objects in view, computed without rays. `None` if the radiance or weight of samples can differ.
    fn empty_tile(&self, job: &TileJob<'_>) -> Option<TileResult> {
        let (
            IntegratorState::Whitted | IntegratorState::Path(_),
            CameraMedium::Constant(_),
            Background::Constant(radiance),
        ) = (&self.integrator, &self.frame.medium, &self.scene.appearance.background)
        else {
            return None;
        };
        if self.frame.filter.has_negative_lobes() {
            return None;
        }
        let pass_spec = job.pass_spec;
        let pixel_of = |spp: u32| {
            let mut pass = PixelAccumulator::new(self.frame.transparent);
            for _ in 0..spp {
                pass.add(&RadianceSample { radiance: self.frame.backdrop.unwrap_or(*radiance), hit: false }, 1.0);
            }
            let mut pixel = PixelEstimate::default();
            for _ in 0..pass_spec.count {
                let (radiance, coverage) = pass.mean();
                pixel.add(radiance, coverage, spp);
            }
            (pixel, pass.bad_samples() * u64::from(pass_spec.count))
        };
        let (full, simple) = (pixel_of(pass_spec.spp), pass_spec.simple_spp.map(pixel_of));
        let mut result = TileResult::new(job);
        for at in pass_spec.pixels_of(job.tile) {
            let (pixel, bad_samples) = simple.as_ref().filter(|_| job.is_simple(at)).unwrap_or(&full);
            result.push(*pixel);
            result.statistics.bad_samples += bad_samples;
        }
        result.statistics.primary_rays_skipped = result.statistics.samples;
        Some(result)
    }
}
