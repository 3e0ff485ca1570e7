//! Checkpoints: states that a render resumes from.

use serde::{Deserialize, Deserializer, Serialize, de::Error as _};

use crate::{
    ContentError, Kept, RenderError, Share, Statistics, StopRule, observer,
    part::{FilmLayout, Part, decode_unchecked},
    pass_state::PassState,
};

/// State of an unfinished render, deserialised from a [`Kept`](crate::Kept).
///
/// The caller must ensure that a render resumes with the same scene. This crate checks the image size and the options only.
///
/// Deserialisation runs [`validate`](Self::validate); [`UncheckedCheckpoint`] reports the reason of an error.
#[derive(Clone, Debug, Serialize)]
pub struct Checkpoint(State);

#[derive(Clone, Debug, Serialize, Deserialize)]
enum State {
    Tiles(#[serde(deserialize_with = "decode_unchecked")] Part),
    Passes(PassState),
}

/// Decoded checkpoint, not yet validated.
#[derive(Debug)]
pub struct UncheckedCheckpoint(State);

impl UncheckedCheckpoint {
    /// Validates the checkpoint.
    ///
    /// # Errors
    /// [`ContentError`] for the first invalid number.
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
    /// Checks all numbers that a decoded file can have wrong. Resuming checks that it belongs to the same image.
    ///
    /// # Errors
    /// [`ContentError`] for the first invalid number.
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

    /// True if a render of this layout, share and rule can resume from here.
    pub(crate) fn fits(&self, layout: FilmLayout, share: Share, rule: Option<&StopRule>, pass_by_pass: bool) -> bool {
        match &self.0 {
            State::Tiles(part) => !pass_by_pass && part.fits(layout, share),
            State::Passes(state) => pass_by_pass && state.fits(layout, share, rule),
        }
    }

    /// Film of a render tile by tile: that of a matching checkpoint, or an empty one.
    pub(crate) fn part_of(
        from: Option<Self>,
        layout: FilmLayout,
        share: Share,
        statistics: Statistics,
    ) -> Result<Part, RenderError> {
        match from {
            None => Ok(Part::empty(layout, share, statistics)),
            Some(Self(State::Tiles(mut part))) if part.fits(layout, share) => {
                part.statistics = part.statistics.continued(&statistics);
                Ok(part)
            }
            Some(_) => Err(RenderError::Checkpoint),
        }
    }

    /// Film of a render pass by pass: that of a matching checkpoint, or an empty one.
    pub(crate) fn passes_of(
        from: Option<Self>,
        layout: FilmLayout,
        share: Share,
        rule: Option<&StopRule>,
        statistics: Statistics,
    ) -> Result<PassState, RenderError> {
        match from {
            None => Ok(PassState::new(layout, share, rule, statistics)),
            Some(Self(State::Passes(mut state))) if state.fits(layout, share, rule) => {
                state.statistics = state.statistics.continued(&statistics);
                Ok(state)
            }
            Some(_) => Err(RenderError::Checkpoint),
        }
    }
}

impl Kept<'_> {
    /// Copy of the state as a checkpoint.
    pub fn to_checkpoint(&self) -> Checkpoint {
        Checkpoint(match self.0 {
            observer::FilmState::Tiles(part) => State::Tiles(part.clone()),
            observer::FilmState::Passes(passes) => State::Passes(passes.clone()),
        })
    }
}
