//! Content of a frame log in JSON.
//!
//! The module has no dependencies within the crate, so that the fuzz target of frame logs can include it.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Maximum size of a frame log in bytes: that of 10⁶ frames.
pub(crate) const MAX_LOG_BYTES: u64 = 1 << 27;

/// Hexadecimal digits of an identity or a hash: 128 bits.
const IDENTITY_DIGITS: usize = 32;

#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct DoneFrames {
    /// Identity of the image, by frame index.
    pub(crate) frames: BTreeMap<u32, String>,
    /// Hash of the image file, by frame index.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub(crate) files: BTreeMap<u32, String>,
}

/// Parses a frame log; an empty file has no frames. `None` for anything else.
pub(crate) fn parse(text: &[u8]) -> Option<DoneFrames> {
    if text.is_empty() {
        return Some(DoneFrames::default());
    }
    let done: DoneFrames = serde_json::from_slice(text).ok()?;
    let is_identity = |text: &String| {
        text.len() == IDENTITY_DIGITS && text.bytes().all(|digit| matches!(digit, b'0'..=b'9' | b'a'..=b'f'))
    };
    done.frames.values().chain(done.files.values()).all(is_identity).then_some(done)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crafted_numbers_of_frame_logs_are_refused() {
        let identity = "0123456789abcdef".repeat(2);
        let of = |frame: &str, value: &str| {
            let frames = parse(format!(r#"{{"frames": {{"{frame}": "{value}"}}}}"#).as_bytes());
            let files = format!(r#"{{"frames": {{"0": "{identity}"}}, "files": {{"{frame}": "{value}"}}}}"#);
            assert_eq!(parse(files.as_bytes()).is_some(), frames.is_some(), "{frame}: {value}");
            frames
        };
        for frame in ["0", "4294967295"] {
            assert!(of(frame, &identity).is_some(), "{frame}");
        }
        for frame in ["4294967296", "18446744073709551615", "-1", "1.5", "1e3", "", "x"] {
            assert_eq!(of(frame, &identity), None, "{frame}");
        }
        let long = "0".repeat(33);
        for identity in ["", "0", &identity[1..], &long, &identity.replace('a', "A"), &identity.replace('a', "g")] {
            assert_eq!(of("0", identity), None, "{identity}");
        }
        let texts = ["{", "[]", "null", r#"{"frames": []}"#, r#"{"frames": {}, "more": 1}"#, r#"{"frames": {"0": 7}}"#];
        for text in texts {
            assert_eq!(parse(text.as_bytes()), None, "{text}");
        }
        assert_eq!(parse(b""), Some(DoneFrames::default()));
    }
}
