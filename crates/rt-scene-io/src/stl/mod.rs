//! STL (3D Systems, 1988), text and binary, through `stl_io`.
//!
//! The size of a file distinguishes the two, as many binary files begin with "solid". Corners at one position become one
//! vertex. Facets are flat; normals in the file are ignored, and colours are left out.

mod ascii_reader;

use std::collections::HashMap;
use std::io::{self, Cursor};
use std::path::Path;

use rt_geometry::MeshData;
use rt_math::Vec3;

use self::ascii_reader::AsciiReader;
use crate::error::ErrorAt;
use crate::files::{refuse_utf16, unify_line_ends};
use crate::memory::{FileSample, load_within_budget};
use crate::sanitize::shortened;
use crate::{LoadError, LoadErrorKind, LoadOptions, Location, Model};

/// Bytes before the facets of a binary file: a comment and the number of facets.
const HEADER: usize = 84;
const COMMENT: usize = 80;
/// Bytes of a facet: a normal, three corners, two bytes for whatever programs like.
const FACET: u64 = 50;

pub(crate) fn load(path: &Path, options: &LoadOptions) -> Result<Model, LoadError> {
    load_within_budget(path, options, peak_bytes, |bytes| load_bytes(bytes, path))
}

/// Bytes of memory that loading takes at its peak.
fn peak_bytes(sample: &FileSample) -> u64 {
    let facets = match promised_size(sample.head()) {
        Some(promised) if promised <= sample.size => (promised - HEADER as u64) / FACET,
        _ => sample.over_lines(|line| [u64::from(line.trim_ascii_start().starts_with(b"facet"))])[0],
    };
    // Triangles, and half as many vertices with the table that finds them again, as in a closed surface.
    sample.size + 48 * facets
}

/// Loads the file that `bytes` hold; `path` is for messages.
pub(crate) fn load_bytes(mut bytes: Vec<u8>, path: &Path) -> Result<Model, LoadError> {
    if bytes.strip_prefix(b"\xEF\xBB\xBF").is_some_and(|text| ascii_reader::begins_solid(text.trim_ascii_start())) {
        bytes.drain(..3);
    }
    let mut mesh = WeldedMesh::default();
    let mut model = Model::default();
    let begins_as_text = ascii_reader::begins_solid(bytes.trim_ascii_start());
    // The comment of a binary file may begin with any bytes.
    if promised_size(&bytes) != Some(bytes.len() as u64) {
        refuse_utf16(&bytes).at(path, "")?;
    }
    match promised_size(&bytes) {
        Some(promised) if promised == bytes.len() as u64 || !begins_as_text || is_followed(&bytes, promised) => {
            let after = (bytes.len() as u64).checked_sub(promised).ok_or_else(|| {
                let facets = (promised - HEADER as u64) / FACET;
                let rule = format!("is truncated: its {facets} facets take {promised} bytes");
                LoadErrorKind::invalid(format_args!("a file of {} bytes", bytes.len()), rule).at(path, "")
            })?;
            if after > 0 {
                let message = format!("{after} bytes after the last facet are left out");
                model.warn(path.display(), message);
            }
            if let Some(message) = left_out_colors(&bytes, promised) {
                model.warn(path.display(), message);
            }
            read_binary(bytes, &mut mesh).map_err(|error| LoadErrorKind::Syntax(error.to_string()).at(path, ""))?;
        }
        _ if begins_as_text => {
            unify_line_ends(&mut bytes);
            read_text(&bytes, &mut mesh)
                .map_err(|(line, message)| LoadErrorKind::Syntax(message).at(path, Location::Line(line)))?;
        }
        _ => {
            let rule = "is not an STL file: it is too short for a binary file and does not begin with `solid`";
            return Err(LoadErrorKind::invalid(format_args!("a file of {} bytes", bytes.len()), rule).at(path, ""));
        }
    }
    model.set_mesh(mesh.data, path)?;
    Ok(model)
}

/// Size of a binary file in bytes, from its number of facets.
fn promised_size(bytes: &[u8]) -> Option<u64> {
    let count = bytes.get(COMMENT..HEADER)?.try_into().ok()?;
    Some(HEADER as u64 + FACET * u64::from(u32::from_le_bytes(count)))
}

