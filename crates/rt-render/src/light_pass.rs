//! Passes of light tracing: caustics, traced from the lights to the camera.

use rt_camera::{PixelSampler, SampleStream, SamplerKind};
use rt_math::{Sampler, random::hash};
use rt_shading::{LightTracingIntegrator, LightTracingScene};

use crate::{
    RenderPlan, Statistics,
    frustum_cull::PrimaryTarget,
    passes::pass_seed,
    splats::{Splat, splat},
    tracer::SceneTracer,
    work_probe::WorkProbe,
};

/// Paths per work item.
const CHUNK: u64 = 4096;

/// Seed that separates the random numbers of light paths from those of pixels.
const LIGHT_PATHS: u64 = 0x6c69_6768_7420_7061;

#[derive(Clone, Copy, Debug)]
pub(crate) struct LightPass {
    pass: u32,
    /// Number of camera samples of the pass over the whole image, independent of the crop.
    paths: u64,
}

/// Result of a chunk of light paths.
pub(crate) struct LightChunk {
    pub(crate) splats: Vec<Splat>,
    /// Counts of the paths. Bad samples are contributions that are NaN, infinite or negative.
    pub(crate) statistics: Statistics,
}

impl LightPass {
    /// Number of work items.
    pub(crate) const fn chunks(&self) -> u64 {
        self.paths.div_ceil(CHUNK)
    }
}

impl RenderPlan<'_> {
    /// Light paths of a pass: one per camera sample. `None` if the plan traces none.
    pub(crate) fn light_pass(&self, pass: u32, spp: u32) -> Option<LightPass> {
        let [width, height] = self.frame.size.map(u64::from);
        let paths = width * height * u64::from(spp);
        self.scene.light_sources.as_ref().map(|_| LightPass { pass, paths })
    }

    /// Traces the paths of a chunk.
    pub(crate) fn trace_light(
        &self,
        pass: LightPass,
        chunk: u64,
        count: bool,
        tracer: &mut LightTracingIntegrator<SampleStream>,
    ) -> LightChunk {
        let mut lit = LightChunk { splats: Vec::new(), statistics: Statistics::default() };
        let Some(sources) = &self.scene.light_sources else { return lit };
        let (world, accelerator) = (self.scene.world.instances(), &self.scene.world.top.accelerator);
        let mut world = SceneTracer::new(&world, accelerator, PrimaryTarget::All(accelerator), WorkProbe::new(count));
        // Always Sobol' points: unlike camera samples, light paths are not arranged in pixels.
        let seed = hash(&[pass_seed(self.frame.seed, pass.pass), LIGHT_PATHS]);
        let sampler = PixelSampler::new(SamplerKind::Sobol, 1, seed);
        let share = 1.0 / pass.paths as f64;
        let end = pass.paths.min((chunk + 1) * CHUNK);
        let samplers = (chunk * CHUNK..end).map(|index| {
            let mut sample = sampler.sample([(index >> 32) as u32, 0], index as u32);
            let time = self.frame.sample_time(&mut sample);
            (sample, time)
        });
        let scene = LightTracingScene { lighting: self.scene.lighting(), sources };
        let sight = |point, time, sampler: &mut SampleStream| {
            let on_lens = if self.frame.camera.has_lens() { sampler.next_2d() } else { [0.5; 2] };
            self.frame.camera.sample_wi(point, on_lens, time)
        };
        tracer.trace(&mut world, scene, samplers, sight, |raster, light| {
            if light.to_array().iter().all(|c| (0.0..f64::INFINITY).contains(c)) {
                let add = |splat| lit.splats.push(splat);
                splat(self.frame.filter, self.frame.crop, self.frame.sample_offset, raster, light * share, add);
            } else {
                lit.statistics.bad_samples += 1;
            }
        });
        lit.statistics.counters = world.probe.counters(world.rays);
        lit.statistics.shading = tracer.take_counts();
        lit
    }
}
