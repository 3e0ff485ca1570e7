//! The two wrappings of glTF: plain JSON, and the binary container GLB.

/// The parts of a file.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Container<'a> {
    pub(super) json: &'a [u8],
    /// The binary chunk of a GLB file, which is the content of the first buffer.
    pub(super) blob: Option<&'a [u8]>,
}

const MAGIC: &[u8] = b"glTF";
const JSON: &[u8] = b"JSON";
const BIN: &[u8] = b"BIN\0";

impl<'a> Container<'a> {
    /// Recognises the container by its first bytes. Bytes after the binary chunk are ignored (glTF 2.0, section 4).
    pub(super) fn split(bytes: &'a [u8]) -> Result<Self, String> {
        if !bytes.starts_with(MAGIC) {
            let json = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
            return match json.trim_ascii_start() {
                [] | [b'{', ..] => Ok(Self { json, blob: None }),
                _ => Err("is not glTF: it begins with neither `{`, as JSON does, nor `glTF`".to_owned()),
            };
        }
        let (Some(version), Some(length)) = (number(bytes, 4), number(bytes, 8)) else {
            return Err(format!("the GLB header is cut off after {} of 12 bytes", bytes.len()));
        };
        if version != 2 {
            return Err(format!("GLB version {version}.x is not supported; it must be 2"));
        }
        let Some(mut rest) = bytes.get(..length).and_then(|all| all.get(12..)) else {
            return Err(format!("the GLB header declares {length} bytes, but the file has {}", bytes.len()));
        };
        let json = chunk(&mut rest, JSON)?.ok_or("the first chunk of the GLB file is not JSON")?;
        let blob = if rest.is_empty() { None } else { chunk(&mut rest, BIN)? };
        Ok(Self { json, blob })
    }

    /// The size of the document in a GLB file, by its first bytes; `None` for plain JSON.
    pub(super) fn json_bytes(head: &[u8]) -> Option<u64> {
        head.strip_prefix(MAGIC).and_then(|_| number(head, 12)).map(|bytes| bytes as u64)
    }
}

/// Takes the next chunk if it is of this kind.
fn chunk<'a>(rest: &mut &'a [u8], kind: &[u8]) -> Result<Option<&'a [u8]>, String> {
    let (Some(length), Some(found), Some(data)) = (number(rest, 0), rest.get(4..8), rest.get(8..)) else {
        return Err(format!("a chunk header of the GLB file is cut off after {} of 8 bytes", rest.len()));
    };
    if found != kind {
        return Ok(None);
    }
    let content = data
        .get(..length)
        .ok_or_else(|| format!("a chunk of the GLB file declares {length} bytes, but {} are left", data.len()))?;
    *rest = &data[length..];
    Ok(Some(content))
}

/// The little-endian number at a position.
fn number(bytes: &[u8], at: usize) -> Option<usize> {
    let four = bytes.get(at..at + 4)?.try_into().ok()?;
    usize::try_from(u32::from_le_bytes(four)).ok()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A GLB file with these chunks.
    pub(crate) fn glb(chunks: &[(&[u8], &[u8])]) -> Vec<u8> {
        let mut body = Vec::new();
        for (kind, data) in chunks {
            body.extend((data.len() as u32).to_le_bytes());
            body.extend(*kind);
            body.extend(*data);
        }
        let mut file = b"glTF\x02\0\0\0".to_vec();
        file.extend((body.len() as u32 + 12).to_le_bytes());
        file.extend(body);
        file
    }

    #[test]
    fn other_text_is_refused() {
        let error = Container::split(b"hello").unwrap_err();
        assert_eq!(error, "is not glTF: it begins with neither `{`, as JSON does, nor `glTF`");
    }

    #[test]
    fn both_wrappings_are_recognised() {
        assert_eq!(Container::split(b"{}"), Ok(Container { json: b"{}", blob: None }));
        assert_eq!(Container::split(b"\xEF\xBB\xBF{}"), Ok(Container { json: b"{}", blob: None }));
        let file = glb(&[(JSON, b"{}  "), (BIN, b"1234"), (b"NEW?", b"5678")]);
        assert_eq!(Container::split(&file), Ok(Container { json: b"{}  ", blob: Some(b"1234") }));
        let file = glb(&[(JSON, b"{}  "), (b"NEW?", b"5678")]);
        assert_eq!(Container::split(&file), Ok(Container { json: b"{}  ", blob: None }));
    }

    #[test]
    fn lies_about_the_length_are_refused() {
        let good = glb(&[(JSON, b"{}  "), (BIN, b"1234")]);
        for length in 4..good.len() {
            assert!(Container::split(&good[..length]).is_err(), "cut at {length}");
        }
        for (at, value, expected) in [
            (4, 1, "GLB version 1.x is not supported; it must be 2"),
            (8, 0, "the GLB header declares 0 bytes, but the file has 36"),
            (8, u32::MAX, "the GLB header declares 4294967295 bytes, but the file has 36"),
            (8, 16, "a chunk header of the GLB file is cut off after 4 of 8 bytes"),
            (12, u32::MAX, "a chunk of the GLB file declares 4294967295 bytes, but 16 are left"),
            (24, 5, "a chunk of the GLB file declares 5 bytes, but 4 are left"),
        ] {
            let mut bad = good.clone();
            bad[at..at + 4].copy_from_slice(&value.to_le_bytes());
            assert_eq!(Container::split(&bad), Err(expected.to_owned()));
        }
        let swapped = glb(&[(BIN, b"1234"), (JSON, b"{}  ")]);
        assert_eq!(Container::split(&swapped), Err("the first chunk of the GLB file is not JSON".to_owned()));
    }
}
