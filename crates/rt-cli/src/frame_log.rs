//! Log of the finished frames of an animation: a small JSON file next to the images.
//!
//! ```text
//!   out-####.png  ->  out-####.png.frames.json, or with --shard 2/8 out-####.png.frames.2-of-8.json
//!   { "frames": { "0": "5e1c...", "1": "90ab..." }, "files": { "0": "77d0...", "1": "c4e9..." } }
//! ```
//!
//! Each frame has the [`Identity`] of its image, and the hash of the image file. Each machine has its own file. Programs that share a
//! file lock it, read the entries of the others, and replace the file.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use rt_render::ShardSpec;
use rt_scene_io::InputHashes;

use crate::args::Frames;
use crate::artifact_error::ArtifactError;
use crate::done_frames::{self, DoneFrames, MAX_LOG_BYTES};
use crate::error::CliError;
use crate::identity::{Identity, hash_of};
use crate::output_file::OutputFile;

#[derive(Debug)]
pub(crate) struct FrameLog {
    output: OutputFile,
    /// Frames of an earlier run that is continued.
    done: DoneFrames,
    /// Entries of an earlier run that this run replaces.
    stale: BTreeMap<u32, String>,
}

impl FrameLog {
    /// Opens the log of an image name pattern. Without `resume`, the frames of this run count as unfinished.
    ///
    /// # Errors
    /// [`CliError`] if the log cannot be written, or is not a log.
    pub(crate) fn open(pattern: &Path, shard: Option<ShardSpec>, own: Frames, resume: bool) -> Result<Self, CliError> {
        let output = OutputFile::prepare_over_link(&log_path(pattern, shard), &[])?;
        let DoneFrames { frames, files } = read(output.path())?;
        let (stale, frames) = frames.into_iter().partition(|(frame, _)| !resume && own.contains(*frame));
        Ok(Self { output, done: DoneFrames { frames, files }, stale })
    }

    /// True if a frame is finished, and `image` is the file that it was written to. Logs of earlier versions lack the hashes of files.
    ///
    /// # Errors
    /// [`CliError`] if the finished frame is of another scene, or of other options.
    pub(crate) fn has(&self, frame: u32, identity: &Identity, scene: &Path, image: &Path) -> Result<bool, CliError> {
        match self.done.frames.get(&frame) {
            Some(known) if *known == identity.to_string() => {
                let written = self.done.files.get(&frame);
                Ok(written.is_none_or(|written| hash_of_image(image).is_some_and(|hash| hash == *written)))
            }
            Some(_) => Err(ArtifactError::Foreign {
                file: self.output.path().to_owned(),
                scene: scene.display().to_string(),
                advice: "; start over with --restart",
            }
            .into()),
            None => Ok(false),
        }
    }

    pub(crate) fn add(&mut self, frame: u32, identity: &Identity, image: &Path) -> Result<(), CliError> {
        let hash = hash_of_image(image);
        let _lock = lock(self.output.path());
        let mut done = read(self.output.path())?;
        // Keep entries that other runs added meanwhile.
        done.frames.retain(|frame, identity| self.stale.get(frame) != Some(identity));
        self.stale.remove(&frame);
        done.frames.insert(frame, identity.to_string());
        done.files.remove(&frame);
        done.files.extend(hash.map(|hash| (frame, hash)));
        done.files.retain(|frame, _| done.frames.contains_key(frame));
        self.output.write(|file| serde_json::to_writer_pretty(file, &done))?;
        Ok(())
    }
}

/// Hash of an image file; `None` if it cannot be read.
fn hash_of_image(image: &Path) -> Option<String> {
    let hash = hash_of(image, &InputHashes::default()).ok()?;
    Some(hash.iter().map(|byte| format!("{byte:02x}")).collect())
}

/// Reads the log; empty if there is none.
fn read(path: &Path) -> Result<DoneFrames, ArtifactError> {
    let other = || ArtifactError::Log(path.to_owned());
    match path.metadata() {
        Err(_) => return Ok(DoneFrames::default()),
        Ok(metadata) if !metadata.is_file() || metadata.len() > MAX_LOG_BYTES => return Err(other()),
        Ok(_) => {}
    }
    let mut text = Vec::new();
    File::open(path)
        .and_then(|file| file.take(MAX_LOG_BYTES).read_to_end(&mut text))
        .map_err(|source| ArtifactError::Read { file: path.to_owned(), source })?;
    done_frames::parse(&text).ok_or_else(other)
}

/// Creates the log if it is missing, and locks it until the file is dropped. Without locks, runs must not overlap.
///
/// Each write replaces the file, so that a lock is valid only on the file that has the name now.
#[cfg(unix)]
fn lock(path: &Path) -> Option<File> {
    use std::fs::OpenOptions;
    use std::io::ErrorKind;
    use std::os::unix::fs::MetadataExt;

    loop {
        // Does not follow links.
        let created = OpenOptions::new().read(true).write(true).create_new(true).open(path);
        let file = match created {
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {
                if path.is_symlink() {
                    crate::atomic_write::write_over_link(path, |_| Ok::<_, String>(())).ok()?;
                    continue;
                }
                match OpenOptions::new().read(true).write(true).open(path) {
                    Err(error) if error.kind() == ErrorKind::NotFound => continue,
                    // File of another user in a shared directory.
                    Err(_) => File::open(path).ok()?,
                    Ok(file) => file,
                }
            }
            created => created.ok()?,
        };
        file.lock().ok()?;
        let locked = file.metadata().ok()?;
        match path.symlink_metadata() {
            Ok(named) if (named.dev(), named.ino()) == (locked.dev(), locked.ino()) => return Some(file),
            _ => {}
        }
    }
}

/// Open files cannot be replaced on this system.
#[cfg(not(unix))]
const fn lock(_path: &Path) -> Option<File> {
    None
}

/// Name pattern with `.frames.json` appended.
fn log_path(pattern: &Path, shard: Option<ShardSpec>) -> PathBuf {
    let mut name = pattern.as_os_str().to_owned();
    match shard {
        None => name.push(".frames.json"),
        Some(spec) => name.push(format!(".frames.{}-of-{}.json", spec.index() + 1, spec.count())),
    }
    PathBuf::from(name)
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn frame_logs_that_are_links_are_replaced() {
        let folder = tempfile::tempdir().expect("a folder");
        let (log, target) = (folder.path().join("log.json"), folder.path().join("target"));
        std::os::unix::fs::symlink(&target, &log).expect("linked");
        drop(lock(&log).expect("locked"));
        assert!(!target.exists() && !log.is_symlink() && log.is_file());
    }

    #[test]
    fn a_lock_is_on_the_file_that_has_the_name_now() {
        let folder = tempfile::tempdir().expect("a folder");
        let log = folder.path().join("log.json");
        let first = lock(&log).expect("locked");
        std::fs::rename(&log, folder.path().join("older.json")).expect("renamed");
        // The older file is still locked, and does not matter.
        let second = lock(&log).expect("locked");
        assert!(File::open(&log).expect("there").try_lock().is_err());
        drop((first, second));
    }
}
