//! Files and references between them, read with care: a scene may come from a stranger.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use rt_shading::Bitmap;

use crate::options::folder_of;
use crate::sanitize::shortened_reference;
use crate::texture::{PixelEncoding, decode_within};
use crate::{LoadErrorKind, LoadOptions, limits};

/// Reads a regular file, or the in-memory file of `options`. The caller has reserved memory for it.
///
/// # Errors
/// A missing or empty file, a folder, a pipe, a device, a file beyond the size limit, or a read error.
pub fn read_file(path: &Path, options: &LoadOptions) -> Result<Vec<u8>, LoadErrorKind> {
    let limit = options.max_file_bytes.unwrap_or(limits::FILE_BYTES);
    let check = |size| LoadErrorKind::check_limit("the file size in bytes (--max-file-size)", size, limit);
    if let Some(bytes) = options.content_of(path) {
        check(bytes.len() as u64)?;
        return if bytes.is_empty() { Err(LoadErrorKind::Empty) } else { Ok(bytes.to_vec()) };
    }
    // The kind is checked before opening: opening a pipe would wait for its writer.
    let metadata = fs::metadata(path)?;
    if metadata.is_dir() {
        return Err(LoadErrorKind::Directory);
    }
    if !metadata.is_file() {
        return Err(LoadErrorKind::NotAFile);
    }
    let file = File::open(path)?;
    let size = file.metadata()?.len();
    check(size)?;
    let mut bytes = Vec::with_capacity(usize::try_from(size).unwrap_or(0));
    // The limit holds even if the file grows meanwhile.
    file.take(limit).read_to_end(&mut bytes)?;
    options.input_hashes.record(path, &bytes);
    if bytes.is_empty() { Err(LoadErrorKind::Empty) } else { Ok(bytes) }
}

/// Reads a file that another one refers to, if the budget suffices.
pub(crate) fn read_referenced(path: &Path, options: &LoadOptions) -> Result<Vec<u8>, LoadErrorKind> {
    let size = match options.content_of(path) {
        Some(bytes) => bytes.len() as u64,
        None => fs::metadata(path).map_or(0, |metadata| metadata.len()),
    };
    options.memory.check(format_args!("the file {}", path.display()), size)?;
    read_file(path, options)
}

/// Refuses UTF-16, recognised by its byte order mark.
///
/// # Errors
/// The bytes begin with the byte order mark of UTF-16.
pub(crate) fn refuse_utf16(bytes: &[u8]) -> Result<(), LoadErrorKind> {
    match bytes {
        [0xFF, 0xFE, ..] => Err(LoadErrorKind::OtherEncoding("UTF-16 (little-endian)")),
        [0xFE, 0xFF, ..] => Err(LoadErrorKind::OtherEncoding("UTF-16 (big-endian)")),
        _ => Ok(()),
    }
}

/// Replaces the line ends of old Macintosh systems in a text.
pub(crate) fn unify_line_ends(text: &mut [u8]) {
    if !text.contains(&b'\n') {
        text.iter_mut().filter(|byte| **byte == b'\r').for_each(|byte| *byte = b'\n');
    }
}

/// Reads a text file in UTF-8, without its byte order mark.
///
/// # Errors
/// Errors of [`read_file`], or bytes that are not UTF-8.
pub fn read_text(path: &Path, options: &LoadOptions) -> Result<String, LoadErrorKind> {
    decode_text(read_file(path, options)?)
}

/// Decodes UTF-8 text, without its byte order mark, and with line feeds as line ends if it has carriage returns only.
pub(crate) fn decode_text(mut bytes: Vec<u8>) -> Result<String, LoadErrorKind> {
    refuse_utf16(&bytes)?;
    unify_line_ends(&mut bytes);
    let text = String::from_utf8(bytes).map_err(|e| LoadErrorKind::NotUtf8(e.utf8_error().valid_up_to()))?;
    match text.strip_prefix('\u{feff}') {
        Some("") => Err(LoadErrorKind::Empty),
        Some(rest) => Ok(rest.to_owned()),
        None => Ok(text),
    }
}

/// Reads an image file as a texture.
///
/// # Errors
/// Errors of [`read_file`] and [`decode_texture`](crate::decode_texture), or a budget that is too small.
pub fn read_texture(path: &Path, options: &LoadOptions) -> Result<Bitmap, LoadErrorKind> {
    read_texture_as(path, PixelEncoding::Colors, options)
}

