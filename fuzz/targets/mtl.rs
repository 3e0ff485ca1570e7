//! Material libraries, by an OBJ file that uses all materials of the library.

#![no_main]

use std::{fmt::Write, fs};

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let mut obj = String::from("mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n");
    for line in String::from_utf8_lossy(bytes).lines().take(100) {
        if let Some(name) = line.strip_prefix("newmtl ") {
            writeln!(obj, "usemtl {name}\nf 1/1 2/2 3/3").expect("memory");
        }
    }
    rt_fuzz::with_file("m.mtl", bytes, |library| {
        let path = library.with_file_name("m.obj");
        fs::write(&path, obj).expect("a folder to write to");
        rt_fuzz::load_and_plan(&path);
    });
});
