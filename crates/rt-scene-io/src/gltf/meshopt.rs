//! Buffer views compressed by meshoptimizer (EXT_meshopt_compression, KHR_meshopt_compression).
//!
//! `draco-gltf` decodes the bit streams; the parameters in the file are checked here.

use std::borrow::Cow;

use draco_gltf::{MeshoptFilter, MeshoptMode, meshopt::decode_buffer_view};
use gltf::json::{buffer::View, extensions::buffer::Buffer};
use serde::Deserialize;
use serde_json::Value;

use crate::LoadErrorKind;
use crate::parser_message::plain;

/// The names of the extension, before and after it was ratified.
pub(super) const NAMES: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// Maximum number of decoded bytes per byte of a stream: a control byte of the vertex codec stands for four planes of at most
/// 256.
const MAX_RATIO: usize = 1024;

/// The object of the extension at a buffer view.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct MeshoptExtension {
    buffer: usize,
    #[serde(default)]
    byte_offset: usize,
    byte_length: usize,
    byte_stride: usize,
    count: usize,
    mode: String,
    filter: Option<String>,
}

/// The name and object of the extension, if the view is compressed.
pub(super) fn of_view(view: &View) -> Option<(&'static str, &Value)> {
    let extensions = &view.extensions.as_ref()?.others;
    NAMES.into_iter().find_map(|name| Some((name, extensions.get(name)?)))
}

/// True for a buffer that only states the decoded size of its views.
pub(super) fn is_placeholder(extensions: Option<&Buffer>) -> bool {
    let fallback = |name: &str| extensions?.others.get(name)?.get("fallback")?.as_bool();
    NAMES.into_iter().any(|name| fallback(name) == Some(true))
}

/// Bytes that a view claims to hold; 0 of one that cannot be read, which [`decode`] refuses.
pub(super) fn decoded_bytes(object: &Value) -> u64 {
    let view = MeshoptExtension::deserialize(object).ok();
    view.map_or(0, |view| (view.count as u64).saturating_mul(view.byte_stride as u64))
}

/// Bytes of a part of a buffer, which may have no data.
pub(super) fn bytes_of<'b>(
    buffers: &'b [Option<Cow<'_, [u8]>>],
    buffer: usize,
    offset: usize,
    length: usize,
) -> Result<&'b [u8], LoadErrorKind> {
    let Some(Some(data)) = buffers.get(buffer) else {
        return Err(LoadErrorKind::Syntax(format!("the buffer {buffer} has no data")));
    };
    let end = offset.checked_add(length);
    end.and_then(|end| data.get(offset..end)).ok_or_else(|| {
        let size = data.len();
        LoadErrorKind::Syntax(format!("{length} bytes at offset {offset} exceed the buffer {buffer} of {size} bytes"))
    })
}

/// Decodes a view, given the content of all buffers.
pub(super) fn decode(object: &Value, buffers: &[Option<Cow<'_, [u8]>>]) -> Result<Vec<u8>, LoadErrorKind> {
    let syntax = |message: String| LoadErrorKind::Syntax(message);
    let view = MeshoptExtension::deserialize(object).map_err(|error| syntax(plain(&error.to_string())))?;
    let source = bytes_of(buffers, view.buffer, view.byte_offset, view.byte_length)?;
    let mode = MeshoptMode::from_name(&view.mode).map_err(|error| syntax(error.to_string()))?;
    let filter = view.filter.as_deref().map_or(Ok(MeshoptFilter::None), MeshoptFilter::from_name);
    let filter = filter.map_err(|error| syntax(error.to_string()))?;
    let size = view.count.checked_mul(view.byte_stride).filter(|size| size / MAX_RATIO <= source.len());
    let Some(size) = size else {
        let (count, stride) = (view.count, view.byte_stride);
        return Err(syntax(format!("{count} elements of {stride} bytes cannot come from {} bytes", source.len())));
    };
    let mut decoded = vec![0; size];
    decode_buffer_view(&mut decoded, source, mode, filter, view.count, view.byte_stride)
        .map_err(|error| syntax(error.to_string()))?;
    Ok(decoded)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    /// Version 0 of the vertex codec with two elements of four bytes. All deltas of the first group are zero; the second
    /// element differs from the first by one in its first byte. The first element is at the end.
    fn stream() -> Vec<u8> {
        // A group of 16 deltas of two bits: the mode of the group, then four bytes of pairs, first element highest.
        let first = [0b01, 0b0010_0000, 0, 0, 0];
        let still = [0b00];
        let mut bytes = vec![0xa0];
        bytes.extend(first);
        bytes.extend(still.repeat(3));
        // The element before the first, at the end of a tail of 32 bytes.
        bytes.extend([0; 28]);
        bytes.extend([10, 20, 30, 40]);
        bytes
    }

    fn object(stream: &[u8], count: usize) -> Value {
        json!({"buffer": 0, "byteLength": stream.len(), "byteStride": 4, "count": count, "mode": "ATTRIBUTES"})
    }

    #[test]
    fn vertices_are_sums_of_differences() {
        let stream = stream();
        let decoded = decode(&object(&stream, 2), &[Some(Cow::Borrowed(stream.as_slice()))]).expect("a stream");
        assert_eq!(decoded, [10, 20, 30, 40, 11, 20, 30, 40]);
    }

    #[test]
    fn lies_are_refused() {
        let stream = stream();
        let refused = |change: &str, value: Value| {
            let mut object = object(&stream, 2);
            object[change] = value;
            decode(&object, &[Some(Cow::Borrowed(stream.as_slice())), None]).expect_err("a lie").to_string()
        };
        assert_eq!(refused("buffer", json!(1)), "the buffer 1 has no data");
        assert_eq!(
            refused("byteOffset", json!(u64::MAX)),
            format!("{} bytes at offset {} exceed the buffer 0 of {0} bytes", stream.len(), u64::MAX)
        );
        assert!(refused("count", json!(1_000_000_000)).contains("cannot come from"));
        assert!(refused("count", json!(u64::MAX)).contains("cannot come from"));
        assert!(refused("byteStride", json!(0)).contains("byteStride"));
        assert!(refused("mode", json!("NOISE")).contains("mode NOISE"));
        assert!(refused("filter", json!("BLUR")).contains("filter BLUR"));
        assert!(refused("byteLength", json!(-1)).contains("found `-1`, expected a whole number from 0 up"));
        for length in 0..stream.len() {
            refused("byteLength", json!(length));
        }
    }
}