/// True for a binary file with bytes after its facets: text has no NUL, which the number of facets contains.
fn is_followed(bytes: &[u8], promised: u64) -> bool {
    promised < bytes.len() as u64 && bytes[COMMENT..HEADER].contains(&0)
}

/// Warning about colours of a binary file of this size. VisCAM and SolidView mark the colour of a facet with the highest bit of
/// its last two bytes. Magics writes `COLOR=` and four bytes to the comment, and clears the bit of facets with a colour.
fn left_out_colors(bytes: &[u8], promised: u64) -> Option<String> {
    if bytes[..COMMENT].windows(6).any(|word| word == b"COLOR=") {
        return Some("the colours of the header (`COLOR=`) and of facets are left out".to_owned());
    }
    let facets = bytes[HEADER..promised as usize].chunks_exact(FACET as usize);
    let (count, colored) = (facets.len(), facets.filter(|facet| facet[FACET as usize - 1] & 0x80 != 0).count());
    (colored > 0).then(|| format!("the colours of {colored} of {count} facets are left out"))
}

/// Triangles whose equal corners share a vertex.
#[derive(Default)]
struct WeldedMesh {
    data: MeshData,
    known: HashMap<[u32; 3], u32>,
}

impl WeldedMesh {
    fn add(&mut self, corners: [stl_io::Vertex; 3]) {
        let triangle = corners.map(|corner| {
            let position = Vec3::new(corner[0], corner[1], corner[2]);
            // 0 and −0 are equal.
            let place = position.to_array().map(|x| (x + 0.0).to_bits());
            *self.known.entry(place).or_insert_with(|| {
                self.data.positions.push(position);
                self.data.positions.len() as u32 - 1
            })
        });
        self.data.triangles.push(triangle);
    }
}

fn read_binary(mut bytes: Vec<u8>, mesh: &mut WeldedMesh) -> io::Result<()> {
    // The reader takes a file whose comment begins with "solid" for text.
    bytes[0] = b'\n';
    let mut bytes = Cursor::new(bytes);
    for facet in stl_io::create_stl_reader(&mut bytes)? {
        mesh.add(facet?.vertices);
    }
    Ok(())
}

/// Reads all solids of a text file; the message of an error comes with its line.
fn read_text(bytes: &[u8], mesh: &mut WeldedMesh) -> Result<(), (usize, String)> {
    let mut lines = AsciiReader::of(bytes);
    while lines.begin_solid()? {
        // The reader ends at the end of a solid.
        let result = stl_io::create_stl_reader(&mut lines)
            .and_then(|mut facets| facets.try_for_each(|facet| facet.map(|facet| mesh.add(facet.vertices))));
        result.map_err(|error| (lines.line(), explained(&error, lines.last_line())))?;
    }
    Ok(())
}

/// Message of `stl_io` with the text of the line, and what is expected.
fn explained(error: &io::Error, line: &[u8]) -> String {
    if error.kind() == io::ErrorKind::UnexpectedEof {
        return "the file ends too early; expected `endsolid` at its end".to_owned();
    }
    let message = error.to_string();
    let line = String::from_utf8_lossy(line.trim_ascii());
    let expected = if message.starts_with("invalid facet header") {
        "`facet normal X Y Z` or `endsolid`"
    } else if message.starts_with("vertex f32") {
        "`vertex X Y Z`"
    } else if message.contains("\"outer\"") {
        "`outer loop`"
    } else if message.contains("expected [\"endloop") {
        "`endloop`"
    } else if message.contains("expected [\"endfacet") {
        "`endfacet`"
    } else {
        let is_bad = |word: &&str| !word.parse().is_ok_and(f32::is_finite);
        let keywords = if line.starts_with(['f', 'F']) { 2 } else { 1 };
        return match line.split_whitespace().skip(keywords).find(is_bad) {
            Some(word) => format!("`{}` is not a finite number", shortened(word)),
            None => message,
        };
    };
    format!("expected {expected}, found `{}`", shortened(&line))
}

#[cfg(test)]
mod tests;
