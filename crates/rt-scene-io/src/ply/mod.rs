//! PLY (Greg Turk, "The PLY Polygon File Format", 1994), text and binary of both byte orders, through `serde_ply`.
//!
//! ```text
//! header ── counts fit the bytes that follow? ──> vertices: x y z, nx ny nz, s t, red green blue alpha
//!                                            └──> faces: lists of corners, cut into triangles; triangle strips
//! ```
//!
//! Vertex colours are the surface colour: integers are shares of their maximum, encoded as in sRGB; fractions are linear. Alpha
//! is ignored. The row counts of the header are compared with the size of the file before rows are read.

mod header;
mod rows;

use std::path::Path;

use rt_geometry::{Face, MeshData};
use rt_image::Encoding;
use rt_math::{Rgb, Vec3};
use rt_shading::{ColorTexture, Phong, Texture, TextureId};
use serde_ply::{DeserializeError, PlyFormat, PlyHeader, PlyReader};

use self::rows::{FaceCorners, PlyVertices, Rows, STRIPS, Skipped, TriangleStrips};
use crate::error::ErrorAt;
use crate::files::{refuse_utf16, unify_line_ends};
use crate::memory::{FileSample, load_within_budget};
use crate::parser_message::plain;
use crate::sanitize::shortened;
use crate::unshare::unshare;
use crate::{LoadError, LoadErrorKind, LoadOptions, Location, Model};

pub(crate) fn load(path: &Path, options: &LoadOptions) -> Result<Model, LoadError> {
    load_within_budget(path, options, peak_bytes, |bytes| {
        refuse_utf16(&bytes).at(path, "")?;
        load_bytes(bytes, path, MissingUvs::Keep)
    })
}

/// Version of [`load`] that gives a file without texture coordinates those of pbrt-v4.
#[cfg(feature = "pbrt")]
pub(crate) fn load_with_face_uvs(path: &Path, options: &LoadOptions) -> Result<Model, LoadError> {
    // Each corner of a face of four becomes a vertex with a normal and texture coordinates, and is listed twice.
    let peak = |sample: &FileSample| peak_bytes(sample) + 4 * (12 + 12 + 8 + 8) * count(sample, "face");
    load_within_budget(path, options, peak, |bytes| {
        refuse_utf16(&bytes).at(path, "")?;
        load_bytes(bytes, path, MissingUvs::PerFace)
    })
}

/// Texture coordinates of a file without any.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MissingUvs {
    /// None.
    Keep,
    /// [`FACE_UVS`], for faces without common vertices.
    PerFace,
}

