//! Checkpoints: periodic snapshots of an unfinished render.

use std::fs::{self, File, TryLockError};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use rt_render::{Checkpoint, CheckpointRef, RenderSnapshot, ShardSpec};

use crate::args::{CheckpointArgs, CheckpointInterval};
use crate::artifact_error::{ArtifactError, ArtifactKind};
use crate::atomic_write;
use crate::checkpoint_format::{self, Label};
use crate::console::Console;
use crate::error::CliError;
use crate::identity::Identity;
use crate::output_file::OutputFile;
use crate::saved_checkpoint::SavedCheckpoint;

/// Checkpointing and sharing of a render.
#[derive(Debug)]
pub(crate) struct CheckpointOptions {
    pub(crate) identity: Identity,
    pub(crate) resume: bool,
    restart: bool,
    /// Path of the checkpoint; `None` for a render without one, such as an image on standard output without `--checkpoint`.
    pub(crate) file: Option<PathBuf>,
    interval: Option<Duration>,
    pub(crate) shard: Option<ShardSpec>,
}

impl CheckpointOptions {
    pub(crate) fn new(args: &CheckpointArgs, file: Option<PathBuf>, identity: Identity) -> Self {
        let interval = match args.checkpoint_every {
            CheckpointInterval::Time(time) => Some(time),
            CheckpointInterval::Never => None,
        };
        let CheckpointArgs { resume, restart, shard, .. } = *args;
        Self { identity, resume, restart, file, interval, shard }
    }
}

/// `--checkpoint`, or the name of the image with `.checkpoint` appended.
pub(crate) fn path_for(args: &CheckpointArgs, image: &Path) -> PathBuf {
    args.checkpoint.clone().unwrap_or_else(|| with_suffix(image, ".checkpoint"))
}

/// [`path_for`] the output. Without `--checkpoint`, only files have one.
pub(crate) fn default_path(args: &CheckpointArgs, output: &OutputFile) -> Option<PathBuf> {
    (args.checkpoint.is_some() || output.is_file()).then(|| path_for(args, output.path()))
}

/// Writer of the checkpoints of one render.
#[derive(Debug)]
pub(crate) struct Checkpointer {
    file: PathBuf,
    interval: Option<Duration>,
    label: Label,
    last: Instant,
    console: Console,
    has_warned: bool,
    /// The checkpoint on disk, open and locked, so that no other render uses it. Only on Unix: elsewhere, open files cannot be
    /// replaced.
    held: Option<File>,
}

impl Checkpointer {
    pub(crate) fn new(file: &Path, options: &CheckpointOptions, label: Label, console: Console) -> Self {
        let interval = options.interval;
        Self { file: file.to_owned(), interval, label, last: Instant::now(), console, has_warned: false, held: None }
    }

    /// Reads the checkpoint of an earlier run to continue, within `memory` bytes. A checkpoint of another image, or an unusable one,
    /// is moved aside with a note.
    ///
    /// # Errors
    /// [`CliError`] if the file is not a checkpoint, is in use by another render, or cannot be continued. Also if it is of this
    /// image, and neither `--resume` nor `--restart` is given.
    pub(crate) fn earlier(
        &mut self,
        options: &CheckpointOptions,
        memory: Option<u64>,
    ) -> Result<Option<Checkpoint>, CliError> {
        self.held = self.lock()?;
        let unusable = match checkpoint_format::label(&self.file, ArtifactKind::Checkpoint) {
            Ok(None) => return Ok(None),
            Ok(Some(label)) if label.identity == self.label.identity && !(options.resume || options.restart) => {
                checkpoint_format::read::<Checkpoint>(&self.file, ArtifactKind::Checkpoint, memory)
                    .err()
                    .filter(is_unusable)
            }
            Ok(Some(label)) if label.identity == self.label.identity => None,
            Ok(Some(label)) => Some(self.foreign(label, "")),
            Err(error) if is_unusable(&error) => Some(error),
            // Links are replaced, not followed.
            Err(ArtifactError::OtherKind { .. } | ArtifactError::NotAFile(_) | ArtifactError::Empty(_))
                if self.file.is_symlink() && !options.resume =>
            {
                return Ok(None);
            }
            Err(error) => return Err(error.into()),
        };
        match unusable {
            _ if options.restart => Ok(None),
            _ if options.resume => {
                let (label, checkpoint) =
                    checkpoint_format::read::<Checkpoint>(&self.file, ArtifactKind::Checkpoint, memory)?;
                if label.identity != self.label.identity {
                    return Err(self.foreign(label, "; start over with --restart").into());
                }
                Ok(Some(checkpoint))
            }
            None => Err(unfinished(&self.file)),
            Some(error) => {
                let fate = match self.move_aside() {
                    Some(aside) => format!("kept as {}", aside.display()),
                    None => "it cannot be renamed, and will be replaced".to_owned(),
                };
                self.console.println(format_args!("note: {}; {fate}; this render starts over", error.cause()))?;
                Ok(None)
            }
        }
    }

