//! Text that is read line by line, so that the line is known where reading stops.

use std::io::{self, Read, Seek, SeekFrom};

/// First line of a solid, in the only form that `stl_io` reads.
const SOLID: &[u8] = b"solid \n";

/// First line of a facet that replaces one with a NaN normal, as programs write it for slivers. Normals are ignored.
const FACET: &[u8] = b"facet normal 0 0 0\n";

fn has_no_normal(line: &[u8]) -> bool {
    let begins = line.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"facet"));
    begins && line.windows(3).any(|word| word.eq_ignore_ascii_case(b"nan"))
}

/// True if a line begins a solid, in letters of either case.
pub(super) fn begins_solid(line: &[u8]) -> bool {
    line.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"))
}

/// Lines of a file. Each read returns one line at most; the line that begins a solid is replaced by [`SOLID`].
pub(super) struct AsciiReader<'a> {
    bytes: &'a [u8],
    /// Start of the next line.
    next: usize,
    /// Start of the lines of the solid.
    start: usize,
    /// Remaining bytes of `SOLID` or `FACET`.
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
        if has_no_normal(line) {
            (self.next, self.head) = (self.next + line.len(), FACET);
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
