//! Logical lines of OBJ and MTL files.

use std::borrow::Cow;

/// A line with its number in the file, counted from 1, without surrounding white space.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Line<'a> {
    pub(crate) number: usize,
    pub(crate) text: Cow<'a, str>,
}

impl Line<'_> {
    /// The first word and the rest, trimmed.
    pub(crate) fn split(&self) -> (&str, &str) {
        match self.text.split_once(char::is_whitespace) {
            Some((keyword, rest)) => (keyword, rest.trim_start()),
            None => (&self.text, ""),
        }
    }

    /// The words after the first, up to a comment.
    pub(crate) fn arguments(&self) -> impl Iterator<Item = &str> {
        self.split().1.split_whitespace().take_while(|word| !word.starts_with('#'))
    }
}

/// The text of a file. A byte order mark is dropped, and line ends of all systems become `\n`. Bytes that are not UTF-8
/// become the characters of Latin-1, so that distinct names stay distinct. The second value is the first line with such
/// bytes, from 1.
pub(crate) fn decode(bytes: &[u8]) -> (Cow<'_, str>, Option<usize>) {
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    let (text, bad) = match std::str::from_utf8(bytes) {
        Ok(text) => (Cow::Borrowed(text), None),
        Err(error) => {
            let good = &bytes[..error.valid_up_to()];
            (latin1(bytes).into(), Some(1 + good.iter().filter(|&&byte| byte == b'\n').count()))
        }
    };
    if text.contains('\r') { (text.replace("\r\n", "\n").replace('\r', "\n").into(), bad) } else { (text, bad) }
}

/// Text whose bytes that are not UTF-8 are Latin-1.
fn latin1(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(bytes.len());
    for chunk in bytes.utf8_chunks() {
        text.push_str(chunk.valid());
        text.extend(chunk.invalid().iter().map(|byte| char::from(*byte)));
    }
    text
}

/// Lines that are neither empty nor comments. A line that ends in `\` outside of a comment is joined with the next.
pub(crate) fn lines(text: &str) -> impl Iterator<Item = Line<'_>> {
    let mut physical = text.split('\n').zip(1..);
    std::iter::from_fn(move || {
        loop {
            let (first, number) = physical.next()?;
            let mut last = first.trim();
            let mut text = Cow::Borrowed(last);
            // A comment may end in the name of a folder.
            while last.ends_with('\\') && !has_comment(last) {
                let joined = text.to_mut();
                joined.pop();
                joined.push(' ');
                let Some((next, _)) = physical.next() else { break };
                last = next.trim();
                joined.push_str(last);
            }
            if !text.is_empty() && !text.starts_with('#') {
                return Some(Line { number, text });
            }
        }
    })
}

/// True if a word of the line begins a comment.
fn has_comment(line: &str) -> bool {
    line.split_whitespace().any(|word| word.starts_with('#'))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(bytes: &[u8]) -> Vec<(usize, String)> {
        let (text, _) = decode(bytes);
        lines(&text).map(|l| (l.number, l.text.into_owned())).collect()
    }

    #[test]
    fn a_comment_that_ends_in_a_folder_swallowed_the_next_line() {
        assert_eq!(all(b"# C:\\models\\\nv 1 2 3"), [(2, "v 1 2 3".to_owned())]);
    }

    #[test]
    fn marks_line_ends_comments_and_continuations() {
        let expected = vec![(1, "v 1 2 3".to_owned()), (3, "f 1 2  3 4".to_owned()), (6, "g a".to_owned())];
        let unix = "v 1 2 3\n# c\n  f 1 2 \\\n 3 4\n\ng a";
        assert_eq!(all(unix.as_bytes()), expected);
        assert_eq!(all(unix.replace('\n', "\r\n").as_bytes()), expected);
        assert_eq!(all(unix.replace('\n', "\r").as_bytes()), expected);
        assert_eq!(all(format!("\u{feff}{unix}").as_bytes()), expected);
        assert_eq!(all(b"v 1\\"), [(1, "v 1 ".to_owned())]);
        assert_eq!(all(b""), []);
    }

    /// All of them became U+FFFD, so that different names were equal.
    #[test]
    fn names_in_latin_1_were_equal() {
        let (text, bad) = decode(b"v 1 2 3\nusemtl K\xfcche\nusemtl K\xe4\xdf\nusemtl K\xc3\xbcche\n");
        let expected = "v 1 2 3\nusemtl Küche\nusemtl Käß\nusemtl Küche\n";
        assert_eq!((text.as_ref(), bad), (expected, Some(2)));
    }

    #[test]
    fn a_trailing_comment_that_ends_in_a_folder_swallowed_the_next_line() {
        let expected = [(1, "v 0 0 0 # C:\\x\\".to_owned()), (2, "v 1 0 0".to_owned())];
        assert_eq!(all(b"v 0 0 0 # C:\\x\\\nv 1 0 0"), expected);
        // A comment may also end a continued line.
        let expected = [(1, "f 1 2  3 #x\\".to_owned()), (3, "f 1 2 4".to_owned())];
        assert_eq!(all(b"f 1 2 \\\n3 #x\\\nf 1 2 4"), expected);
        // The name holds a number sign.
        assert_eq!(all(b"g a#b \\\nc"), [(1, "g a#b  c".to_owned())]);
    }
}
