//! Output files: their paths are checked before the work that they are for.

use std::env;
use std::fmt::Display;
use std::fs;
use std::io::{self, ErrorKind, IsTerminal, Write};
use std::path::{Path, PathBuf};

use crate::atomic_write::{clear_away, folder_of, write_atomically, write_elsewhere};
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

/// True for a name that ends in a separator, also with a dot. [`Path`] ignores both.
fn is_folder_name(path: &Path) -> bool {
    let name = path.as_os_str().as_encoded_bytes();
    let name = name.strip_suffix(b".").unwrap_or(name);
    name.last().is_some_and(|&byte| std::path::is_separator(byte.into()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::atomic_write::temporary_file;

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
