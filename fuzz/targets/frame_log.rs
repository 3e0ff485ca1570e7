//! Frame logs: which frames of an animation are done.

#![no_main]

use libfuzzer_sys::fuzz_target;

#[path = "../../crates/rt-cli/src/done_frames.rs"]
#[allow(dead_code, reason = "the program needs more of it")]
mod done_frames;

fuzz_target!(|bytes: &[u8]| {
    rt_fuzz::within_budget(|| {
        if let Some(done) = done_frames::parse(bytes) {
            let written = serde_json::to_vec_pretty(&done).expect("memory");
            assert_eq!(done_frames::parse(&written), Some(done), "what is written is read back");
        }
    });
});
