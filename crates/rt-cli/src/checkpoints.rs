//! Checkpoints: what a render can go on from, written now and then beside its picture.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use rt_render::{Checkpoint, Kept, SoFar};

use crate::args::{Every, KeepArgs};
use crate::console::Console;
use crate::error::Failure;
use crate::kept_file::{self, KeptError, KeptKind, Label};
use crate::output::OutputFile;

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

    /// The checkpoint of an earlier run, if it is to be continued and there is one.
    pub(crate) fn earlier(&self, args: &KeepArgs) -> Result<Option<Checkpoint>, Failure> {
        if !kept_file::may_be_replaced(&self.file) {
            return Err(KeptError::OtherKind { file: self.file.clone(), kind: KeptKind::Checkpoint }.into());
        }
        if args.restart || !self.file.exists() {
            return Ok(None);
        }
        if !args.resume {
            return Err(Failure::Usage(format!(
                "{} holds a render that was not finished: go on with --resume, or begin anew with --restart",
                self.file.display()
            )));
        }
        let (label, checkpoint) = kept_file::read::<Checkpoint>(&self.file, KeptKind::Checkpoint)?;
        if label.identity != self.label.identity {
            let advice = "; begin anew with --restart";
            return Err(KeptError::Foreign { file: self.file.clone(), scene: label.scene, advice }.into());
        }
        Ok(Some(checkpoint))
    }

    /// Writes one if it is time for it.
    pub(crate) fn tick(&mut self, so_far: &SoFar<'_>) {
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

    /// Writes one: whole, or not at all.
    fn write(&self, kept: &Kept<'_>) -> Result<(), String> {
        let unfinished = self.unfinished();
        let written = File::create(&unfinished)
            .map_err(|error| error.to_string())
            .and_then(|mut file| {
                kept_file::write(&mut file, &self.label, kept)?;
                file.sync_all().map_err(|error| error.to_string())
            })
            .and_then(|()| fs::rename(&unfinished, &self.file).map_err(|error| error.to_string()));
        if written.is_err() {
            // What is left of it is of no use to anybody.
            let _ = fs::remove_file(&unfinished);
        }
        written
    }

    /// Writes the last one, if need be where there is room; tells where it is.
    pub(crate) fn write_last(&self, kept: &Kept<'_>, refuges: &[PathBuf]) -> Result<PathBuf, String> {
        let Err(reason) = self.write(kept) else { return Ok(self.file.clone()) };
        let name = self.file.file_name().unwrap_or_default().to_string_lossy();
        // Renders of other folders may look for refuge in the same one.
        let name = format!("rt-cli-{}-{name}", std::process::id());
        let elsewhere =
            refuges.iter().map(|refuge| Self { file: refuge.join(&name), label: self.label.clone(), ..*self });
        elsewhere.into_iter().find_map(|other| other.write(kept).ok().map(|()| other.file)).ok_or(reason)
    }

    /// Where one is while it is written. The name is always the same, so that a run that is killed leaves one at most, which
    /// the next run replaces or removes.
    fn unfinished(&self) -> PathBuf {
        let mut name = self.file.as_os_str().to_owned();
        name.push(".new");
        PathBuf::from(name)
    }

    /// Removes what a finished render needs no more.
    pub(crate) fn remove(&self) {
        // There may be none, and if one stays, `--resume` finds nothing left to do.
        let _ = fs::remove_file(&self.file);
        let _ = fs::remove_file(self.unfinished());
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
