//! Files that are written whole or not at all.
//!
//! A file is written under a temporary name in its own folder, synchronised, and renamed: whoever looks sees the older
//! file or the new one, never a part, and an older file survives every failure.

use std::env;
use std::ffi::{OsStr, OsString};
use std::fmt::Display;
use std::fs::{self, File};
use std::io::{self, BufWriter, ErrorKind, IsTerminal, Seek, Write};
use std::path::{Path, PathBuf};

use bytesize::ByteSize;
use tempfile::NamedTempFile;

use crate::console::reserve_stdout;
use crate::error::Failure;
use crate::stdin::is_dash;

/// A place that was found fit to write a file to.
#[derive(Debug)]
pub(crate) struct OutputFile {
    /// As the user names it.
    path: PathBuf,
    /// Where it really goes: symbolic links followed.
    target: PathBuf,
    folder: PathBuf,
    /// It is no file, but standard output.
    is_stdout: bool,
}

/// The name of standard output in messages.
const STDOUT: &str = "standard output";

/// Why a file cannot be written.
#[derive(Debug, thiserror::Error)]
pub(crate) enum OutputError {
    /// The path ends in no name.
    #[error("cannot write `{}`: it names no file", .0.display())]
    NoName(PathBuf),
    /// The folder is missing, or is no folder.
    #[error("cannot write `{}`: {} is not a folder; create it, or choose another", path.display(), folder.display())]
    NoFolder {
        /// The file.
        path: PathBuf,
        /// Where it should go.
        folder: PathBuf,
    },
    /// A folder, a pipe or a device.
    #[error("cannot write `{}`: it exists and is not a regular file; choose another name, or `-` for standard output", .0.display())]
    NotAFile(PathBuf),
    /// The older file is protected.
    #[error("cannot write `{}`: it exists and is read-only; remove it, or choose another name", .0.display())]
    ReadOnly(PathBuf),
    /// A file that the command reads.
    #[error("cannot write `{}`: it is an input; choose another name", .0.display())]
    IsInput(PathBuf),
    /// The folder does not take files.
    #[error("cannot write `{}`: the folder {} takes no files: {source}", path.display(), folder.display())]
    Folder {
        /// The file.
        path: PathBuf,
        /// Where it should go.
        folder: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// There is no room for the file.
    #[error(
        "cannot write `{}`: it may take {}, and {} has room for {}",
        path.display(), ByteSize(*bytes), folder.display(), ByteSize(*available)
    )]
    NoSpace {
        /// The file.
        path: PathBuf,
        /// Where it should go.
        folder: PathBuf,
        /// Bytes that are free.
        available: u64,
        /// Bytes that the file may take.
        bytes: u64,
    },
    /// Writing failed halfway. Nothing of it is left.
    #[error("cannot write `{}`: {reason}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the writer or the system says.
        reason: String,
    },
    /// Writing failed, but the content was put elsewhere.
    #[error("{original}; it was saved as `{}` instead", rescued.display())]
    Rescued {
        /// Why it is not where it should be.
        original: Box<Self>,
        /// Where it is.
        rescued: PathBuf,
    },
}

/// The place that a link leads to, or the path itself. What a link leads to need not exist.
fn followed(path: &Path) -> Result<PathBuf, OutputError> {
    if let Ok(target) = path.canonicalize() {
        return Ok(target);
    }
    let Ok(link) = path.read_link() else { return Ok(path.to_owned()) };
    let target = folder_of(path).join(link);
    // Pipes, as of /dev/stdout, have a link to them but no place of their own.
    if path.exists() || target.is_symlink() { Err(OutputError::NotAFile(path.to_owned())) } else { Ok(target) }
}

impl OutputFile {
    /// Checks that a file can be written to `path`, before work is spent on its content: the folder takes files, and
    /// nothing is there but perhaps an older file that is not one of `inputs`. A link is written through: the file that it leads to
    /// is replaced, not the link. The path `-` is standard output, which reports keep clear of from then on.
    pub(crate) fn prepare(path: &Path, inputs: &[PathBuf]) -> Result<Self, OutputError> {
        Self::prepare_target(path, followed(path)?, inputs)
    }

