//! glTF as JSON.

#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| rt_fuzz::with_file("m.gltf", bytes, rt_fuzz::load_and_plan));
