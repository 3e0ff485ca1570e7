//! What a render can go on from.

use serde::{Deserialize, Serialize};

use crate::{
    RenderError, Statistics, StopRule,
    part::{Frame, Part, Share},
    progressive::PassState,
};

/// A render in the midst of it, as [`Kept`](crate::Kept) was written down.
///
/// Whoever keeps one keeps beside it what scene it is of: this crate can only tell that the picture has the same size and is
/// made the same way.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Checkpoint(State);

#[derive(Clone, Debug, Serialize, Deserialize)]
enum State {
    Tiles(Part),
    Passes(PassState),
}

impl Checkpoint {
    /// Camera samples taken so far.
    pub const fn samples(&self) -> u64 {
        match &self.0 {
            State::Tiles(part) => part.statistics.samples,
            State::Passes(state) => state.statistics.samples,
        }
    }

    /// Rays traced so far, of all kinds.
    pub fn rays(&self) -> u64 {
        match &self.0 {
            State::Tiles(part) => part.statistics.counters.total().rays,
            State::Passes(state) => state.statistics.counters.total().rays,
        }
    }

    /// The finished tiles of a render tile by tile: of a checkpoint that fits, or none.
    pub(crate) fn part_of(
        from: Option<Self>,
        frame: Frame,
        share: Share,
        statistics: Statistics,
    ) -> Result<Part, RenderError> {
        match from {
            None => Ok(Part::empty(frame, share, statistics)),
            Some(Self(State::Tiles(mut part))) if part.frame == frame && part.share == share && part.is_sound() => {
                part.statistics = part.statistics.continued(&statistics);
                Ok(part)
            }
            Some(_) => Err(RenderError::Checkpoint),
        }
    }

    /// The sums of a render pass by pass: of a checkpoint that fits, or none.
    pub(crate) fn passes_of(
        from: Option<Self>,
        frame: Frame,
        share: Share,
        rule: Option<&StopRule>,
        statistics: Statistics,
    ) -> Result<PassState, RenderError> {
        match from {
            None => Ok(PassState::new(frame, share, rule, statistics)),
            Some(Self(State::Passes(mut state))) if state.fits(frame, share, rule) => {
                state.statistics = state.statistics.continued(&statistics);
                Ok(state)
            }
            Some(_) => Err(RenderError::Checkpoint),
        }
    }
}
