//! Files and references on disk.

use std::{
    fs::{self, Permissions},
    os::unix::fs::{PermissionsExt, symlink},
    path::Path,
    process::Command,
};

use crate::input::{Content, Input};

const GOOD: &str = "(lights: [ambient(gray(1))], camera: (look_from: (0, 0, 5)), nodes: [(shape: sphere())])";

pub(crate) fn missing_file() -> Input {
    Input::made("scene.ron", |_| {}).refused(&["scene.ron: does not exist"])
}

pub(crate) fn directory() -> Input {
    let make = |folder: &Path| fs::create_dir(folder.join("scene.ron")).expect("a folder");
    Input::made("scene.ron", make).refused(&["scene.ron: is a directory; give the path of a file"])
}

pub(crate) fn unreadable_file() -> Vec<Input> {
    // Unreadable even for root: nothing is mapped at its beginning.
    let memory = |folder: &Path| symlink("/proc/self/mem", folder.join("scene.ron")).expect("a link");
    let lock = |folder: &Path| {
        let path = folder.join("scene.ron");
        fs::write(&path, GOOD).expect("written");
        fs::set_permissions(&path, Permissions::from_mode(0o000)).expect("locked");
        if fs::read(&path).is_ok() {
            fs::remove_file(path).expect("removed");
        }
    };
    // Root has no file to read in the second case.
    vec![
        Input::made("scene.ron", memory).refused(&["scene.ron: cannot be read: "]),
        Input::made("scene.ron", lock).refused(&["scene.ron: "]),
    ]
}

pub(crate) fn empty_file() -> Vec<Input> {
    ["scene.ron", "scene.json", "m.obj", "m.gltf", "m.glb"]
        .map(|name| Input::file(name, "").refused(if name == "m.obj" { &["m.obj: "] } else { &["is empty"] }))
        .into()
}

pub(crate) fn truncated_at_every_byte() -> Vec<Input> {
    (0..GOOD.len()).map(|length| Input::scene(&GOOD[..length]).refused(&["scene.ron"])).collect()
}

pub(crate) fn not_utf8() -> Vec<Input> {
    let obj = b"o K\xfcche\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    vec![
        Input::file("scene.ron", b"(nodes: \xff[])").refused(&["scene.ron", "is not UTF-8 text: the byte at offset 8"]),
        Input::file("m.obj", obj).shown(&["m.obj:1", "not UTF-8"]),
    ]
}

pub(crate) fn nul_bytes() -> Vec<Input> {
    vec![
        Input::scene("(nodes: \0[])").refused(&["scene.ron:1:"]),
        Input::file("m.obj", "v 0 0 \0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").refused(&["m.obj:1: ", "is not a number"]),
    ]
}

pub(crate) fn byte_order_mark() -> Vec<Input> {
    vec![
        Input::scene(&format!("\u{feff}{GOOD}")).shown(&[]),
        Input::file("m.obj", "\u{feff}v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").shown(&[]),
    ]
}

pub(crate) fn windows_line_ends() -> Vec<Input> {
    vec![
        Input::scene(&GOOD.replace(", ", ",\r\n")).shown(&[]),
        Input::file("m.obj", "v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 3\r\n").shown(&[]),
    ]
}

pub(crate) fn single_line_of_5_mb() -> Vec<Input> {
    let spaces = Content { head: "(".into(), part: " ".into(), times: 5_000_000, tail: "nodes: [))".into() };
    let corners = Content { head: "f".into(), part: " 1".into(), times: 2_500_000, tail: Vec::new() };
    vec![
        Input::long("scene.ron", spaces).refused(&["scene.ron:1:5000"]),
        Input::long("m.obj", corners).refused(&["m.obj:1: "]),
    ]
}

pub(crate) fn pipe_or_device() -> Vec<Input> {
    let pipe = |folder: &Path| {
        let made = Command::new("mkfifo").arg(folder.join("scene.ron")).status().expect("mkfifo");
        assert!(made.success());
    };
    let device = |folder: &Path| symlink("/dev/zero", folder.join("scene.ron")).expect("a link");
    [pipe, device].map(|make| Input::made("scene.ron", make).refused(&["scene.ron: is not a regular file"])).into()
}

