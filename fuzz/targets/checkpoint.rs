//! Content of checkpoints: decoded, checked, and gone on from.

#![no_main]

use libfuzzer_sys::fuzz_target;
use rt_render::UncheckedCheckpoint;

fuzz_target!(|bytes: &[u8]| {
    rt_fuzz::within_budget(|| {
        let Ok(unchecked) = postcard::from_bytes::<UncheckedCheckpoint>(bytes) else { return };
        let Ok(checkpoint) = unchecked.check() else { return };
        rt_fuzz::go_on(&checkpoint);
    });
});
