//! Tiles and light paths of a render, in parallel.

use std::sync::atomic::AtomicBool;

use rt_shading::LightTracingIntegrator;

use crate::{
    Crop, RenderPlan, RunOptions,
    first_hit_layers::FirstHitLayer,
    light_pass::{LightChunk, LightPass},
    parallel_for::{Outcome, parallel_for, thread_count},
    passes::PassSpec,
    render_tile::ThreadState,
    tile::tiles,
    tile_job::{TileJob, TileResult},
};

/// Threads and tiles of a render.
pub(crate) struct TileScheduler<'p> {
    plan: &'p RenderPlan<'p>,
    threads: usize,
    tiles: Vec<Crop>,
    count: bool,
    interrupt: Option<&'p AtomicBool>,
    layers: &'p [FirstHitLayer],
}

impl<'p> TileScheduler<'p> {
    pub(crate) fn new(plan: &'p RenderPlan<'p>, options: &RunOptions<'p>) -> Self {
        let threads = thread_count(options.threads);
        let RunOptions { count, interrupt, layers, .. } = *options;
        Self { plan, threads, tiles: tiles(plan.frame.crop), count, interrupt, layers }
    }

    pub(crate) const fn threads(&self) -> usize {
        self.threads
    }

    /// Tiles of the plan, by index.
    pub(crate) fn tiles(&self) -> &[Crop] {
        &self.tiles
    }

    /// Renders tiles, by index, skipping those without sampled pixels. `finished` receives the results in any order, on
    /// this thread, while other tiles are rendered.
    pub(crate) fn render_tiles(
        &self,
        pass_spec: &PassSpec<'_>,
        numbers: &[usize],
        finished: impl FnMut(usize, TileResult),
    ) -> Outcome {
        let render = |state: &mut ThreadState, number: usize| {
            let job = TileJob { layers: self.layers, ..TileJob::new(self.tiles[number], pass_spec, self.interrupt) };
            let result = self.plan.render_tile(&job, self.count, state);
            (!result.is_abandoned).then_some(result)
        };
        let has_pixels = |number: &usize| pass_spec.pixels_of(self.tiles[*number]).next().is_some();
        let numbers: Vec<_> = numbers.iter().copied().filter(has_pixels).collect();
        let new_state = || ThreadState::new(self.plan);
        parallel_for(self.threads, &numbers, self.interrupt, (new_state, render), finished)
    }

    /// Traces all light paths of a pass. `finished` receives their splats in any order, on this thread.
    pub(crate) fn trace_light(&self, pass: LightPass, mut finished: impl FnMut(LightChunk)) -> Outcome {
        let tracer = || LightTracingIntegrator::new(self.plan.integrator.path_settings(), self.plan.scene.features);
        let trace = |tracer: &mut LightTracingIntegrator<_>, chunk: usize| {
            Some(self.plan.trace_light(pass, chunk as u64, self.count, tracer))
        };
        let chunks: Vec<_> = (0..pass.chunks() as usize).collect();
        parallel_for(self.threads, &chunks, self.interrupt, (tracer, trace), |_, lit| finished(lit))
    }
}
