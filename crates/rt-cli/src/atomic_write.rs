//! Atomic writing of files.
//!
//! A file is written under a temporary name in its own directory, synchronised, and renamed. Readers see the older file or the new
//! one, never a part; an older file survives every failure.

use std::ffi::{OsStr, OsString};
use std::fmt::Display;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

/// Writes a file of `folder` atomically. Returns it, locked where the system has locks.
pub(crate) fn write_atomically<E: Display>(
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

/// Parent directory, which is `.` for a bare name.
pub(crate) fn folder_of(path: &Path) -> &Path {
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
pub(crate) fn temporary_file(folder: &Path, target: &Path) -> io::Result<NamedTempFile> {
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
pub(crate) fn clear_away(folder: &Path, target: &Path) {
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

    fn rescued(file: &mut dyn Write) -> io::Result<()> {
        file.write_all(b"rescued")
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
            let path = write_elsewhere(Path::new(&name), &dirs, rescued).expect("written");
            let found = path.extension().and_then(OsStr::to_str);
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
        let path = write_elsewhere(target, &[folder.path().to_owned()], rescued).expect("written");
        assert_eq!(path.extension().and_then(OsStr::to_str), Some("png"));
    }
}
