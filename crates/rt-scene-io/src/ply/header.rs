//! Checks of the header.

use std::ops::Range;

use serde_ply::{ElementDef, PlyFormat, PlyHeader, PropertyType, ScalarType};

use super::rows::{COLOR, COLUMNS, CORNERS, POSITION, STRIPS, column};
use crate::LoadErrorKind;

/// Removes the byte order mark that some editors write before text.
pub(super) fn remove_mark(bytes: &mut Vec<u8>) {
    const MARK: &[u8] = "\u{feff}".as_bytes();
    if bytes.starts_with(MARK) {
        bytes.drain(..MARK.len());
    }
}

/// Replaces the line ends of old Macintosh systems up to the end of the header: binary data follow.
pub(super) fn unify_line_ends(bytes: &mut [u8]) {
    const END: &[u8] = b"\rend_header\r";
    if !bytes.starts_with(b"ply\r") || bytes.starts_with(b"ply\r\n") {
        return;
    }
    if let Some(start) = bytes.windows(END.len()).position(|window| window == END) {
        bytes[..start + END.len()].iter_mut().filter(|byte| **byte == b'\r').for_each(|byte| *byte = b'\n');
    }
}

/// Checks that there are vertices with positions, and that the `present` bytes after the header can hold all rows.
pub(super) fn check(header: &PlyHeader, present: u64) -> Result<(), LoadErrorKind> {
    // The white space after the last word of a text may be missing.
    let available = present + u64::from(header.format == PlyFormat::Ascii);
    for (i, element) in header.elem_defs.iter().enumerate() {
        if header.elem_defs[..i].iter().any(|before| before.name == element.name) {
            return Err(LoadErrorKind::Duplicate { kind: "element", name: element.name.clone() });
        }
    }
    let mut needed: u64 = 0;
    for element in &header.elem_defs {
        let row: u64 =
            element.properties.iter().map(|property| min_bytes(header.format, &property.property_type)).sum();
        if row == 0 && element.count > 0 {
            let value = format!("the element `{}` of {} rows", element.name, element.count);
            return Err(LoadErrorKind::invalid(value, "has no properties: give at least one"));
        }
        needed = needed.saturating_add(row.saturating_mul(element.count as u64));
    }
    if needed > available {
        let unit = if present == 1 { "byte" } else { "bytes" };
        let value = format!("{present} {unit} after the header");
        return Err(LoadErrorKind::invalid(
            value,
            format!("are too few: its elements take at least {needed}; the file is truncated"),
        ));
    }
    let Some(vertex) = header.get_element("vertex") else {
        return Err(LoadErrorKind::Syntax("the header has no element `vertex`".to_owned()));
    };
    for names in &COLUMNS[POSITION] {
        if !names.iter().any(|name| vertex.has_property(name)) {
            return Err(LoadErrorKind::Syntax(format!("the element `vertex` has no property `{}`", names[0])));
        }
    }
    Ok(())
}

/// Minimum size of a value: a list may be empty, and a word of text takes a digit and a separator.
fn min_bytes(format: PlyFormat, property: &PropertyType) -> u64 {
    let first = match property {
        PropertyType::Scalar(scalar) | PropertyType::List { count_type: scalar, .. } => scalar,
    };
    match (format, first) {
        (PlyFormat::Ascii, _) | (_, ScalarType::I16 | ScalarType::U16) => 2,
        (_, ScalarType::I8 | ScalarType::U8) => 1,
        (_, ScalarType::I32 | ScalarType::U32 | ScalarType::F32) => 4,
        (_, ScalarType::F64) => 8,
    }
}

/// True if vertices have all of these columns.
pub(super) fn has(header: &PlyHeader, columns: Range<usize>) -> bool {
    let has =
        |names: &&[&str]| header.get_element("vertex").is_some_and(|v| names.iter().any(|name| v.has_property(name)));
    COLUMNS[columns].iter().all(has)
}

