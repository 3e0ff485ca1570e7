use super::*;

const FACET_TEXT: &str =
    "facet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n  vertex 0 1 0\n endloop\nendfacet\n";
const OTHER_TEXT: &str =
    "facet normal 0 0 1\n outer loop\n  vertex 1 0 0\n  vertex 1 1 0\n  vertex -0 1 0\n endloop\nendfacet\n";

/// Triangles of both files, in which equal corners are one vertex.
const TRIANGLES: [[u32; 3]; 2] = [[0, 1, 2], [1, 3, 2]];

fn text() -> String {
    format!("solid a\n{FACET_TEXT}{OTHER_TEXT}endsolid a\n")
}

/// Two triangles with a common edge.
fn binary(comment: &[u8]) -> Vec<u8> {
    let mut bytes = comment.to_vec();
    bytes.resize(COMMENT, b' ');
    bytes.extend(2u32.to_le_bytes());
    for corners in [[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], [[1.0, 0.0], [1.0, 1.0], [-0.0, 1.0]]] {
        bytes.extend([0.0f32, 0.0, 1.0].map(f32::to_le_bytes).concat());
        for [x, y] in corners {
            bytes.extend([x, y, 0.0f32].map(f32::to_le_bytes).concat());
        }
        bytes.extend([0, 0]);
    }
    bytes
}

fn load_all(bytes: &[u8]) -> Result<Model, LoadError> {
    load_bytes(bytes.to_vec(), Path::new("m.stl"))
}

fn refused(bytes: &[u8]) -> String {
    load_all(bytes).expect_err("a bad file").to_string()
}

#[test]
fn text_and_binary_hold_the_same_square() {
    for bytes in [text().into_bytes(), binary(b"made by a program"), binary(b"solid but not text"), binary(b"solid ")] {
        let model = load_all(&bytes).expect("a square");
        let data = model.mesh_data(0);
        assert_eq!(data.triangles, TRIANGLES);
        assert_eq!(data.positions.len(), 4);
        assert_eq!((data.normals.len(), model.warnings.len()), (0, 0));
    }
}

#[test]
fn text_may_have_any_first_line_case_and_line_ends() {
    let solids = format!("\n  solid\r\n{FACET_TEXT}endsolid\n\nsolid b c\n{OTHER_TEXT}endsolid b c");
    // A file with the line ends of old Macintosh systems was one line, and one with a byte order mark was binary.
    let (returns, marked) = (text().replace('\n', "\r"), ["\u{feff}", text().as_str()].concat());
    for variant in [solids, text().to_uppercase(), returns, marked] {
        assert_eq!(load_all(variant.as_bytes()).expect("a square").mesh_data(0).triangles, TRIANGLES, "{variant}");
    }
    assert!(refused(text().replacen("outer loop", "outer", 1).replace('\n', "\r").as_bytes()).starts_with("m.stl:3: "));
}

#[test]
fn facets_whose_normal_is_no_number_are_as_good_as_others() {
    for normal in [
        "nan nan nan",
        "NaN 0 1",
        "-nan(ind) -nan(ind) -nan(ind)",
        "-1.#IND -1.#IND -1.#IND",
        "inf 1.#INF 0",
        "1e999 0 0",
    ] {
        let model = load_all(text().replace("facet normal 0 0 1", &format!("facet normal {normal}")).as_bytes());
        assert_eq!(model.expect("a square").mesh_data(0).triangles, TRIANGLES);
    }
    let bad =
        text().replacen("facet normal 0 0 1", "facet normal nan nan nan", 1).replacen("vertex 1 0 0", "vertex 1 0", 1);
    assert!(
        refused(bad.as_bytes()).starts_with("m.stl:5: expected `vertex X Y Z`, found `vertex 1 0`"),
        "lines are counted on"
    );
}

/// The file was refused.
#[test]
fn the_name_behind_endsolid_may_be_in_any_encoding() {
    for name in [&b"K\xf6rper"[..], b"\xff", b""] {
        let bytes = [b"solid ", name, b"\n", FACET_TEXT.as_bytes(), b" EndSolid\t", name].concat();
        assert_eq!(load_all(&bytes).expect("a triangle").mesh_data(0).triangles, [[0, 1, 2]]);
    }
}

