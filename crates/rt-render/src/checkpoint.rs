//! Checkpoints: states that a render resumes from.

use serde::{Deserialize, Deserializer, Serialize, de::Error as _};

use crate::{
    CheckpointRef, ContentError, RenderError, ShardSpec, Statistics, StopRule,
    film::film_tile::FilmLayout,
    observer,
    pass_state::PassState,
    shard::{Shard, decode_unchecked},
};

/// State of an unfinished render, deserialised from a [`CheckpointRef`](crate::CheckpointRef).
///
/// The caller must ensure that a render resumes with the same scene. This crate checks the image size and the options only.
///
/// Deserialisation runs [`validate`](Self::validate); [`UncheckedCheckpoint`] reports the reason of an error.
#[derive(Clone, Debug, Serialize)]
pub struct Checkpoint(State);

#[derive(Clone, Debug, Serialize, Deserialize)]
enum State {
    Tiles(#[serde(deserialize_with = "decode_unchecked")] Shard),
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
            State::Tiles(shard) => shard.validate(),
            State::Passes(state) => state.validate(),
        }
    }

    /// Camera samples taken so far.
    pub const fn samples(&self) -> u64 {
        match &self.0 {
            State::Tiles(shard) => shard.statistics.samples,
            State::Passes(state) => state.statistics.samples,
        }
    }

    /// Rays traced so far, of all kinds.
    pub fn rays(&self) -> u64 {
        match &self.0 {
            State::Tiles(shard) => shard.statistics.counters.total().rays,
            State::Passes(state) => state.statistics.counters.total().rays,
        }
    }

    /// True if a render of this layout, shard and rule can resume from here.
    pub(crate) fn fits(
        &self,
        layout: FilmLayout,
        spec: ShardSpec,
        rule: Option<&StopRule>,
        pass_by_pass: bool,
    ) -> bool {
        match &self.0 {
            State::Tiles(shard) => !pass_by_pass && shard.fits(layout, spec),
            State::Passes(state) => pass_by_pass && state.fits(layout, spec, rule),
        }
    }

    /// Film of a render tile by tile: that of a matching checkpoint, or an empty one.
    pub(crate) fn shard_of(
        from: Option<Self>,
        layout: FilmLayout,
        spec: ShardSpec,
        statistics: Statistics,
    ) -> Result<Shard, RenderError> {
        match from {
            None => Ok(Shard::empty(layout, spec, statistics)),
            Some(Self(State::Tiles(mut shard))) if shard.fits(layout, spec) => {
                shard.statistics = shard.statistics.continued(&statistics);
                Ok(shard)
            }
            Some(_) => Err(RenderError::Checkpoint),
        }
    }

    /// Film of a render pass by pass: that of a matching checkpoint, or an empty one.
    pub(crate) fn passes_of(
        from: Option<Self>,
        layout: FilmLayout,
        spec: ShardSpec,
        rule: Option<&StopRule>,
        statistics: Statistics,
    ) -> Result<PassState, RenderError> {
        match from {
            None => Ok(PassState::new(layout, spec, rule, statistics)),
            Some(Self(State::Passes(mut state))) if state.fits(layout, spec, rule) => {
                state.statistics = state.statistics.continued(&statistics);
                Ok(state)
            }
            Some(_) => Err(RenderError::Checkpoint),
        }
    }
}

impl CheckpointRef<'_> {
    /// Copy of the state as a checkpoint.
    pub fn to_checkpoint(&self) -> Checkpoint {
        Checkpoint(match self.0 {
            observer::FilmState::Tiles(shard) => State::Tiles(shard.clone()),
            observer::FilmState::Passes(passes) => State::Passes(passes.clone()),
        })
    }
}
