//! Whoever watches a render while it goes on.

use rt_image::Image;
use serde::Serialize;

use crate::{
    Checkpoint, Crop, ErrorEstimate, Progress,
    part::{Frame, Part, TilePixels},
    progressive::PassState,
    tiles::Tile,
};

/// Who watches a render. Closures that take a [`Progress`] are observers as well.
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

/// A render in the midst of it.
pub struct RenderSnapshot<'a> {
    pub(crate) progress: Progress,
    pub(crate) tile: Tile,
    pub(crate) state: State<'a>,
}

/// What a render can go on from, to be written down; it is read as a [`Checkpoint`](crate::Checkpoint).
#[derive(Clone, Copy, Serialize)]
pub struct Kept<'a>(pub(crate) State<'a>);

impl Kept<'_> {
    /// Copy that a render can go on from.
    pub fn to_checkpoint(&self) -> Checkpoint {
        Checkpoint::of(self.0)
    }
}

/// What there is of the picture.
#[derive(Clone, Copy, Serialize)]
pub(crate) enum State<'a> {
    /// Some tiles, each of which has all of its samples.
    Tiles(&'a Part),
    /// All tiles, after some passes.
    Passes(&'a PassState),
}

impl RenderSnapshot<'_> {
    /// How far it has come.
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

    /// The whole picture so far: tiles that nothing is known of are black. Takes a moment.
    pub fn film(&self) -> Image {
        match self.state {
            State::Tiles(part) => part.film(),
            State::Passes(passes) => passes.film(),
        }
    }

    /// Estimated error of the picture after the last pass over all of it; `None` before the second pass, for a render tile by tile,
    /// and where all passes are the same.
    pub fn error(&self) -> Option<ErrorEstimate> {
        match self.state {
            State::Passes(passes) if passes.frame.passes_differ => passes.error.estimate(),
            State::Passes(_) | State::Tiles(_) => None,
        }
    }

    /// What a render can go on from, to be written down now.
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
