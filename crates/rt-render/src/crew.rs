//! The threads of a render, and how they share its tiles.

use std::sync::{
    atomic::{AtomicUsize, Ordering},
    mpsc,
};

use rt_shading::LightTracer;

use crate::{
    RenderError, RenderPlan, RunOptions,
    light_pass::{LightPass, LitChunk},
    passes::Sweep,
    tile::{Finished, Task, Worker},
    tiles::{Tile, tiles},
};

/// Threads that wait for sweeps over the image.
pub(crate) struct Crew<'p> {
    plan: &'p RenderPlan<'p>,
    pool: rayon::ThreadPool,
    tiles: Vec<Tile>,
    count: bool,
}

impl<'p> Crew<'p> {
    pub(crate) fn new(plan: &'p RenderPlan<'p>, options: &RunOptions) -> Result<Self, RenderError> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(options.threads).build()?;
        let crop = plan.crop;
        Ok(Self { plan, pool, tiles: tiles(crop.x, crop.y, crop.width, crop.height), count: options.count })
    }

    pub(crate) fn threads(&self) -> usize {
        self.pool.current_num_threads()
    }

    pub(crate) fn tile_count(&self) -> usize {
        self.tiles.len()
    }

    /// Renders all tiles in which there is something to sample. `finished` gets each with its number, in any order, on this
    /// thread, while others are being rendered.
    pub(crate) fn sweep(&self, sweep: &Sweep<'_>, mut finished: impl FnMut(usize, Finished)) {
        let render = |worker: &mut Worker, index: usize| {
            let tile = self.tiles[index];
            let task = Task::new(tile, sweep);
            let is_wanted = sweep.pixels_of(tile).next().is_some();
            is_wanted.then(|| (index, self.plan.render_tile(&task, self.count, worker)))
        };
        self.share(self.tiles.len(), || Worker::new(self.plan), render, |(index, tile)| finished(index, tile));
    }

    /// Follows all light paths of a pass. `finished` gets what they do, in any order, on this thread.
    pub(crate) fn trace_light(&self, pass: LightPass, finished: impl FnMut(LitChunk)) {
        let tracer = || LightTracer::new(self.plan.view.path_settings(), self.plan.needs);
        let trace = |tracer: &mut LightTracer<_>, chunk: usize| {
            Some(self.plan.trace_light(pass, chunk as u64, self.count, tracer))
        };
        self.share(pass.chunks() as usize, tracer, trace, finished);
    }

    /// Shares so many pieces of work out among the threads, each of which has a worker of its own and takes the next piece that
    /// nobody has begun, until there is none.
    fn share<W, T: Send>(
        &self,
        pieces: usize,
        worker: impl Fn() -> W + Sync,
        work: impl Fn(&mut W, usize) -> Option<T> + Sync,
        finished: impl FnMut(T),
    ) {
        let (sender, receiver) = mpsc::channel();
        let next = AtomicUsize::new(0);
        let (next, worker, work) = (&next, &worker, &work);
        self.pool.in_place_scope(|scope| {
            for sender in vec![sender; self.threads()] {
                scope.spawn(move |_| {
                    let mut worker = worker();
                    let begun = core::iter::repeat_with(|| next.fetch_add(1, Ordering::Relaxed));
                    for piece in begun.take_while(|piece| *piece < pieces) {
                        if let Some(done) = work(&mut worker, piece) {
                            // The receiver outlives this loop, so that sending cannot fail.
                            let _ = sender.send(done);
                        }
                    }
                });
            }
            receiver.into_iter().for_each(finished);
        });
    }
}
