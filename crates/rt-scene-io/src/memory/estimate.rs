//! Estimate of the memory for loading a file, from its size and samples of its content.
//!
//! ```text
//!   peak ≈ c · size + Σ cᵢ · nᵢ        nᵢ: vertices, corners, ... from the header, or extrapolated from the samples
//! ```
//!
//! The factors belong to the loaders. They are upper bounds: `docs/MEMORY.md` compares them with measured peaks.

use std::fs::{self, File};
use std::io::{Cursor, Read, Seek, SeekFrom};
use std::path::Path;

use super::Reservation;
use crate::{LoadErrorKind, LoadOptions, SceneNode};

/// Number of samples of a text.
const PIECES: u64 = 32;
/// and so much of it in each.
const PIECE_BYTES: u64 = 1 << 15;

/// Bytes of memory that a node of a scene file takes while it is loaded.
const NODE_BYTES: u64 = 1700;

/// Bytes of memory per list at a node, such as its transforms.
const LIST_BYTES: u64 = 1200;

/// A file as far as it is looked at beforehand.
pub(crate) struct FileSample {
    /// Size of the file in bytes.
    pub(crate) size: u64,
    /// Pieces from all over the file, in their order. The first one is its beginning, the others begin with a line if
    /// there is one.
    pieces: Vec<Vec<u8>>,
}

impl FileSample {
    /// `None` for unreadable or irregular files, which the loader refuses.
    pub(super) fn of(path: &Path, options: &LoadOptions) -> Option<Self> {
        if let Some(bytes) = options.content_of(path) {
            return Self::read(Cursor::new(bytes), bytes.len() as u64);
        }
        // Opening a pipe would wait for its writer.
        let metadata = fs::metadata(path).ok().filter(fs::Metadata::is_file)?;
        Self::read(File::open(path).ok()?, metadata.len())
    }

    pub(crate) fn read(mut file: impl Read + Seek, size: u64) -> Option<Self> {
        let stride = size.div_ceil(PIECES).max(PIECE_BYTES);
        let mut pieces = Vec::new();
        for start in (0..size).step_by(usize::try_from(stride).ok()?) {
            let mut piece = Vec::new();
            file.seek(SeekFrom::Start(start)).ok()?;
            (&mut file).take(PIECE_BYTES).read_to_end(&mut piece).ok()?;
            if start > 0 && stride > PIECE_BYTES {
                let line = piece.iter().position(|&byte| byte == b'\n').map_or(0, |end| end + 1);
                piece.drain(..line);
            }
            pieces.push(piece);
        }
        Some(Self { size, pieces })
    }

    /// The beginning of the file.
    #[cfg(any(feature = "gltf", feature = "ply", feature = "stl", test))]
    pub(crate) fn head(&self) -> &[u8] {
        self.pieces.first().map_or(&[], Vec::as_slice)
    }

    /// Sum over all lines of the file, extrapolated from the samples.
    pub(crate) fn over_lines<const N: usize>(&self, mut count: impl FnMut(&[u8]) -> [u64; N]) -> [u64; N] {
        let mut sums = [0; N];
        for line in self.pieces.iter().flat_map(|piece| piece.split(|&byte| matches!(byte, b'\n' | b'\r'))) {
            for (sum, value) in sums.iter_mut().zip(count(line)) {
                *sum += value;
            }
        }
        let seen: usize = self.pieces.iter().map(Vec::len).sum();
        let share = self.size as f64 / seen.max(1) as f64;
        sums.map(|sum| (sum as f64 * share).ceil() as u64)
    }
}

/// Reserves the peak memory of a scene file: the text, its parsed nodes and its resolved nodes.
pub(crate) fn reserve_scene(path: &Path, options: &LoadOptions) -> Result<Reservation, LoadErrorKind> {
    let bytes = options.memory.limit().and_then(|_| FileSample::of(path, options)).map_or(0, |sample| {
        let [nodes, lists] = sample.over_lines(elements);
        sample.size * 27 / 10 + NODE_BYTES * nodes + LIST_BYTES * lists
    });
    options.memory.reserve(format_args!("the scene {}", path.display()), bytes)
}

