//! What a render can go on from.

use serde::{Deserialize, Deserializer, Serialize, de::Error as _};

use crate::{
    ContentError, RenderError, Statistics, StopRule, observer,
    part::{Frame, Part, Share, decode_unchecked},
    progressive::PassState,
};

/// A render in the midst of it, as [`Kept`](crate::Kept) was written down.
///
/// Whoever keeps one keeps beside it what scene it is of: this crate can only tell that the picture has the same size and is
/// made the same way.
///
/// Whatever is deserialized has gone through [`validate`](Self::validate); [`UncheckedCheckpoint`] tells the reason of a refusal.
#[derive(Clone, Debug, Serialize)]
pub struct Checkpoint(State);

#[derive(Clone, Debug, Serialize, Deserialize)]
enum State {
    Tiles(#[serde(deserialize_with = "decode_unchecked")] Part),
    Passes(PassState),
}

/// A checkpoint as it was decoded, of which no number has been checked.
#[derive(Debug)]
pub struct UncheckedCheckpoint(State);

impl UncheckedCheckpoint {
    /// The checkpoint, once all of its numbers are checked.
    ///
    /// # Errors
    /// [`ContentError`] with the first number that cannot be right.
    pub fn check(self) -> Result<Checkpoint, ContentError> {
        let checkpoint = Checkpoint(self.0);
        checkpoint.validate()?;
        Ok(checkpoint)
    }
}

impl<'de> Deserialize<'de> for UncheckedCheckpoint {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        State::deserialize(deserializer).map(Self)
    }
}

impl<'de> Deserialize<'de> for Checkpoint {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        UncheckedCheckpoint::deserialize(deserializer)?.check().map_err(D::Error::custom)
    }
}

impl Checkpoint {
    /// Copy of the state of a render.
    pub(crate) fn of(state: observer::State<'_>) -> Self {
        Self(match state {
            observer::State::Tiles(part) => State::Tiles(part.clone()),
            observer::State::Passes(passes) => State::Passes(passes.clone()),
        })
    }

    /// Checks every number that a file may have got wrong. Whether it is of the same picture is checked when a render goes on.
    ///
    /// # Errors
    /// [`ContentError`] with the first number that cannot be right.
    pub fn validate(&self) -> Result<(), ContentError> {
        match &self.0 {
            State::Tiles(part) => part.validate(),
            State::Passes(state) => state.validate(),
        }
    }

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
            Some(Self(State::Tiles(mut part))) if part.frame == frame && part.share == share => {
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
