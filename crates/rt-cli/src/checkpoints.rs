//! Checkpoints: what a render can go on from, written now and then beside its picture.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use rt_render::{Checkpoint, Kept, RenderSnapshot};

use crate::args::{Every, KeepArgs};
use crate::console::Console;
use crate::error::Failure;
use crate::kept_file::{self, KeptError, KeptKind, Label};
use crate::output::{self, OutputFile};

/// Where checkpoints of a render go, and how often.
#[derive(Debug)]
pub(crate) struct Checkpoints {
    file: PathBuf,
    every: Option<Duration>,
    label: Label,
    last: Instant,
    console: Console,
    /// It was said that they cannot be written.
    has_warned: bool,
}

impl Checkpoints {
    /// Those of a render whose result goes to `output`.
    pub(crate) fn new(args: &KeepArgs, output: &OutputFile, label: Label, console: Console) -> Self {
        let file = place(args, output);
        let every = match args.checkpoint_every {
            Every::Time(time) => Some(time),
            Every::Never => None,
        };
        Self { file, every, label, last: Instant::now(), console, has_warned: false }
    }

    /// The file.
    pub(crate) fn file(&self) -> &Path {
        &self.file
    }

    /// The checkpoint of an earlier run, if it is to be continued and there is one. One of another picture, or that is of no use
    /// to this program, stays until a checkpoint of this render takes its place, or the picture is finished; a note says so.
    ///
    /// # Errors
    /// [`Failure`] if there is a file that is no checkpoint, or a checkpoint of which nothing is said, or one that is to be
    /// continued and cannot be. Reading it may take `memory` bytes.
    pub(crate) fn earlier(&self, args: &KeepArgs, memory: Option<u64>) -> Result<Option<Checkpoint>, Failure> {
        let found = kept_file::label(&self.file, KeptKind::Checkpoint);
        let of_no_use = match found {
            Ok(None) => return Ok(None),
            Ok(Some(label)) if label.identity == self.label.identity => None,
            Ok(Some(label)) => Some(self.foreign(label, "")),
            Err(error @ (KeptError::Damaged(_) | KeptError::Version { .. } | KeptError::Content { .. })) => Some(error),
            // A link that somebody has put there is replaced, and what it leads to is not touched.
            Err(KeptError::OtherKind { .. } | KeptError::NotAFile(_)) if self.file.is_symlink() && !args.resume => {
                return Ok(None);
            }
            Err(error) => return Err(error.into()),
        };
        match of_no_use {
            _ if args.restart => Ok(None),
            _ if args.resume => {
                let (label, checkpoint) = kept_file::read::<Checkpoint>(&self.file, KeptKind::Checkpoint, memory)?;
                if label.identity != self.label.identity {
                    return Err(self.foreign(label, "; begin anew with --restart").into());
                }
                Ok(Some(checkpoint))
            }
            None => Err(Failure::Usage(format!(
                "{} holds a render that was not finished: go on with --resume, or begin anew with --restart",
                self.file.display()
            ))),
            Some(error) => {
                self.console.say(format_args!(
                    "note: {error}; this render begins anew, and replaces that checkpoint by its own when it writes one, or \
                     removes it when the picture is finished"
                ))?;
                Ok(None)
            }
        }
    }

    fn foreign(&self, label: Label, advice: &'static str) -> KeptError {
        KeptError::Foreign { file: self.file.clone(), scene: label.scene, advice }
    }

    /// Writes one if it is time for it.
    pub(crate) fn tick(&mut self, so_far: &RenderSnapshot<'_>) {
        if self.every.is_none_or(|every| self.last.elapsed() < every) {
            return;
        }
        if let Err(reason) = self.write(&so_far.checkpoint())
            && !self.has_warned
        {
            self.has_warned = true;
            let file = self.file.display();
            self.console.warn(format_args!("no checkpoint can be written to {file}: {reason}; the render goes on"));
        }
        // Writing a large one may take a while, of which most of the time should not be made.
        self.last = Instant::now();
    }

    /// Writes one: whole, or not at all. A link that has its name is replaced.
    fn write(&self, kept: &Kept<'_>) -> Result<(), String> {
        output::write_over_link(&self.file, |file| kept_file::write(file, &self.label, kept))
    }

    /// Writes the last one, if need be where there is room; tells where it is.
    pub(crate) fn write_last(&self, kept: &Kept<'_>, refuges: &[PathBuf]) -> Result<PathBuf, String> {
        let Err(reason) = self.write(kept) else { return Ok(self.file.clone()) };
        output::rescue(&self.file, refuges, |file| kept_file::write(file, &self.label, kept)).ok_or(reason)
    }

    /// Removes what a finished render needs no more.
    pub(crate) fn remove(&self) {
        // There may be none, and if one stays, `--resume` finds nothing left to do.
        let _ = fs::remove_file(&self.file);
    }
}

/// Where the checkpoint of a render goes whose result goes to `output`.
pub(crate) fn place(args: &KeepArgs, output: &OutputFile) -> PathBuf {
    args.checkpoint.clone().unwrap_or_else(|| beside(output.path()))
}

/// The name of a result with `.checkpoint` behind it.
fn beside(output: &Path) -> PathBuf {
    let mut name = output.as_os_str().to_owned();
    name.push(".checkpoint");
    PathBuf::from(name)
}
