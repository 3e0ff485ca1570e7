//! Neutral files of the Standard Procedural Databases.

#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| rt_fuzz::with_file("s.nff", bytes, rt_fuzz::load_and_plan));