/// Maximum value of a colour in the first of these columns; `None` for fractions.
pub(super) fn whole(header: &PlyHeader, columns: Range<usize>) -> Option<f32> {
    let names = COLUMNS.get(columns)?.first()?;
    let property = header.get_element("vertex")?.properties.iter().find(|p| names.contains(&p.name.as_str()))?;
    match &property.property_type {
        PropertyType::Scalar(ScalarType::I8) => Some(f32::from(i8::MAX)),
        PropertyType::Scalar(ScalarType::U8) => Some(f32::from(u8::MAX)),
        PropertyType::Scalar(ScalarType::I16) => Some(f32::from(i16::MAX)),
        PropertyType::Scalar(ScalarType::U16) => Some(f32::from(u16::MAX)),
        // Programs that write 32 bits mean bytes all the same.
        PropertyType::Scalar(ScalarType::I32 | ScalarType::U32) => Some(f32::from(u8::MAX)),
        _ => None,
    }
}

/// True if there are rows of faces or strips.
pub(super) fn has_faces(header: &PlyHeader) -> bool {
    ["face", STRIPS].iter().any(|name| header.get_element(name).is_some_and(|element| element.count > 0))
}

/// Version in the line `format` of a header, which `serde_ply` passes over.
pub(super) fn version(bytes: &[u8]) -> Option<&str> {
    let lines = bytes.split(|byte| *byte == b'\n').take_while(|line| !line.starts_with(b"end_header"));
    let mut words =
        lines.filter_map(|line| str::from_utf8(line).ok()?.strip_prefix("format ")).next()?.split_whitespace();
    words.nth(1)
}

/// Messages about content other than a mesh.
pub(super) fn left_out(header: &PlyHeader) -> Vec<String> {
    let mut sentences = Vec::new();
    for ElementDef { name, count, properties } in &header.elem_defs {
        let known: fn(&str) -> bool = match name.as_str() {
            "vertex" if has(header, COLOR) => |name| column(name.as_bytes()).is_some(),
            // Alpha without colours is ignored.
            "vertex" => |name| column(name.as_bytes()).is_some_and(|column| column < COLOR.start),
            "face" | STRIPS => |name| CORNERS.contains(&name),
            _ => {
                sentences.push(format!("the element `{name}` of {count} rows is left out"));
                continue;
            }
        };
        let unknown: Vec<_> = properties.iter().filter(|p| !known(&p.name)).map(|p| format!("`{}`", p.name)).collect();
        if !unknown.is_empty() {
            sentences.push(format!("properties of the element `{name}` are left out: {}", unknown.join(", ")));
        }
    }
    sentences
}

/// Line of the first row of a text with another number of words than its element has, with a message. Words are read as they follow each
/// other, so that all rows after it may be shifted.
pub(super) fn irregular_row(header: &PlyHeader, bytes: &[u8]) -> Option<(usize, String)> {
    if header.format != PlyFormat::Ascii {
        return None;
    }
    let mut lines = (1..).zip(bytes.split(|byte| *byte == b'\n'));
    lines.find(|(_, line)| line.trim_ascii() == b"end_header")?;
    let mut rows = lines.filter(|(_, line)| !line.trim_ascii().is_empty());
    for ElementDef { name, count, properties } in &header.elem_defs {
        for (number, line) in rows.by_ref().take(*count) {
            let mut words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
            let total = words.clone().count();
            let mut needed = 0_usize;
            for property in properties {
                needed += 1;
                let word = words.next();
                if let PropertyType::List { .. } = property.property_type {
                    let length: usize = str::from_utf8(word?).ok()?.parse().ok()?;
                    needed = length.saturating_add(needed);
                    words.by_ref().take(length).for_each(|_| ());
                }
            }
            if total != needed {
                let unit = if total == 1 { "number" } else { "numbers" };
                let message = format!(
                    "this row has {total} {unit}, but one of `{name}` has {needed}; rows after it may be shifted"
                );
                return Some((number, message));
            }
        }
    }
    None
}
