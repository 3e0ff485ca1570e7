//! Observers of a running render.

use rt_image::Image;
use serde::Serialize;

use crate::{
    Crop, ErrorEstimate, Progress,
    film::film_tile::{FilmLayout, FilmTile},
    pass_state::PassState,
    shard::Shard,
};

/// Observer of a render. Closures that take a [`Progress`] are observers as well.
pub trait Observer {
    /// Called after each tile, in any order, on the thread that started the render. Other threads continue meanwhile.
    fn tile_done(&mut self, snapshot: &RenderSnapshot<'_>);

    /// Called at the end of a resumable render: one that was interrupted, or in which a thread panicked.
    fn unfinished(&mut self, _kept: &CheckpointRef<'_>) {}
}

impl<F: FnMut(Progress)> Observer for F {
    fn tile_done(&mut self, snapshot: &RenderSnapshot<'_>) {
        self(snapshot.progress());
    }
}

/// Snapshot of a running render.
pub struct RenderSnapshot<'a> {
    pub(crate) progress: Progress,
    pub(crate) tile: Crop,
    pub(crate) state: FilmState<'a>,
}

/// Serialisable view of the film. It is deserialised as a [`Checkpoint`](crate::Checkpoint).
#[derive(Clone, Copy, Serialize)]
pub struct CheckpointRef<'a>(pub(crate) FilmState<'a>);

/// Film of a running render, borrowed for a checkpoint.
#[derive(Clone, Copy, Serialize)]
pub(crate) enum FilmState<'a> {
    /// Tile by tile: finished tiles with all of their samples.
    Tiles(&'a Shard),
    /// Pass by pass: all pixels after some passes.
    Passes(&'a PassState),
}

impl RenderSnapshot<'_> {
    /// Progress of the render.
    pub const fn progress(&self) -> Progress {
        self.progress
    }

    /// Tile that was finished last, in pixels of the whole image.
    pub const fn tile(&self) -> Crop {
        self.tile
    }

    /// Current radiance of the pixels of the tile, row by row.
    pub fn pixels(&self) -> Vec<[f32; 3]> {
        self.film_tile().pixels
    }

    /// Coverage of the pixels of the tile, if the image is transparent.
    pub fn alpha(&self) -> Option<Vec<f32>> {
        self.layout().transparent.then(|| self.film_tile().alpha)
    }

    /// Current image; unrendered tiles are black. Copies all pixels.
    pub fn film(&self) -> Image {
        match self.state {
            FilmState::Tiles(shard) => shard.film(),
            FilmState::Passes(passes) => passes.film(),
        }
    }

    /// Estimated error of the image after the last complete pass. `None` before the second pass, for renders tile by tile, and if
    /// all passes are equal.
    pub fn error(&self) -> Option<ErrorEstimate> {
        match self.state {
            FilmState::Passes(passes) if passes.layout.passes_differ => passes.error.estimate(),
            FilmState::Passes(_) | FilmState::Tiles(_) => None,
        }
    }

    /// State of the render for a checkpoint.
    pub const fn checkpoint(&self) -> CheckpointRef<'_> {
        CheckpointRef(self.state)
    }

    fn layout(&self) -> &FilmLayout {
        match self.state {
            FilmState::Tiles(shard) => &shard.layout,
            FilmState::Passes(passes) => &passes.layout,
        }
    }

    fn film_tile(&self) -> FilmTile {
        match self.state {
            FilmState::Tiles(shard) => shard.tile(self.tile).cloned().unwrap_or_default(),
            FilmState::Passes(passes) => passes.film_tile(self.tile),
        }
    }
}