#[test]
fn every_bad_line_is_named() {
    let line = |from: &str, to: &str| refused(text().replacen(from, to, 1).as_bytes());
    assert!(
        line("facet normal 0 0 1", "facet norm 0 0 1")
            .starts_with("m.stl:2: expected `facet normal X Y Z` or `endsolid`, found `facet norm 0 0 1`")
    );
    assert!(line("outer loop", "outer").starts_with("m.stl:3: expected `outer loop`, found `outer`"));
    assert!(line("vertex 1 0 0", "vertex 1 0 zero").starts_with("m.stl:5: `zero` is not a finite number"));
    assert!(line("vertex 1 0 0", "vertex 1 0 nan").starts_with("m.stl:5: `nan` is not a finite number"));
    assert!(line("vertex 1 0 0", "vertex 1 0").starts_with("m.stl:5: expected `vertex X Y Z`, found `vertex 1 0`"));
    assert!(line("endsolid a", "").starts_with("m.stl:16: the file ends too early"), "{}", line("endsolid a", ""));
    assert_eq!(line("endsolid a\n", "endsolid a\nrest"), "m.stl:17: expected `solid` or the end of the file");
    assert_eq!(refused(b"solid a\nendsolid a"), "m.stl: has no usable triangles");
}

#[test]
fn numbers_of_facets_are_checked_before_anything_is_read() {
    let mut many = binary(b"");
    many[COMMENT..HEADER].copy_from_slice(&u32::MAX.to_le_bytes());
    let expected = "m.stl: a file of 184 bytes is truncated: its 4294967295 facets take 214748364834 bytes";
    assert_eq!(refused(&many), expected);
    assert_eq!(
        refused(b"abc"),
        "m.stl: a file of 3 bytes is not an STL file: it is too short for a binary file and does not begin with `solid`"
    );
    let longer = [binary(b""), vec![0; 7]].concat();
    assert_eq!(load_all(&longer).expect("a square").warnings[0].message, "7 bytes after the last facet are left out");
}

/// Colours were left out without a word.
#[test]
fn colours_of_facets_and_headers_are_a_warning() {
    let messages = |bytes: &[u8]| load_all(bytes).expect("a square").messages().join("\n");
    let mut one = binary(b"");
    one[HEADER + FACET as usize - 2..][..2].copy_from_slice(&0x801f_u16.to_le_bytes());
    assert_eq!(messages(&one), "the colours of 1 of 2 facets are left out");
    // Without the highest bit, the two bytes are no colour.
    let mut other = binary(b"");
    other[HEADER + FACET as usize - 2] = 0x1f;
    assert_eq!(messages(&other), "");
    let magics = binary(b"a COLOR=\xff\x00\x00\xff,MATERIAL=");
    assert_eq!(messages(&magics), "the colours of the header (`COLOR=`) and of facets are left out");
}

/// They were read as text, which lacks its end.
#[test]
fn binary_files_that_begin_with_solid_may_have_bytes_after_the_facets() {
    for comment in [&b"solid foo\0\0"[..], b"solid made by a program"] {
        let model = load_all(&[binary(comment), b"\0\0rest".to_vec()].concat()).expect("a square");
        assert_eq!(model.mesh_data(0).triangles, TRIANGLES);
        assert_eq!(model.messages(), ["6 bytes after the last facet are left out"]);
    }
}

#[test]
fn cut_and_changed_files_never_panic() {
    for bytes in [text().into_bytes(), binary(b""), binary(b"solid")] {
        for length in 0..bytes.len() {
            let _ = load_all(&bytes[..length]);
        }
        for (place, value) in (0..bytes.len()).flat_map(|place| [0, b' ', 127, 255].map(|value| (place, value))) {
            let mut changed = bytes.clone();
            changed[place] = value;
            let _ = load_all(&changed);
        }
    }
}
