//! Observers of a running render.

use rt_image::Image;
use serde::Serialize;

use crate::{
    Crop, ErrorEstimate, Progress,
    part::{Frame, Part, TilePixels},
    pass_state::PassState,
    tiles::Tile,
};

/// Observer of a render. Closures that take a [`Progress`] are observers as well.
pub trait Observer {
    /// Called after each tile, in any order, on the thread that has begun the render; the others go on meanwhile.
    fn tile_done(&mut self, so_far: &RenderSnapshot<'_>);

    /// Called at the end of a render that could go on: one that was interrupted, or lacks tiles in which a worker failed.
    fn unfinished(&mut self, _kept: &Kept<'_>) {}
}

impl<F: FnMut(Progress)> Observer for F {
    fn tile_done(&mut self, so_far: &RenderSnapshot<'_>) {
        self(so_far.progress());
    }
}

/// Snapshot of a running render.
pub struct RenderSnapshot<'a> {
    pub(crate) progress: Progress,
    pub(crate) tile: Tile,
    pub(crate) state: State<'a>,
}

/// State for a checkpoint, to be serialised; it is read as a [`Checkpoint`](crate::Checkpoint).
#[derive(Clone, Copy, Serialize)]
pub struct Kept<'a>(pub(crate) State<'a>);

/// Current state of the image.
#[derive(Clone, Copy, Serialize)]
pub(crate) enum State<'a> {
    /// Some tiles, each of which has all of its samples.
    Tiles(&'a Part),
    /// All tiles, after some passes.
    Passes(&'a PassState),
}

impl RenderSnapshot<'_> {
    /// Progress of the render.
    pub const fn progress(&self) -> Progress {
        self.progress
    }

    /// The tile that has just been done, in pixels of the whole image.
    pub const fn tile(&self) -> Crop {
        let Tile { x, y, width, height } = self.tile;
        Crop { x, y, width, height }
    }

    /// Radiance of the pixels of the tile, row by row, as the film would have it now.
    pub fn pixels(&self) -> Vec<[f32; 3]> {
        self.tile_pixels().pixels
    }

    /// Coverage of the pixels of the tile, if the picture is transparent.
    pub fn alpha(&self) -> Option<Vec<f32>> {
        self.frame().transparent.then(|| self.tile_pixels().alpha)
    }

    /// Current image; unrendered tiles are black. Copies all pixels.
    pub fn film(&self) -> Image {
        match self.state {
            State::Tiles(part) => part.film(),
            State::Passes(passes) => passes.film(),
        }
    }

    /// Estimated error of the image after the last pass over all of it. `None` before the second pass, for a render tile by tile,
    /// and if all passes are equal.
    pub fn error(&self) -> Option<ErrorEstimate> {
        match self.state {
            State::Passes(passes) if passes.frame.passes_differ => passes.error.estimate(),
            State::Passes(_) | State::Tiles(_) => None,
        }
    }

    /// State for a checkpoint, to be serialised now.
    pub const fn checkpoint(&self) -> Kept<'_> {
        Kept(self.state)
    }

    fn frame(&self) -> &Frame {
        match self.state {
            State::Tiles(part) => &part.frame,
            State::Passes(passes) => &passes.frame,
        }
    }

    fn tile_pixels(&self) -> TilePixels {
        match self.state {
            State::Tiles(part) => part.tile(self.tile).cloned().unwrap_or_default(),
            State::Passes(passes) => passes.tile_pixels(self.tile),
        }
    }
}
