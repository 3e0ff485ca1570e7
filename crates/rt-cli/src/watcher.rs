//! Who looks on while a picture is rendered: the bar, the keeper of checkpoints, and a viewer.

use std::path::PathBuf;

use rt_render::{Checkpoint, Kept, Observer, RenderSnapshot};

use crate::checkpoints::Checkpoints;
use crate::display::Display;
use crate::progress::ProgressDisplay;

/// All who look on.
pub(crate) struct Watcher {
    progress: ProgressDisplay,
    checkpoints: Option<Checkpoints>,
    refuges: Vec<PathBuf>,
    /// Where the last checkpoint is, or why it is nowhere.
    kept: Option<Result<PathBuf, String>>,
    display: Option<Display>,
}

impl Watcher {
    /// Of a render that goes on from an earlier checkpoint, or begins. A last checkpoint that cannot be written where it should is
    /// taken to one of the refuges.
    pub(crate) fn new(
        quiet: bool,
        earlier: Option<&Checkpoint>,
        checkpoints: Option<Checkpoints>,
        refuges: Vec<PathBuf>,
        display: Option<Display>,
    ) -> Self {
        let (samples, rays) = earlier.map_or((0, 0), |earlier| (earlier.samples(), earlier.rays()));
        Self { progress: ProgressDisplay::new(quiet, samples, rays), checkpoints, refuges, kept: None, display }
    }

    /// The render is over: whoever keeps its checkpoints, where the last one is if it was not finished, and who shows it.
    pub(crate) fn finish(self) -> (Option<Checkpoints>, Option<Result<PathBuf, String>>, Option<Display>) {
        self.progress.finish();
        (self.checkpoints, self.kept, self.display)
    }
}

impl Observer for &mut Watcher {
    fn tile_done(&mut self, so_far: &RenderSnapshot<'_>) {
        self.progress.update(so_far.progress());
        if let Some(checkpoints) = &mut self.checkpoints {
            checkpoints.tick(so_far);
        }
        if let Some(display) = &mut self.display {
            display.tile_done(so_far);
        }
    }

    fn unfinished(&mut self, kept: &Kept<'_>) {
        let checkpoints = self.checkpoints.as_ref();
        self.kept = checkpoints.map(|checkpoints| checkpoints.write_last(kept, &self.refuges));
    }
}
