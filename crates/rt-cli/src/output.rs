//! Atomic output files.
//!
//! A file is written under a temporary name in its own directory, synchronised, and renamed. Readers see the older file or the new
//! one, never a part; an older file survives every failure.

use std::env;
use std::ffi::{OsStr, OsString};
use std::fmt::Display;
use std::fs::{self, File};
use std::io::{self, BufWriter, ErrorKind, IsTerminal, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::console::reserve_stdout;
use crate::error::{CliError, usage};
use crate::output_error::OutputError;
use crate::stdin::is_dash;

/// Output path that was checked to be writable.
#[derive(Debug)]
pub(crate) struct OutputFile {
    /// Path as typed.
    path: PathBuf,
    /// Path with symbolic links followed.
    target: PathBuf,
    folder: PathBuf,
    destination: Destination,
    /// True for a text, of which a pipe may take the start only.
    is_text: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Destination {
    File,
    Stdout,
    /// The null device: nothing is kept.
    Null,
}

/// True for the device that discards what is written to it.
pub(crate) fn is_null_device(path: &Path) -> bool {
    cfg!(unix) && path == Path::new("/dev/null")
}

const STDOUT: &str = "standard output";

/// Target of a link, which need not exist, or the path itself.
fn followed(path: &Path) -> Result<PathBuf, OutputError> {
    if let Ok(target) = path.canonicalize() {
        return Ok(target);
    }
    let Ok(link) = path.read_link() else { return Ok(path.to_owned()) };
    let target = folder_of(path).join(link);
    // Links to pipes, such as /dev/stdout, have no path as their target.
    if path.exists() {
        Err(OutputError::NotAFile(path.to_owned()))
    } else if target.is_symlink() {
        Err(OutputError::BrokenLink(path.to_owned()))
    } else {
        Ok(target)
    }
}

impl OutputFile {
    /// Checks that `path` is writable: its directory takes files, and the path is free or an older file that is not one of
    /// `inputs`. A link is written through. The path `-` is standard output, which is then reserved for the file.
    pub(crate) fn prepare(path: &Path, inputs: &[PathBuf]) -> Result<Self, OutputError> {
        Self::prepare_target(path, followed(path)?, inputs)
    }

    /// Version of [`Self::prepare`] that replaces links. For predictable names: checkpoints, shards and frame logs.
    pub(crate) fn prepare_over_link(path: &Path, inputs: &[PathBuf]) -> Result<Self, OutputError> {
        Self::prepare_target(path, path.to_owned(), inputs)
    }

    /// Standard output or the null device.
    fn no_file(path: &Path, target: &Path, destination: Destination) -> Self {
        let (path, target, folder) = (path.to_owned(), target.to_owned(), PathBuf::new());
        Self { path, target, folder, destination, is_text: false }
    }

    fn prepare_target(path: &Path, target: PathBuf, inputs: &[PathBuf]) -> Result<Self, OutputError> {
        if is_dash(path) {
            reserve_stdout();
            return Ok(Self::no_file(STDOUT.as_ref(), "stdout".as_ref(), Destination::Stdout));
        }
        if is_null_device(path) {
            return Ok(Self::no_file(path, path, Destination::Null));
        }
        if target.file_name().is_none() {
            return Err(OutputError::NoName(path.to_owned()));
        }
        if is_folder_name(path) || is_folder_name(&target) {
            return Err(OutputError::FolderName(path.to_owned()));
        }
        let folder = folder_of(&target);
        if !folder.is_dir() {
            return Err(OutputError::NoFolder { path: path.to_owned(), folder: folder.to_owned() });
        }
        match fs::symlink_metadata(&target) {
            Ok(older) if older.is_symlink() => {}
            Ok(older) if !older.is_file() => return Err(OutputError::NotAFile(path.to_owned())),
            Ok(older) if older.permissions().readonly() => return Err(OutputError::ReadOnly(path.to_owned())),
            Err(source) if source.kind() == ErrorKind::InvalidFilename => {
                return Err(OutputError::BadName { path: path.to_owned(), source });
            }
            _ => {}
        }
        let is_same = |path: PathBuf| inputs.iter().any(|input| input.canonicalize().is_ok_and(|input| input == path));
        if path.canonicalize().is_ok_and(is_same) {
            return Err(OutputError::IsInput(path.to_owned()));
        }
        // An anonymous file proves that the directory is writable, and leaves nothing behind.
        match tempfile::tempfile_in(folder) {
            Ok(_) => {
                clear_away(folder, &target);
                Ok(Self {
                    path: path.to_owned(),
                    folder: folder.to_owned(),
                    target,
                    destination: Destination::File,
                    is_text: false,
                })
            }
            Err(source) => Err(OutputError::Folder { path: path.to_owned(), folder: folder.to_owned(), source }),
        }
    }

    /// Output whose content has this extension, for a fallback file in place of standard output.
    pub(crate) fn with_extension(self, extension: &str) -> Self {
        let target = if self.is_stdout() { self.target.with_extension(extension) } else { self.target };
        Self { target, ..self }
    }

    /// Output for a text. A broken pipe is then not an error: its reader has read enough.
    pub(crate) fn for_text(self) -> Self {
        Self { is_text: true, ..self }
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    pub(crate) fn is_stdout(&self) -> bool {
        self.destination == Destination::Stdout
    }

    /// False for standard output and the null device.
    pub(crate) fn is_file(&self) -> bool {
        self.destination == Destination::File
    }

    pub(crate) fn is_same_file(&self, other: &Self) -> bool {
        if !self.is_file() || !other.is_file() {
            return self.is_stdout() && other.is_stdout();
        }
        let location = |file: &Self| Some((file.folder.canonicalize().ok()?, file.target.file_name()?.to_owned()));
        location(self) == location(other)
    }

    pub(crate) fn write<E: Display>(
        &self,
        content: impl FnOnce(&mut dyn Write) -> Result<(), E>,
    ) -> Result<(), OutputError> {
        let written = match self.destination {
            Destination::File => write_atomically(&self.target, &self.folder, content).map(drop),
            Destination::Stdout => write_to_stdout(content, self.is_text),
            Destination::Null => content(&mut io::sink()).map_err(|error| error.to_string()),
        };
        written.map_err(|reason| OutputError::Write { path: self.path.clone(), reason })
    }

    /// Writes the file; if that fails, writes it under a new name to the first writable fallback directory.
    ///
    /// # Errors
    /// [`OutputError::WrittenElsewhere`] if the fallback succeeded.
    pub(crate) fn write_with_fallback<E: Display>(
        &self,
        fallback_dirs: &[PathBuf],
        content: impl Fn(&mut dyn Write) -> Result<(), E>,
    ) -> Result<(), OutputError> {
        let Err(original) = self.write(&content) else { return Ok(()) };
        match write_elsewhere(&self.target, fallback_dirs, content) {
            Some(path) => Err(OutputError::WrittenElsewhere { original: Box::new(original), path }),
            None => Err(original),
        }
    }

    /// Checks the free disk space; an older file stays until the new one is complete.
    pub(crate) fn check_space(&self, bytes: u64) -> Result<(), OutputError> {
        if !self.is_file() {
            return Ok(());
        }
        match fs4::available_space(&self.folder) {
            Ok(available) if available < bytes => {
                Err(OutputError::NoSpace { path: self.path.clone(), folder: self.folder.clone(), available, bytes })
            }
            // Unknown on this system.
            _ => Ok(()),
        }
    }
}

/// Fallback directories, the given one first; it must exist.
pub(crate) fn fallback_dirs(fallback: Option<&Path>) -> Result<Vec<PathBuf>, CliError> {
    if let Some(folder) = fallback.filter(|folder| !folder.is_dir()) {
        return usage(format!(
            "--fallback-dir {} is not a directory; create it, or choose another one",
            folder.display()
        ));
    }
    Ok(fallback.map(Path::to_owned).into_iter().chain([env::temp_dir(), PathBuf::from(".")]).collect())
}

/// Collects the errors of several files.
pub(crate) fn write_all(results: impl IntoIterator<Item = Result<(), OutputError>>) -> Result<(), CliError> {
    let failed: Vec<_> = results.into_iter().filter_map(Result::err).collect();
    if failed.is_empty() { Ok(()) } else { Err(CliError::Outputs(failed)) }
}

/// Refuses binary output to a terminal.
pub(crate) fn refuse_terminal(path: &Path) -> Result<(), CliError> {
    if is_dash(path) && io::stdout().is_terminal() {
        return usage("standard output is a terminal: redirect it, or name a file");
    }
    Ok(())
}

/// Writes complete content to standard output. A broken pipe is not an error for a text.
fn write_to_stdout<E: Display>(
    content: impl FnOnce(&mut dyn Write) -> Result<(), E>,
    is_text: bool,
) -> Result<(), String> {
    let mut bytes = Vec::new();
    content(&mut bytes).map_err(|error| error.to_string())?;
    let mut stdout = io::stdout().lock();
    match stdout.write_all(&bytes).and_then(|()| stdout.flush()) {
        Err(error) if is_text && error.kind() == ErrorKind::BrokenPipe => Ok(()),
        written => written.map_err(|error| error.to_string()),
    }
}

/// Writes a file atomically; a link of its name is replaced, not followed. Returns the file, which is locked where the system
/// has locks.
pub(crate) fn write_over_link<E: Display>(
    target: &Path,
    content: impl FnOnce(&mut dyn Write) -> Result<(), E>,
) -> Result<File, String> {
    write_atomically(target, folder_of(target), content)
}

/// Writes the content of `target` under a new, unpredictable name to the first writable fallback directory, and returns its path.
/// Existing files and links are neither replaced nor followed.
pub(crate) fn write_elsewhere<E: Display>(
    target: &Path,
    fallback_dirs: &[PathBuf],
    content: impl Fn(&mut dyn Write) -> Result<(), E>,
) -> Option<PathBuf> {
    let name = short_name(target);
    let write_to = |dir: &PathBuf| {
        let suffix = format!("-{name}{UNFINISHED}");
        let mut builder = tempfile::Builder::new();
        builder.prefix(".rt-cli-").suffix(&suffix);
        let mut file = create(&builder, dir).ok()?;
        fill(&mut file, &content).ok()?;
        file.as_file().sync_all().ok()?;
        let hidden = file.path().file_name()?.to_str()?;
        let path = dir.join(hidden.strip_prefix('.')?.strip_suffix(UNFINISHED)?);
        file.persist_noclobber(&path).ok()?;
        sync_folder(dir);
        Some(path)
    };
    fallback_dirs.iter().find_map(write_to)
}

/// True for a name that ends in a separator, also with a dot. [`Path`] ignores both.
fn is_folder_name(path: &Path) -> bool {
    let name = path.as_os_str().as_encoded_bytes();
    let name = name.strip_suffix(b".").unwrap_or(name);
    name.last().is_some_and(|&byte| std::path::is_separator(byte.into()))
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."))
}

fn fill<E: Display>(
    file: &mut NamedTempFile,
    content: impl FnOnce(&mut dyn Write) -> Result<(), E>,
) -> Result<(), String> {
    let mut writer = BufWriter::new(file.as_file_mut());
    content(&mut writer).map_err(|error| error.to_string())?;
    writer.flush().map_err(|error| error.to_string())
}

fn write_atomically<E: Display>(
    target: &Path,
    folder: &Path,
    content: impl FnOnce(&mut dyn Write) -> Result<(), E>,
) -> Result<File, String> {
    let mut file = temporary_file(folder, target).map_err(|error| error.to_string())?;
    fill(&mut file, content)?;
    let file = replace(target, file).map_err(|error| error.to_string())?;
    sync_folder(folder);
    Ok(file)
}

/// Synchronises a directory. Some systems refuse that, which is harmless: the file itself is complete.
fn sync_folder(folder: &Path) {
    let _ = File::open(folder).and_then(|folder| folder.sync_all());
}

/// Renames a finished file over an older one, and keeps its permissions.
fn replace(target: &Path, file: NamedTempFile) -> io::Result<File> {
    if let Some(older) = fs::symlink_metadata(target).ok().filter(fs::Metadata::is_file) {
        file.as_file().set_permissions(older.permissions())?;
    }
    file.as_file().sync_all()?;
    Ok(file.persist(target)?)
}

/// Extension of unfinished files.
const UNFINISHED: &str = ".unfinished";

/// Length in bytes up to which a name is kept whole: with what is added, it must stay within the limit of file systems.
const LIMIT: usize = 200;

/// Start of a name that is too long. A character takes at most four bytes.
fn start_of(name: &OsStr) -> String {
    name.to_string_lossy().chars().take(LIMIT / 4).collect()
}

/// Name of `target` in a fallback directory: of a long one, the start and the extension.
fn short_name(target: &Path) -> String {
    let name = target.file_name().unwrap_or_default();
    let whole = name.to_string_lossy();
    if whole.len() <= LIMIT {
        return whole.into_owned();
    }
    let extension = target.extension().map(OsStr::to_string_lossy).filter(|extension| extension.len() <= LIMIT / 10);
    extension.map_or_else(|| start_of(name), |extension| format!("{}.{extension}", start_of(name)))
}

/// Prefix of the unfinished files of `target`; of a long name, it has the start.
fn unfinished_name(target: &Path) -> OsString {
    let name = target.file_name().unwrap_or_default();
    let mut prefix = OsString::from(".");
    if name.len() <= LIMIT {
        prefix.push(name);
    } else {
        prefix.push(start_of(name));
    }
    prefix.push("-");
    prefix
}

/// Locked file that is removed unless it is renamed.
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
    // Without locks, unfinished files of killed runs stay.
    let _ = file.as_file().try_lock();
    Ok(file)
}

/// Removes unfinished files of `target` that killed runs left. Files of running programs are locked.
fn clear_away(folder: &Path, target: &Path) {
    let prefix = unfinished_name(target);
    let is_unfinished = |name: &OsStr| {
        let name = name.as_encoded_bytes();
        name.starts_with(prefix.as_encoded_bytes()) && name.ends_with(UNFINISHED.as_bytes())
    };
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        // Opening a pipe would block.
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        let is_free = || File::open(entry.path()).is_ok_and(|file| file.try_lock().is_ok());
        if is_unfinished(&entry.file_name()) && is_file && is_free() {
            // A leftover is harmless.
            let _ = fs::remove_file(entry.path());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(text: &str) -> impl Fn(&mut dyn Write) -> io::Result<()> {
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
    fn files_of_killed_runs_are_removed_and_files_being_written_are_not() {
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
    fn content_goes_to_a_fallback_directory_if_the_folder_is_gone() {
        let folder = tempfile::tempdir().expect("a folder");
        let refuge = tempfile::tempdir().expect("a folder");
        let gone = folder.path().join("gone");
        fs::create_dir(&gone).expect("created");
        let output = prepare(&gone.join("a.txt")).expect("fit");
        fs::remove_dir(&gone).expect("removed");
        let Err(OutputError::WrittenElsewhere { path: rescued, .. }) =
            output.write_with_fallback(&[PathBuf::from("/nowhere"), refuge.path().to_owned()], text("precious"))
        else {
            panic!("not rescued")
        };
        assert_eq!(rescued.parent(), Some(refuge.path()));
        assert_eq!(rescued.extension().and_then(|e| e.to_str()), Some("txt"));
        assert_eq!(fs::read_to_string(&rescued).expect("there"), "precious");
        let lost = output.write_with_fallback(core::slice::from_ref(&gone), text("precious"));
        assert!(matches!(lost, Err(OutputError::Write { .. })), "{lost:?}");
    }

    #[test]
    fn unwritable_paths_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("file.txt");
        fs::write(&file, "x").expect("written");
        let check = |path: &Path| prepare(path).expect_err("unfit");
        assert!(matches!(check(Path::new("")), OutputError::NoName(_)));
        assert!(matches!(check(Path::new("/")), OutputError::NoName(_)));
        assert!(matches!(check(folder.path()), OutputError::NotAFile(_)));
        assert!(matches!(check(&folder.path().join("missing/a.png")), OutputError::NoFolder { .. }));
        assert!(matches!(check(&file.join("a.png")), OutputError::NoFolder { .. }));
        for name in ["a.png/", "a.png/.", "file.txt/"] {
            assert!(matches!(check(&folder.path().join(name)), OutputError::FolderName(_)), "{name}");
        }
        assert!(matches!(check(&folder.path().join("a".repeat(300))), OutputError::BadName { .. }));
        let input = OutputFile::prepare(&folder.path().join("./file.txt"), std::slice::from_ref(&file));
        assert!(matches!(input, Err(OutputError::IsInput(_))));
        let mut permissions = fs::metadata(&file).expect("there").permissions();
        permissions.set_readonly(true);
        fs::set_permissions(&file, permissions).expect("set");
        assert!(matches!(check(&file), OutputError::ReadOnly(_)));
    }

    #[test]
    fn a_name_that_leaves_no_room_for_that_of_the_unfinished_file_is_written() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join(format!("{}é.txt", "a".repeat(240)));
        prepare(&path).expect("a file name").write(text("short")).expect("written");
        assert_eq!(fs::read_to_string(&path).expect("there"), "short");
    }

    #[test]
    fn fallback_files_of_long_names_are_short_and_keep_the_extension() {
        let folder = tempfile::tempdir().expect("a folder");
        let dirs = [folder.path().to_owned()];
        for (name, extension) in [
            (format!("{}.png", "a".repeat(251)), Some("png")),
            (format!("{}.exr.checkpoint", "é".repeat(110)), Some("checkpoint")),
            (format!("a.{}", "b".repeat(250)), None),
        ] {
            let rescued = write_elsewhere(Path::new(&name), &dirs, text("rescued")).expect("written");
            let found = rescued.extension().and_then(OsStr::to_str);
            assert_eq!(found.filter(|extension| extension.len() < 20), extension, "{name}");
        }
    }

    #[test]
    #[cfg(unix)]
    fn fallback_files_of_names_that_are_not_text_are_written() {
        use std::os::unix::ffi::OsStrExt;
        let folder = tempfile::tempdir().expect("a folder");
        let name = [&[0xff; 190][..], b".png"].concat();
        let target = Path::new(OsStr::from_bytes(&name));
        let rescued = write_elsewhere(target, &[folder.path().to_owned()], text("rescued")).expect("written");
        assert_eq!(rescued.extension().and_then(OsStr::to_str), Some("png"));
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
    fn links_at_predictable_names_are_not_followed() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().expect("a folder");
        let (precious, link) = (folder.path().join("precious.txt"), folder.path().join("link.txt"));
        fs::write(&precious, "precious").expect("written");
        symlink(&precious, &link).expect("linked");
        OutputFile::prepare_over_link(&link, &[]).expect("fit").write(text("new")).expect("written");
        assert_eq!(fs::read_to_string(&precious).expect("there"), "precious");
        assert!(!link.is_symlink() && fs::read_to_string(&link).expect("there") == "new");
        // The fallback name is not that of the process.
        let name = folder.path().join(format!("rt-cli-{}-a.txt", std::process::id()));
        symlink(&precious, &name).expect("linked");
        let rescued =
            write_elsewhere(Path::new("gone/a.txt"), &[folder.path().to_owned()], text("rescued")).expect("room");
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
        assert!(matches!(prepare(Path::new("/dev/zero")), Err(OutputError::NotAFile(_))));
        let null = prepare(Path::new("/dev/null")).expect("fit");
        null.write(text("discarded")).expect("written");
        assert!(!null.is_same_file(&null) && !Path::new("/dev/null").is_file());
    }
}
