//! The threads of a render, and how they share its tiles.

use std::sync::{
    atomic::{AtomicUsize, Ordering},
    mpsc,
};

use crate::{
    RenderError, RenderPlan, RunOptions,
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
        let (sender, receiver) = mpsc::channel();
        let next = AtomicUsize::new(0);
        self.pool.in_place_scope(|scope| {
            for sender in vec![sender; self.threads()] {
                let next = &next;
                scope.spawn(move |_| self.work(sweep, next, &sender));
            }
            receiver.into_iter().for_each(|(index, tile)| finished(index, tile));
        });
    }

    /// What one thread does: the next tile that nobody has begun, until there is none.
    fn work(&self, sweep: &Sweep<'_>, next: &AtomicUsize, sender: &mpsc::Sender<(usize, Finished)>) {
        let mut worker = Worker::new(self.plan);
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(&tile) = self.tiles.get(index) else { return };
            if sweep.pixels_of(tile).next().is_some() {
                let tile = self.plan.render_tile(&Task { tile, sweep }, self.count, &mut worker);
                // The receiver outlives this loop, so that sending cannot fail.
                let _ = sender.send((index, tile));
            }
        }
    }
}
