//! OBJ files, sorted for `tobj`.
//!
//! `tobj` reads numbers, shares vertices and splits meshes. It lacks line continuation, smoothing groups and line numbers, and
//! misaligns normals and texture coordinates where only some faces have them. The statements are therefore sorted first: all
//! vertices, then the faces of each [`ObjPart`] as a group, with absolute indices. Unreadable statements are refused here, with
//! their line.

use std::{
    collections::{BTreeMap, HashMap},
    fmt::Write,
};

use super::smoothing::Smoothing;
use crate::sanitize::shortened;
use crate::text::lines::{Line, lines};
use crate::{LoadErrorKind, error::LineError, limits::FACE_CORNERS};

/// Faces that become one mesh.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct ObjPart {
    /// Name of the object or group; may be empty.
    pub(super) name: String,
    /// Name of the object, the last `o` statement; may be empty.
    object: String,
    /// The material in force, if any.
    pub(super) material: Option<String>,
    /// The smoothing group in force.
    pub(super) smoothing: Smoothing,
    /// Presence of texture coordinates and normals at all corners.
    attributes: [bool; 2],
}

impl ObjPart {
    /// Faces of the same value share normals: those of a smoothing group, or those of an object without smoothing groups.
    pub(super) fn smoothed_surface(&self) -> (Smoothing, &str) {
        let object = match self.smoothing {
            Smoothing::Unspecified => self.object.as_str(),
            Smoothing::Off | Smoothing::Group(_) => "",
        };
        (self.smoothing, object)
    }
}

/// A file in order.
#[derive(Debug, Default)]
pub(super) struct ObjDocument {
    /// Statements for `tobj`: group `i` holds the faces of `parts[i]`, in which every corner has the same attributes.
    pub(super) text: String,
    /// In order of their first face.
    pub(super) parts: Vec<ObjPart>,
    /// Arguments of `mtllib`, the names of material libraries, with their lines.
    pub(super) libraries: Vec<(usize, String)>,
    /// Skipped statements: their number, and the first line.
    pub(super) skipped: BTreeMap<String, (usize, usize)>,
}

/// Statements that do not change an image of triangles.
const HARMLESS: [&str; 7] = ["mg", "lod", "bevel", "c_interp", "d_interp", "shadow_obj", "trace_obj"];

impl ObjDocument {
    /// # Errors
    /// All lines that cannot be read.
    pub(super) fn parse(text: &str) -> Result<Self, Vec<LineError>> {
        let mut reader = StatementReader::default();
        let mut bad = Vec::new();
        for line in lines(text) {
            if let Err(message) = reader.statement(&line) {
                bad.push(LineError { line: line.number, kind: LoadErrorKind::Syntax(message) });
            }
        }
        if !bad.is_empty() {
            return Err(bad);
        }
        let StatementReader { mut document, positions, colours, faces, .. } = reader;
        let others = std::mem::replace(&mut document.text, positions);
        if !colours.is_empty() {
            document.text = coloured(&document.text, &colours);
        }
        document.text.push_str(&others);
        for (i, faces) in faces.iter().enumerate() {
            // Writing to a string does not fail.
            let _ = writeln!(document.text, "g {i}");
            document.text.push_str(faces);
        }
        Ok(document)
    }

    /// Statements with this keyword whose arguments are not numbers: `tobj` reports only that there is one.
    pub(super) fn find_bad_numbers(source: &str, keyword: &str) -> Vec<LineError> {
        let lines = lines(source).filter(|line| line.split().0 == keyword);
        let bad = lines.filter_map(|line| {
            let bad = line.arguments().take(3).find(|word| word.parse::<f32>().is_err())?;
            Some(LineError::new(line.number, format_args!("`{}`", shortened(bad)), "is not a number"))
        });
        bad.collect()
    }
}

/// Marks vertices without a colour in a file where others have one. Colours have no negative components.
pub(super) const NO_COLOUR: [f32; 3] = [-1.0; 3];

/// Adds its colour to each vertex statement.
fn coloured(positions: &str, colours: &[[f32; 3]]) -> String {
    let mut text = String::new();
    for (position, [r, g, b]) in positions.lines().zip(colours) {
        // Writing to a string does not fail.
        let _ = writeln!(text, "{position} {r} {g} {b}");
    }
    text
}

