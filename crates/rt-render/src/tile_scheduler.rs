//! Threads of a render, and the parallel loop over its tiles.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{
    atomic::{AtomicBool, AtomicUsize, Ordering},
    mpsc,
};

use rt_shading::LightTracingIntegrator;

use crate::{
    RenderError, RenderPlan, RunOptions,
    light_pass::{LightChunk, LightPass},
    passes::PassSpec,
    tile::ThreadState,
    tile_job::{TileJob, TileResult},
    tiles::{Tile, tiles},
};

/// Thread pool of a render.
pub(crate) struct TileScheduler<'p> {
    plan: &'p RenderPlan<'p>,
    pool: rayon::ThreadPool,
    tiles: Vec<Tile>,
    count: bool,
    interrupt: Option<&'p AtomicBool>,
}

/// Outcome of a parallel loop.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Outcome {
    /// True if the loop was interrupted before all items were done.
    pub(crate) interrupted: bool,
    /// Items in which a thread panicked.
    pub(crate) lost: Vec<usize>,
}

impl<'p> TileScheduler<'p> {
    pub(crate) fn new(plan: &'p RenderPlan<'p>, options: &RunOptions<'p>) -> Result<Self, RenderError> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(options.threads).build()?;
        Ok(Self { plan, pool, tiles: tiles(plan.frame.crop), count: options.count, interrupt: options.interrupt })
    }

    pub(crate) fn threads(&self) -> usize {
        self.pool.current_num_threads()
    }

    /// Tiles of the plan, by index.
    pub(crate) fn tiles(&self) -> &[Tile] {
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
            let job = TileJob::new(self.tiles[number], pass_spec, self.interrupt);
            let result = self.plan.render_tile(&job, self.count, state);
            (!result.is_abandoned).then_some(result)
        };
        let has_pixels = |number: &usize| pass_spec.pixels_of(self.tiles[*number]).next().is_some();
        let numbers: Vec<_> = numbers.iter().copied().filter(has_pixels).collect();
        self.parallel_for(&numbers, || ThreadState::new(self.plan), render, finished)
    }

    /// Traces all light paths of a pass. `finished` receives their splats in any order, on this thread.
    pub(crate) fn trace_light(&self, pass: LightPass, mut finished: impl FnMut(LightChunk)) -> Outcome {
        let tracer = || LightTracingIntegrator::new(self.plan.integrator.path_settings(), self.plan.scene.features);
        let trace = |tracer: &mut LightTracingIntegrator<_>, chunk: usize| {
            Some(self.plan.trace_light(pass, chunk as u64, self.count, tracer))
        };
        let chunks: Vec<_> = (0..pass.chunks() as usize).collect();
        self.parallel_for(&chunks, tracer, trace, |_, lit| finished(lit))
    }

    fn is_interrupted(&self) -> bool {
        self.interrupt.is_some_and(|interrupt| interrupt.load(Ordering::Relaxed))
    }

    /// Runs work items in parallel. Each thread has its own state and takes the next item until none is left or the loop is
    /// interrupted. `work` returns `None` if it abandoned the item after an interrupt. A panic loses the item and replaces the
    /// state of its thread.
    fn parallel_for<W, T: Send>(
        &self,
        items: &[usize],
        new_state: impl Fn() -> W + Sync,
        work: impl Fn(&mut W, usize) -> Option<T> + Sync,
        mut finished: impl FnMut(usize, T),
    ) -> Outcome {
        let (sender, receiver) = mpsc::channel();
        let next = AtomicUsize::new(0);
        let (next, new_state, work) = (&next, &new_state, &work);
        let mut left = items.len();
        let mut lost = Vec::new();
        self.pool.in_place_scope(|scope| {
            for sender in vec![sender; self.threads()] {
                scope.spawn(move |_| {
                    let mut state = new_state();
                    while !self.is_interrupted() {
                        let Some(&item) = items.get(next.fetch_add(1, Ordering::Relaxed)) else { break };
                        // Unwind safety: the state is replaced after a panic, and work changes nothing else.
                        let done = match catch_unwind(AssertUnwindSafe(|| work(&mut state, item))) {
                            Ok(None) => break,
                            Ok(done) => done,
                            Err(_) => {
                                state = new_state();
                                None
                            }
                        };
                        // Sending cannot fail: the receiver outlives this loop.
                        let _ = sender.send((item, done));
                    }
                });
            }
            for (item, done) in receiver {
                left -= 1;
                match done {
                    Some(done) => finished(item, done),
                    None => lost.push(item),
                }
            }
        });
        Outcome { interrupted: left > 0, lost }
    }
}

#[cfg(test)]
mod tests {
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
        test(
            &TileScheduler::new(&plan, &RunOptions { threads: 3, interrupt, ..RunOptions::default() })
                .expect("threads"),
        );
    }

    #[test]
    fn a_panic_loses_its_item_and_replaces_the_state() {
        with_scheduler(None, |scheduler| {
            let items: Vec<_> = (10..90).collect();
            let mut sum = 0;
            // The state is true after a panic: a state that is not replaced fails the first assertion.
            let work = |broken: &mut bool, item: usize| {
                assert!(!core::mem::replace(broken, true), "the state of a panic is still used");
                assert_ne!(item % 20, 7, "a defect");
                *broken = false;
                Some(item)
            };
            let mut outcome = scheduler.parallel_for(
                &items,
                || false,
                work,
                |item, done| {
                    assert_eq!(item, done);
                    sum += done;
                },
            );
            outcome.lost.sort_unstable();
            assert_eq!(outcome, Outcome { interrupted: false, lost: vec![27, 47, 67, 87] });
            assert_eq!(sum, (10..90).sum::<usize>() - (27 + 47 + 67 + 87));
        });
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
                let in_middle = |tile: &Tile| tile.pixels().any(|pixel| pixel == middle);
                let tile = scheduler.tiles().iter().position(in_middle).expect("tiles cover the image");
                let outcome = scheduler.render_tiles(&pass_spec, &[tile], |_, _| finished += 1);
                assert_eq!((outcome, finished), (Outcome { interrupted: true, lost: Vec::new() }, 0));
            });
        });
    }

    #[test]
    fn an_interruption_finishes_started_items() {
        let interrupt = AtomicBool::new(false);
        with_scheduler(Some(&interrupt), |scheduler| {
            let (begun, mut finished) = (AtomicUsize::new(0), 0);
            let work = |(): &mut (), item: usize| {
                begun.fetch_add(1, Ordering::Relaxed);
                if item == 5 {
                    interrupt.store(true, Ordering::Relaxed);
                }
                Some(())
            };
            let items: Vec<_> = (0..100_000).collect();
            let outcome = scheduler.parallel_for(&items, || (), work, |_, ()| finished += 1);
            assert!(outcome.interrupted && outcome.lost.is_empty());
            assert!(finished == begun.load(Ordering::Relaxed) && finished < 100_000, "{finished}");
        });
    }
}
