//! Scene files in RON.

#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| rt_fuzz::with_file("scene.ron", bytes, rt_fuzz::load_and_plan));
