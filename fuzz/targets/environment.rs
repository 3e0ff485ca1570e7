//! Images as light around a scene.

#![no_main]

use libfuzzer_sys::fuzz_target;
use rt_math::Rgb;
use rt_scene_io::{LoadOptions, read_environment};

fuzz_target!(|bytes: &[u8]| {
    rt_fuzz::with_file("e.hdr", bytes, |path| {
        let _ = read_environment(path, Rgb::gray(2.0), 1.0, &LoadOptions::default());
    });
});