#[derive(Default)]
struct StatementReader {
    document: ObjDocument,
    /// Vertex statements without colours.
    positions: String,
    /// The colour of each vertex so far, if any has one.
    colours: Vec<[f32; 3]>,
    /// Face statements of each part.
    faces: Vec<String>,
    /// Numbers of `v`, `vt` and `vn` so far.
    counts: [usize; 3],
    state: ObjState,
    part_index: HashMap<ObjPart, usize>,
    /// The part for the present state with these attributes.
    current: HashMap<[bool; 2], usize>,
    corners: Vec<[Option<usize>; 3]>,
}

#[derive(Clone, Default)]
struct ObjState {
    name: String,
    object: String,
    material: Option<String>,
    smoothing: Smoothing,
}

impl StatementReader {
    fn statement(&mut self, line: &Line<'_>) -> Result<(), String> {
        let (keyword, rest) = line.split();
        match keyword {
            "v" => self.vertex(line, 0, 3)?,
            "vt" => self.vertex(line, 1, 2)?,
            "vn" => self.vertex(line, 2, 3)?,
            "f" | "fo" => self.face(line)?,
            "l" | "p" => self.skip("line or point", line.number),
            "mtllib" => self.document.libraries.push((line.number, rest.to_owned())),
            "o" => self.change(|state| {
                rest.clone_into(&mut state.name);
                rest.clone_into(&mut state.object);
            }),
            "g" => self.change(|state| rest.clone_into(&mut state.name)),
            "usemtl" => {
                let name = (!rest.is_empty()).then(|| rest.to_owned());
                self.change(|state| state.material = name);
            }
            "s" => {
                let smoothing = match line.arguments().next().unwrap_or("off") {
                    "off" | "0" => Smoothing::Off,
                    "on" => Smoothing::Group(1),
                    group => Smoothing::Group(
                        group
                            .parse()
                            .map_err(|_| format!("`{group}` is not a smoothing group; give a number or off"))?,
                    ),
                };
                self.change(|state| state.smoothing = smoothing);
            }
            _ if HARMLESS.contains(&keyword) => {}
            _ => self.skip(&format!("unsupported statement `{}`", shortened(keyword)), line.number),
        }
        Ok(())
    }

    /// Copies the first `needed` numbers of a vertex statement. `w` is ignored; a colour may follow the position with or
    /// without it.
    fn vertex(&mut self, line: &Line<'_>, kind: usize, needed: usize) -> Result<(), String> {
        let keyword = line.split().0;
        if kind == 0 {
            self.colour(line)?;
        }
        // A bad vertex counts too, so that later faces keep their indices.
        self.counts[kind] += 1;
        let text = if kind == 0 { &mut self.positions } else { &mut self.document.text };
        text.push_str(keyword);
        let mut found = 0;
        for word in line.arguments().take(needed) {
            text.push(' ');
            text.push_str(word);
            found += 1;
        }
        if kind == 1 && found == 1 {
            // One-dimensional texture coordinates.
            text.push_str(" 0");
        } else if found < needed {
            return Err(format!("`{keyword}` needs {needed} numbers, but has {found}"));
        }
        text.push('\n');
        Ok(())
    }

    /// Keeps the colour of a vertex.
    fn colour(&mut self, line: &Line<'_>) -> Result<(), String> {
        let first = match line.arguments().take(8).count() {
            6 => 3,
            7 => 4,
            _ if self.colours.is_empty() => return Ok(()),
            _ => {
                self.colours.push(NO_COLOUR);
                return Ok(());
            }
        };
        let mut colour = NO_COLOUR;
        for (part, word) in colour.iter_mut().zip(line.arguments().skip(first)) {
            *part = word.parse().map_err(|_| format!("`{}` is not a number", shortened(word)))?;
        }
        if !colour.iter().all(|part| (0.0..=1.0).contains(part)) {
            self.skip("vertex colour outside of 0 to 1", line.number);
            colour = colour.map(|part: f32| if part.is_nan() { 0.0 } else { part.clamp(0.0, 1.0) });
        }
        self.colours.resize(self.counts[0], NO_COLOUR);
        self.colours.push(colour);
        Ok(())
    }

