//! Content of the files of parts: decoded, checked, joined, and made an image of.

#![no_main]

use libfuzzer_sys::fuzz_target;
use rt_render::{Shard, UncheckedShard};

/// Pixels of the largest image that is made: a short input may claim 2²⁸, which are legal and take gigabytes.
const MAX_BYTES: u64 = 1 << 24;

fuzz_target!(|bytes: &[u8]| {
    rt_fuzz::within_budget(|| {
        let Ok(unchecked) = postcard::from_bytes::<UncheckedShard>(bytes) else { return };
        let Ok(shard) = unchecked.check() else { return };
        let missing = shard.missing_tiles();
        if shard.rendering_bytes() > MAX_BYTES {
            return;
        }
        let merged = Shard::merge(vec![shard.clone()]);
        assert!(missing == 0 || merged.is_err(), "a shard that lacks tiles is not an image");
        if let Ok(merged) = merged {
            assert!(merged.validate().is_ok(), "what is joined is sound");
        }
        assert!(!shard.into_rendering().film.pixels().is_empty());
    });
});
