//! Bytes that a document refers to: in the file itself, in data URIs, or in other files.

use std::{borrow::Cow, cell::Cell, collections::HashMap, path::Path};

use base64::{
    DecodeError, Engine,
    alphabet::STANDARD,
    engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig},
};
use gltf::{Document, buffer::View};
use percent_encoding::percent_decode_str;

use super::meshopt;
use crate::{
    LoadError, LoadErrorKind, LoadOptions,
    error::ErrorAt,
    files::{read_referenced, resolve_uri},
    limits,
    memory::Reservation,
};

/// Base64 as it occurs, with or without padding.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

pub(super) struct Buffers<'a> {
    path: &'a Path,
    document: &'a Document,
    /// `None` for buffers without data, which some extensions use as placeholders.
    data: Vec<Option<Cow<'a, [u8]>>>,
    /// Content of compressed views, by index.
    decoded: HashMap<usize, Vec<u8>>,
    /// Elements read so far from accessors without a buffer.
    zeros: Cell<u64>,
    /// Reserved memory of the buffers that are not in the file itself.
    _reservations: Vec<Reservation>,
}

impl<'a> Buffers<'a> {
    /// Loads all buffers. `blob` is the binary chunk of a GLB file.
    pub(super) fn load(
        document: &'a Document,
        blob: Option<&'a [u8]>,
        path: &'a Path,
        options: &LoadOptions,
    ) -> Result<Self, LoadError> {
        let (mut data, mut reservations) = (Vec::new(), Vec::new());
        for (i, buffer) in document.as_json().buffers.iter().enumerate() {
            let content = match &buffer.uri {
                Some(uri) => {
                    let fail = |reason: LoadErrorKind| reason.at(path, format!("buffers[{i}].uri"));
                    let content = fetch(uri, path, options).map_err(fail)?;
                    let what = format_args!("buffer {i} of {}", path.display());
                    reservations.push(options.memory.reserve(what, content.len() as u64).map_err(fail)?);
                    Some(Cow::Owned(content))
                }
                None if meshopt::is_placeholder(buffer.extensions.as_ref()) => None,
                None => blob.filter(|_| i == 0).map(Cow::Borrowed),
            };
            data.push(match content {
                Some(mut content) => {
                    let claimed = buffer.byte_length.0;
                    if claimed > content.len() as u64 {
                        let rule = format!("exceeds the size of the buffer, {} bytes", content.len());
                        return Err(LoadErrorKind::invalid(claimed, rule).at(path, format!("buffers[{i}].byteLength")));
                    }
                    match &mut content {
                        Cow::Borrowed(bytes) => *bytes = &bytes[..claimed as usize],
                        Cow::Owned(bytes) => bytes.truncate(claimed as usize),
                    }
                    Some(content)
                }
                None => None,
            });
        }
        let decoded = decode_views(document, &data, path, options, &mut reservations)?;
        Ok(Self { path, document, data, decoded, zeros: Cell::new(0), _reservations: reservations })
    }

    pub(super) fn view(&self, view: &View<'_>) -> Result<&[u8], LoadError> {
        if let Some(decoded) = self.decoded.get(&view.index()) {
            return Ok(decoded);
        }
        let bytes = meshopt::bytes_of(&self.data, view.buffer().index(), view.offset(), view.length());
        bytes.at(self.path, format!("bufferViews[{}]", view.index()))
    }

    /// Adds elements without a buffer to those of all accessors, which have a limit.
    pub(super) fn count_zeros(&self, count: u64) -> Result<(), LoadErrorKind> {
        self.zeros.set(self.zeros.get() + count);
        let (what, limit) = ("the sum of all counts without a bufferView", limits::GLTF_ALL_ZEROS);
        LoadErrorKind::check_limit(what, self.zeros.get(), limit)
    }

    /// Bytes of all buffers, and of decoded views.
    pub(super) fn bytes(&self) -> u64 {
        let buffers: usize = self.data.iter().flatten().map(|data| data.len()).sum();
        let views: usize = self.decoded.values().map(Vec::len).sum();
        (buffers + views) as u64
    }

    /// The document whose buffers these are.
    pub(super) const fn document(&self) -> &'a Document {
        self.document
    }

    /// The file, for messages.
    pub(super) const fn path(&self) -> &'a Path {
        self.path
    }
}