    fn face(&mut self, line: &Line<'_>) -> Result<(), String> {
        self.corners.clear();
        for word in line.arguments() {
            if self.corners.len() == FACE_CORNERS {
                let n = line.arguments().count();
                return Err(format!("a face has {n} corners; it may have at most {FACE_CORNERS}"));
            }
            let corner = corner(word, self.counts)?;
            if corner.dangling {
                self.skip("missing normal or texture coordinate", line.number);
            }
            self.corners.push(corner.indices);
        }
        if self.corners.len() < 3 {
            self.skip("face with fewer than three corners", line.number);
            return Ok(());
        }
        let attributes = [1, 2].map(|kind| self.corners.iter().all(|corner| corner[kind].is_some()));
        let part = self.part(attributes);
        let out = &mut self.faces[part];
        out.push('f');
        for [position, uv, normal] in &self.corners {
            // Writing to a string does not fail.
            let _ = match (position, uv.filter(|_| attributes[0]), normal.filter(|_| attributes[1])) {
                (Some(v), None, None) => write!(out, " {v}"),
                (Some(v), Some(vt), None) => write!(out, " {v}/{vt}"),
                (Some(v), None, Some(vn)) => write!(out, " {v}//{vn}"),
                (Some(v), Some(vt), Some(vn)) => write!(out, " {v}/{vt}/{vn}"),
                (None, ..) => Ok(()),
            };
        }
        out.push('\n');
        Ok(())
    }

    fn part(&mut self, attributes: [bool; 2]) -> usize {
        if let Some(&index) = self.current.get(&attributes) {
            return index;
        }
        let ObjState { name, object, material, smoothing } = self.state.clone();
        let part = ObjPart { name, object, material, smoothing, attributes };
        let index = *self.part_index.entry(part.clone()).or_insert_with(|| {
            self.document.parts.push(part);
            self.faces.push(String::new());
            self.faces.len() - 1
        });
        self.current.insert(attributes, index);
        index
    }

    fn change(&mut self, change: impl FnOnce(&mut ObjState)) {
        change(&mut self.state);
        self.current.clear();
    }

    fn skip(&mut self, what: &str, line: usize) {
        match self.document.skipped.get_mut(what) {
            Some((count, _)) => *count += 1,
            None => {
                self.document.skipped.insert(what.to_owned(), (1, line));
            }
        }
    }
}

struct Corner {
    /// Indices of `v`, `vt` and `vn`, counted from 1.
    indices: [Option<usize>; 3],
    /// True if it names a missing `vt` or `vn`.
    dangling: bool,
}

/// Reads `v`, `v/vt`, `v//vn` or `v/vt/vn`.
fn corner(word: &str, counts: [usize; 3]) -> Result<Corner, String> {
    let mut corner = Corner { indices: [None; 3], dangling: false };
    for (kind, text) in word.split('/').enumerate() {
        let slot =
            corner.indices.get_mut(kind).ok_or_else(|| format!("`{}` is not a corner of a face", shortened(word)))?;
        if text.is_empty() {
            continue;
        }
        let index: i64 = text.parse().map_err(|_| format!("`{}` is not a whole number of 64 bits", shortened(text)))?;
        *slot = absolute(index, counts[kind]);
        match (kind, *slot) {
            (0, None) => {
                let count = counts[0];
                return Err(format!(
                    "vertex {index} of the face is out of range: {count} come before it (indices start at 1)"
                ));
            }
            (_, None) => corner.dangling = true,
            _ => {}
        }
    }
    match corner.indices[0] {
        Some(_) => Ok(corner),
        None => Err(format!("the corner `{}` has no vertex index", shortened(word))),
    }
}

/// Indices count from 1; negative ones count back from the last statement before the face.
fn absolute(index: i64, count: usize) -> Option<usize> {
    let position = if index < 0 { index.checked_add_unsigned(count as u64 + 1)? } else { index };
    usize::try_from(position).ok().filter(|p| (1..=count).contains(p))
}

#[cfg(test)]
mod tests {
    use super::*;

    const VERTICES: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\n";

    fn parse(faces: &str) -> ObjDocument {
        ObjDocument::parse(&format!("{VERTICES}{faces}")).expect("a good file")
    }

    fn refused(faces: &str) -> String {
        let bad = ObjDocument::parse(&format!("{VERTICES}{faces}")).expect_err("a bad file");
        let lines: Vec<String> = bad.iter().map(|LineError { line, kind }| format!("{line}: {kind}")).collect();
        lines.join("\n")
    }

    #[test]
    fn negative_indices_count_back() {
        let document = parse("f -4/-1/-1 -3/1/1 3/-1/1\nv 5 5 5\nf -1 -2 -3");
        assert!(document.text.ends_with("g 0\nf 1/1/1 2/1/1 3/1/1\ng 1\nf 5 4 3\n"), "{}", document.text);
    }

