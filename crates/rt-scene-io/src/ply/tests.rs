use super::*;
use std::fmt::Write;

const SQUARE: &str = "ply\nformat ascii 1.0\ncomment c\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                      element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";

fn load_all(bytes: impl Into<Vec<u8>>) -> Result<Model, LoadError> {
    load_bytes(bytes.into(), Path::new("m.ply"), MissingUvs::Keep)
}

fn refused(bytes: impl Into<Vec<u8>>) -> String {
    load_all(bytes).expect_err("a bad file").to_string()
}

/// The square in binary, with normals, texture coordinates in doubles, an element between, and corners by 16 bits.
fn binary(big: bool) -> Vec<u8> {
    let mut header = String::new();
    let order = if big { "big" } else { "little" };
    write!(header, "ply\nformat binary_{order}_endian 1.0\nelement vertex 4\n").expect("written");
    for name in ["x", "y", "z", "nx", "ny", "nz"] {
        writeln!(header, "property float {name}").expect("written");
    }
    header += "property double u\nproperty uchar quality\nproperty double v\nelement edge 1\nproperty list uchar short a\n\
               element face 2\nproperty list uchar ushort vertex_index\nend_header\n";
    let mut bytes = header.into_bytes();
    let f32s = |bytes: &mut Vec<u8>, x: f32| bytes.extend(if big { x.to_be_bytes() } else { x.to_le_bytes() });
    let f64s = |bytes: &mut Vec<u8>, x: f64| bytes.extend(if big { x.to_be_bytes() } else { x.to_le_bytes() });
    let u16s = |bytes: &mut Vec<u8>, x: u16| bytes.extend(if big { x.to_be_bytes() } else { x.to_le_bytes() });
    for (x, y) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
        for value in [x, y, 0.0, 0.0, 0.0, 2.0] {
            f32s(&mut bytes, value);
        }
        f64s(&mut bytes, f64::from(x));
        bytes.push(7);
        f64s(&mut bytes, f64::from(y));
    }
    bytes.push(2);
    u16s(&mut bytes, 1);
    u16s(&mut bytes, 2);
    for triangle in [[0, 1, 2], [0, 2, 3]] {
        bytes.push(3);
        for corner in triangle {
            u16s(&mut bytes, corner);
        }
    }
    bytes
}

/// A file with the line ends of old Macintosh systems was refused.
#[test]
fn lines_of_text_may_end_in_carriage_returns() {
    assert_eq!(load_all(SQUARE.replace('\n', "\r")).expect("a square").mesh_data(0).triangles.len(), 2);
}

/// Text with a byte order mark was no PLY file. Text of all other formats may have one.
#[test]
fn text_may_begin_with_a_byte_order_mark() {
    for text in [SQUARE.to_owned(), SQUARE.replace('\n', "\r\n"), SQUARE.replace('\n', "\r")] {
        let bytes = format!("\u{feff}{text}").into_bytes();
        let sample = FileSample::read(std::io::Cursor::new(&bytes), bytes.len() as u64).expect("a sample");
        assert_eq!((count(&sample, "vertex"), count(&sample, "face")), (4, 1));
        let model = load_all(bytes).expect("a square");
        assert_eq!((model.mesh_data(0).triangles.len(), model.warnings.len()), (2, 0));
    }
}