    /// Does the same for a file whose name the program chooses, or others can guess: a checkpoint, a part, a frame log. A link is
    /// replaced, and what it leads to is left alone.
    pub(crate) fn prepare_over_link(path: &Path, inputs: &[PathBuf]) -> Result<Self, OutputError> {
        Self::prepare_target(path, path.to_owned(), inputs)
    }

    fn prepare_target(path: &Path, target: PathBuf, inputs: &[PathBuf]) -> Result<Self, OutputError> {
        if is_dash(path) {
            reserve_stdout();
            let (path, folder) = (PathBuf::from(STDOUT), env::temp_dir());
            return Ok(Self { target: path.clone(), path, folder, is_stdout: true });
        }
        if target.file_name().is_none() {
            return Err(OutputError::NoName(path.to_owned()));
        }
        let folder = folder_of(&target);
        if !folder.is_dir() {
            return Err(OutputError::NoFolder { path: path.to_owned(), folder: folder.to_owned() });
        }
        if let Some(older) = fs::symlink_metadata(&target).ok().filter(|older| !older.is_symlink()) {
            if !older.is_file() {
                return Err(OutputError::NotAFile(path.to_owned()));
            }
            if older.permissions().readonly() {
                return Err(OutputError::ReadOnly(path.to_owned()));
            }
        }
        let is_same =
            |place: PathBuf| inputs.iter().any(|input| input.canonicalize().is_ok_and(|input| input == place));
        if path.canonicalize().is_ok_and(is_same) {
            return Err(OutputError::IsInput(path.to_owned()));
        }
        // An anonymous file proves that the folder takes files, and leaves nothing behind whatever happens later.
        match tempfile::tempfile_in(folder) {
            Ok(_) => {
                clear_away(folder, &target);
                Ok(Self { path: path.to_owned(), folder: folder.to_owned(), target, is_stdout: false })
            }
            Err(source) => Err(OutputError::Folder { path: path.to_owned(), folder: folder.to_owned(), source }),
        }
    }

    /// The path as the user names it.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// True for standard output.
    pub(crate) const fn is_stdout(&self) -> bool {
        self.is_stdout
    }

    /// True if `other` is written to the same file.
    pub(crate) fn is_same_file(&self, other: &Self) -> bool {
        if self.is_stdout || other.is_stdout {
            return self.is_stdout && other.is_stdout;
        }
        let place = |file: &Self| Some((file.folder.canonicalize().ok()?, file.target.file_name()?.to_owned()));
        place(self) == place(other)
    }

    /// Writes the file.
    pub(crate) fn write<E: Display>(
        &self,
        content: impl FnOnce(&mut BufWriter<&mut File>) -> Result<(), E>,
    ) -> Result<(), OutputError> {
        let written = if self.is_stdout {
            write_to_stdout(content)
        } else {
            write_atomically(&self.target, &self.folder, content)
        };
        written.map_err(|reason| OutputError::Write { path: self.path.clone(), reason })
    }

    /// Writes the file; if that fails, writes it under a new name in the first of the folders `refuges` that takes it, so that
    /// its content is not lost, and says so in the error.
    pub(crate) fn write_or_rescue<E: Display>(
        &self,
        refuges: &[PathBuf],
        content: impl Fn(&mut BufWriter<&mut File>) -> Result<(), E>,
    ) -> Result<(), OutputError> {
        let Err(original) = self.write(&content) else { return Ok(()) };
        match rescue(&self.target, refuges, content) {
            Some(rescued) => Err(OutputError::Rescued { original: Box::new(original), rescued }),
            None => Err(original),
        }
    }

    /// Refuses to begin what will not fit on the disk: the new file lies beside an older one until it is whole.
    pub(crate) fn check_space(&self, bytes: u64) -> Result<(), OutputError> {
        if self.is_stdout {
            return Ok(());
        }
        match fs4::available_space(&self.folder) {
            Ok(available) if available < bytes => {
                Err(OutputError::NoSpace { path: self.path.clone(), folder: self.folder.clone(), available, bytes })
            }
            // A system that does not say is no reason to stop.
            _ => Ok(()),
        }
    }
}

/// Folders for what cannot be written where it should, the user's own first.
pub(crate) fn refuges(fallback: Option<&Path>) -> Vec<PathBuf> {
    fallback.map(Path::to_owned).into_iter().chain([env::temp_dir(), PathBuf::from(".")]).collect()
}

