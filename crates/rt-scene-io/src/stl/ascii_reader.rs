//! Text that is read line by line, so that the line is known where reading stops.

use std::io::{self, Read, Seek, SeekFrom};

/// First line of a solid, in the only form that `stl_io` reads.
const SOLID: &[u8] = b"solid \n";

/// Line that replaces the first one of each facet. Normals are ignored, and programs write those of slivers as `nan`, `inf` or
/// `-1.#IND`.
const FACET: &[u8] = b"facet normal 0 0 0\n";

/// Line that replaces the last one of a solid, which may have a name in any encoding.
const END: &[u8] = b"endsolid\n";

/// The line that replaces one of a file; `None` for those that `stl_io` reads.
fn replacement(line: &[u8]) -> Option<&'static [u8]> {
    let mut words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
    let mut next_is = |word: &[u8]| words.next().is_some_and(|next| next.eq_ignore_ascii_case(word));
    match line.trim_ascii_start().first()?.to_ascii_lowercase() {
        b'f' => (next_is(b"facet") && next_is(b"normal")).then_some(FACET),
        b'e' => next_is(b"endsolid").then_some(END),
        _ => None,
    }
}

/// True if a line begins a solid, in letters of either case.
pub(super) fn begins_solid(line: &[u8]) -> bool {
    line.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"))
}

/// Lines of a file. Each read returns one line at most; the lines that begin and end a solid or begin a facet are replaced.
pub(super) struct AsciiReader<'a> {
    bytes: &'a [u8],
    /// Start of the next line.
    next: usize,
    /// Start of the lines of the solid.
    start: usize,
    /// Remaining bytes of `SOLID`, `FACET` or `END`.
    head: &'static [u8],
}

impl<'a> AsciiReader<'a> {
    pub(super) const fn of(bytes: &'a [u8]) -> Self {
        Self { bytes, next: 0, start: 0, head: &[] }
    }

    /// Line that was read last, from 1.
    pub(super) fn line(&self) -> usize {
        let read = &self.bytes[..self.next];
        let ends = read.iter().filter(|byte| **byte == b'\n').count();
        if read.is_empty() || read.ends_with(b"\n") { ends.max(1) } else { ends + 1 }
    }

    /// Text of [`line`](Self::line).
    pub(super) fn last_line(&self) -> &'a [u8] {
        let read = &self.bytes[..self.next];
        let read = read.strip_suffix(b"\n").unwrap_or(read);
        read.rsplit(|byte| *byte == b'\n').next().unwrap_or_default()
    }

    fn next_line(&self) -> &'a [u8] {
        let rest = &self.bytes[self.next..];
        let length = rest.iter().position(|byte| *byte == b'\n').map_or(rest.len(), |end| end + 1);
        &rest[..length]
    }

    /// Goes to the lines after the next one that is not empty; false at the end of the file.
    pub(super) fn begin_solid(&mut self) -> Result<bool, (usize, String)> {
        while self.next < self.bytes.len() {
            let line = self.next_line();
            self.next += line.len();
            match line.trim_ascii() {
                b"" => {}
                text if begins_solid(text) => {
                    (self.start, self.head) = (self.next, SOLID);
                    return Ok(true);
                }
                _ => {
                    return Err((self.line(), "expected `solid` or the end of the file".to_owned()));
                }
            }
        }
        Ok(false)
    }
}

impl Read for AsciiReader<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if !self.head.is_empty() {
            return self.head.read(buffer);
        }
        let mut line = self.next_line();
        if let Some(head) = replacement(line) {
            (self.next, self.head) = (self.next + line.len(), head);
            return self.head.read(buffer);
        }
        let count = line.read(buffer)?;
        // `stl_io` reads lower case only.
        buffer[..count].make_ascii_lowercase();
        self.next += count;
        Ok(count)
    }
}

impl Seek for AsciiReader<'_> {
    /// Returns to the start of the solid, the only position that `stl_io` seeks.
    fn seek(&mut self, place: SeekFrom) -> io::Result<u64> {
        if place != SeekFrom::Start(0) {
            return Err(io::ErrorKind::Unsupported.into());
        }
        (self.next, self.head) = (self.start, SOLID);
        Ok(0)
    }
}