/// A binary file whose header has the line ends of old Macintosh systems was refused.
#[test]
fn lines_of_a_binary_header_may_end_in_carriage_returns() {
    for big in [false, true] {
        let mut bytes = binary(big);
        let end = bytes.windows(11).position(|window| window == b"end_header\n").expect("an end") + 11;
        bytes[..end].iter_mut().filter(|byte| **byte == b'\n').for_each(|byte| *byte = b'\r');
        // A byte of the data is a carriage return.
        bytes[end] = b'\r';
        let model = load_all(bytes.clone()).expect("a square");
        assert_eq!(model.mesh_data(0).triangles, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(model.mesh_data(0).positions[1], Vec3::X);
        assert!(model.mesh_data(0).positions[0] != Vec3::ZERO);
        let sample = FileSample::read(std::io::Cursor::new(&bytes), bytes.len() as u64).expect("a sample");
        assert_eq!((count(&sample, "vertex"), count(&sample, "face")), (4, 2));
    }
}

#[test]
fn text_and_both_byte_orders_hold_the_same_square() {
    let text = load_all(SQUARE).expect("a square");
    assert_eq!(text.mesh_data(0).triangles.len(), 2);
    assert_eq!(text.warnings, []);
    for big in [false, true] {
        let model = load_all(binary(big)).expect("a square");
        assert_eq!(model.mesh_data(0).positions, text.mesh_data(0).positions);
        assert_eq!(model.mesh_data(0).triangles, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(model.mesh_data(0).normals, [Vec3::Z; 4]);
        assert_eq!(model.mesh_data(0).uvs, [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        assert_eq!(
            model.messages(),
            ["properties of the element `vertex` are left out: `quality`", "the element `edge` of 1 rows is left out"]
        );
    }
}

#[test]
fn faces_of_two_corners_are_no_point_cloud() {
    assert_eq!(
        refused(SQUARE.replace("4 0 1 2 3", "2 0 1")),
        "m.ply: has no usable triangles (warning: m.ply: faces with fewer than three corners were left out: 1)"
    );
}

#[test]
fn bytes_after_the_header_are_those_of_the_file() {
    let header = SQUARE.split_inclusive("end_header\n").next().expect("a header");
    assert!(refused(header).starts_with("m.ply: 0 bytes after the header are too few"), "{}", refused(header));
    // A text without its last line break is whole.
    load_all(SQUARE.trim_end()).expect("a square");
}

#[test]
fn a_binary_file_without_its_last_byte_is_refused() {
    for big in [false, true] {
        let mut bytes = binary(big);
        bytes.pop();
        let length = bytes.len();
        assert_eq!(refused(bytes), format!("m.ply: the file ends too early (before byte {length})"));
    }
}

#[test]
fn other_bytes_are_no_ply_file() {
    let noise: Vec<u8> = (0..3000_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    assert_eq!(refused(noise), "m.ply:1: is not a PLY file: the first line must be `ply`");
    assert_eq!(refused(*b"ply\nformat ascii 1.0\ncomment \xff\n"), "m.ply:3: the header is not UTF-8 text");
}

#[test]
fn another_version_of_the_format_is_a_warning() {
    let model = load_all(SQUARE.replace("ascii 1.0", "ascii 2.0")).expect("a square");
    assert_eq!(model.messages(), ["the file has version 2.0 of the format; it is read as version 1.0"]);
}

#[test]
fn a_concave_face_covers_its_own_area_only() {
    let dart = SQUARE.replace("0 0 0\n1 0 0\n1 1 0\n0 1 0", "0 0 0\n2 0 0\n0.5 0.5 0\n0 2 0");
    let model = load_all(dart).expect("a dart");
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| model.mesh_data(0).positions[i as usize]);
        (b - a).cross(c - a).z / 2.0
    };
    assert_eq!(model.mesh_data(0).triangles.iter().map(area).collect::<Vec<_>>(), [0.5, 0.5]);
}

#[test]
fn headers_that_promise_too_much_are_refused_at_once() {
    let many = SQUARE.replace("vertex 4", "vertex 4000000000");
    assert_eq!(
        refused(many),
        "m.ply: 34 bytes after the header are too few: its elements take at least 24000000002; the file is truncated"
    );
    let most = SQUARE.replace("face 1", "face 18446744073709551615");
    assert!(refused(most).contains("at least 18446744073709551615"));
    let nothing = SQUARE.replace("element face", "element void 4000000000\nelement face");
    assert_eq!(refused(nothing), "m.ply: the element `void` of 4000000000 rows has no properties: give at least one");
    // A list that is longer than the file.
    let mut long = binary(false);
    let at = long.len() - 7;
    long[at] = 255;
    assert!(refused(long).contains("the file ends too early"));
}

#[test]
fn every_bad_line_is_named() {
    let cases = [
        (SQUARE.replace("ply\n", "plx\n"), "m.ply:1: is not a PLY file: the first line must be `ply`"),
        (
            SQUARE.replace("float y", "flaot y"),
            "m.ply:6: unknown type `flaot`; known are `char`, `uchar`, `short`, `ushort`, `int`, `uint`, `float`, `double`",
        ),
        (SQUARE.replace("float z", "float w"), "m.ply: the element `vertex` has no property `z`"),
        (SQUARE.replace("element vertex", "element vortex"), "m.ply: the header has no element `vertex`"),
        (SQUARE.replace("1 1 0\n", "1 x 0\n"), "m.ply:13: `x` is not a number"),
        (SQUARE.replace("4 0 1 2 3", "4 0 1 -2 3"), "m.ply:15: found `-2`, expected a whole number from 0 up"),
        (
            SQUARE.replace("4 0 1 2 3", "4 0 1 2.5 3"),
            "m.ply:15: `2.5` is not a whole number that fits the type of its property",
        ),
        (SQUARE.replace("4 0 1 2 3", "400 0 1 2 3"), "m.ply:15: `400` is not a whole number from 0 to 255"),
        (
            SQUARE.replace("vertex 4", "vertex many"),
            "m.ply:4: `many` is not a number of rows; expected a whole number from 0 up",
        ),
        (SQUARE.replace("4 0 1 2 3", "5 0 1 2 3"), "m.ply:15: the file ends too early"),
    ];
    for (text, expected) in cases {
        assert_eq!(refused(text), expected);
    }
    assert!(refused(SQUARE.replace("4 0 1 2 3", "4 0 1 2 9")).starts_with("m.ply: element face: "));
    assert!(
        refused(SQUARE.replace("face 1", "face 0").replace("4 0 1 2 3\n", ""))
            .contains("a point cloud without faces is not supported")
    );
    assert!(
        refused(SQUARE.replace("element face", "element vertex")).contains("there are two elements named `vertex`")
    );
}

#[test]
fn strips_are_triangles_as_well() {
    let strips =
        SQUARE.replace("element face 1\nproperty list uchar int", "element tristrips 1\nproperty list int int");
    let text = strips.replace("4 0 1 2 3\n", "9 0 1 3 2 2 -1 1 2 3\n");
    let model = load_all(text).expect("a model");
    assert_eq!(model.mesh_data(0).triangles, [[0, 1, 3], [1, 2, 3], [1, 2, 3]]);
    assert!(model.warnings.iter().all(|warning| !warning.message.contains("tristrips")), "{:?}", model.warnings);
    assert!(refused(strips.replace("4 0 1 2 3", "3 0 1 4")).contains("vertex index 4"));
    // Faces and strips may occur together, in any order.
    let both =
        SQUARE.replace("element face", "element tristrips 1\nproperty list int int vertex_indices\nelement face");
    let model = load_all(both.replace("4 0 1 2 3\n", "3 0 1 2\n3 0 2 3\n")).expect("a model");
    assert_eq!(model.mesh_data(0).triangles.len(), 2);
}

#[test]
fn faces_that_are_none_are_counted() {
    let text = SQUARE.replace("face 1", "face 3").replace("4 0 1 2 3\n", "4 0 1 2 3\n2 0 1\n0\n");
    let model = load_all(text).expect("a model");
    assert_eq!(model.warnings[0].message, "faces with fewer than three corners were left out: 2");
}

#[test]
fn cut_files_never_panic() {
    for bytes in [SQUARE.as_bytes().to_vec(), binary(false), binary(true)] {
        for length in 0..bytes.len() - 1 {
            let cut = load_all(&bytes[..length]);
            assert!(cut.is_err() || length + 3 > bytes.len(), "cut at {length}");
        }
        for (place, value) in (0..bytes.len()).flat_map(|place| [0, 1, 127, 255].map(|value| (place, value))) {
            let mut changed = bytes.clone();
            changed[place] = value;
            let _ = load_all(changed);
        }
    }
}

/// The square with one colour for each vertex.
fn colored(kind: &str, alpha: &str, colors: [&str; 4]) -> Model {
    let header = format!("property float z\nproperty {kind} red\nproperty {kind} green\nproperty {kind} blue\n{alpha}");
    let mut text = SQUARE.replace("property float z\n", &header);
    for (corner, color) in ["0 0 0\n", "1 0 0\n", "1 1 0\n", "0 1 0\n"].into_iter().zip(colors) {
        text = text.replacen(&format!("\n{corner}"), &format!("\n{} {color}\n", corner.trim_end()), 1);
    }
    load_all(text).expect("a colored square")
}

#[test]
fn colours_of_vertices_are_decoded_and_shown() {
    let bytes = colored("uchar", "", ["255 0 188", "0 255 0", "0 0 255", "10 20 30"]);
    let shown = bytes.mesh_data(0).colors[0];
    assert_eq!((shown[0], shown[1], shown[3]), (1.0, 0.0, 1.0));
    assert!((shown[2] - 0.502_886_5).abs() < 1e-6, "{shown:?}");
    assert_eq!(bytes.warnings, []);
    let phong = bytes.materials[0].to_phong();
    assert_eq!(bytes.textures, [Texture::VertexColor(None)]);
    assert_eq!(phong.diffuse, ColorTexture::Textured(TextureId(0), Rgb::WHITE));
    assert_eq!(phong.ambient, ColorTexture::Textured(TextureId(0), Rgb::gray(0.1)));

    let alpha = "property uchar alpha\n";
    let floats = colored("float", alpha, ["0.5 0 1 255", "2 0 0 0", "0 0 0 51", "1 1 1 255"]);
    assert_eq!(
        floats.mesh_data(0).colors,
        [[0.5, 0.0, 1.0, 1.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.2], [1.0, 1.0, 1.0, 1.0]]
    );
    assert!(load_all(SQUARE).expect("a square").textures.is_empty());
}

/// Floats up to 255 were accepted without a word: `path` clamped them, `whitted` did not.
#[test]
fn float_colours_above_one_are_a_warning() {
    let model = colored("float", "", ["255 128 0", "1 1 1", "0 0 1.5", "0 0 0"]);
    assert_eq!(
        model.messages(),
        [
            "vertex colours above 1 are clamped: 2 of 4; colours of type `float` are 1 at most, those of type `uchar` 255"
        ]
    );
    assert_eq!(model.mesh_data(0).colors[..3], [[1.0, 1.0, 0.0, 1.0], [1.0; 4], [0.0, 0.0, 1.0, 1.0]]);
    assert_eq!(colored("float", "", ["1 0.5 0", "1 1 1", "0 0 1", "0 0 0"]).warnings, []);
    assert_eq!(colored("uchar", "", ["255 128 0"; 4]).warnings, []);
}

#[test]
fn a_part_of_a_colour_is_left_out_with_a_warning() {
    let red = SQUARE.replace("property float z\n", "property float z\nproperty uchar red\n").replace(" 0\n", " 0 9\n");
    let model = load_all(red).expect("a square");
    assert!(model.mesh_data(0).colors.is_empty() && model.textures.is_empty());
    assert_eq!(model.warnings[0].message, "properties of the element `vertex` are left out: `red`");
}
