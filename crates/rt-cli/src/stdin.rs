//! Standard input as a file: read once, under the name `-`.

use std::ffi::OsStr;
use std::io::{self, IsTerminal, Read};
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use rt_scene_io::{InMemoryFile, LoadErrorKind, limits};
use serde::Deserialize;
use serde::de::IgnoredAny;

use crate::error::{CliError, usage};

/// File stem of a scene from standard input.
const STEM: &str = "stdin";

/// Formats of `--input-format`, by file extension.
pub(crate) const FORMATS: [&str; 9] = ["ron", "json", "gltf", "glb", "obj", "nff", "pbrt", "ply", "stl"];

/// True for `-`, the name of standard input and output.
pub(crate) fn is_dash(path: &Path) -> bool {
    path.as_os_str() == OsStr::new("-")
}

/// Content of standard input: at most `max_bytes`, or the default limit of a file, and at most `memory`.
pub(crate) fn content(max_bytes: Option<u64>, memory: Option<u64>) -> Result<Arc<[u8]>, CliError> {
    static CONTENT: OnceLock<Arc<[u8]>> = OnceLock::new();
    if let Some(content) = CONTENT.get() {
        return Ok(content.clone());
    }
    if io::stdin().is_terminal() {
        return usage("standard input is a terminal; pipe a file into it, or name a file");
    }
    let failed = |reason: LoadErrorKind| CliError::from(reason.at(Path::new("standard input"), ""));
    let of_file = (max_bytes.unwrap_or(limits::FILE_BYTES), "--max-file-size");
    let of_memory = memory.map(|bytes| (bytes, "--memory"));
    let (limit, option) = of_memory.filter(|(bytes, _)| *bytes < of_file.0).unwrap_or(of_file);
    let mut bytes = Vec::new();
    let read = io::stdin().lock().take(limit.saturating_add(1)).read_to_end(&mut bytes);
    read.map_err(|error| failed(error.into()))?;
    if bytes.is_empty() {
        return Err(failed(LoadErrorKind::Syntax("is empty (0 bytes); pipe a file into it".to_owned())));
    }
    if bytes.len() as u64 > limit {
        // Its size is unknown: reading has stopped.
        let message = format!("has more bytes than the limit of {limit}; raise {option}, or pipe a smaller file");
        return Err(failed(LoadErrorKind::Syntax(message)));
    }
    Ok(CONTENT.get_or_init(|| bytes.into()).clone())
}

/// Scene or model from standard input, named by its format.
pub(crate) fn scene(
    format: Option<&str>,
    max_bytes: Option<u64>,
    memory: Option<u64>,
) -> Result<InMemoryFile, CliError> {
    let bytes = content(max_bytes, memory)?;
    let format = format.or_else(|| format_of(&bytes)).ok_or_else(|| {
        let known = FORMATS.join(", ");
        CliError::Usage(format!("the format of standard input is unknown: add --input-format with one of {known}"))
    })?;
    Ok(InMemoryFile { path: PathBuf::from(format!("{STEM}.{format}")), bytes })
}

/// Format of a file by its content, if unambiguous.
fn format_of(bytes: &[u8]) -> Option<&'static str> {
    if bytes.starts_with(b"glTF") {
        return Some("glb");
    }
    if matches!(without_mark(bytes), [b'p', b'l', b'y', b'\n' | b'\r', ..]) {
        return Some("ply");
    }
    match *beginning(bytes)? {
        [b'{', ..] => Some(if is_gltf(bytes) { "gltf" } else { "json" }),
        [b'(', ..] | [b'#', b'!', b'[', ..] => Some("ron"),
        _ => None,
    }
}

/// Content without its byte order mark.
fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// Content without leading white space and RON comments.
fn beginning(bytes: &[u8]) -> Option<&[u8]> {
    let mut rest = without_mark(bytes);
    loop {
        rest = rest.trim_ascii_start();
        let (end, is_comment) = match rest {
            [b'/', b'/', ..] => (rest.iter().position(|&byte| byte == b'\n'), true),
            [b'/', b'*', ..] => (rest.windows(2).position(|pair| pair == b"*/").map(|at| at + 2), true),
            _ => (None, false),
        };
        if !is_comment {
            return Some(rest);
        }
        rest = rest.get(end?..)?;
    }
}

/// True for JSON with `asset`, which every glTF file has, and no scene file.
fn is_gltf(bytes: &[u8]) -> bool {
    #[derive(Deserialize)]
    struct Head {
        asset: Option<IgnoredAny>,
    }
    serde_json::from_slice::<Head>(bytes).is_ok_and(|head| head.asset.is_some())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_detected_by_unambiguous_content() {
        for (content, format) in [
            ("(nodes: [])", Some("ron")),
            ("\u{feff}// a scene\n/* of\n nothing */ (nodes: [])", Some("ron")),
            ("#![enable(implicit_some)]\n()", Some("ron")),
            (" {\"nodes\": []}", Some("json")),
            ("{\"nodes\": [", Some("json")),
            ("{\"asset\": {\"version\": \"2.0\"}}", Some("gltf")),
            ("glTF\u{2}", Some("glb")),
            ("ply\nformat ascii 1.0\n", Some("ply")),
            ("\u{feff}ply\nformat ascii 1.0\n", Some("ply")),
            ("v 0 0 0\n", None),
            ("solid cube\n", None),
            ("// nothing but a comment", None),
            ("/* that does not end", None),
            ("", None),
        ] {
            assert_eq!(format_of(content.as_bytes()), format, "{content}");
        }
    }
}