/// Writes everything, whatever becomes of some of it.
pub(crate) fn write_all(results: impl IntoIterator<Item = Result<(), OutputError>>) -> Result<(), Failure> {
    let failed: Vec<_> = results.into_iter().filter_map(Result::err).collect();
    if failed.is_empty() { Ok(()) } else { Err(Failure::Outputs(failed)) }
}

/// Refuses to write what is no text to a terminal.
pub(crate) fn refuse_terminal(path: &Path) -> Result<(), Failure> {
    if is_dash(path) && io::stdout().is_terminal() {
        let message = "standard output is a terminal, which shows no such file: redirect it, or name a file";
        return Err(Failure::Usage(message.to_owned()));
    }
    Ok(())
}

/// Writes what is complete to standard output. A reader that has left has seen enough: that is no failure.
fn write_to_stdout<E: Display>(content: impl FnOnce(&mut BufWriter<&mut File>) -> Result<(), E>) -> Result<(), String> {
    let mut file = tempfile::tempfile().map_err(|error| error.to_string())?;
    let mut writer = BufWriter::new(&mut file);
    content(&mut writer).map_err(|error| error.to_string())?;
    writer.flush().map_err(|error| error.to_string())?;
    drop(writer);
    let mut stdout = io::stdout().lock();
    let copied = file.rewind().and_then(|()| io::copy(&mut file, &mut stdout)).and_then(|_| stdout.flush());
    match copied {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(error.to_string()),
        _ => Ok(()),
    }
}

/// Writes a file, whole or not at all, in the place of whatever has its name: a link is replaced, not followed.
pub(crate) fn write_over_link<E: Display>(
    target: &Path,
    content: impl FnOnce(&mut BufWriter<&mut File>) -> Result<(), E>,
) -> Result<(), String> {
    write_atomically(target, folder_of(target), content)
}

/// Writes what cannot go to `target` under a new name in the first of the folders `refuges` that takes it, and returns its path.
/// No file or link that is there is replaced or followed: nobody can know the name beforehand.
pub(crate) fn rescue<E: Display>(
    target: &Path,
    refuges: &[PathBuf],
    content: impl Fn(&mut BufWriter<&mut File>) -> Result<(), E>,
) -> Option<PathBuf> {
    let name = target.file_name().unwrap_or_default().to_string_lossy();
    let rescue_to = |refuge: &PathBuf| {
        let suffix = format!("-{name}{UNFINISHED}");
        let mut builder = tempfile::Builder::new();
        builder.prefix(".rt-cli-").suffix(&suffix);
        let mut file = create(&builder, refuge).ok()?;
        fill(&mut file, &content).ok()?;
        file.as_file().sync_all().ok()?;
        let hidden = file.path().file_name()?.to_str()?;
        let rescued = refuge.join(hidden.strip_prefix('.')?.strip_suffix(UNFINISHED)?);
        file.persist_noclobber(&rescued).ok()?;
        sync_folder(refuge);
        Some(rescued)
    };
    refuges.iter().find_map(rescue_to)
}

/// The folder that a file lies in.
fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."))
}

fn fill<E: Display>(
    file: &mut NamedTempFile,
    content: impl FnOnce(&mut BufWriter<&mut File>) -> Result<(), E>,
) -> Result<(), String> {
    let mut writer = BufWriter::new(file.as_file_mut());
    content(&mut writer).map_err(|error| error.to_string())?;
    writer.flush().map_err(|error| error.to_string())
}

fn write_atomically<E: Display>(
    target: &Path,
    folder: &Path,
    content: impl FnOnce(&mut BufWriter<&mut File>) -> Result<(), E>,
) -> Result<(), String> {
    let mut file = temporary_file(folder, target).map_err(|error| error.to_string())?;
    fill(&mut file, content)?;
    replace(target, file).map_err(|error| error.to_string())?;
    sync_folder(folder);
    Ok(())
}

/// Not all systems let a folder be synchronised, so a refusal is no failure: the file itself is complete.
fn sync_folder(folder: &Path) {
    let _ = File::open(folder).and_then(|folder| folder.sync_all());
}

/// Puts a finished file in the place of an older one, whose permissions it takes.
fn replace(target: &Path, file: NamedTempFile) -> io::Result<()> {
    if let Some(older) = fs::symlink_metadata(target).ok().filter(fs::Metadata::is_file) {
        file.as_file().set_permissions(older.permissions())?;
    }
    file.as_file().sync_all()?;
    file.persist(target)?;
    Ok(())
}

