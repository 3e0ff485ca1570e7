//! Images that are compared and developed.

#![no_main]

use libfuzzer_sys::fuzz_target;
use rt_image::{image_format, read_image};

fuzz_target!(|bytes: &[u8]| {
    rt_fuzz::with_file("p.png", bytes, |path| {
        let format = image_format(path);
        if let Ok(film) = read_image(path) {
            assert!(format.is_ok(), "what can be read has a format");
            assert_eq!(film.pixels().len() as u64, u64::from(film.width()) * u64::from(film.height()));
        }
    });
});