    /// Renames the file to the first free name of `.old`, `.old.2`, ...; `None` if that fails.
    fn move_aside(&mut self) -> Option<PathBuf> {
        let names = (1_u32..1000).map(|n| if n == 1 { ".old".to_owned() } else { format!(".old.{n}") });
        let mut paths = names.map(|suffix| with_suffix(&self.file, &suffix));
        let free = paths.find(|path| path.symlink_metadata().is_err())?;
        fs::rename(&self.file, &free).ok()?;
        // The moved file is no longer of this render.
        self.held = None;
        Some(free)
    }

    fn foreign(&self, label: Label, advice: &'static str) -> ArtifactError {
        ArtifactError::Foreign { file: self.file.clone(), scene: label.scene, advice }
    }

    /// Writes a checkpoint if the interval has passed.
    pub(crate) fn tick(&mut self, so_far: &RenderSnapshot<'_>) {
        if self.interval.is_none_or(|interval| self.last.elapsed() < interval) {
            return;
        }
        if let Err(reason) = self.write(&so_far.checkpoint())
            && !self.has_warned
        {
            self.has_warned = true;
            let file = self.file.display();
            self.console.warn(format_args!("cannot write the checkpoint {file}: {reason}; the render continues"));
        }
        // The interval starts after writing, so that large checkpoints do not take most of the time.
        self.last = Instant::now();
    }

    fn write(&mut self, kept: &CheckpointRef<'_>) -> Result<(), String> {
        // Its checkpoint stays even after its end, so that it can be resumed.
        if cfg!(unix) && self.file.is_file() && !self.is_held() {
            return Err("another render has written this file since this one began".to_owned());
        }
        let file = atomic_write::write_over_link(&self.file, |file| checkpoint_format::write(file, &self.label, kept))?;
        self.held = cfg!(unix).then_some(file);
        Ok(())
    }

    /// Locks the file on disk, if there is one.
    ///
    /// # Errors
    /// [`ArtifactError::InUse`] if another render holds the lock, or has just replaced the file. Systems without locks give none.
    fn lock(&self) -> Result<Option<File>, ArtifactError> {
        // Opening a pipe would block.
        if !cfg!(unix) || !self.file.metadata().is_ok_and(|metadata| metadata.is_file()) {
            return Ok(None);
        }
        let Ok(file) = File::open(&self.file) else { return Ok(None) };
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => Err(ArtifactError::InUse(self.file.clone())),
            _ if !is_named(&file, &self.file) => Err(ArtifactError::InUse(self.file.clone())),
            _ => Ok(Some(file)),
        }
    }

    /// True if the locked file has the name of the checkpoint. Other renders may have replaced it.
    fn is_held(&self) -> bool {
        self.held.as_ref().is_some_and(|held| is_named(held, &self.file))
    }

    /// Writes the last checkpoint, if need be to a fallback directory.
    pub(crate) fn write_last(
        &mut self,
        kept: &CheckpointRef<'_>,
        fallback_dirs: &[PathBuf],
    ) -> Result<SavedCheckpoint, String> {
        let Err(reason) = self.write(kept) else {
            return Ok(SavedCheckpoint { file: self.file.clone(), is_elsewhere: false });
        };
        let write = |file: &mut dyn Write| checkpoint_format::write(file, &self.label, kept);
        let file = atomic_write::write_elsewhere(&self.file, fallback_dirs, write).ok_or(reason)?;
        Ok(SavedCheckpoint { file, is_elsewhere: true })
    }

    /// Removes the checkpoint of a finished render. A failure is harmless: `--resume` would find all tiles finished.
    pub(crate) fn remove(&self) {
        // Otherwise the file, if there is one, is that of another render.
        if self.is_held() || !cfg!(unix) {
            let _ = fs::remove_file(&self.file);
        }
    }
}

/// Refuses a checkpoint of this image that can be continued.
pub(crate) fn refuse_unfinished(file: &Path, identity: Identity, memory: Option<u64>) -> Result<(), CliError> {
    let kind = ArtifactKind::Checkpoint;
    match checkpoint_format::label(file, kind) {
        Ok(Some(label))
            if label.identity == identity && checkpoint_format::read::<Checkpoint>(file, kind, memory).is_ok() =>
        {
            Err(unfinished(file))
        }
        _ => Ok(()),
    }
}

fn unfinished(file: &Path) -> CliError {
    CliError::Usage(format!(
        "{} is the checkpoint of an unfinished render: continue with --resume, or start over with --restart",
        file.display()
    ))
}

/// True for a checkpoint that cannot be continued, and is kept for the user.
const fn is_unusable(error: &ArtifactError) -> bool {
    matches!(error, ArtifactError::Damaged(_) | ArtifactError::Version { .. } | ArtifactError::Content { .. })
}

/// True if the path leads to this open file.
#[cfg(unix)]
fn is_named(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;

    let named = path.metadata().and_then(|named| Ok((named, file.metadata()?)));
    named.is_ok_and(|(named, open)| (named.dev(), named.ino()) == (open.dev(), open.ino()))
}

/// Open files cannot be replaced on this system.
#[cfg(not(unix))]
const fn is_named(_file: &File, _path: &Path) -> bool {
    true
}

fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(suffix);
    PathBuf::from(name)
}
