//! Warnings about unsupported content of model files, so that `--strict` can refuse it.

use std::fs;

use rt_scene_io::{LoadError, LoadOptions, Scene, load};

/// Loads the first of these files, with the others next to it.
fn loaded(files: &[(&str, &[u8])]) -> Result<Scene, LoadError> {
    let folder = tempfile::tempdir().unwrap();
    for (name, content) in files {
        fs::write(folder.path().join(name), content).unwrap();
    }
    load(&folder.path().join(files[0].0), &LoadOptions::default())
}

/// The warnings that the files cause, without the folder.
fn warnings(files: &[(&str, &[u8])]) -> Vec<String> {
    let scene = loaded(files).unwrap_or_else(|error| panic!("{error}"));
    let name = |text: String| text.rsplit('/').next().map(str::to_owned).unwrap_or(text);
    scene.warnings.iter().map(|warning| format!("{}: {}", name(warning.place.clone()), warning.message)).collect()
}

fn warnings_of(name: &str, content: impl AsRef<[u8]>) -> Vec<String> {
    warnings(&[(name, content.as_ref())])
}

const OBJ: &[u8] = b"mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3\n";

#[test]
fn unknown_mtl_statements_are_warned_of() {
    let mtl = b"newmtl a\nKd 1 1 1\nillum 2\nKm 0.5\nmap_Foo x.png\nillum 2\nKm 0.25\n";
    let said = warnings(&[("a.obj", OBJ), ("a.mtl", mtl)]);
    let expected = [
        "a.mtl:4: unsupported statement `Km`: left out (2 times, this is the first)",
        "a.mtl:5: unsupported statement `map_Foo`: left out",
    ];
    assert_eq!(said, expected);
    let known =
        b"newmtl a\nKd 1 1 1\nKs 0 0 0\nKa 0 0 0\nNs 10\nNi 1.5\nd 1\nillum 2\nTf 1 1 1\nKe 0 0 0\nPr 0.5\nPm 0\n";
    assert_eq!(warnings(&[("a.obj", OBJ), ("a.mtl", known)]), [""; 0]);
}

#[test]
fn an_absolute_texture_in_an_mtl_file_is_a_missing_texture() {
    for path in ["/absolute.png", "C:\\textures\\absolute.png"] {
        let mtl = format!("newmtl a\nKd 1 1 1\nmap_Kd {path}\n");
        let said = warnings(&[("a.obj", OBJ), ("a.mtl", mtl.as_bytes())]);
        let shown = path.replace('\\', "/");
        let expected =
            format!("a.mtl: material `a`: the path of the image `{shown}` is absolute; the plain colour is used");
        let said: Vec<String> = said.iter().map(|line| line.replace(&expected, "expected")).collect();
        assert_eq!(said, ["expected"], "{expected}");
    }
}

const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                   element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

#[test]
fn rows_of_a_ply_file_beyond_those_promised_are_warned_of() {
    assert_eq!(warnings_of("a.ply", PLY), [""; 0]);
    assert_eq!(warnings_of("a.ply", format!("{PLY}\n  \n")), [""; 0], "white space says nothing");
    let surplus = format!("{PLY}9 9 9\n1 2\n");
    assert_eq!(
        warnings_of("a.ply", surplus),
        ["a.ply: 2 lines beyond the rows that the header declares are left out, the first of them line 14"]
    );
    let header = PLY.split("end_header\n").next().unwrap().replace("ascii", "binary_little_endian");
    let mut binary = format!("{header}end_header\n").into_bytes();
    for number in [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
        binary.extend(number.to_le_bytes());
    }
    binary.push(3);
    for corner in [0_i32, 1, 2] {
        binary.extend(corner.to_le_bytes());
    }
    assert_eq!(warnings_of("a.ply", &binary), [""; 0]);
    binary.extend([0; 7]);
    assert_eq!(warnings_of("a.ply", &binary), ["a.ply: 7 bytes beyond the rows that the header declares are left out"]);
}

/// Regression: rows after one with a number too many or too few were shifted without a word, or only the last one was named.
#[test]
fn rows_of_a_ply_file_with_another_number_of_words_are_warned_of() {
    let after = "rows after it may be shifted";
    for (row, changed, line, counts) in [
        ("\n3 0 1 2\n", "\n3 0 1 2 7\n", 13, "5 numbers, but one of `face` has 4"),
        ("\n3 0 1 2\n", "\n\n3 0\n1 2\n", 14, "2 numbers, but one of `face` has 4"),
    ] {
        let warnings = warnings_of("a.ply", PLY.replacen(row, changed, 1));
        assert_eq!(warnings[0], format!("a.ply:{line}: this row has {counts}; {after}"), "{changed}");
    }
    let short = PLY.replacen("\n1 0 0\n", "\n1\n", 1).replace("\n0 1 0\n", "\n0 0 0 1 0\n");
    let warnings = warnings_of("a.ply", short);
    assert_eq!(warnings, [format!("a.ply:11: this row has 1 number, but one of `vertex` has 3; {after}")]);
    // The end of the file says little about the cause.
    let long = PLY.replace("\n0 1 0\n", "\n0 1 0 9\n");
    let error = loaded(&[("a.ply", long.as_bytes())]).expect_err("shifted").to_string();
    let row = format!("; line 12: this row has 4 numbers, but one of `vertex` has 3; {after}");
    assert!(error.ends_with(&row), "{error}");
}

