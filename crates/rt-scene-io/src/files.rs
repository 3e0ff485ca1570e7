//! Files and references between them, read with care: a scene may come from a stranger.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use rt_shading::Bitmap;

use crate::options::folder_of;
use crate::{LoadOptions, Reason, decode_texture};

/// Largest file that is read.
const MAX_FILE_BYTES: u64 = 1 << 30;

/// Reads a regular file of at most 1 GiB.
///
/// # Errors
/// If there is no such file, it is empty, a folder, a pipe or a device, too large, or cannot be read.
pub fn read_file(path: &Path) -> Result<Vec<u8>, Reason> {
    // The kind is checked before opening: opening a pipe would wait for its writer.
    if !fs::metadata(path)?.is_file() {
        return Err(Reason::NotAFile);
    }
    let file = File::open(path)?;
    let size = file.metadata()?.len();
    if size > MAX_FILE_BYTES {
        return Err(Reason::TooLarge { what: "the size in bytes", value: size, limit: MAX_FILE_BYTES });
    }
    let mut bytes = Vec::new();
    // The limit holds even if the file grows meanwhile.
    file.take(MAX_FILE_BYTES).read_to_end(&mut bytes)?;
    if bytes.is_empty() { Err(Reason::Empty) } else { Ok(bytes) }
}

/// Reads a text file in UTF-8, without its byte order mark.
///
/// # Errors
/// As [`read_file`], or if the bytes are not UTF-8.
pub fn read_text(path: &Path) -> Result<String, Reason> {
    let text = String::from_utf8(read_file(path)?).map_err(|e| Reason::NotUtf8(e.utf8_error().valid_up_to()))?;
    match text.strip_prefix('\u{feff}') {
        Some("") => Err(Reason::Empty),
        Some(rest) => Ok(rest.to_owned()),
        None => Ok(text),
    }
}

/// Reads an image file as a texture.
///
/// # Errors
/// As [`read_file`] and [`decode_texture`].
pub fn read_texture(path: &Path) -> Result<Bitmap, Reason> {
    Ok(decode_texture(&read_file(path)?)?)
}

/// The file that `reference` names, as written in the file `referrer`.
///
/// References are relative to the folder of the referrer. The file must exist and lie below `options.root` (by
/// default that folder), also after symbolic links are followed. Backslashes count as slashes. What is found is added
/// to `options.referenced`.
///
/// # Errors
/// If the reference is absolute, a URL, leaves the root, or names nothing.
pub fn resolve_path(reference: &str, referrer: &Path, options: &LoadOptions) -> Result<PathBuf, Reason> {
    let bad = |rule: &str| Reason::BadReference { reference: reference.to_owned(), rule: rule.to_owned() };
    if reference.is_empty() {
        return Err(bad("is empty: name a file"));
    }
    let relative = reference.replace('\\', "/");
    if relative.contains("://") || relative.starts_with("file:") {
        return Err(bad("is a URL: only files can be read"));
    }
    if relative.starts_with('/') || relative.as_bytes().get(1) == Some(&b':') {
        return Err(bad("is absolute: write it relative to the folder of the file that refers to it"));
    }
    if relative.contains('\0') {
        return Err(bad("contains a NUL character"));
    }
    let folder = folder_of(referrer);
    let path = folder.join(&relative);
    let found = path.canonicalize().map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => {
            Reason::MissingReference { reference: reference.to_owned(), looked_for: path.clone() }
        }
        _ => bad(&format!("cannot be read: {error} (looked for {})", path.display())),
    })?;
    let root = options.root.as_deref().unwrap_or(folder);
    let inside = root.canonicalize().map_err(|error| bad(&format!("has no root {}: {error}", root.display())))?;
    if found.starts_with(inside) {
        options.referenced.add(found);
        // The joined path reads better in messages than the canonical one.
        Ok(path)
    } else {
        Err(bad(&format!("lies outside of {}: copy it there, or choose another root folder", root.display())))
    }
}
