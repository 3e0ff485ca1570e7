//! Which frames of an animation are done: a small JSON file beside their pictures.
//!
//! ```text
//!   out-####.png  ->  out-####.png.frames.json, or with --shard 2/8 out-####.png.frames.2-of-8.json
//!   { "frames": { "0": "5e1c...", "1": "90ab..." } }
//! ```
//!
//! Each frame is known by the [`Identity`] of its picture. Each machine has a file of its own, so that none overwrites another's.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use rt_render::Share;
use serde::{Deserialize, Serialize};

use crate::args::Frames;
use crate::error::Failure;
use crate::identity::Identity;
use crate::kept_file::KeptError;
use crate::output::OutputFile;

/// The frames that are done.
#[derive(Debug)]
pub(crate) struct FrameLog {
    output: OutputFile,
    /// Those that this run renders.
    own: Frames,
    done: Done,
}

/// The file.
#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Done {
    /// Identities of their pictures, by their numbers.
    frames: BTreeMap<u32, String>,
}

impl FrameLog {
    /// The log of pictures whose names are made by this pattern. Nothing is known of the frames of this run, unless an earlier one
    /// is to be continued.
    ///
    /// # Errors
    /// [`Failure`] if it could not be written, or is there and is no such file.
    pub(crate) fn open(pattern: &Path, shard: Option<Share>, own: Frames, resume: bool) -> Result<Self, Failure> {
        let output = OutputFile::prepare(&beside(pattern, shard), &[])?;
        let mut done = read(output.path())?;
        done.frames.retain(|frame, _| resume || !own.contains(*frame));
        Ok(Self { output, own, done })
    }

    /// True if a frame is done already.
    ///
    /// # Errors
    /// [`Failure`] if what is done is the frame of another scene, or of other options.
    pub(crate) fn has(&self, frame: u32, identity: &Identity, scene: &Path) -> Result<bool, Failure> {
        match self.done.frames.get(&frame) {
            Some(known) if *known == identity.to_string() => Ok(true),
            Some(_) => Err(KeptError::Foreign {
                file: self.output.path().to_owned(),
                scene: scene.display().to_string(),
                advice: "; begin anew with --restart",
            }
            .into()),
            None => Ok(false),
        }
    }

    /// Adds a frame whose picture is written.
    pub(crate) fn add(&mut self, frame: u32, identity: &Identity) -> Result<(), Failure> {
        self.done.frames.insert(frame, identity.to_string());
        // Other runs may have rendered other frames meanwhile.
        let others = read(self.output.path())?.frames.into_iter().filter(|(frame, _)| !self.own.contains(*frame));
        self.done.frames.extend(others);
        Ok(self.output.write(|file| serde_json::to_writer_pretty(file, &self.done))?)
    }
}

/// What is in the file; nothing if there is none.
fn read(file: &Path) -> Result<Done, KeptError> {
    let Ok(bytes) = fs::read(file) else { return Ok(Done::default()) };
    serde_json::from_slice(&bytes).map_err(|_| KeptError::Log(file.to_owned()))
}

/// The name of a pattern with `.frames.json` behind it.
fn beside(pattern: &Path, shard: Option<Share>) -> PathBuf {
    let mut name = pattern.as_os_str().to_owned();
    match shard {
        None => name.push(".frames.json"),
        Some(share) => name.push(format!(".frames.{}-of-{}.json", share.index() + 1, share.count())),
    }
    PathBuf::from(name)
}
