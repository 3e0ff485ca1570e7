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
    /// True if the loop was interrupted before all items were started.
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

    /// The tiles of the plan, by number.
    pub(crate) fn tiles(&self) -> &[Tile] {
        &self.tiles
    }

    /// Renders those of the tiles, by number, in which there is something to sample. `finished` gets each, in any order, on
    /// this thread, while others are being rendered.
    pub(crate) fn render_tiles(
        &self,
        pass_spec: &PassSpec<'_>,
        accel_options: &[usize],
        finished: impl FnMut(usize, TileResult),
    ) -> Outcome {
        let render = |worker: &mut ThreadState, number: usize| {
            let job = TileJob::new(self.tiles[number], pass_spec);
            self.plan.render_tile(&job, self.count, worker)
        };
        let is_wanted = |number: &usize| pass_spec.pixels_of(self.tiles[*number]).next().is_some();
        let accel_options: Vec<_> = accel_options.iter().copied().filter(is_wanted).collect();
        self.parallel_for(&accel_options, || ThreadState::new(self.plan), render, finished)
    }

    /// Follows all light paths of a pass. `finished` gets what they do, in any order, on this thread.
    pub(crate) fn trace_light(&self, pass: LightPass, mut finished: impl FnMut(LightChunk)) -> Outcome {
        let tracer = || LightTracingIntegrator::new(self.plan.integrator.path_settings(), self.plan.scene.features);
        let trace = |tracer: &mut LightTracingIntegrator<_>, chunk: usize| {
            self.plan.trace_light(pass, chunk as u64, self.count, tracer)
        };
        let chunks: Vec<_> = (0..pass.chunks() as usize).collect();
        self.parallel_for(&chunks, tracer, trace, |_, lit| finished(lit))
    }

    fn is_interrupted(&self) -> bool {
        self.interrupt.is_some_and(|interrupt| interrupt.load(Ordering::Relaxed))
    }

    /// Runs work items on the threads. Each thread has a state of its own and takes the next item that no other has
    /// started, until all are taken or the loop is interrupted. A panic loses the item and replaces the thread's state.
    fn parallel_for<W, T: Send>(
        &self,
        pieces: &[usize],
        worker: impl Fn() -> W + Sync,
        work: impl Fn(&mut W, usize) -> T + Sync,
        mut finished: impl FnMut(usize, T),
    ) -> Outcome {
        let (sender, receiver) = mpsc::channel();
        let next = AtomicUsize::new(0);
        let (next, worker, work) = (&next, &worker, &work);
        let mut left = pieces.len();
        let mut lost = Vec::new();
        self.pool.in_place_scope(|scope| {
            for sender in vec![sender; self.threads()] {
                scope.spawn(move |_| {
                    let mut own = worker();
                    while !self.is_interrupted() {
                        let Some(&piece) = pieces.get(next.fetch_add(1, Ordering::Relaxed)) else { break };
                        // The worker is replaced after a panic, and nothing else is changed by its work.
                        let done = catch_unwind(AssertUnwindSafe(|| work(&mut own, piece)));
                        if done.is_err() {
                            own = worker();
                        }
                        // The receiver outlives this loop, so that sending cannot fail.
                        let _ = sender.send((piece, done.ok()));
                    }
                });
            }
            for (piece, done) in receiver {
                left -= 1;
                match done {
                    Some(done) => finished(piece, done),
                    None => lost.push(piece),
                }
            }
        });
        Outcome { interrupted: left > 0, lost }
    }
}

#[cfg(test)]
mod tests {
    use rt_scene_io::{Content, MaterialId, NamedCamera, Node, Scene};

    use super::*;
    use crate::PlanOptions;

    /// A plan of one sphere, which is all that a crew needs.
    fn with_scheduler(interrupt: Option<&AtomicBool>, test: impl FnOnce(&TileScheduler<'_>)) {
        let sphere = rt_geometry::Sphere::new(rt_math::DVec3::ZERO, 1.0).expect("a sphere");
        let projection = rt_camera::Projection::Orthographic { height: 3.0 };
        let camera = rt_camera::CameraSettings::new(rt_math::Transform::translate(rt_math::DVec3::Z * 4.0), projection);
        let mut scene = Scene::empty("one sphere");
        scene.cameras = vec![NamedCamera { name: "main".into(), settings: camera, medium: None }];
        scene.appearance.materials = vec![rt_shading::Material::new("any".into(), rt_shading::Phong::default())];
        scene.nodes = vec![Node::new(Content::Shape(rt_geometry::Shape::Sphere(sphere)), MaterialId(0))];
        let plan = RenderPlan::compile(&scene, &PlanOptions::default()).expect("compiles");
        test(
            &TileScheduler::new(&plan, &RunOptions { threads: 3, interrupt, ..RunOptions::default() })
                .expect("threads"),
        );
    }

    #[test]
    fn a_panic_costs_its_piece_and_a_new_worker() {
        with_scheduler(None, |scheduler| {
            let pieces: Vec<_> = (10..90).collect();
            let mut sum = 0;
            // A worker that went on after its panic would say so by its count.
            let work = |broken: &mut bool, piece: usize| {
                assert!(!core::mem::replace(broken, true), "the worker of a panic goes on");
                assert_ne!(piece % 20, 7, "a defect");
                *broken = false;
                piece
            };
            let mut outcome = scheduler.parallel_for(
                &pieces,
                || false,
                work,
                |piece, done| {
                    assert_eq!(piece, done);
                    sum += done;
                },
            );
            outcome.lost.sort_unstable();
            assert_eq!(outcome, Outcome { interrupted: false, lost: vec![27, 47, 67, 87] });
            assert_eq!(sum, (10..90).sum::<usize>() - (27 + 47 + 67 + 87));
        });
    }

    #[test]
    fn an_interruption_finishes_what_is_begun() {
        let interrupt = AtomicBool::new(false);
        with_scheduler(Some(&interrupt), |scheduler| {
            let (begun, mut finished) = (AtomicUsize::new(0), 0);
            let work = |(): &mut (), piece: usize| {
                begun.fetch_add(1, Ordering::Relaxed);
                if piece == 5 {
                    interrupt.store(true, Ordering::Relaxed);
                }
            };
            let pieces: Vec<_> = (0..100_000).collect();
            let outcome = scheduler.parallel_for(&pieces, || (), work, |_, ()| finished += 1);
            assert!(outcome.interrupted && outcome.lost.is_empty());
            assert!(finished == begun.load(Ordering::Relaxed) && finished < 100_000, "{finished}");
        });
    }
}
