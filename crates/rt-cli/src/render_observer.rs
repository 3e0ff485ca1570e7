//! Observer of a render: progress bar, checkpoints, and image viewer.

use std::path::PathBuf;

use rt_render::{Checkpoint, CheckpointRef, Observer, RenderSnapshot};

use crate::checkpointer::Checkpointer;
use crate::display::Display;
use crate::progress::ProgressDisplay;
use crate::saved_checkpoint::SavedCheckpoint;

pub(crate) struct RenderObserver {
    pub(crate) progress: ProgressDisplay,
    pub(crate) checkpointer: Option<Checkpointer>,
    fallback_dirs: Vec<PathBuf>,
    /// Last checkpoint of an unfinished render, or the reason why it could not be written.
    pub(crate) kept: Option<Result<SavedCheckpoint, String>>,
    pub(crate) display: Option<Display>,
}

impl RenderObserver {
    pub(crate) fn new(
        quiet: bool,
        earlier: Option<&Checkpoint>,
        checkpointer: Option<Checkpointer>,
        fallback_dirs: Vec<PathBuf>,
        display: Option<Display>,
    ) -> Self {
        let (samples, rays) = earlier.map_or((0, 0), |earlier| (earlier.samples(), earlier.rays()));
        let progress = ProgressDisplay::new(quiet, samples, rays);
        Self { progress, checkpointer, fallback_dirs, kept: None, display }
    }
}

impl Observer for &mut RenderObserver {
    fn tile_done(&mut self, so_far: &RenderSnapshot<'_>) {
        self.progress.update(so_far.progress());
        if let Some(checkpointer) = &mut self.checkpointer {
            checkpointer.tick(so_far);
        }
        if let Some(display) = &mut self.display {
            display.tile_done(so_far);
        }
    }

    fn unfinished(&mut self, kept: &CheckpointRef<'_>) {
        self.kept = self.checkpointer.as_mut().map(|checkpointer| checkpointer.write_last(kept, &self.fallback_dirs));
    }
}
