//! Stereolithography, ascii and binary.

#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| rt_fuzz::with_file("m.stl", bytes, rt_fuzz::load_and_plan));
