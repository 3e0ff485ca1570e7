//! Errors of output files.

use std::io;
use std::path::{Path, PathBuf};

use bytesize::ByteSize;

#[derive(Debug, thiserror::Error)]
pub(crate) enum OutputError {
    #[error("cannot write `{}`: it is not a file name", .0.display())]
    NoName(PathBuf),
    #[error("cannot write `{}`: a name with a slash at its end is that of a directory; remove the slash, or add a file name", .0.display())]
    FolderName(PathBuf),
    #[error("cannot write `{}`: {source}; choose another name", path.display())]
    BadName { path: PathBuf, source: io::Error },
    #[error("cannot write `{}`: {} {}", path.display(), folder.display(), folder_problem(folder))]
    NoFolder { path: PathBuf, folder: PathBuf },
    #[error("cannot write `{}`: it exists and is not a regular file; choose another name, or `-` for standard output", .0.display())]
    NotAFile(PathBuf),
    #[error("cannot write `{}`: it is a symbolic link to a link that leads to no file; remove it, or choose another name", .0.display())]
    BrokenLink(PathBuf),
    #[error("cannot write `{}`: it exists and is read-only; remove it, or choose another name", .0.display())]
    ReadOnly(PathBuf),
    #[error("cannot write `{}`: it is an input; choose another name", .0.display())]
    IsInput(PathBuf),
    #[error("cannot write `{}`: the directory {} is not writable: {source}", path.display(), folder.display())]
    Folder { path: PathBuf, folder: PathBuf, source: io::Error },
    #[error(
        "cannot write `{}`: it may take {}, but only {} are free in {}; choose another directory",
        path.display(), ByteSize(*bytes), ByteSize(*available), folder.display()
    )]
    NoSpace { path: PathBuf, folder: PathBuf, available: u64, bytes: u64 },
    /// Writing failed; temporary files are removed.
    #[error("cannot write `{}`: {reason}", path.display())]
    Write { path: PathBuf, reason: String },
    #[error("{original}; it was saved as `{}` instead", path.display())]
    WrittenElsewhere { original: Box<Self>, path: PathBuf },
}

fn folder_problem(folder: &Path) -> &'static str {
    if folder.exists() {
        "is not a directory; choose another one"
    } else {
        "does not exist; create it, or choose another one"
    }
}