/// A scene whose floor shows this image.
fn textured(reference: &str) -> Input {
    let material = format!("(color: image(file: \"{reference}\"))");
    Input::scene(&format!("(materials: {{\"m\": phong{material}}}, nodes: [(shape: plane(), material: \"m\")])"))
}

pub(crate) fn references_that_leave_the_folder() -> Vec<Input> {
    let link = |folder: &Path| {
        symlink("../secret.png", folder.join("link.png")).expect("a link");
        let scene = "(materials: {\"m\": phong(color: image(file: \"link.png\"))}, nodes: [])";
        fs::write(folder.join("scene.ron"), scene).expect("written");
    };
    vec![
        textured("../secret.png")
            .refused(&["scene.ron:1:", ": materials[\"m\"].color: `../secret.png` lies outside of"]),
        textured("/etc/passwd").refused(&["`/etc/passwd` is absolute"]),
        textured("file:///etc/passwd").refused(&["is a URL"]),
        textured("http://example.org/x.png").refused(&["is a URL"]),
        textured("C:\\\\x.png").refused(&["is absolute"]),
        Input::made("scene.ron", link).refused(&["`link.png` lies outside of"]),
        Input::file("m.gltf", gltf_with_buffer("../secret.bin")).refused(&["m.gltf", "secret.bin"]),
        Input::file("m.obj", "mtllib ../secret.png\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
            .refused(&["m.obj:1: `../secret.png` lies outside"]),
    ]
}

/// `rt-scene-io/tests/strictness.rs` has all formats and both byte orders.
pub(crate) fn utf_16() -> Input {
    let bytes: Vec<u8> = "\u{feff}(nodes: [])".encode_utf16().flat_map(u16::to_le_bytes).collect();
    Input::file("scene.ron", bytes).refused(&["is text in UTF-16 (little-endian): save it as UTF-8"])
}

fn gltf_with_buffer(uri: &str) -> String {
    format!(r#"{{"asset": {{"version": "2.0"}}, "buffers": [{{"byteLength": 4, "uri": "{uri}"}}]}}"#)
}

/// A PNG with this header and no pixels: the checksums are right.
fn png_of(width: u32, height: u32) -> Vec<u8> {
    let mut bytes = b"\x89PNG\r\n\x1a\n".to_vec();
    let mut chunk = |kind: &[u8; 4], data: &[u8]| {
        bytes.extend((data.len() as u32).to_be_bytes());
        let body = [kind, data].concat();
        bytes.extend(&body);
        bytes.extend(crc32fast::hash(&body).to_be_bytes());
    };
    let header = [&width.to_be_bytes()[..], &height.to_be_bytes(), &[8, 2, 0, 0, 0]].concat();
    chunk(b"IHDR", &header);
    chunk(b"IDAT", &[0; 30_000]);
    chunk(b"IEND", &[]);
    bytes
}

pub(crate) fn texture_bomb() -> Vec<Input> {
    vec![
        textured("t.png")
            .with_file("t.png", png_of(60_000, 60_000))
            .refused(&["materials[\"m\"].color", "60000 x 60000"]),
        textured("t.png").with_file("t.png", png_of(8_000, 8_000)).refused(&["materials[\"m\"].color", "8000x8000"]),
    ]
}

pub(crate) fn texture_without_pixels() -> Vec<Input> {
    let hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 0 +X 0\n";
    vec![
        textured("t.png").with_file("t.png", png_of(0, 0)).refused(&["materials[\"m\"].color"]),
        textured("t.hdr").with_file("t.hdr", hdr).refused(&["materials[\"m\"].color"]),
    ]
}

pub(crate) fn truncated_texture() -> Vec<Input> {
    let whole = png_of(4, 4);
    let cut = [0, 7, 20, 40, whole.len() / 2];
    let input = |length: usize| textured("t.png").with_file("t.png", &whole[..length]);
    let jpeg = &include_bytes!("../../../../fuzz/seeds/texture/RGB.jpg")[..655];
    let mut inputs: Vec<Input> =
        cut.map(|length| input(length).refused(&["scene.ron:1:", ": materials[\"m\"].color: "])).into();
    inputs.push(
        textured("t.jpg").with_file("t.jpg", jpeg).refused(&["materials[\"m\"].color: ", "truncated or damaged"]),
    );
    inputs
}
