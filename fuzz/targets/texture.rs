//! Images as textures.

#![no_main]

use libfuzzer_sys::fuzz_target;
use rt_scene_io::decode_texture;

fuzz_target!(|bytes: &[u8]| {
    rt_fuzz::within_budget(|| {
        if let Ok(bitmap) = decode_texture(bytes) {
            assert_eq!(bitmap.pixels.len() as u64, u64::from(bitmap.width) * u64::from(bitmap.height));
            assert!(bitmap.pixels.iter().flatten().all(|c| c.is_finite()));
        }
    });
});