/// Numbers of records without a name and of lists in a line of RON or JSON. Nodes and their transforms are written so;
/// points and lists of points do not count.
fn elements(line: &[u8]) -> [u64; 2] {
    let mut before = b',';
    let (mut records, mut lists) = (0, 0);
    for (i, &byte) in line.iter().enumerate().filter(|(_, byte)| !byte.is_ascii_whitespace()) {
        if matches!(byte, b'{' | b'(' | b'[') {
            let next = line[i + 1..].iter().find(|byte| !byte.is_ascii_whitespace());
            let holds_numbers = next.is_some_and(|next| matches!(next, b'0'..=b'9' | b'-' | b'+' | b'.' | b'['));
            let is_record = byte != b'[' && matches!(before, b',' | b'[' | b'(');
            records += u64::from(is_record && !holds_numbers);
            lists += u64::from(byte == b'[' && !holds_numbers && next != Some(&b'('));
        }
        before = byte;
    }
    [records, lists]
}

pub(crate) fn tree_bytes(nodes: &[SceneNode]) -> u64 {
    let (mut open, mut bytes) = (vec![nodes], 0);
    while let Some(nodes) = open.pop() {
        bytes += size_of_val(nodes) as u64;
        for node in nodes {
            bytes += node.name.len() as u64;
            open.push(&node.children);
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(content: &str) -> FileSample {
        let file = tempfile::NamedTempFile::new().expect("a file");
        fs::write(file.path(), content).expect("written");
        FileSample::of(file.path(), &LoadOptions::default()).expect("a regular file")
    }

    #[test]
    fn short_files_are_counted_line_by_line() {
        let sample = sample("a\nbb\n\nb\n");
        assert_eq!(sample.head(), b"a\nbb\n\nb\n");
        assert_eq!(sample.over_lines(|line| [u64::from(line.starts_with(b"b")), line.len() as u64]), [2, 4]);
    }

    #[test]
    fn long_files_are_estimated_from_all_over() {
        // Two parts of different density, as vertices and faces in a model.
        let text = "v 1.25 2.5 3.75\n".repeat(200_000) + &"f 1 2\n".repeat(300_000);
        let sample = sample(&text);
        assert!(sample.pieces.iter().map(Vec::len).sum::<usize>() as u64 <= PIECES * PIECE_BYTES);
        let [v, f] = sample.over_lines(|line| [b"v ", b"f "].map(|word| u64::from(line.starts_with(word))));
        assert!((190_000..210_000).contains(&v) && (285_000..315_000).contains(&f), "{v} {f}");
    }

    #[test]
    fn nodes_are_distinguished_from_points_and_shapes() {
        for (line, counts) in [
            ("(nodes: [(), (shape: sphere(center: (1, -2, .5))), (instance: \"a\"),", [4, 0]),
            ("(shape: box(min: (0, 0, 0), max: (1, 1, 1)), transform: [rotate_y(3), translate(1, 2, 3)])", [1, 1]),
            ("positions: [(0, 1, 2), ( 3, 4, 5)],", [0, 0]),
            (
                r#"{"nodes": [{}, {"shape": {"sphere": {"center": [1, 2, 3]}}, "transform": [{"rotate_x": 3}]}]}"#,
                [4, 2],
            ),
            ("", [0, 0]),
        ] {
            assert_eq!(elements(line.as_bytes()), counts, "{line}");
        }
    }

    #[test]
    fn what_is_no_file_has_no_sample() {
        let of = |path: &str| FileSample::of(Path::new(path), &LoadOptions::default());
        assert!(of("/nonexistent").is_none() && of("/").is_none());
        assert_eq!(sample("").over_lines(|_| [1]), [0]);
    }
}