/// Version of [`read_texture`] for images of colours or of data.
pub(crate) fn read_texture_as(
    path: &Path,
    pixels: PixelEncoding,
    options: &LoadOptions,
) -> Result<Bitmap, LoadErrorKind> {
    let bytes = read_referenced(path, options)?;
    let what = format_args!("the texture {}", path.display());
    let _file = options.memory.reserve(what, bytes.len() as u64)?;
    decode_within(&bytes, pixels, what, &options.memory)
}

/// True for a path from the root of a file system, of any system.
pub(crate) fn is_absolute(reference: &str) -> bool {
    reference.starts_with(['/', '\\']) || reference.as_bytes().get(1) == Some(&b':')
}

/// File that `reference` names, as written in the file `referrer`.
///
/// References are relative to the folder of the referrer. The file must exist and lie below `options.root` (by default that
/// folder), also after symbolic links are resolved. Backslashes count as slashes. The file is added to `options.referenced`.
///
/// # Errors
/// An absolute reference, a URL, a path outside of the root, or a missing file.
pub fn resolve_path(reference: &str, referrer: &Path, options: &LoadOptions) -> Result<PathBuf, LoadErrorKind> {
    resolve_normalized(reference, referrer, options, str::to_owned)
}

/// Version of [`resolve_path`] for the path of a URI, whose dot segments need no directories (RFC 3986, section 5.2.4).
#[cfg(feature = "gltf")]
pub(crate) fn resolve_uri(uri: &str, referrer: &Path, options: &LoadOptions) -> Result<PathBuf, LoadErrorKind> {
    resolve_normalized(uri, referrer, options, without_dot_segments)
}

/// A relative path without `.`, and without `..` except at its beginning.
#[cfg(feature = "gltf")]
fn without_dot_segments(path: &str) -> String {
    let mut kept: Vec<&str> = Vec::new();
    for segment in path.split('/') {
        match (segment, kept.last()) {
            (".", _) | ("", None) => {}
            ("..", Some(last)) if *last != ".." => {
                kept.pop();
            }
            _ => kept.push(segment),
        }
    }
    kept.join("/")
}

/// Resolves a reference by its path after `normalize`, which gets a relative path with slashes.
fn resolve_normalized(
    reference: &str,
    referrer: &Path,
    options: &LoadOptions,
    normalize: fn(&str) -> String,
) -> Result<PathBuf, LoadErrorKind> {
    let bad = |rule: &str| LoadErrorKind::bad_reference(reference, rule);
    if reference.is_empty() {
        return Err(bad("is empty: name a file"));
    }
    let relative = reference.replace('\\', "/");
    if relative.contains("://") || relative.starts_with("file:") {
        return Err(bad("is a URL: only files can be read"));
    }
    let normalized = normalize(&relative);
    if is_absolute(&relative) || is_absolute(&normalized) {
        return Err(bad("is absolute: write it relative to the directory of the file that refers to it"));
    }
    if relative.contains('\0') {
        return Err(bad("contains a NUL character"));
    }
    let folder = folder_of(referrer);
    let path = folder.join(&normalized);
    let found = path.canonicalize().map_err(|error| match error.kind() {
        // No file has a name that is too long, or lies below a file.
        io::ErrorKind::NotFound | io::ErrorKind::NotADirectory | io::ErrorKind::InvalidFilename => {
            LoadErrorKind::MissingReference { reference: reference.to_owned(), looked_for: path.clone() }
        }
        _ => bad(&format!("cannot be read: {error} (looked for {})", shortened_reference(&path.to_string_lossy()))),
    })?;
    let root = options.root.as_deref().unwrap_or(folder);
    let inside = root.canonicalize().map_err(|error| bad(&format!("has no root {}: {error}", root.display())))?;
    if found.starts_with(inside) {
        options.referenced.add(found);
        // The joined path reads better in messages than the canonical one.
        Ok(path)
    } else {
        let is_current = root == Path::new(".");
        let root = if is_current { "the current directory".into() } else { root.to_string_lossy() };
        Err(bad(&format!("lies outside of {root}: copy it there, or choose another root directory (--asset-root)")))
    }
}