    #[test]
    fn indices_out_of_range_are_refused_with_their_line() {
        for (face, expected) in [
            ("f 1 2 5", "7: vertex 5 of the face is out of range: 4 come before it (indices start at 1)"),
            ("\nf 0 1 2", "8: vertex 0 of the face is out of range: 4 come before it (indices start at 1)"),
            ("f 1 2 -5", "7: vertex -5 of the face is out of range: 4 come before it (indices start at 1)"),
            ("f 1 2 9223372036854775808", "7: `9223372036854775808` is not a whole number of 64 bits"),
            ("f 1/1/1/1 2 3", "7: `1/1/1/1` is not a corner of a face"),
            ("f 1 2 /1", "7: the corner `/1` has no vertex index"),
        ] {
            assert_eq!(refused(face), expected);
        }
        assert!(refused(&format!("f 1 2 {}", i64::MIN)).starts_with("7: vertex "));
    }

    #[test]
    fn attributes_that_only_some_corners_have_are_left_out() {
        let document = parse("f 1/1 2 3/1\nf 1/1 2/1 3/1\nf 1/2/0 2/1/1 4/1/1");
        assert_eq!(document.skipped.values().collect::<Vec<_>>(), [&(1, 9)]);
        assert_eq!(document.parts.len(), 2);
        assert!(document.text.ends_with("g 0\nf 1 2 3\nf 1 2 4\ng 1\nf 1/1 2/1 3/1\n"), "{}", document.text);
    }

    #[test]
    fn parts_gather_the_faces_of_one_state() {
        let document = parse("o a\nusemtl m\ns 1\nf 1 2 3\nusemtl n n\nf 1 3 4\nusemtl m\nf 2 3 4\ns off\nf 2 3 4\n");
        let seen: Vec<_> =
            document.parts.iter().map(|p| (p.name.as_str(), p.material.as_deref(), p.smoothing)).collect();
        let (one, off) = (Smoothing::Group(1), Smoothing::Off);
        assert_eq!(seen, [("a", Some("m"), one), ("a", Some("n n"), one), ("a", Some("m"), off)]);
        assert!(document.text.contains("g 0\nf 1 2 3\nf 2 3 4\n"));
    }

    #[test]
    fn what_is_left_out_is_counted() {
        let document = parse("l 1 2\np 1\nf 1 2\nv 0 0 0 1 0 0\nvp 1 2\nmg 1\nf 1 2 3\n");
        let skipped: Vec<_> = document.skipped.iter().map(|(what, at)| (what.as_str(), *at)).collect();
        let expected = [
            ("face with fewer than three corners", (1, 9)),
            ("line or point", (2, 7)),
            ("unsupported statement `vp`", (1, 11)),
        ];
        assert_eq!(skipped, expected);
    }

    #[test]
    fn vertices_without_a_colour_are_marked_next_to_those_with_one() {
        let document = parse("v 5 5 5 0.5 0 2\nv 6 6 6\nv 7 7 7 1 0.25 0.5 0\n");
        let colours: Vec<_> = document.text.lines().take(7).map(|line| line.splitn(5, ' ').nth(4)).collect();
        let none = Some("-1 -1 -1");
        assert_eq!(colours, [none, none, none, none, Some("0.5 0 1"), none, Some("0.25 0.5 0")]);
        assert_eq!(document.skipped["vertex colour outside of 0 to 1"], (1, 7));
        assert_eq!(refused("v 1 2 3 red 0 0"), "7: `red` is not a number");
    }

    #[test]
    fn short_vertices_and_huge_faces_are_refused() {
        assert_eq!(refused("v 1 2"), "7: `v` needs 3 numbers, but has 2");
        let huge = format!("f{}", " 1".repeat(FACE_CORNERS + 1));
        assert_eq!(refused(&huge), "7: a face has 100001 corners; it may have at most 100000");
        let found = ObjDocument::find_bad_numbers("v 1 2 3\n\nv 1,5 2 3", "v");
        let [LineError { line: 3, kind }] = &found[..] else { panic!("one line: {found:?}") };
        assert_eq!(kind.to_string(), "`1,5` is not a number");
    }

    #[test]
    fn a_bad_vertex_does_not_make_the_faces_after_it_bad() {
        assert_eq!(
            refused("v 1 2\nf 1 2 5\nf 1 2 6\n"),
            "7: `v` needs 3 numbers, but has 2\n9: vertex 6 of the face is out of range: 5 come before it (indices start at 1)"
        );
    }
}