fn decode_views(
    document: &Document,
    data: &[Option<Cow<'_, [u8]>>],
    path: &Path,
    options: &LoadOptions,
    reservations: &mut Vec<Reservation>,
) -> Result<HashMap<usize, Vec<u8>>, LoadError> {
    let mut total = 0;
    let mut decoded = HashMap::new();
    for (index, view) in document.as_json().buffer_views.iter().enumerate() {
        let Some((name, object)) = meshopt::of_view(view) else { continue };
        let fail = |reason: LoadErrorKind| reason.at(path, format!("bufferViews[{index}].extensions.{name}"));
        let what = format_args!("view {index} of {}", path.display());
        reservations.push(options.memory.reserve(what, meshopt::decoded_bytes(object)).map_err(fail)?);
        let bytes = meshopt::decode(object, data).map_err(fail)?;
        total += bytes.len() as u64;
        let (what, limit) = ("the size of all decoded views in bytes", limits::GLTF_DECODED_BYTES);
        LoadErrorKind::check_limit(what, total, limit).map_err(fail)?;
        decoded.insert(index, bytes);
    }
    Ok(decoded)
}

/// The bytes that a URI names: a data URI, or a file below the root folder. Other schemes are refused.
pub(super) fn fetch(uri: &str, path: &Path, options: &LoadOptions) -> Result<Vec<u8>, LoadErrorKind> {
    match uri.split_at_checked("data:".len()) {
        Some((scheme, rest)) if scheme.eq_ignore_ascii_case("data:") => decode_data_uri(rest),
        _ => {
            let decoded = percent_decode_str(uri).decode_utf8_lossy();
            match read_referenced(&resolve_uri(&decoded, path, options)?, options) {
                // An empty buffer is no error before someone reads from it.
                Err(LoadErrorKind::Empty) => Ok(Vec::new()),
                other => other,
            }
        }
    }
}

/// `[type][;base64],content`, without the scheme (RFC 2397). Its words ignore case, as all words of URIs and media types do.
fn decode_data_uri(rest: &str) -> Result<Vec<u8>, LoadErrorKind> {
    let Some((kind, content)) = rest.split_once(',') else {
        return Err(LoadErrorKind::Syntax("a data URI must have a comma before its content".to_owned()));
    };
    let content: Cow<'_, [u8]> = percent_decode_str(content).into();
    let is_base64 = kind.rsplit_once(';').is_some_and(|(_, last)| last.eq_ignore_ascii_case("base64"));
    if is_base64 {
        BASE64.decode(content).map_err(|error| LoadErrorKind::Syntax(format!("bad base64: {}", base64_fault(&error))))
    } else {
        Ok(content.into_owned())
    }
}

/// Fault of a text that should be base64.
fn base64_fault(error: &DecodeError) -> String {
    match error {
        DecodeError::InvalidByte(at, byte) | DecodeError::InvalidLastSymbol { offset: at, symbol: byte, .. } => {
            format!("{:?} at offset {at} is invalid", char::from(*byte))
        }
        DecodeError::InvalidLength(length) => format!("the last of its {length} characters is one too many"),
        DecodeError::InvalidPadding => "the padding is invalid".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_uris() {
        let fetch = |uri: &str| fetch(uri, Path::new("m.gltf"), &LoadOptions::default()).map_err(|e| e.to_string());
        assert_eq!(fetch("data:application/octet-stream;base64,AQID/w=="), Ok(vec![1, 2, 3, 255]));
        assert_eq!(fetch("data:;base64,AQID/w"), Ok(vec![1, 2, 3, 255]));
        assert_eq!(fetch("data:,a%20b"), Ok(b"a b".to_vec()));
        assert!(fetch("data:;base64,A!ID").is_err_and(|e| e == "bad base64: '!' at offset 1 is invalid"));
        assert!(fetch("data:nothing").is_err_and(|e| e.contains("comma")));
    }

    /// `;BASE64` was read as plain text, `DATA:` as the name of a file, and `%2B` as three digits of base64.
    #[test]
    fn words_of_data_uris_ignore_case_and_base64_may_be_percent_encoded() {
        let fetch = |uri: &str| fetch(uri, Path::new("m.gltf"), &LoadOptions::default()).map_err(|e| e.to_string());
        for uri in ["data:;BASE64,+/8D", "DATA:;base64,+/8D", "Data:a/b;Base64,%2B%2f8D", "data:a/b;c=d;base64,%2B/8D"]
        {
            assert_eq!(fetch(uri), Ok(vec![251, 255, 3]), "{uri}");
        }
        assert_eq!(fetch("data:a/b;base6,+/8D"), Ok(b"+/8D".to_vec()));
    }

    #[test]
    fn only_files_below_the_root_are_read() {
        let outer = tempfile::tempdir().expect("a folder");
        std::fs::write(outer.path().join("secret.bin"), b"secret").expect("written");
        std::fs::create_dir(outer.path().join("in side")).expect("a folder");
        std::fs::write(outer.path().join("in side/a b.bin"), b"1234").expect("written");
        let file = outer.path().join("in side/m.gltf");
        let fetch = |uri: &str| fetch(uri, &file, &LoadOptions::default());
        assert_eq!(fetch("a%20b.bin").ok(), Some(b"1234".to_vec()));
        assert_eq!(fetch("a b.bin").ok(), Some(b"1234".to_vec()));
        for uri in ["../secret.bin", "%2e%2e/secret.bin", "..%2Fsecret.bin", "/etc/passwd", "file:///etc/passwd"] {
            assert!(matches!(fetch(uri), Err(LoadErrorKind::BadReference { .. })), "{uri}");
        }
        for uri in ["http://a/b.bin", "C:\\b.bin", ""] {
            assert!(matches!(fetch(uri), Err(LoadErrorKind::BadReference { .. })), "{uri}");
        }
    }
}