/// Texture coordinates of the corners of a face in pbrt-v4, which has triangles and quadrilaterals only.
const FACE_UVS: [[f32; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

/// Bytes of memory that loading takes at its peak.
fn peak_bytes(sample: &FileSample) -> u64 {
    let count = |name| count(sample, name);
    // The length of strips is unknown before reading: at most all of the file, in numbers of four bytes.
    let strips = if count(STRIPS) > 0 { 12 * sample.size } else { 0 };
    sample.size + 56 * count("vertex") + 28 * count("face") + strips
}

/// Number of rows that the header declares for an element.
fn count(sample: &FileSample, name: &str) -> u64 {
    let mut head = sample.head().to_vec();
    header::remove_mark(&mut head);
    header::unify_line_ends(&mut head);
    let header = PlyReader::from_reader(&mut head.as_slice()).map(|reader| reader.header().clone()).ok();
    header.and_then(|header| header.get_element(name).map(|element| element.count as u64)).unwrap_or(0)
}

/// Loads the file that `bytes` hold; `path` is for messages.
pub(crate) fn load_bytes(mut bytes: Vec<u8>, path: &Path, missing_uvs: MissingUvs) -> Result<Model, LoadError> {
    header::remove_mark(&mut bytes);
    if bytes.starts_with(b"ply\rformat ascii") {
        unify_line_ends(&mut bytes);
    }
    header::unify_line_ends(&mut bytes);
    // The reader wants white space after the last word; behind binary data it does no harm.
    bytes.push(b'\n');
    let mut rest = bytes.as_slice();
    let header = PlyReader::from_reader(&mut rest).map(|reader| reader.header().clone());
    let header = header.map_err(|error| explain(&error, &bytes, rest, None, path))?;
    // The last byte is not the file's.
    header::check(&header, (rest.len() as u64).saturating_sub(1)).at(path, "")?;
    let mut rest = bytes.as_slice();
    let content = read(&mut rest).map_err(|error| explain(&error, &bytes, rest, Some(&header), path))?;
    if header.format != PlyFormat::Ascii && rest.is_empty() {
        // The byte that is not the file's was read as one of its rows.
        let message = format!("the file ends too early (before byte {})", bytes.len() - 1);
        return Err(LoadErrorKind::Syntax(message).at(path, ""));
    }
    let surplus = surplus(&bytes, rest, header.format);
    let PlyContent { vertices, corners } = content;
    if corners.is_empty() && !header::has_faces(&header) {
        let what = "a point cloud without faces";
        return Err(LoadErrorKind::Unsupported(what.to_owned()).at(path, ""));
    }
    let mut model = Model::default();
    let mut warn = |message: String| model.warn(path.display(), message);
    if let Some(version) = header::version(&bytes).filter(|version| *version != "1.0") {
        warn(format!("the file has version {} of the format; it is read as version 1.0", shortened(version)));
    }
    for left_out in header::left_out(&header) {
        warn(left_out);
    }
    if let Some((line, message)) = header::irregular_row(&header, &bytes) {
        model.warn(format_args!("{}:{line}", path.display()), message);
    }
    let mut warn = |message: String| model.warn(path.display(), message);
    surplus.into_iter().for_each(&mut warn);
    if corners.short > 0 {
        warn(format!("faces with fewer than three corners were left out: {}", corners.short));
    }
    if corners.is_empty() {
        return Err(model.empty("has no usable triangles", path));
    }
    let mut data = mesh_data(&header, &vertices, &corners).at(path, "element face")?;
    if missing_uvs == MissingUvs::PerFace && data.uvs.is_empty() {
        lay_face_uvs(&mut data, &corners).at(path, "element face")?;
    }
    let is_colored = !data.colors.is_empty();
    let clamped = clamp_colors(&mut data.colors);
    if clamped > 0 {
        warn(format!(
            "vertex colours above 1 are clamped: {clamped} of {}; colours of type `float` are 1 at most, those of type \
             `uchar` 255",
            data.colors.len()
        ));
    }
    model.set_mesh(data, path)?;
    if is_colored {
        show_colors(&mut model);
    }
    Ok(model)
}

/// Gives the one material the colours of the vertices, with as much of the ambient light as plain grey takes.
fn show_colors(model: &mut Model) {
    let color = TextureId(model.textures.len() as u32);
    model.textures.push(Texture::VertexColor(None));
    for material in &mut model.materials {
        material.model = Phong::lambertian(ColorTexture::Textured(color, Rgb::WHITE)).into();
    }
}

/// Message about a file of another format.
const NO_PLY: &str = "is not a PLY file: the first line must be `ply`";

/// Relevant content of a file.
#[derive(Default)]
struct PlyContent {
    vertices: PlyVertices,
    corners: FaceCorners,
}

fn read(bytes: &mut &[u8]) -> Result<PlyContent, DeserializeError> {
    let mut reader = PlyReader::from_reader(bytes)?;
    let (mut content, mut strips) = (PlyContent::default(), TriangleStrips::default());
    while let Some(element) = reader.current_element() {
        match element.name.as_str() {
            "vertex" => Rows(content.vertices) = reader.next_element()?,
            "face" => Rows(content.corners) = reader.next_element()?,
            STRIPS => Rows(strips) = reader.next_element()?,
            _ => {
                reader.next_element::<Rows<Skipped>>()?;
            }
        }
    }
    strips.add_to(&mut content.corners);
    Ok(content)
}

/// Warning about content after the rows that the header declares; `None` without any. `rest` is the unread content.
fn surplus(bytes: &[u8], rest: &[u8], format: PlyFormat) -> Option<String> {
    // The last byte is not the file's.
    let rest = &rest[..rest.len().saturating_sub(1)];
    if format != PlyFormat::Ascii {
        let unit = if rest.len() == 1 { "byte" } else { "bytes" };
        let sentence = format!("{} {unit} beyond the rows that the header declares are left out", rest.len());
        return (!rest.is_empty()).then_some(sentence);
    }
    let read = bytes.len() - 1 - rest.len();
    let lines = 1 + bytes[..read].iter().filter(|byte| **byte == b'\n').count()..;
    let (mut first, mut count) = (None, 0_usize);
    for (line, text) in lines.zip(rest.split(|byte| *byte == b'\n')) {
        if !text.trim_ascii().is_empty() {
            first = first.or(Some(line));
            count += 1;
        }
    }
    let (first, unit) = (first?, if count == 1 { "line" } else { "lines" });
    let place = if count == 1 { format!("(line {first})") } else { format!("the first of them line {first}") };
    let comma = if count == 1 { " " } else { ", " };
    Some(format!("{count} {unit} beyond the rows that the header declares are left out{comma}{place}"))
}

/// Error at the position up to which the file was read: a line of text, or a byte.
fn explain(error: &DeserializeError, bytes: &[u8], rest: &[u8], header: Option<&PlyHeader>, path: &Path) -> LoadError {
    let format = header.map(|header| header.format);
    // The last byte is not the file's.
    let read = &bytes[..(bytes.len() - rest.len()).min(bytes.len() - 1)];
    let message = match error.0.kind() {
        _ if !bytes.starts_with(b"ply") => NO_PLY.to_owned(),
        std::io::ErrorKind::InvalidData if format.is_none() && str::from_utf8(read).is_err() => {
            "the header is not UTF-8 text".to_owned()
        }
        std::io::ErrorKind::UnexpectedEof => "the file ends too early".to_owned(),
        _ => explained(&error.0.to_string(), read),
    };
    match format {
        // The end of the line of the last word may have been read with it.
        None | Some(PlyFormat::Ascii) => {
            let line = 1 + read.iter().rev().skip(1).filter(|byte| **byte == b'\n').count();
            let cause = header.and_then(|header| header::irregular_row(header, bytes)).filter(|row| row.0 < line);
            let cause = cause.map_or_else(String::new, |(line, row)| format!("; line {line}: {row}"));
            LoadErrorKind::Syntax(message + &cause).at(path, Location::Line(line))
        }
        Some(_) => LoadErrorKind::Syntax(format!("{message} (before byte {})", read.len())).at(path, ""),
    }
}

/// Message of `serde-ply` with the offending word, the last one that was read, and what is expected.
fn explained(message: &str, read: &[u8]) -> String {
    let last = read.trim_ascii_end().rsplit(u8::is_ascii_whitespace).next().unwrap_or_default();
    let word = shortened(&String::from_utf8_lossy(last));
    let name = |start: &str| message.strip_prefix(start).map(shortened);
    if let Some(kind) = message.strip_prefix("Failed to parse ").and_then(|rest| rest.strip_suffix(" from ASCII")) {
        return match kind {
            "f32" | "f64" => format!("`{word}` is not a number"),
            "u8" => format!("`{word}` is not a whole number from 0 to 255"),
            "u16" => format!("`{word}` is not a whole number from 0 to 65535"),
            "u32" => format!("`{word}` is not a whole number from 0 to 4294967295"),
            _ => format!("`{word}` is not a whole number that fits the type of its property"),
        };
    }
    if let Some(count) = name("Invalid element count: ") {
        return format!("`{count}` is not a number of rows; expected a whole number from 0 up");
    }
    if let Some(kind) = name("Unknown scalar type: ") {
        return format!(
            "unknown type `{kind}`; known are `char`, `uchar`, `short`, `ushort`, `int`, `uint`, `float`, `double`"
        );
    }
    if let Some(format) = name("Unknown format: ") {
        return format!("unknown format `{format}`; known are `ascii`, `binary_little_endian`, `binary_big_endian`");
    }
    if message.starts_with("File must start with") {
        return NO_PLY.to_owned();
    }
    plain(message)
}

fn mesh_data(
    header: &PlyHeader,
    vertices: &PlyVertices,
    corners: &FaceCorners,
) -> Result<MeshData, rt_geometry::MeshError> {
    let positions = vertices.rows.iter().map(|row| Vec3::new(row[0], row[1], row[2])).collect();
    let faces = corners.faces().map(|outline| Face { outline, holes: &[] });
    let mut data = MeshData::from_polygons(positions, faces)?;
    if header::has(header, rows::NORMAL) {
        data.normals = vertices.rows.iter().map(|row| Vec3::new(row[3], row[4], row[5])).collect();
    }
    if header::has(header, rows::UV) {
        data.uvs = vertices.rows.iter().map(|row| [row[6], row[7]]).collect();
    }
    if header::has(header, rows::COLOR) {
        data.colors = colors(header, vertices);
    }
    Ok(data)
}

/// Gives each corner of the faces a vertex of its own, at [`FACE_UVS`]; further corners are at (0, 0).
fn lay_face_uvs(data: &mut MeshData, corners: &FaceCorners) -> Result<(), rt_geometry::MeshError> {
    let order: Vec<u32> = corners.faces().flatten().copied().collect();
    unshare(data, &order);
    let indices: Vec<u32> = (0..order.len() as u32).collect();
    let mut rest = indices.as_slice();
    let faces = corners.faces().map(|face| {
        let (outline, after) = rest.split_at(face.len());
        rest = after;
        Face { outline, holes: &[] }
    });
    let MeshData { positions, triangles, .. } = MeshData::from_polygons(std::mem::take(&mut data.positions), faces)?;
    (data.positions, data.triangles) = (positions, triangles);
    let uv = |corner: usize| FACE_UVS.get(corner).copied().unwrap_or_default();
    data.uvs = corners.faces().flat_map(|face| (0..face.len()).map(uv)).collect();
    Ok(())
}

/// Linear colours with alpha, 1 where the file has none.
fn colors(header: &PlyHeader, vertices: &PlyVertices) -> Vec<[f32; 4]> {
    let linear: fn(f32) -> f32 = match header::whole(header, rows::COLOR) {
        Some(_) => |share| Encoding::Srgb.decode_signal(f64::from(share)) as f32,
        None => |share| share,
    };
    let max = header::whole(header, rows::COLOR).unwrap_or(1.0);
    let max_alpha = header::whole(header, rows::ALPHA).unwrap_or(1.0);
    let has_alpha = header::has(header, rows::ALPHA);
    let decoded = vertices.colors.iter().map(|[r, g, b, a]| {
        let [r, g, b] = [r, g, b].map(|c| linear(c / max));
        [r, g, b, if has_alpha { a / max_alpha } else { 1.0 }]
    });
    decoded.collect()
}

/// Clamps components above 1, without alpha. Returns the number of changed colours.
fn clamp_colors(colors: &mut [[f32; 4]]) -> usize {
    let mut count = 0;
    for [r, g, b, _] in colors.iter_mut().filter(|[r, g, b, _]| r.max(*g).max(*b) > 1.0) {
        [*r, *g, *b] = [r.min(1.0), g.min(1.0), b.min(1.0)];
        count += 1;
    }
    count
}

#[cfg(test)]
mod tests;