/// Regression: the comment included all that follows.
#[test]
fn a_comment_ends_where_lines_end_by_carriage_returns() {
    let pbrt = "WorldBegin\r# a sphere\rShape \"sphere\"\r";
    assert_eq!(loaded(&[("a.pbrt", pbrt.as_bytes())]).expect("a scene").nodes.len(), 1);
    let ron = "(// nodes\r nodes: [(shape: sphere())],\r)\r";
    assert_eq!(loaded(&[("a.ron", ron.as_bytes())]).expect("a scene").nodes.len(), 1);
}

const SPHERE: &str = "WorldBegin\nShape \"sphere\"\n";

#[test]
fn attributes_of_pbrt_that_nothing_uses_are_warned_of() {
    let shape = "Attribute \"shape\" \"float radius\" 2 \"float typo\" 3\n";
    assert_eq!(
        warnings_of("a.pbrt", format!("{shape}{SPHERE}")),
        ["a.pbrt:1: the attribute \"typo\" for \"shape\" is not used"]
    );
    let kind = "Attribute \"shapes\" \"float radius\" 2\n";
    assert_eq!(
        warnings_of("a.pbrt", format!("{kind}{SPHERE}")),
        ["a.pbrt:1: `Attribute \"shapes\"` has an unknown target: give shape, light, material, medium or texture"]
    );
    // One shape has a use for what another has not.
    let two = "Attribute \"shape\" \"float radius\" 2\nWorldBegin\nShape \"sphere\"\n\
               Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2]\n";
    assert_eq!(warnings_of("a.pbrt", two), [""; 0]);
    // An attribute of which its scope has made no use, nor any below it.
    let scoped = "WorldBegin\nAttributeBegin\nAttribute \"shape\" \"float zmaxx\" 2\nShape \"sphere\"\nAttributeEnd\n";
    assert_eq!(warnings_of("a.pbrt", scoped), ["a.pbrt:3: the attribute \"zmaxx\" for \"shape\" is not used"]);
}

#[test]
fn parameters_of_media_are_named() {
    let medium = "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" \"float scale\" 1\n";
    assert_eq!(
        warnings_of("a.pbrt", format!("{medium}{SPHERE}")),
        ["a.pbrt:1: `MakeNamedMedium` is left out: media are not supported"]
    );
}

#[test]
fn a_gltf_scene_without_nodes_is_empty() {
    let triangle = "\"meshes\": [], \"nodes\": [{\"name\": \"elsewhere\"}]";
    for scenes in
        ["[{}]", "[{\"name\": \"x\"}]", "[{\"nodes\": []}]", "[{\"name\": \"nodes\", \"extras\": {\"a\": [1]}}]"]
    {
        let text = format!("{{\"asset\": {{\"version\": \"2.0\"}}, \"scene\": 0, \"scenes\": {scenes}, {triangle}}}");
        let scene = loaded(&[("a.gltf", text.as_bytes())]).unwrap_or_else(|error| panic!("{scenes}: {error}"));
        assert!(scene.meshes.is_empty() && scene.nodes.iter().all(|node| node.children.is_empty()), "{scenes}");
        assert!(scene.warnings[0].message.contains("no triangles"), "{scenes}: {:?}", scene.warnings);
    }
}

#[test]
fn files_in_utf_16_are_named_as_such() {
    let gltf = "{\"asset\": {\"version\": \"2.0\"}}";
    let stl = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n";
    let texts = [
        ("a.ron", "(nodes: [])"),
        ("a.json", "{\"nodes\": []}"),
        ("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
        ("a.pbrt", SPHERE),
        ("a.nff", "v\ns 0 0 0 1\n"),
        ("a.gltf", gltf),
        ("a.ply", PLY),
        ("a.stl", stl),
    ];
    for (name, text) in texts {
        for (bytes, order) in encodings(text) {
            let error = loaded(&[(name, &bytes)]).expect_err(name).to_string();
            let said = format!("{name}: is text in UTF-16 ({order}): save it as UTF-8");
            assert!(error.ends_with(&said), "{error}");
        }
    }
    for (bytes, order) in encodings("newmtl a\nKd 1 1 1\n") {
        let error = loaded(&[("a.obj", OBJ), ("a.mtl", &bytes)]).expect_err("a.mtl").to_string();
        assert!(error.ends_with(&format!("a.mtl: is text in UTF-16 ({order}): save it as UTF-8")), "{error}");
    }
    for (bytes, order) in encodings(SPHERE) {
        let error = loaded(&[("a.pbrt", b"Include \"b.pbrt\""), ("b.pbrt", &bytes)]).expect_err("b.pbrt").to_string();
        assert!(error.contains(&format!("is text in UTF-16 ({order})")), "{error}");
    }
}

/// A text in UTF-16, with a byte order mark.
fn encodings(text: &str) -> [(Vec<u8>, &'static str); 2] {
    let units: Vec<u16> = std::iter::once(0xFEFF).chain(text.encode_utf16()).collect();
    let little = units.iter().flat_map(|unit| unit.to_le_bytes()).collect();
    let big = units.iter().flat_map(|unit| unit.to_be_bytes()).collect();
    [(little, "little-endian"), (big, "big-endian")]
}