/// Ending of the names of files that are being written.
const UNFINISHED: &str = ".unfinished";

/// How names of files begin that are being written and will be called `target`.
fn unfinished_name(target: &Path) -> OsString {
    let mut name = OsString::from(".");
    name.push(target.file_name().unwrap_or_default());
    name.push("-");
    name
}

/// A file that is removed unless it is renamed, with the permissions of any new file. It is locked as long as it is being written.
fn temporary_file(folder: &Path, target: &Path) -> io::Result<NamedTempFile> {
    let prefix = unfinished_name(target);
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(UNFINISHED);
    create(&builder, folder)
}

fn create(builder: &tempfile::Builder<'_, '_>, folder: &Path) -> io::Result<NamedTempFile> {
    #[cfg(unix)]
    let builder = &{
        let mut builder = builder.clone();
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        builder
    };
    let file = builder.tempfile_in(folder)?;
    // Where nothing can be locked, what a kill leaves stays.
    let _ = file.as_file().try_lock();
    Ok(file)
}

/// Removes what a program that was killed has left of the same file. What another one is writing is locked.
fn clear_away(folder: &Path, target: &Path) {
    let prefix = unfinished_name(target);
    let is_unfinished = |name: &OsStr| {
        let name = name.as_encoded_bytes();
        name.starts_with(prefix.as_encoded_bytes()) && name.ends_with(UNFINISHED.as_bytes())
    };
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        // Whoever opens a pipe waits for its other end.
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        let is_free = || File::open(entry.path()).is_ok_and(|file| file.try_lock().is_ok());
        if is_unfinished(&entry.file_name()) && is_file && is_free() {
            // If it stays, it is in nobody's way.
            let _ = fs::remove_file(entry.path());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(text: &str) -> impl Fn(&mut BufWriter<&mut File>) -> io::Result<()> {
        move |file| file.write_all(text.as_bytes())
    }

    fn prepare(path: &Path) -> Result<OutputFile, OutputError> {
        OutputFile::prepare(path, &[])
    }

    fn entries(folder: &Path) -> usize {
        fs::read_dir(folder).expect("a folder").count()
    }

    #[test]
    fn files_are_replaced_and_nothing_else_is_left() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.txt");
        for content in ["first", "second"] {
            prepare(&path).expect("fit").write(text(content)).expect("written");
            assert_eq!(fs::read_to_string(&path).expect("there"), content);
            assert_eq!(entries(folder.path()), 1);
        }
    }

    #[test]
    fn what_a_kill_has_left_is_cleared_away_and_what_is_being_written_is_not() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.txt");
        let left = folder.path().join(".a.txt-K1ll3d.unfinished");
        let other = folder.path().join(".b.txt-K1ll3d.unfinished");
        for file in [&left, &other] {
            fs::write(file, "half").expect("written");
        }
        let being_written = temporary_file(folder.path(), &path).expect("created");
        prepare(&path).expect("fit");
        assert!(!left.exists() && other.exists() && being_written.path().exists());
    }

    #[test]
    fn preparing_leaves_no_trace() {
        let folder = tempfile::tempdir().expect("a folder");
        prepare(&folder.path().join("a.txt")).expect("fit");
        assert_eq!(entries(folder.path()), 0);
    }

    #[test]
    fn an_older_file_survives_a_failure_halfway() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.txt");
        fs::write(&path, "older").expect("written");
        let failed = prepare(&path).expect("fit").write(|file| {
            file.write_all(&[0; 100_000])?;
            Err(io::Error::other("disk full"))
        });
        assert!(matches!(failed, Err(OutputError::Write { reason, .. }) if reason == "disk full"));
        assert_eq!(fs::read_to_string(&path).expect("there"), "older");
        assert_eq!(entries(folder.path()), 1);
    }

    #[test]
    fn content_is_rescued_if_the_folder_is_gone() {
        let folder = tempfile::tempdir().expect("a folder");
        let refuge = tempfile::tempdir().expect("a folder");
        let gone = folder.path().join("gone");
        fs::create_dir(&gone).expect("created");
        let output = prepare(&gone.join("a.txt")).expect("fit");
        fs::remove_dir(&gone).expect("removed");
        let Err(OutputError::Rescued { rescued, .. }) =
            output.write_or_rescue(&[PathBuf::from("/nowhere"), refuge.path().to_owned()], text("precious"))
        else {
            panic!("not rescued")
        };
        assert_eq!(rescued.parent(), Some(refuge.path()));
        assert_eq!(rescued.extension().and_then(|e| e.to_str()), Some("txt"));
        assert_eq!(fs::read_to_string(&rescued).expect("there"), "precious");
        let lost = output.write_or_rescue(core::slice::from_ref(&gone), text("precious"));
        assert!(matches!(lost, Err(OutputError::Write { .. })), "{lost:?}");
    }

    #[test]
    fn unfit_places_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("file.txt");
        fs::write(&file, "x").expect("written");
        let check = |path: &Path| prepare(path).expect_err("unfit");
        assert!(matches!(check(Path::new("")), OutputError::NoName(_)));
        assert!(matches!(check(Path::new("/")), OutputError::NoName(_)));
        assert!(matches!(check(folder.path()), OutputError::NotAFile(_)));
        assert!(matches!(check(&folder.path().join("missing/a.png")), OutputError::NoFolder { .. }));
        assert!(matches!(check(&file.join("a.png")), OutputError::NoFolder { .. }));
        let input = OutputFile::prepare(&folder.path().join("./file.txt"), std::slice::from_ref(&file));
        assert!(matches!(input, Err(OutputError::IsInput(_))));
        let mut permissions = fs::metadata(&file).expect("there").permissions();
        permissions.set_readonly(true);
        fs::set_permissions(&file, permissions).expect("set");
        assert!(matches!(check(&file), OutputError::ReadOnly(_)));
    }

    #[test]
    fn the_same_file_is_recognised_by_any_path() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| prepare(&folder.path().join(name)).expect("fit");
        assert!(at("a.png").is_same_file(&at("./a.png")));
        assert!(!at("a.png").is_same_file(&at("b.png")));
    }

    #[test]
    #[cfg(unix)]
    fn links_are_written_through_and_permissions_kept() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().expect("a folder");
        let (real, link) = (folder.path().join("real.txt"), folder.path().join("link.txt"));
        fs::write(&real, "older").expect("written");
        fs::set_permissions(&real, PermissionsExt::from_mode(0o640)).expect("set");
        symlink(&real, &link).expect("linked");
        prepare(&link).expect("fit").write(text("new")).expect("written");
        assert_eq!(fs::read_to_string(&real).expect("there"), "new");
        assert!(fs::symlink_metadata(&link).expect("there").is_symlink());
        assert_eq!(fs::metadata(&real).expect("there").permissions().mode() & 0o777, 0o640);
    }

    #[test]
    #[cfg(unix)]
    fn links_at_names_that_can_be_guessed_were_followed() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().expect("a folder");
        let (precious, link) = (folder.path().join("precious.txt"), folder.path().join("link.txt"));
        fs::write(&precious, "precious").expect("written");
        symlink(&precious, &link).expect("linked");
        OutputFile::prepare_over_link(&link, &[]).expect("fit").write(text("new")).expect("written");
        assert_eq!(fs::read_to_string(&precious).expect("there"), "precious");
        assert!(!link.is_symlink() && fs::read_to_string(&link).expect("there") == "new");
        // The name of a rescued file was that of the process.
        let name = folder.path().join(format!("rt-cli-{}-a.txt", std::process::id()));
        symlink(&precious, &name).expect("linked");
        let rescued = rescue(Path::new("gone/a.txt"), &[folder.path().to_owned()], text("rescued")).expect("room");
        assert!(rescued != name && fs::read_to_string(&rescued).expect("there") == "rescued");
        assert_eq!(fs::read_to_string(&precious).expect("there"), "precious");
        // A link to an input is not replaced either.
        symlink(&precious, folder.path().join("scene.ron")).expect("linked");
        let input = OutputFile::prepare_over_link(&folder.path().join("scene.ron"), &[precious]);
        assert!(matches!(input, Err(OutputError::IsInput(_))));
    }

    #[test]
    #[cfg(unix)]
    fn devices_are_never_replaced() {
        assert!(matches!(prepare(Path::new("/dev/null")), Err(OutputError::NotAFile(_))));
    }
}
