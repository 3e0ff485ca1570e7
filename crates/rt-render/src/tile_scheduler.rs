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

#[cfg(test)]
mod tests {
    use std::sync::atomic::Ordering;

    use rt_scene_io::{Content, MaterialId, NamedCamera, Scene, SceneNode};

    use super::*;
    use crate::PlanOptions;

    /// Calls a test with the scheduler of a plan of one sphere.
    fn with_scheduler(interrupt: Option<&AtomicBool>, test: impl FnOnce(&TileScheduler<'_>)) {
        let sphere = rt_geometry::Sphere::new(rt_math::DVec3::ZERO, 1.0).expect("a sphere");
        let projection = rt_camera::Projection::Orthographic { height: 3.0 };
        let camera = rt_camera::CameraSettings::new(rt_math::Transform::translate(rt_math::DVec3::Z * 4.0), projection);
        let mut scene = Scene::empty("one sphere");
        scene.cameras = vec![NamedCamera { name: "main".into(), settings: camera, medium: None }];
        scene.appearance.materials = vec![rt_shading::Material::new("any".into(), rt_shading::Phong::default())];
        scene.nodes = vec![SceneNode::new(Content::Shape(rt_geometry::Shape::Sphere(sphere)), MaterialId(0))];
        let plan = RenderPlan::compile(&scene, &PlanOptions::default()).expect("compiles");
        test(&TileScheduler::new(&plan, &RunOptions { threads: 3, interrupt, ..RunOptions::default() }));
    }

    /// The tile would take hours.
    #[test]
    fn an_interrupt_does_not_wait_for_tiles_of_many_samples() {
        let interrupt = AtomicBool::new(false);
        with_scheduler(Some(&interrupt), |scheduler| {
            let pass_spec = PassSpec { first: 0, count: 1, spp: 1 << 30, simple_spp: None, pixels: None };
            std::thread::scope(|scope| {
                scope.spawn(|| {
                    std::thread::sleep(std::time::Duration::from_millis(50));
                    interrupt.store(true, Ordering::Relaxed);
                });
                let mut finished = 0;
                let middle = [scheduler.plan.frame.crop.width / 2, scheduler.plan.frame.crop.height / 2];
                let in_middle = |tile: &Crop| tile.pixels().any(|pixel| pixel == middle);
                let tile = scheduler.tiles().iter().position(in_middle).expect("tiles cover the image");
                let outcome = scheduler.render_tiles(&pass_spec, &[tile], |_, _| finished += 1);
                assert_eq!((outcome, finished), (Outcome { interrupted: true, lost: Vec::new() }, 0));
            });
        });
    }
}
